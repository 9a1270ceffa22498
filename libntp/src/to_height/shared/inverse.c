/* SPDX-License-Identifier: MIT */
/*
 * inverse.c - the inverse of the normal equations without weights, holes and ends
 *
 * Without these the normal equations are diagonal in frequencies.  The diagonal is the squared
 * gains of the stencil plus those of the pairs.  So the equations are solved by a Fourier (wrap) or
 * cosine transform along both axes, a division, and the transforms back.  All of it lies in `to`.
 */
#include "to_height/shared/inverse.h"

#include "base/view.h"

#include <math.h>
#include <string.h>

enum { ROWS = NTP__FFT_ROWS };

/* Mirrored axes have texels at both ends that count half; one-sided slopes lie between texels. */
static ntp__fft_kind kind_of(ntp_kernel kernel, ntp_border border, int32_t n)
{
    if (border == NTP_BORDER_MIRROR && kernel != NTP_KERNEL_FORWARD && n > 1)
        return NTP__FFT_MIRROR;
    return border == NTP_BORDER_WRAP ? NTP__FFT_REAL : NTP__FFT_COSINE;
}

static void init_spectrum(ntp__spectrum *s, ntp__scratch *memory, ntp_kernel kernel,
                          ntp_border border, int32_t n, void *fft_work)
{
    ntp__fft_kind kind = kind_of(kernel, border, n);
    ntp__fft_plan(&s->fft, memory, kind, n, false, fft_work);
    s->gains = ntp__take(memory, (size_t) n * sizeof *s->gains);
    s->edge = ntp__take(memory, (size_t) n * sizeof *s->edge);
    if (memory->base == NULL)
        return;
    for (int32_t i = 0; i < n; i++) {
        /* If the axis wraps, element i has i (or n - i) turns in n texels; else half as many. */
        int64_t half = kind == NTP__FFT_MIRROR ? n - 1 : n;
        int64_t whole = kind == NTP__FFT_REAL ? n : 2 * half;
        ntp__gains forward;
        ntp__stencil_gains(&s->gains[i], kernel, i, whole);
        ntp__stencil_gains(&forward, NTP_KERNEL_FORWARD, i, whole);
        s->edge[i] = forward.along[0] * forward.along[0];
    }
}

void ntp__inverse_init(ntp__inverse *v, const ntp__height_plan *plan, ntp__crew crew,
                       ntp__scratch *memory)
{
    memset(v, 0, sizeof *v);
    v->rows = plan->kernel != NTP_KERNEL_BAKED;
    v->width = plan->width;
    v->height = plan->height;
    v->crew = crew;
    double x = plan->dx / plan->dy, y = plan->dy / plan->dx;
    v->share_x = x > 1 ? y * y : 1;
    v->share_y = y > 1 ? x * x : 1;
    ntp_kernel kernel = v->rows ? plan->kernel : NTP_KERNEL_FORWARD;
    ntp__fft_kind kind_x = kind_of(kernel, plan->border_x, v->width);
    ntp__fft_kind kind_y = kind_of(kernel, plan->border_y, v->height);
    size_t x_work = ntp__fft_work_bytes(kind_x, v->width, false);
    size_t y_work = ntp__fft_work_bytes(kind_y, v->height, false);
    v->work = ntp__take(memory, (size_t) crew.parts * sizeof *v->work);
    for (int32_t i = 0; i < crew.parts; i++) {
        void *work = ntp__take(memory, x_work > y_work ? x_work : y_work);
        if (memory->base != NULL)
            v->work[i] = work;
    }
    /* A row for each part: rows below the last one, which rounding errors reach. */
    v->zeros = ntp__take(memory, (size_t) crew.parts * (size_t) v->width * sizeof *v->zeros);
    void *work = v->work != NULL ? v->work[0] : NULL;
    init_spectrum(&v->along, memory, kernel, plan->border_x, v->width, work);
    init_spectrum(&v->across, memory, kernel, plan->border_y, v->height, work);
}

/* Rows below the last one are zeros, as rounding errors pass between the two rows of a line. */
static void rows_of(const ntp__inverse *v, int32_t part, int32_t item, float *rows[ROWS])
{
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        rows[i] =
            y < v->height ? ntp__at_mut(v->to, 0, y) : v->zeros + (size_t) part * (size_t) v->width;
        if (y >= v->height)
            memset(rows[i], 0, (size_t) v->width * sizeof(float));
    }
}

static void multiply(double *line, const float *by, int32_t n)
{
    for (int32_t x = 0; x < n; x++)
        line[x] *= (double) by[x];
}

/* The right-hand side of a texel that counts half is twice as much. */
static void take_row(const ntp__inverse *v, double *line, int32_t y)
{
    const double *from = v->from + (size_t) y * (size_t) v->width;
    bool end = v->across.fft.kind == NTP__FFT_MIRROR && (y == 0 || y == v->height - 1);
    for (int32_t x = 0; x < v->width; x++)
        line[x] = end ? 2 * from[x] : from[x];
    if (v->scale != NULL)
        multiply(line, v->scale + (size_t) y * (size_t) v->width, v->width);
    if (v->along.fft.kind == NTP__FFT_MIRROR) {
        line[0] *= 2;
        line[v->width - 1] *= 2;
    }
}

