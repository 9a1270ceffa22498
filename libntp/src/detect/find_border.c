/* SPDX-License-Identifier: MIT */
/*
 * find_border.c - which border the normals at the edges of a texture were made with
 *
 * The heights were found without regard to the slopes at the edges, so these slopes can tell.  Each
 * border makes normals from the heights there, and the one that gives back the stored normals is
 * the answer.  Lines along an edge are taken in stretches.  Columns are the rows of the transposed
 * picture.
 */
#include "texel/unused.h"
#include "stencil/taps.h"
#include "base/view.h"

#include <math.h>

enum {
    HALO = NTP__MAX_RADIUS,
    STRIP = 2 * HALO + 2, /* lines at an edge, enough for every kernel and border */
    STRETCH = 64,
    LONG = STRETCH + 2 * HALO,
    LEAST_SIDE = 16
};

/* Normals of the right border may be off by so many levels of 8 bit, as a root mean square. */
static const double most_error = 3;
/* A border that fits nearly as well as the best one is as good. */
static const double nearly = 1.25, nearly_levels = 0.05;
/* Noise at the edges does not rule out a texture that tiles. */
static const double much_worse = 1.5;

/* Two opposite edges.  Rows of the turned views run along them. */
typedef struct edges {
    const ntp_const_image *src;
    ntp_const_image turned, heights;
    ntp_normals_options how;
    uint32_t touch;
    bool down;   /* they are the upper and the lower edge: nothing is turned */
    float drift; /* of the heights from one edge to the other */
} edges;

static ntp_const_image turn(const ntp_const_image *view, bool down)
{
    return down ? *view : ntp__transposed(view);
}

static double height_at(const edges *e, int32_t line, int32_t i)
{
    return (double) *(const float *) ntp__at(&e->heights, i, line);
}

/* The mean step across the seam, less what steps beside it make expect.  Slopes of most kernels span
 * two texels, and so do the steps then: even and odd heights may lie apart. */
static double find_drift(const edges *e)
{
    enum { SIDE = 4 };
    double sum = 0;
    int32_t last = e->heights.height - 1, n = e->heights.width;
    for (int32_t i = 0; i < n; i++) {
        double h[2 * SIDE], *seam = h + SIDE; /* heights before the seam, and after it */
        for (int32_t k = 0; k < SIDE; k++) {
            h[k] = height_at(e, last + 1 - SIDE + k, i);
            seam[k] = height_at(e, k, i);
        }
        double over = seam[0] - seam[-2] + seam[1] - seam[-1];
        double beside = seam[2] - seam[0] + seam[-1] - seam[-3];
        double next = seam[3] - seam[1] + seam[-2] - seam[-4];
        if (e->how.kernel == NTP_KERNEL_FORWARD)
            sum += seam[0] - seam[-1] - (seam[1] - seam[0] + seam[-1] - seam[-2]) / 2;
        else /* the parabola through slopes at 3/2 and 5/2 texels from the seam, at 1/2 of one */
            sum += (over - 1.5 * beside + 0.5 * next) / 2;
    }
    return sum / n;
}

/* A stretch of the lines at an edge: heights, and the normals of one line. */
typedef struct stretch {
    float heights[STRIP * LONG];
    float normals[STRIP * LONG * 4]; /* of any type */
    ntp__block made, stored;
} stretch;

/* Copies lines at the first edge or the last one, from texel `first` on.  wrapped: the last lines
 * and then the first ones, less the drift. */
static void copy_heights(stretch *s, const edges *e, bool wrapped, bool last, int32_t first,
                         int32_t n)
{
    int32_t lines = e->heights.height;
    for (int32_t k = 0; k < STRIP; k++) {
        bool before = wrapped && k < STRIP / 2;
        int32_t line = last ? lines - STRIP + k : k;
        float drift = wrapped && !before ? e->drift : 0;
        if (wrapped)
            line = before ? lines - STRIP / 2 + k : k - STRIP / 2;
        for (int32_t i = 0; i < n; i++)
            s->heights[k * n + i] = (float) height_at(e, line, first + i) - drift;
    }
}

/* Makes normals of line `at` of a stretch of n texels, without the halos, and unpacks them. */
static ntp_status make_normals(stretch *s, const edges *e, ntp_border border, int32_t at, int32_t n)
{
    const ntp_const_image *src = e->src;
    ntp_normals_options how = e->how;
    ntp_image heights = ntp_image_packed(s->heights, n, STRIP, 1, NTP_TYPE_F32);
    ntp_image normals = ntp_image_packed(s->normals, n, STRIP, src->channels, src->type);
    ntp_const_image packed = ntp_image_as_const(&heights), made = ntp_image_as_const(&normals);
    ntp_const_image from = turn(&packed, e->down), to = turn(&made, e->down);
    ntp_rect row = { HALO, at, n - HALO, at + 1 }, column = { at, HALO, at + 1, n - HALO };
    made.encoding = src->encoding;
    normals.encoding = src->encoding;
    normals.y = src->y;
    normals.width = to.width;
    normals.height = to.height;
    normals.row_stride = to.row_stride;
    normals.pixel_stride = to.pixel_stride;
    how.border_x = how.border_y = border;
    NTP__TRY(ntp_normals_from_height(&normals, &from, &how, NULL, e->down ? &row : &column));
    ntp__unpack(&s->made, &made, HALO, at, n - 2 * HALO);
    return NTP_OK;
}

typedef struct squares {
    double sum;
    int64_t count;
} squares;

