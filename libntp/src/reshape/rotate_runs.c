/* SPDX-License-Identifier: MIT */
/*
 * rotate_runs.c - turning a texture by any angle, many texels at a time
 *
 * Doubles decide nearly all texels, many at a time.  Weights and places are exact in them.  So are sums of
 * levels, and of levels of 8 bit times alpha: they have less than 53 bits.  A turn then is off by 2^-50 of the
 * length of (x, y), which is far less than kernels ask for; those leave what is near a boundary to the integers.
 * Sums of 16 bit times alpha are off by less than 2^-48 of what the weights add up to.  Their sign of z, and their
 * direction, are good enough unless they are far shorter than that.
 */
#include "base/inlining.h"
#include "reshape/rotation.h"
#include "stencil/border.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

enum { STEP = NTP__ROTATED_AT_ONCE };

typedef ntp__rotation job;

/* Places along one axis. */
typedef struct axis {
    int64_t from, step; /* twice the way from the center of the picture, turned back */
    bool flip;
    ntp_border border;
    int32_t side, first, n; /* of the picture; of it src has n from the first on */
    int32_t ring;
    ptrdiff_t stride;
} axis;

/* Where index i of the picture lies in src. */
static int32_t inside(const axis *a, int64_t i, bool is_part)
{
    if (is_part)
        i = i - a->first < 0 ? 0 : i - a->first < a->n ? i - a->first : a->n - 1;
    else if (i < 0 || i >= a->side)
        i = ntp__border_map(a->border, (int32_t) i, a->side).index[0];
    return (int32_t) i;
}

static void find_axis(const axis *a, bool is_part, ptrdiff_t at[2][STEP], double share[2][STEP],
                      int32_t n)
{
    const int32_t drop = NTP__UNIT_BITS + 1 - NTP__PLACE_BITS;
    int64_t from = a->from;
    for (int32_t i = 0; i < n; i++, from += a->step) {
        int64_t place =
            (a->flip ? -from : from) + (a->side - (int64_t) 1) * ((int64_t) 1 << NTP__UNIT_BITS);
        place = (place + ((int64_t) 1 << (drop - 1))) >> drop;
        const double beyond = (double) (place & (NTP__ONE_TEXEL - 1)) / NTP__ONE_TEXEL;
        share[0][i] = 1 - beyond;
        share[1][i] = beyond;
        for (int32_t k = 0; k < 2; k++)
            at[k][i] = ntp__ring_row(a->ring, inside(a, (place >> NTP__PLACE_BITS) + k, is_part)) *
                       a->stride;
    }
}

static void find_places(const job *j, ntp__places *p, int32_t x, int32_t y, int32_t n)
{
    const ntp_part *part = &j->part;
    const ntp_const_image *src = j->src;
    const int64_t u = 2 * (int64_t) x + 1 - part->width, v = 2 * (int64_t) y + 1 - part->height;
    const int64_t c = j->turn.cosine, s = j->turn.sine;
    const axis axes[2] = {
        { c * u + s * v, 2 * c, j->how->flip_x, j->how->border_x, part->width, part->src_x,
          src->width, 0, src->pixel_stride },
        { c * v - s * u, -2 * s, j->how->flip_y, j->how->border_y, part->height, part->src_y,
          src->height, src->ring_rows, src->row_stride },
    };
    for (int32_t k = 0; k < 2; k++)
        find_axis(&axes[k], j->how->part != NULL, p->at[k], p->share[k], n);
}

/* The sums of the four texels around each place. */
typedef struct run {
    ntp__places places;
    struct {
        double c[3][STEP], weight[STEP], alpha[STEP], extra[STEP];
    } sum;
} run;

#define COPY(AT, SIZE)                                                                             \
    for (int32_t i = 0; i < n; i++)                                                                \
    memcpy(to + size * i + (AT), from + column[i] + row[i] + (AT), SIZE)