static void forward_rows(void *job, int32_t part, int32_t item)
{
    ntp__inverse *v = job;
    float *rows[ROWS];
    size_t width = (size_t) v->width;
    rows_of(v, part, item, rows);
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        double *line = ntp__fft_line(&v->along.fft, v->work[part], i);
        if (y < v->height)
            take_row(v, line, y);
        else
            memset(line, 0, width * sizeof *line);
    }
    v->along.fft.loops->forward(&v->along.fft, rows, v->work[part]);
}

static void inverse_rows(void *job, int32_t part, int32_t item)
{
    ntp__inverse *v = job;
    float *rows[ROWS];
    rows_of(v, part, item, rows);
    v->along.fft.loops->inverse(&v->along.fft, rows, v->work[part]);
    for (int32_t i = 0; i < ROWS && v->scale != NULL; i++) {
        int32_t y = item * ROWS + i;
        for (int32_t x = 0; x < v->width && y < v->height; x++)
            rows[i][x] *= v->scale[(size_t) y * (size_t) v->width + (size_t) x];
    }
}

typedef struct group {
    const ntp__inverse *v;
    int32_t x0;
} group;

/* The inverse of what the normal equations multiply element (x, y) of the transform by. */
static double factor_of(const ntp__inverse *v, int32_t x, int32_t y)
{
    const ntp__gains *gx = &v->along.gains[x], *gy = &v->across.gains[y];
    double right = gx->along[0] * gy->across[0] + gx->along[1] * gy->across[1];
    double down = gx->across[0] * gy->along[0] + gx->across[1] * gy->along[1];
    double rough = v->share_x * v->along.edge[x] + v->share_y * v->across.edge[y];
    double sum = v->strength * rough + v->prior * rough * rough;
    sum += v->rows ? v->share_x * right * right + v->share_y * down * down : 0;
    return (x > 0 || y > 0) && sum > 0 ? 1 / sum : 0;
}

static void factors(const void *user, int32_t y, double factor[ROWS])
{
    const group *g = user;
    for (int32_t i = 0; i < ROWS; i++)
        factor[i] = g->x0 + i < g->v->width ? factor_of(g->v, g->x0 + i, y) : 0;
}

static void columns(void *job, int32_t part, int32_t item)
{
    ntp__inverse *v = job;
    group g = { v, item * ROWS };
    int32_t left = v->width - g.x0;
    v->across.fft.loops->filter(&v->across.fft, ntp__at_mut(v->to, g.x0, 0),
                                v->to->row_stride / (ptrdiff_t) sizeof(float),
                                left < ROWS ? left : ROWS, factors, &g, v->work[part]);
}

void ntp__inverse_apply(ntp__inverse *v, const ntp_image *to, const double *from)
{
    int32_t batches = (v->height + ROWS - 1) / ROWS, groups = (v->width + ROWS - 1) / ROWS;
    v->to = to;
    v->from = from;
    ntp__crew_each(&v->crew, forward_rows, v, batches);
    ntp__crew_each(&v->crew, columns, v, groups);
    ntp__crew_each(&v->crew, inverse_rows, v, batches);
}

/* ---------------------------------------------------------------------------------- scale */

enum { REACH = 2, PASSES = 2 }; /* of the mean over neighbors */

typedef struct smoothing {
    const ntp__inverse *v;
    float *plane, *work;
} smoothing;

/* Where an index beyond an end lies: on the other side, or at the end. */
static size_t place(const ntp__spectrum *axis, int32_t i, int32_t n)
{
    if (axis->fft.kind == NTP__FFT_REAL)
        return (size_t) (((i % n) + n) % n);
    return (size_t) (i < 0 ? 0 : i < n ? i : n - 1);
}

static void smooth_row(void *job, int32_t part, int32_t y)
{
    smoothing *s = job;
    int32_t width = s->v->width;
    const float *from = s->plane + (size_t) y * (size_t) width;
    float *to = s->work + (size_t) y * (size_t) width;
    (void) part;
    for (int32_t x = 0; x < width; x++) {
        float sum = 0;
        for (int32_t k = -REACH; k <= REACH; k++)
            sum += from[place(&s->v->along, x + k, width)];
        to[x] = sum / (2 * REACH + 1);
    }
}

static void smooth_column(void *job, int32_t part, int32_t y)
{
    smoothing *s = job;
    size_t width = (size_t) s->v->width;
    float *to = s->plane + (size_t) y * width;
    (void) part;
    memset(to, 0, width * sizeof *to);
    for (int32_t k = -REACH; k <= REACH; k++) {
        const float *from = s->work + place(&s->v->across, y + k, s->v->height) * width;
        for (size_t x = 0; x < width; x++)
            to[x] += from[x] / (2 * REACH + 1);
    }
}

void ntp__inverse_scale(ntp__inverse *v, float *scale, float *work)
{
    smoothing s = { v, scale, work };
    for (int32_t i = 0; i < PASSES; i++) {
        ntp__crew_each(&v->crew, smooth_row, &s, v->height);
        ntp__crew_each(&v->crew, smooth_column, &s, v->height);
    }
    for (size_t i = 0; i < (size_t) v->width * (size_t) v->height; i++) {
        float eighth = sqrtf(sqrtf(sqrtf(scale[i])));
        scale[i] = 1 / (eighth * eighth * eighth);
    }
    v->scale = scale;
}
