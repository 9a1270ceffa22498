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
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

enum { STEP = NTP__ROTATED_AT_ONCE };

typedef ntp__rotation job;

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
    const double xx = j->by[0][0], xy = j->by[0][1], yx = j->by[1][0], yy = j->by[1][1];
    for (int32_t i = 0; i < STEP; i++) {
        const double x = r->sum.c[0][i], y = r->sum.c[1][i];
        v->c[0][i] = xx * x + xy * y;
        v->c[1][i] = yx * x + yy * y;
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

void ntp__rotate_run(const ntp__rotation *j, ntp__block *out, int32_t x, int32_t y, int32_t n)
{
    run r;
    ntp__vectors v;
    int32_t doubt[NTP__BLOCK];
    memset(&r.sum, 0, sizeof r.sum);
    ntp__find_places(j, &r.places, x, y, n);
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