/* Reads the texels of one side of the places as if they lay side by side. */
static void read_texels(const job *j, ntp__block *block, const ptrdiff_t *column,
                        const ptrdiff_t *row, int32_t n)
{
    float texels[4 * STEP];
    char *to = (char *) texels;
    const char *from = j->src->data;
    const ptrdiff_t size = j->src->channels * ntp__sample_size(j->src->type);
    ntp_const_image view = *j->src;
    view.data = texels;
    view.pixel_stride = size;
    view.ring_rows = 0;
    if (size == 3)
        COPY(0, 3);
    else if (size == 6)
        COPY(0, 6);
    else if (size == 2)
        COPY(0, 2);
    for (ptrdiff_t k = 0; size % 4 == 0 && k < size; k += 4)
        COPY(k, 4);
    ntp__unpack(block, &view, 0, 0, n);
}

/* Adds one of the four texels around each place.  What is beyond n is not looked at later. */
ONE_COPY static void add_texels(const job *j, run *restrict r, int32_t right, int32_t below,
                                int32_t n)
{
    ntp__block block;
    ntp__vectors v;
    double w[STEP];
    const double by_alpha = j->by_alpha ? 1 : 0, always = 1 - by_alpha;
    read_texels(j, &block, r->places.at[0][right], r->places.at[1][below], n);
    ntp__block_vectors(&v, &block, n, j->m, j->src->encoding);
    for (int32_t i = 0; i < STEP; i++) {
        const double share = r->places.share[0][right][i] * r->places.share[1][below][i];
        const double alpha = block.c[3][i];
        r->sum.alpha[i] += share * alpha;
        w[i] = share * (by_alpha * alpha + always);
    }
    const bool suspect = ntp__any_suspect(&block, n, j->m);
    for (int32_t i = 0; suspect && i < n; i++) {
        if (ntp__texel_unused(&block, i, j->m, j->how->touch_unused))
            w[i] = 0;
    }
    for (int32_t i = 0; i < STEP; i++) {
        r->sum.c[0][i] += w[i] * v.c[0][i];
        r->sum.c[1][i] += w[i] * v.c[1][i];
        r->sum.c[2][i] += w[i] * v.c[2][i];
        r->sum.weight[i] += w[i];
        r->sum.extra[i] += w[i] * block.c[2][i];
    }
}

/* Turns the sums. */
static void turn_sums(const job *j, ntp__vectors *restrict v, const run *restrict r)
{
    const double strength = ntp__strength_value(&j->strength) * 0x1p-30; /* and that of sines */
    const double cosine = (double) j->turn.cosine * strength;
    const double sine =
        (double) (j->src->y == NTP_Y_DOWN ? -j->turn.sine : j->turn.sine) * strength;
    /* of x and y of the sums, each */
    const double cx = j->how->flip_x ? -cosine : cosine, sx = j->how->flip_x ? -sine : sine;
    const double cy = j->how->flip_y ? -cosine : cosine, sy = j->how->flip_y ? -sine : sine;
    for (int32_t i = 0; i < STEP; i++) {
        const double x = r->sum.c[0][i], y = r->sum.c[1][i];
        v->c[0][i] = cx * x + sy * y;
        v->c[1][i] = cy * y - sx * x;
        v->c[2][i] = r->sum.c[2][i];
    }
}

/* The third sample where it is no component of a vector; exact, but where in doubt. */
SELDOM static void find_extra(const job *j, ntp__block *out, int32_t *doubt, const run *r,
                              int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        const double level =
            r->sum.weight[i] > 0 ? r->sum.extra[i] / r->sum.weight[i] + 0.5 : j->m + 0.5;
        const int32_t near = (int32_t) (level + 0.5);
        out->c[2][i] = (int32_t) level;
        doubt[i] |= level - near < 0x1p-20 && near - level < 0x1p-20 ? NTP__IN_DOUBT : 0;
    }
}

static bool exact_sums(const job *j)
{
    return !j->by_alpha || j->m == 255;
}

