/* SPDX-License-Identifier: MIT */
/*
 * precondition.c - the preconditioner of weighted least squares
 *
 * Without weights, holes and ends the normal equations are diagonal in frequencies.  The diagonal
 * is the squared gains of the stencil plus those of the pairs.  So the equations are solved by a
 * Fourier (wrap) or cosine transform along both axes, a division, and the transforms back.  All of
 * it lies in dst.
 */
#include "to_height/weighted/weighted.h"

#include <string.h>

enum { ROWS = NTP__FFT_ROWS };

static ntp__fft_kind kind_of(ntp_border border)
{
    return border == NTP_BORDER_WRAP ? NTP__FFT_REAL : NTP__FFT_COSINE;
}

size_t ntp__spectrum_work(ntp_border border, int32_t n)
{
    return ntp__fft_work_bytes(kind_of(border), n, false);
}

void ntp__spectrum_init(ntp__spectrum *s, ntp__scratch *memory, ntp_kernel kernel,
                        ntp_border border, int32_t n, void *fft_work)
{
    ntp__fft_kind kind = kind_of(border);
    ntp__fft_plan(&s->fft, memory, kind, n, false, fft_work);
    s->gains = ntp__take(memory, (size_t) n * sizeof *s->gains);
    s->edge = ntp__take(memory, (size_t) n * sizeof *s->edge);
    if (memory->base == NULL)
        return;
    for (int32_t i = 0; i < n; i++) {
        /* If the axis wraps, element i has i (or n - i) turns in n texels; else half as many. */
        int64_t whole = kind == NTP__FFT_REAL ? n : 2 * (int64_t) n;
        ntp__gains forward;
        ntp__stencil_gains(&s->gains[i], kernel, i, whole);
        ntp__stencil_gains(&forward, NTP_KERNEL_FORWARD, i, whole);
        s->edge[i] = forward.along[0] * forward.along[0];
    }
}

/* Rows below the last one are zeros, as rounding errors pass between the two rows of a line. */
static void rows_of(const ntp__weighted *w, const ntp__weighted_part *part, int32_t item,
                    float *rows[ROWS])
{
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        rows[i] = y < w->height ? ntp__at_mut(w->dst, 0, y) : part->row;
        if (y >= w->height)
            memset(rows[i], 0, (size_t) w->width * sizeof(float));
    }
}

static void forward_rows(void *job, int32_t index, int32_t item)
{
    ntp__weighted *w = job;
    ntp__weighted_part *part = &w->parts[index];
    float *rows[ROWS];
    rows_of(w, part, item, rows);
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        const double *line = y < w->height ? w->r + ntp__weighted_at(w, y) : part->nothing;
        memcpy(ntp__fft_line(&w->along.fft, part->fft_work, i), line,
               (size_t) w->width * sizeof *line);
    }
    w->along.fft.loops->forward(&w->along.fft, rows, part->fft_work);
}

static void inverse_rows(void *job, int32_t index, int32_t item)
{
    ntp__weighted *w = job;
    float *rows[ROWS];
    rows_of(w, &w->parts[index], item, rows);
    w->along.fft.loops->inverse(&w->along.fft, rows, w->parts[index].fft_work);
}

typedef struct group {
    const ntp__weighted *w;
    int32_t x0;
} group;

/* The inverse of what the normal equations multiply element (x, y) of the transform by. */
static double factor_of(const ntp__weighted *w, int32_t x, int32_t y)
{
    const ntp__gains *gx = &w->along.gains[x], *gy = &w->across.gains[y];
    double right = gx->along[0] * gy->across[0] + gx->along[1] * gy->across[1];
    double down = gx->across[0] * gy->along[0] + gx->across[1] * gy->along[1];
    double sum = w->strength * (w->share_x * w->along.edge[x] + w->share_y * w->across.edge[y]);
    sum += w->rows ? w->share_x * right * right + w->share_y * down * down : 0;
    return (x > 0 || y > 0) && sum > 0 ? 1 / sum : 0;
}

static void factors(const void *user, int32_t y, double factor[ROWS])
{
    const group *g = user;
    for (int32_t i = 0; i < ROWS; i++)
        factor[i] = g->x0 + i < g->w->width ? factor_of(g->w, g->x0 + i, y) : 0;
}

static void columns(void *job, int32_t index, int32_t item)
{
    ntp__weighted *w = job;
    group g = { w, item * ROWS };
    int32_t left = w->width - g.x0;
    w->across.fft.loops->filter(&w->across.fft, ntp__at_mut(w->dst, g.x0, 0),
                                w->dst->row_stride / (ptrdiff_t) sizeof(float),
                                left < ROWS ? left : ROWS, factors, &g, w->parts[index].fft_work);
}

void ntp__weighted_precondition(ntp__weighted *w)
{
    int32_t batches = (w->height + ROWS - 1) / ROWS, groups = (w->width + ROWS - 1) / ROWS;
    ntp__crew_each(&w->crew, forward_rows, w, batches);
    ntp__crew_each(&w->crew, columns, w, groups);
    ntp__crew_each(&w->crew, inverse_rows, w, batches);
}
