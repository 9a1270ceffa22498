/* SPDX-License-Identifier: MIT */
/*
 * rotate.c - turning a texture by any angle
 *
 * A texel of the result is made from the four texels around the place that the turn takes to its
 * center.  Their vectors are summed with bilinear weights, turned like the picture, and only the
 * direction of the result is rounded to levels.  Integers say what that is: sines have 30 bits,
 * places 15 bits after the point, so a weight has 30, and a sum of levels times alpha fits in 64.
 * (rotate_runs.c has the same by doubles, where these are sure of it.)
 */
#include "base/cpu.h"
#include "reshape/rotation.h"
#include "stencil/border.h"
#include "texel/level.h"
#include "texel/unused.h"

enum { STRENGTH_ROOM = 60 /* bits of a vector, so that a strength fits beside them */ };

typedef ntp__rotation job;

/* ------------------------------------------------------------------------------ angles */

int64_t ntp__ticks_of(double angle, int32_t quarter_turns)
{
    int64_t circle = 4 * ntp__quarter();
    int64_t ticks = (int64_t) (angle * 0x1p32 + (angle < 0 ? -0.5 : 0.5));
    ticks = (ticks + quarter_turns * ntp__quarter()) % circle;
    return ticks < 0 ? ticks + circle : ticks;
}

/* A product of numbers in units of 2^-62. */
static uint64_t product(uint64_t a, uint64_t b)
{
    return ntp__mul_high(a, b) << 2;
}

/* 1 - s/(k (k + 1)) (1 - s/((k + 2)(k + 3)) (1 - ...)): the cosine of the root of s for k = 1, and
 * for k = 2 its sine over it, good to 2^-58 up to 45 degrees. */
static uint64_t series(uint64_t square, uint64_t k)
{
    const uint64_t one = (uint64_t) 1 << 62;
    const int32_t terms = 9;
    uint64_t sum = one;
    for (int32_t i = terms; i >= 0; i--) {
        const uint64_t n = k + 2 * (uint64_t) i;
        sum = one - product(square, sum) / (n * (n + 1));
    }
    return sum;
}

static int64_t rounded(uint64_t v)
{
    const int32_t drop = 62 - NTP__UNIT_BITS;
    return (int64_t) ((v + ((uint64_t) 1 << (drop - 1))) >> drop);
}

ntp__turn ntp__turn_of(int64_t ticks)
{
    const uint64_t radian = 5151302725743731799u; /* pi / 180 in units of 2^-68 */
    int64_t quarters = ticks / ntp__quarter(), rest = ticks % ntp__quarter();
    bool beyond = 2 * rest > ntp__quarter();
    uint64_t near = (uint64_t) (beyond ? ntp__quarter() - rest : rest); /* up to 45 degrees */
    uint64_t x = ntp__mul_high(near << 26, radian), square = product(x, x);
    int64_t sine = rounded(product(x, series(square, 2))), cosine = rounded(series(square, 1));
    ntp__turn t = { beyond ? sine : cosine, beyond ? cosine : sine };
    for (int64_t i = 0; i < quarters; i++) {
        ntp__turn next = { -t.sine, t.cosine };
        t = next;
    }
    return t;
}

/* ------------------------------------------------------------------------------ places */

void ntp__find_axes(const job *j, ntp__axis axes[2], int32_t x, int32_t y)
{
    const ntp_part *p = &j->part;
    const ntp_const_image *src = j->src;
    /* twice the way from the center of the picture, turned back */
    const int64_t u = 2 * (int64_t) x + 1 - p->width, v = 2 * (int64_t) y + 1 - p->height;
    const int64_t c = j->turn.cosine, s = j->turn.sine;
    axes[0] =
        (ntp__axis) { c * u + s * v, 2 * c, j->how->border_x, p->width, p->src_x, src->width };
    axes[1] =
        (ntp__axis) { c * v - s * u, -2 * s, j->how->border_y, p->height, p->src_y, src->height };
    const bool flip[2] = { j->how->flip_x, j->how->flip_y };
    for (int32_t k = 0; k < 2; k++) {
        ntp__axis *const a = &axes[k];
        a->from = (flip[k] ? -a->from : a->from) +
                  (a->side - (int64_t) 1) * ((int64_t) 1 << NTP__UNIT_BITS) +
                  ((int64_t) 1 << (NTP__DROPPED_BITS - 1));
        a->step = flip[k] ? -a->step : a->step;
    }
}