/* Those whose sums are too inexact are in doubt, too. */
SELDOM static void doubt_short(const job *j, int32_t *doubt, const ntp__vectors *v, const run *r,
                               int32_t n)
{
    const double s = ntp__strength_value(&j->strength), most = s * s > 1 ? s * s : 1;
    for (int32_t i = 0; i < n; i++) {
        const double x = v->c[0][i], y = v->c[1][i], z = v->c[2][i];
        const double least = r->sum.weight[i] * r->sum.weight[i]; /* M * 2^-16 is 1 */
        if (!(z * z >= least && x * x + y * y + z * z >= least * most))
            doubt[i] = NTP__IN_DOUBT;
    }
}

static bool same_sums(const run *r, int32_t i, int32_t k)
{
    return r->sum.c[0][i] == r->sum.c[0][k] && r->sum.c[1][i] == r->sum.c[1][k] &&
           r->sum.c[2][i] == r->sum.c[2][k] && r->sum.weight[i] == r->sum.weight[k] &&
           r->sum.extra[i] == r->sum.extra[k];
}

/* Does again what is in doubt. */
SELDOM static void settle(const job *j, ntp__block *out, const int32_t *doubt, const run *r,
                          int32_t n)
{
    int32_t last = -1; /* flat ones are always in doubt at some angles */
    for (int32_t i = 0; i < n; i++) {
        if (!doubt[i])
            continue;
        const bool again = exact_sums(j) && last >= 0 && same_sums(r, i, last);
        for (int32_t k = 0; again && k < 3; k++)
            out->c[k][i] = out->c[k][last];
        if (!again)
            ntp__rotate_texel(j, out, &r->places, i);
        last = i;
    }
}

/* The levels of n texels from (x, y) of the picture on. */
static void rotate_run(const job *j, ntp__block *out, int32_t x, int32_t y, int32_t n)
{
    run r;
    ntp__vectors v;
    int32_t doubt[NTP__BLOCK];
    memset(&r.sum, 0, sizeof r.sum);
    find_places(j, &r.places, x, y, n);
    for (int32_t k = 0; k < 4; k++)
        add_texels(j, &r, k % 2, k / 2, n);
    turn_sums(j, &v, &r);
    ntp__block_directions(out, doubt, &v, n, j->m, j->src->encoding, false);
    if (j->src->encoding == NTP_ENCODING_XY)
        find_extra(j, out, doubt, &r, n);
    if (!exact_sums(j))
        doubt_short(j, doubt, &v, &r, n);
    const bool keep_clear = !(j->how->touch_unused & NTP_UNUSED_TRANSPARENT);
    for (int32_t i = 0; i < n; i++)
        out->c[3][i] = r.sum.weight[i] == 0 && keep_clear ? 0 : (int32_t) (r.sum.alpha[i] + 0.5);
    settle(j, out, doubt, &r, n);
}

void ntp__rotate(const ntp_image *dst, const ntp_const_image *src, const ntp_transform_options *how,
                 ntp__strength strength, int64_t ticks, const ntp_rect *area)
{
    const ntp_part whole = { src->width, src->height, 0, 0, 0, 0 };
    const job j = { .dst = dst,
                    .src = src,
                    .how = how,
                    .strength = strength,
                    .turn = ntp__turn_of(ticks),
                    .part = how->part != NULL ? *how->part : whole,
                    .m = ntp__max(src->type),
                    .extra = src->encoding == NTP_ENCODING_XY && src->channels >= 3,
                    .by_alpha =
                        src->channels == 4 && !(how->touch_unused & NTP_UNUSED_TRANSPARENT) };
    ntp__block out;
    for (int32_t y = area->y0; y < area->y1; y++) {
        for (int32_t x = area->x0; x < area->x1; x += STEP) {
            const int32_t n = area->x1 - x < STEP ? area->x1 - x : STEP;
            rotate_run(&j, &out, x + j.part.dst_x, y + j.part.dst_y, n);
            ntp__store_levels(dst, &out, x, y, n);
        }
    }
}
