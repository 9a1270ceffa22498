/* SPDX-License-Identifier: MIT */
/*
 * between.c - do slopes lie between texels, where damage or smooth ground hides the kernel?
 *
 * The derivative u of p down the picture is the derivative v of q to the right, at the same place.
 * Forward slopes p lie half a texel to the right of their texel, and q half a texel below it.  So u of
 * a texel is v half a texel to the right and half a texel up; for all other kernels it is v of that
 * texel.  So u - v is a part of the derivative of both to the right and up, and least squares tell which:
 * the products of the two are summed, and those of the derivative of u with that of v.
 *
 * Damage does not move it.  Errors of p and q that have nothing in common add to none of these sums
 * on average, and errors that are alike in each texel cancel in u - v.  They have the finest detail,
 * so that is filtered out.
 *
 * On smooth ground half a texel changes little, and errors hide it.  The same is then done with slopes
 * of half the size, the means of 2 x 2 texels: that filter lets less of the errors through.  Rough
 * ground has detail that these means bend, so they count only where nearly none is left.
 */
#include "detect/between.h"

#include "base/cpu.h"
#include "detect/between_loops_tmpl.h"
#include "detect/filter.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

enum {
    POINTS = BETWEEN_POINTS,
    PATCHES = 8, /* along a side of the picture */
    CELL = BETWEEN_CELL,
    CELLS = (POINTS / CELL) * (POINTS / CELL),
    MOVED = BETWEEN_MOVED,
    SMOOTH = 5,
    STEEP = SMOOTH + 2,
    SIDE = BETWEEN_SIDE, /* MOVED + STEEP - 1 */
    REACH = (SIDE - POINTS) / 2,
    WIDE = BETWEEN_STEP, /* on smooth ground */
    BORDER = 2           /* slopes nearer to an edge may come from a border */
};

/* A binomial, and central differences after it. */
static const float smooth[SMOOTH] = { 1 / 16.0F, 4 / 16.0F, 6 / 16.0F, 4 / 16.0F, 1 / 16.0F };
static const float steep[STEEP] = { -1 / 32.0F, -4 / 32.0F, -5 / 32.0F, 0,
                                    5 / 32.0F,  4 / 32.0F,  1 / 32.0F };

/* Cells count alike, but those with little in them less: a few edges do not decide. */
static const double LITTLE = 0.5; /* of the mean square */
/* Of the way to slopes between texels.  In textures made smaller by two it is half as long, and
 * `forward` suits them no less than others. */
static const double LEAST_WAY = 0.4;
/* By chance all cells together are so far ahead, in standard errors, on one map in 160.  Further off than
 * any slopes is what errors make of ground that shows nothing. */
static const double CLEARLY = 2.5, FAR = 5;
/* Ground is smooth where u and v of neighbors are alike: their products then come near to the squares.
 * Of ground with a spectrum of 1 / f^2.2 they have 0.75, and of noise less. */
static const double ALIKE = 0.875;

typedef struct patch {
    float p[SIDE][SIDE], q[SIDE][SIDE]; /* slopes */
    float half[SIDE][SIDE];
    float u[MOVED][MOVED], v[MOVED][MOVED];
    ntp__block block;
} patch;

/* Of a cell: twice the products of u - v and how much u + v rises to the right and up; those of what u and
 * v rise, which are as many with slopes between texels; of neighbors; and of the same texel the squares. */
typedef struct tally {
    double ahead, rise, both, square;
} tally;

static void sum_slopes(float *p, float *q, const ntp__block *b, int32_t m, float sign, int32_t step)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__sum_slopes_avx2(p, q, b, m, sign, step);
        return;
    }
#endif
    ntp__sum_slopes(p, q, b, m, sign, step);
}

/* Reads the slopes around the points, from (x, y) on, as sums of step x step texels; false: some texels
 * may hold no normal. */