/* Where index i of the picture lies in src. */
static int32_t inside(const ntp__axis *a, int64_t i, bool is_part)
{
    if (is_part)
        i = i - a->first < 0 ? 0 : i - a->first < a->n ? i - a->first : a->n - 1;
    else if (i < 0 || i >= a->side)
        i = ntp__border_map(a->border, (int32_t) i, a->side).index[0];
    return (int32_t) i;
}

static void find_axis(const ntp__axis *a, bool is_part, ptrdiff_t at[2][NTP__ROTATED_AT_ONCE],
                      double share[2][NTP__ROTATED_AT_ONCE], ptrdiff_t stride, int32_t n)
{
    int64_t from = a->from;
    for (int32_t i = 0; i < n; i++, from += a->step) {
        const int64_t place = from >> NTP__DROPPED_BITS;
        const double beyond = (double) (place & (NTP__ONE_TEXEL - 1)) / NTP__ONE_TEXEL;
        share[0][i] = 1 - beyond;
        share[1][i] = beyond;
        for (int32_t k = 0; k < 2; k++)
            at[k][i] = inside(a, (place >> NTP__PLACE_BITS) + k, is_part) * stride;
    }
}

void ntp__find_places(const job *j, ntp__places *p, int32_t x, int32_t y, int32_t n)
{
    ntp__axis axes[2];
    ntp__find_axes(j, axes, x, y);
    for (int32_t k = 0; k < 2; k++)
        find_axis(&axes[k], j->how->part != NULL, p->at[k], p->share[k],
                  k == 0 ? j->src->pixel_stride : j->src->row_stride, n);
}

/* ------------------------------------------------------------------------------ texels */

typedef struct sums {
    int64_t v[3], weight, alpha, extra;
} sums;

/* Adds one of the four texels. */
static void add_texel(const job *j, sums *s, ptrdiff_t at, int64_t w)
{
    ntp__block one;
    int32_t v[3];
    ntp_const_image view = *j->src;
    view.data = (const char *) view.data + at;
    if (w == 0)
        return;
    ntp__unpack(&one, &view, 0, 0, 1);
    s->alpha += w * one.c[3][0];
    if (ntp__texel_unused(&one, 0, j->m, j->how->touch_unused))
        return;
    if (j->by_alpha)
        w *= one.c[3][0];
    ntp__texel_vector(v, &one, 0, j->m, j->src->encoding);
    s->v[0] += w * (j->how->flip_x ? -v[0] : v[0]);
    s->v[1] += w * (j->how->flip_y ? -v[1] : v[1]);
    s->v[2] += w * v[2];
    s->weight += w;
    s->extra += w * one.c[2][0];
}

/* The four texels around place i. */
static sums around(const job *j, const ntp__places *p, int32_t i)
{
    sums sum = { { 0, 0, 0 }, 0, 0, 0 };
    for (int32_t k = 0; k < 4; k++) {
        const double share = p->share[0][k % 2][i] * p->share[1][k / 2][i];
        add_texel(j, &sum, p->at[0][k % 2][i] + p->at[1][k / 2][i], (int64_t) (share * 0x1p30));
    }
    return sum;
}

static ntp__i128 turned(int64_t a, int64_t by_a, int64_t b, int64_t by_b)
{
    return ntp__i128_add(ntp__i128_multiply(ntp__i128_of(a), by_a),
                         ntp__i128_multiply(ntp__i128_of(b), by_b));
}

