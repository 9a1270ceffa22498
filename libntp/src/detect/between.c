/* SPDX-License-Identifier: MIT */
/*
 * between.c - do slopes lie between texels, where damage or smooth ground hides the kernel?
 *
 * The derivative of p down the picture is that of q to the right, at the same place.  Forward slopes
 * p lie half a texel to the right of their texel, and q half a texel below it.  So p is moved to the
 * left by a mean of two neighbors and q up, and the difference of the derivatives is taken; then both
 * are moved the other way.  Errors of the levels add as much to one difference as to the other,
 * whatever made them, as the two are mirror images.  So the two are alike but for forward slopes.
 */
#include "detect/between.h"

#include "texel/level.h"
#include "texel/unused.h"

#include <math.h>
#include <string.h>

enum {
    POINTS = 32, /* a side of a patch */
    PATCHES = 8, /* along a side of the picture */
    REACH = 2,   /* of the taps */
    EDGE = 4,    /* slopes nearer to an edge may come from a border */
    SIDE = POINTS + 2 * REACH,
    BINS = 64, /* of squares, by their power of two */
    LOWEST = 1023 - 48,
    LEAST_COUNT = 1 << 14
};

/* A binomial, and the derivative or the mean after it. */
static const float derivative[5] = { -0.125F, -0.25F, 0, 0.25F, 0.125F };
static const float moved[4] = { 0.125F, 0.375F, 0.375F, 0.125F };

/* Squares beyond so many times the median one count less and less: a few edges do not decide. */
static const double large = 14;
/* Of textures whose slopes lie at their texels, this share of the squares was at most 0.03. */
static const double least_share = 0.06;

typedef struct patch {
    float p[SIDE][SIDE], q[SIDE][SIDE]; /* slopes */
    float half[SIDE][SIDE];
    float down_p[POINTS + 1][POINTS + 1], right_q[POINTS + 1][POINTS + 1];
    ntp__block block;
} patch;

/* Squares, by their power of two. */
typedef struct tally {
    double before[BINS], after[BINS];
    int64_t count[BINS], all;
} tally;

/* Reads the slopes around the points from (x, y) on; false: some texels may hold no normal. */
static bool read_patch(patch *a, const ntp_const_image *src, int32_t x, int32_t y)
{
    int32_t m = ntp__max(src->type);
    float m2 = (float) m * (float) m, least = m2 / 100, sign = src->y == NTP_Y_UP ? 1 : -1;
    for (int32_t j = 0; j < SIDE; j++) {
        ntp__unpack(&a->block, src, x - REACH, y - REACH + j, SIDE);
        if (ntp__any_suspect(&a->block, SIDE, m))
            return false;
        for (int32_t i = 0; i < SIDE; i++) {
            float u = (float) (2 * a->block.c[0][i] - m), v = (float) (2 * a->block.c[1][i] - m);
            float rest = m2 - u * u - v * v, z = sqrtf(rest < least ? least : rest);
            a->p[j][i] = -u / z;
            a->q[j][i] = sign * v / z;
        }
    }
    return true;
}

/* The derivative down of p and that to the right of q, both moved by half a texel: at [j][i] they
 * belong half a texel before the point, at [j][i + 1] or [j + 1][i] half a texel after it. */
static void differentiate(patch *a)
{
    memset(a->half, 0, sizeof a->half);
    memset(a->down_p, 0, sizeof a->down_p);
    memset(a->right_q, 0, sizeof a->right_q);
    for (int32_t j = 0; j < POINTS; j++) {
        for (int32_t k = 0; k < 5; k++) {
            for (int32_t i = 0; i < SIDE; i++)
                a->half[j][i] += derivative[k] * a->p[j + k][i];
        }
        for (int32_t k = 0; k < 4; k++) {
            for (int32_t i = 0; i <= POINTS; i++)
                a->down_p[j][i] += moved[k] * a->half[j][i + k];
        }
    }
    memset(a->half, 0, sizeof a->half);
    for (int32_t j = 0; j <= POINTS; j++) {
        for (int32_t k = 0; k < 4; k++) {
            for (int32_t i = 0; i < SIDE; i++)
                a->half[j][i] += moved[k] * a->q[j + k][i];
        }
        for (int32_t k = 0; k < 5; k++) {
            for (int32_t i = 0; i < POINTS; i++)
                a->right_q[j][i] += derivative[k] * a->half[j][i + k];
        }
    }
}

/* Its power of two. */
static int32_t bin_of(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    int32_t bin = (int32_t) (bits >> 52) - LOWEST;
    return bin < 0 ? 0 : bin < BINS ? bin : BINS - 1;
}

static void add_square(tally *t, double sums[BINS], float v)
{
    double square = (double) v * (double) v;
    int32_t bin = bin_of(square);
    sums[bin] += square;
    t->count[bin]++;
    t->all++;
}

static void add_patch(tally *t, const patch *a)
{
    for (int32_t j = 0; j < POINTS; j++) {
        for (int32_t i = 0; i < POINTS; i++) {
            add_square(t, t->before, a->down_p[j][i] - a->right_q[j][i]);
            add_square(t, t->after, a->down_p[j][i + 1] - a->right_q[j + 1][i]);
        }
    }
}

static bool decide(const tally *t)
{
    int32_t middle = 0;
    int64_t below = t->count[0];
    double before = 0, after = 0, times = 1;
    while (2 * below < t->all && middle < BINS - 1)
        below += t->count[++middle];
    for (int32_t i = 0; i < BINS; i++) {
        times = i > middle ? 2 * times : 1; /* so many times the median */
        double weight = i > middle ? 1 / (1 + times / large) : 1;
        before += weight * t->before[i];
        after += weight * t->after[i];
    }
    return t->all >= LEAST_COUNT && after > before &&
           after - before >= least_share * (after + before);
}

bool ntp__lie_between(const ntp_const_image *src)
{
    tally t;
    patch a;
    int32_t across = src->width - 2 * EDGE - POINTS, down = src->height - 2 * EDGE - POINTS;
    if (across < 0 || down < 0)
        return false;
    int32_t columns = across / POINTS + 1, rows = down / POINTS + 1;
    columns = columns < PATCHES ? columns : PATCHES;
    rows = rows < PATCHES ? rows : PATCHES;
    memset(&t, 0, sizeof t);
    for (int32_t i = 0; i < columns * rows; i++) {
        int32_t x = columns > 1 ? (int32_t) ((int64_t) across * (i % columns) / (columns - 1)) : 0;
        int32_t y = rows > 1 ? (int32_t) ((int64_t) down * (i / columns) / (rows - 1)) : 0;
        if (!read_patch(&a, src, EDGE + x, EDGE + y))
            continue;
        differentiate(&a);
        add_patch(&t, &a);
    }
    return decide(&t);
}