static void compare(squares *total, stretch *s, const edges *e, int32_t line, int32_t first,
                    int32_t n)
{
    int32_t m = ntp__max(e->src->type);
    ntp__unpack(&s->stored, &e->turned, first, line, n);
    for (int32_t i = 0; i < n; i++) {
        if (ntp__texel_unused(&s->stored, i, m, e->touch))
            continue;
        double x = s->stored.c[0][i] - s->made.c[0][i], y = s->stored.c[1][i] - s->made.c[1][i];
        total->sum += x * x + y * y;
        total->count += 2;
    }
}

/* The root mean square error of both edges, in levels of 8 bit; negative: it cannot be told. */
static double error_of(const edges *e, ntp_border border)
{
    stretch s;
    squares total = { 0, 0 };
    int32_t lines = e->turned.height, length = e->turned.width;
    bool wrapped = border == NTP_BORDER_WRAP;
    for (int32_t end = 0; end < 2; end++) {
        bool last = end == 1;
        int32_t at = wrapped ? STRIP / 2 - end : last ? STRIP - 1 : 0;
        /* Texels at the ends depend on the border of the other axis too. */
        for (int32_t i = HALO; i < length - HALO; i += STRETCH) {
            int32_t n = length - HALO - i < STRETCH ? length - HALO - i : STRETCH;
            copy_heights(&s, e, wrapped, last, i - HALO, n + 2 * HALO);
            if (make_normals(&s, e, wrapped ? NTP_BORDER_CLAMP : border, at, n + 2 * HALO) !=
                NTP_OK)
                return -1;
            compare(&total, &s, e, last ? lines - 1 : 0, i, n);
        }
    }
    double level = e->src->type == NTP_TYPE_U8 ? 1 : 257;
    return total.count > 0 ? sqrt(total.sum / (double) total.count) / level : -1;
}

ntp_border ntp_free_border(ntp_kernel kernel)
{
    return kernel == NTP_KERNEL_FORWARD ? NTP_BORDER_CLAMP : NTP_BORDER_MIRROR;
}

/* Chooses the border that fits; of those that fit alike, the one that the whole texture
 * suggests. */
static void choose(ntp_border_fit *fit, bool wraps, ntp_kernel kernel)
{
    const double *error = fit->error;
    ntp_border likely = wraps ? NTP_BORDER_WRAP : NTP_BORDER_EXTRAPOLATE;
    int32_t best = -1;
    for (int32_t b = 0; b < NTP_BORDERS; b++) {
        if (error[b] >= 0 && (best < 0 || error[b] < error[best]))
            best = b;
    }
    fit->decided = 1;
    if (best >= 0 && error[best] <= most_error) {
        bool as_good = error[likely] >= 0 && error[likely] <= nearly * error[best] + nearly_levels;
        fit->border = as_good ? likely : (ntp_border) best;
    } else if (wraps && error[NTP_BORDER_WRAP] >= 0 &&
               error[NTP_BORDER_WRAP] <= much_worse * error[best]) {
        fit->border = NTP_BORDER_WRAP;
    } else {
        fit->border = ntp_free_border(kernel);
        fit->decided = 0;
    }
}

/* Can heights be made with this border at all edges? */
static bool is_solved(const ntp_height_options *how, const ntp_const_image *src, ntp_border border)
{
    ntp_height_options with = *how;
    with.border_x = with.border_y = border;
    return ntp_height_scratch_size(&with, src->width, src->height, 1) > 0;
}

ntp_status ntp_find_border(ntp_border_fit *fit, const ntp_const_image *src,
                           const ntp_const_image *heights, const ntp_height_options *how,
                           int32_t down, int32_t wraps)
{
    if (fit == NULL || how == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_view(heights));
    if (heights->encoding != NTP_ENCODING_HEIGHT || heights->type != NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(src, heights) || src->ring_rows != 0 || heights->ring_rows != 0)
        return NTP_ERR_SHAPE;
    edges e = { .src = src,
                .turned = turn(src, down != 0),
                .heights = turn(heights, down != 0),
                .how = { .scale = 1, .dx = how->dx, .dy = how->dy, .kernel = how->kernel },
                .touch = how->touch_unused,
                .down = down != 0 };
    if (how->touch_unused > NTP_UNUSED_ALL || (int) how->method < NTP_HEIGHT_AUTO ||
        (int) how->method > NTP_HEIGHT_WEIGHTED ||
        (how->kernel != NTP_KERNEL_BAKED && ntp_normals_reach(&e.how) < 0))
        return NTP_ERR_ARGUMENT;
    if (src->encoding == NTP_ENCODING_VECTOR) /* of any length, so (2, 2, 2) is no padding */
        e.touch |= NTP_UNUSED_BLACK | NTP_UNUSED_WHITE;
    for (int32_t b = 0; b < NTP_BORDERS; b++)
        fit->error[b] = -1;
    if (src->width < LEAST_SIDE || src->height < LEAST_SIDE || how->kernel == NTP_KERNEL_BAKED) {
        fit->border = wraps ? NTP_BORDER_WRAP : ntp_free_border(how->kernel);
        fit->decided = wraps != 0;
        return NTP_OK;
    }
    e.drift = wraps ? (float) find_drift(&e) : 0;
    for (int32_t b = 0; b < NTP_BORDERS; b++) {
        if (is_solved(how, src, (ntp_border) b))
            fit->error[b] = error_of(&e, (ntp_border) b);
    }
    choose(fit, wraps != 0, how->kernel);
    return NTP_OK;
}