void ntp__rotate_texel(const job *j, ntp__block *out, const ntp__places *p, int32_t i)
{
    const sums s = around(j, p, i);
    /* With green down y counts down, as rows do, and the turn is that of the picture. */
    int64_t sine = j->src->y == NTP_Y_DOWN ? -j->turn.sine : j->turn.sine;
    ntp__i128 v[3] = { turned(s.v[0], j->turn.cosine, s.v[1], sine),
                       turned(s.v[1], j->turn.cosine, s.v[0], -sine),
                       ntp__i128_shift(ntp__i128_of(s.v[2]), NTP__UNIT_BITS) };
    int32_t c[3] = { 0, 0, j->m };
    ntp__i128_shorten(v, STRENGTH_ROOM);
    v[0] = ntp__i128_multiply(v[0], j->strength.numerator);
    v[1] = ntp__i128_multiply(v[1], j->strength.numerator);
    v[2] = ntp__i128_shift(v[2], j->strength.shift);
    ntp__direction_levels(c, v, j->m, j->src->encoding);
    const int64_t one = (int64_t) 1 << (2 * NTP__PLACE_BITS);
    const bool none = s.weight == 0;
    if (j->extra && !none)
        c[2] = (int32_t) ((2 * s.extra + s.weight) / (2 * s.weight));
    for (int32_t k = 0; k < 3; k++)
        out->c[k][i] = c[k];
    const bool clear = none && !(j->how->touch_unused & NTP_UNUSED_TRANSPARENT);
    out->c[3][i] = clear ? 0 : (int32_t) ((2 * s.alpha + one) / (2 * one));
}

/* Makes n texels of the result from (x, y) on. */
static void rotate_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    const int32_t px = x + j->part.dst_x, py = y + j->part.dst_y; /* in the picture */
    ntp__block out;
#ifdef NTP_HAVE_AVX2
    if (j->quick) {
        enum { FEW = 6 }; /* as many as take less time than all others, one by one */
        int32_t at[NTP__ROTATED_AT_ONCE];
        const int32_t left = ntp__rotate_rgb_avx2(j, ntp__at_mut(j->dst, x, y), at, px, py, n);
        for (int32_t i = 0; i < left && left <= FEW; i++) {
            ntp__places one;
            ntp__find_places(j, &one, px + at[i], py, 1);
            ntp__rotate_texel(j, &out, &one, 0);
            ntp__store_levels(j->dst, &out, x + at[i], y, 1);
        }
        if (left <= FEW)
            return;
    }
#endif
    ntp__rotate_run(j, &out, px, py, n);
    ntp__store_levels(j->dst, &out, x, y, n);
}

/* Texels of a tile lie near each other in the source, too. */
static void rotate_tiles(const job *j, const ntp_rect *area)
{
    enum { ROWS = 64 };
    for (int32_t y0 = area->y0; y0 < area->y1; y0 += ROWS) {
        const int32_t y1 = area->y1 - y0 < ROWS ? area->y1 : y0 + ROWS;
        for (int32_t x = area->x0; x < area->x1; x += NTP__ROTATED_AT_ONCE) {
            const int32_t n =
                area->x1 - x < NTP__ROTATED_AT_ONCE ? area->x1 - x : NTP__ROTATED_AT_ONCE;
            for (int32_t y = y0; y < y1; y++)
                rotate_run(j, x, y, n);
        }
    }
}

/* How sums are turned, and made stronger. */
static void find_factors(job *j)
{
    const double strength = ntp__strength_value(&j->strength) * 0x1p-30; /* and that of sines */
    const double cosine = (double) j->turn.cosine * strength;
    const double sine =
        (double) (j->src->y == NTP_Y_DOWN ? -j->turn.sine : j->turn.sine) * strength;
    const double x = j->how->flip_x ? -1 : 1, y = j->how->flip_y ? -1 : 1;
    j->by[0][0] = x * cosine;
    j->by[0][1] = y * sine;
    j->by[1][0] = -x * sine;
    j->by[1][1] = y * cosine;
}

void ntp__rotate(const ntp_image *dst, const ntp_const_image *src, const ntp_transform_options *how,
                 ntp__strength strength, int64_t ticks, const ntp_rect *area)
{
    const ntp_part whole = { src->width, src->height, 0, 0, 0, 0 };
    job j = { .dst = dst,
              .src = src,
              .how = how,
              .strength = strength,
              .turn = ntp__turn_of(ticks),
              .part = how->part != NULL ? *how->part : whole,
              .m = ntp__max(src->type),
              .extra = src->encoding == NTP_ENCODING_XY && src->channels >= 3,
              .by_alpha = src->channels == 4 && !(how->touch_unused & NTP_UNUSED_TRANSPARENT) };
    find_factors(&j);
#ifdef NTP_HAVE_AVX2
    j.quick = ntp__can_rotate_rgb(&j) && ntp__cpu_has_avx2(NTP__CPU_ALL);
#endif
    rotate_tiles(&j, area);
}