static bool read_patch(patch *a, const ntp_const_image *src, int32_t x, int32_t y, int32_t step)
{
    int32_t m = ntp__max(src->type), side = SIDE * step;
    float sign = src->y == NTP_Y_UP ? 1 : -1;
    memset(a->p, 0, sizeof a->p);
    memset(a->q, 0, sizeof a->q);
    for (int32_t j = 0; j < side; j++) {
        ntp__unpack(&a->block, src, x, y + j, side);
        if (ntp__any_suspect(&a->block, side, m))
            return false;
        sum_slopes(a->p[j / step], a->q[j / step], &a->block, m, sign, step);
    }
    return true;
}

/* The derivatives.  Here [j][i] is row j - 1 and column i - 1 of the points. */
static void differentiate(patch *a)
{
    enum { WITHIN = (STEEP - SMOOTH) / 2 };
    for (int32_t j = 0; j < MOVED; j++) {
        ntp__filter(a->half[j], a->p[j], SIDE, steep, STEEP, false, SIDE);
        ntp__filter(a->u[j], a->half[j] + WITHIN, 1, smooth, SMOOTH, false, MOVED);
    }
    for (int32_t j = 0; j < MOVED; j++) {
        ntp__filter(a->half[j], a->q[j + WITHIN], SIDE, smooth, SMOOTH, false, SIDE);
        ntp__filter(a->v[j], a->half[j], 1, steep, STEEP, false, MOVED);
    }
}

/* Adds CELL rows of points to the cells beside each other. */
static void sum_up(tally *cells, const patch *a, int32_t first)
{
    ntp__products sums;
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        ntp__sum_products_avx2(&sums, a->u + first, a->v + first);
    else
#endif
        ntp__sum_products(&sums, a->u + first, a->v + first);
    for (int32_t i = 0; i < POINTS; i++) {
        tally *t = &cells[i / CELL];
        t->ahead += (double) sums.ahead[i];
        t->rise += (double) sums.rise[i];
        t->both += (double) sums.both[i];
        t->square += (double) sums.square[i];
    }
}

static bool decide(const tally *t, int32_t count, int32_t step)
{
    double all = 0, ahead = 0, rise = 0, both = 0, square = 0, spread = 0;
    for (int32_t i = 0; i < count; i++)
        all += t[i].square;
    if (!(all > 0))
        return false;
    for (int32_t i = 0; i < count; i++) {
        double weight = 1 / (t[i].square + LITTLE * all / count), part = weight * t[i].ahead;
        ahead += part;
        spread += part * part;
        rise += weight * t[i].rise;
        both += weight * t[i].both;
        square += weight * t[i].square;
    }
    if (step > 1 && both < ALIKE * square)
        return false;
    return ahead * step > LEAST_WAY * rise && ahead * step < FAR * rise &&
           ahead * ahead > CLEARLY * CLEARLY * spread;
}

static bool lie_between(const ntp_const_image *src, int32_t step)
{
    tally cells[PATCHES * PATCHES * CELLS];
    patch a;
    int32_t count = 0, points = POINTS * step, edge = REACH * step + BORDER;
    memset(cells, 0, sizeof cells);
    int32_t across = src->width - 2 * edge - points, down = src->height - 2 * edge - points;
    if (across < 0 || down < 0)
        return false;
    int32_t columns = across / points + 1, rows = down / points + 1;
    columns = columns < PATCHES ? columns : PATCHES;
    rows = rows < PATCHES ? rows : PATCHES;
    for (int32_t i = 0; i < columns * rows; i++) {
        int32_t x = columns > 1 ? (int32_t) ((int64_t) across * (i % columns) / (columns - 1)) : 0;
        int32_t y = rows > 1 ? (int32_t) ((int64_t) down * (i / columns) / (rows - 1)) : 0;
        if (!read_patch(&a, src, BORDER + x, BORDER + y, step))
            continue;
        differentiate(&a);
        for (int32_t j = 0; j < POINTS; j += CELL, count += POINTS / CELL)
            sum_up(&cells[count], &a, j);
    }
    return decide(cells, count, step);
}

bool ntp__lie_between(const ntp_const_image *src)
{
    return lie_between(src, 1) || lie_between(src, WIDE);
}
