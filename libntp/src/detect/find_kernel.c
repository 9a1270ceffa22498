/* SPDX-License-Identifier: MIT */
/*
 * find_kernel.c - which kernel made these normals
 *
 * A kernel takes slopes p = (D across)(S down) h and q = (S across)(D down) h, with D a difference
 * and S a mean along one axis.  So (S across)(D down) p = (D across)(S down) q if p and q come from
 * that kernel.  Rounding puts the two sides apart, by a variance that is known.  Each kernel is
 * tried on points of sampled rows, and the square of the difference is compared with that variance.
 */
#include "base/cpu.h"
#include "base/view.h"
#include "detect/between.h"
#include "detect/filter.h"
#include "detect/kernel_loops_tmpl.h"
#include "detect/level_edges.h"
#include "texel/level.h"

#include <string.h>

enum {
    TAPS = 7,
    REACH = TAPS / 2,
    EDGE = REACH + 2, /* points nearer to an edge may hold slopes that a border made */
    WIDE = NTP__BLOCK,
    POINTS = WIDE - 2 * REACH, /* of a stretch */
    WORTH = WIDE + 8,          /* with zeros beyond, as loops go on to whole lanes */
    MOST_ROWS = 1024,
    MOST_COLUMNS = 256,
    ENOUGH_POINTS = 1 << 14, /* the mean of so many squares is right to a few percent */
    CANDIDATES = 7
};

enum { NARROW, ONE_SIDED, WIDE5, OF_SURFACE, DIFFERENCES };
static const float DIFFERENCE[DIFFERENCES][TAPS] = {
    [NARROW] = { 0, 0, -0.5F, 0, 0.5F, 0, 0 },
    [ONE_SIDED] = { 0, 0, 0, -1, 1, 0, 0 },
    [WIDE5] = { 0, -0.1F, -0.2F, 0, 0.2F, 0.1F, 0 },
    /* the derivative of a smooth surface, from samples at seven texels */
    [OF_SURFACE] = { -1 / 60.0F, 9 / 60.0F, -45 / 60.0F, 0, 45 / 60.0F, -9 / 60.0F, 1 / 60.0F },
};

enum { NO_MEAN, EVEN3, BINOMIAL3, FLAT3, EVEN5, MEANS };
static const float MEAN[MEANS][TAPS] = {
    [NO_MEAN] = { 0, 0, 0, 1, 0, 0, 0 },
    [EVEN3] = { 0, 0, 1 / 3.0F, 1 / 3.0F, 1 / 3.0F, 0, 0 },
    [BINOMIAL3] = { 0, 0, 0.25F, 0.5F, 0.25F, 0, 0 },
    [FLAT3] = { 0, 0, 0.1875F, 0.625F, 0.1875F, 0, 0 },
    [EVEN5] = { 0, 0.2F, 0.2F, 0.2F, 0.2F, 0.2F, 0 },
};

/* Sobel 5 x 5 is Sobel 3 x 3 of a blurred heightfield, so nothing tells the two apart.  The kernels
 * of the old plug-in are no products of D and S. */
static const struct candidate {
    ntp_kernel kernel;
    int32_t difference, mean;
} CANDIDATE[CANDIDATES] = {
    { NTP_KERNEL_CENTRAL, NARROW, NO_MEAN },   { NTP_KERNEL_FORWARD, ONE_SIDED, NO_MEAN },
    { NTP_KERNEL_PREWITT3, NARROW, EVEN3 },    { NTP_KERNEL_SOBEL3, NARROW, BINOMIAL3 },
    { NTP_KERNEL_SCHARR3, NARROW, FLAT3 },     { NTP_KERNEL_PREWITT5, WIDE5, EVEN5 },
    { NTP_KERNEL_BAKED, OF_SURFACE, NO_MEAN },
};

/* Central differences of heights that a binomial has blurred show whether there is anything to
 * see. */
static const float SEEN_DIFFERENCE[TAPS] = { -1 / 32.0F, -4 / 32.0F, -5 / 32.0F, 0,
                                             5 / 32.0F,  4 / 32.0F,  1 / 32.0F };
static const float SEEN_MEAN[TAPS] = {
    0, 1 / 16.0F, 4 / 16.0F, 6 / 16.0F, 4 / 16.0F, 1 / 16.0F, 0
};

/* A misfit of 1 is that of rounding alone.  A kernel is decided only between these two.  Below the
 * least one, so few levels occur that rounding is no noise. */
static const double MOST_MISFIT = 1.2, LEAST_MISFIT = 0.85;
/* Every other kernel must fit worse by this factor, also than rounding alone: on smooth ground
 * neighbors share rounding errors, which takes most from the misfit of `forward`.  `baked` fits
 * slopes that a wide kernel made nearly as well as the kernel itself, so it has to be clearer. */
static const double CLEARLY = 1.15, CLEARLY_BAKED = 1.5;
/* The answer is central unless another kernel fits better by this factor, and not too badly
 * itself. */
static const double BETTER = 1.15, USABLE_MISFIT = 4;
/* Where no kernel fits, central is off by far on normals that were not made by it, and lets even and
 * odd heights drift apart under noise.  `baked` does neither, unless it misfits so much more. */
static const double AS_GOOD = 1.03;
/* Nor is it `baked` where the blur of `sobel3` shows under damage: it fits better than that of `scharr3`,
 * which blurs less, by the first factor, and `baked` better than central by the second.  Of surfaces
 * `sobel3` fits far better than central, as it hides the damage: below the third.  Central is then best. */
static const double LESS_BLUR = 0.95, NO_BLUR = 0.92, HIDES = 0.7;
static const uint64_t LEAST_POINTS = 200;

/* The rows around a point's row. */
typedef struct rows {
    float p[TAPS][WIDE], q[TAPS][WIDE];             /* slopes to the right and down the picture */
    float p_noise[TAPS][WIDE], q_noise[TAPS][WIDE]; /* what rounding adds to their squares */
    int32_t bad[WIDE + TAPS];
} rows;

typedef struct sums {
    double square[CANDIDATES];
    uint64_t points;
} sums;

/* Slopes from red and green. */
static void to_slopes(rows *at, int32_t k, ntp__block *b, const ntp_const_image *src,
                      uint32_t touch, int32_t n)
{
    int32_t m = ntp__max(src->type);
    float sign = src->y == NTP_Y_UP ? 1.0F : -1.0F;
    for (int32_t i = 0; i < n && !(touch & NTP_UNUSED_TRANSPARENT); i++)
        at->bad[i] |= b->c[3][i] == 0;
    for (int32_t i = 0; i < n && b->any_broken; i++)
        at->bad[i] |= b->broken[i];
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__to_slopes_avx2(at->p[k], at->q[k], at->bad, b, m, sign, n);
        return;
    }
#endif
    ntp__to_slopes(at->p[k], at->q[k], at->bad, b, m, sign, n);
}

/* The variance of their rounding errors. */
static void to_noise(rows *at, int32_t k, float level, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__to_noise_avx2(at->p_noise[k], at->q_noise[k], at->p[k], at->q[k], level, n);
        return;
    }
#endif
    ntp__to_noise(at->p_noise[k], at->q_noise[k], at->p[k], at->q[k], level, n);
}

static void to_worth(int32_t *worth, const float *u, const float *v, const int32_t *bad,
                     float level, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__to_worth_avx2(worth, u, v, bad, TAPS, level, n);
        return;
    }
#endif
    ntp__to_worth(worth, u, v, bad, TAPS, level, n);
}

static double sum_squares(float *e, const float *expected, const int32_t *worth, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        return ntp__sum_squares_avx2(e, expected, worth, n);
#endif
    return ntp__sum_squares(e, expected, worth, (n + 3) & -4);
}

/* The sums of n columns; in: the first of the first row. */
static void down(float *out, const float *in, const float taps[TAPS], int32_t n)
{
    ntp__filter(out, in, WIDE, taps, TAPS, false, n);
}

/* Sums for out[0..n - 1], of which out[0] belongs to in[REACH]; onto: they are added to it. */
static void across(float *out, const float *in, const float taps[TAPS], bool onto, int32_t n)
{
    ntp__filter(out, in, 1, taps, TAPS, onto, n);
}

static void squared(float out[TAPS], const float taps[TAPS])
{
    for (int32_t k = 0; k < TAPS; k++)
        out[k] = taps[k] * taps[k];
}

/* Finds the points that can tell: where both mixed differences are more than a level. */
static int32_t find_points(int32_t worth[WORTH], const rows *at, float level, int32_t n)
{
    float line[WIDE], u[WIDE] = { 0 }, v[WIDE] = { 0 };
    int32_t count = 0;
    down(line, at->p[0], SEEN_DIFFERENCE, n + 2 * REACH);
    across(u, line, SEEN_MEAN, false, n);
    down(line, at->q[0], SEEN_MEAN, n + 2 * REACH);
    across(v, line, SEEN_DIFFERENCE, false, n);
    to_worth(worth, u, v, at->bad, level, n);
    for (int32_t i = 0; i < n; i++)
        count += worth[i];
    return count;
}

/* The rows of a stretch, filtered down the picture.  Candidates share them. */
typedef struct filtered {
    float p[DIFFERENCES][WIDE], q[MEANS][WIDE];
    float p_noise[DIFFERENCES][WIDE], q_noise[MEANS][WIDE];
} filtered;

/* The same of all taps; squares: of the squares of them. */
static void filter_down(float (*out)[WIDE], const float *in, const float (*taps)[TAPS],
                        int32_t count, bool squares, int32_t n)
{
    for (int32_t i = 0; i < count; i++) {
        float taps2[TAPS];
        squared(taps2, taps[i]);
        down(out[i], in, squares ? taps2 : taps[i], n);
    }
}

static void try_candidate(double *sum, const struct candidate *c, const filtered *at,
                          const int32_t *worth, int32_t n)
{
    float e[WIDE] = { 0 }, expected[WIDE] = { 0 };
    float minus[TAPS], difference2[TAPS], mean2[TAPS];
    for (int32_t k = 0; k < TAPS; k++)
        minus[k] = -DIFFERENCE[c->difference][k];
    squared(difference2, DIFFERENCE[c->difference]);
    squared(mean2, MEAN[c->mean]);
    across(e, at->p[c->difference], MEAN[c->mean], false, n);
    across(e, at->q[c->mean], minus, true, n);
    across(expected, at->p_noise[c->difference], mean2, false, n);
    across(expected, at->q_noise[c->mean], difference2, true, n);
    *sum += sum_squares(e, expected, worth, n);
}

/* Adds the points x..x + n - 1 of row y. */
static void add_stretch(sums *s, const ntp_const_image *src, uint32_t touch, int32_t x, int32_t y,
                        int32_t n)
{
    rows at;
    filtered lines;
    ntp__block block;
    int32_t worth[WORTH] = { 0 };
    int32_t texels = n + 2 * REACH;
    memset(at.bad, 0, sizeof at.bad);
    for (int32_t k = 0; k < TAPS; k++) {
        ntp__unpack(&block, src, x - REACH, y - REACH + k, texels);
        to_slopes(&at, k, &block, src, touch, texels);
    }
    float level = 2 / (float) ntp__max(src->type);
    int32_t count = find_points(worth, &at, level, n);
    if (count == 0)
        return;
    int32_t first = 0, last = n - 1;
    while (!worth[first])
        first++;
    while (!worth[last])
        last--;
    s->points += (uint64_t) count;
    for (int32_t k = 0; k < TAPS; k++)
        to_noise(&at, k, level, texels);
    n = last - first + 1;
    const int32_t wide = n + 2 * REACH;
    filter_down(lines.p, at.p[0] + first, DIFFERENCE, DIFFERENCES, false, wide);
    filter_down(lines.q, at.q[0] + first, MEAN, MEANS, false, wide);
    filter_down(lines.p_noise, at.p_noise[0] + first, DIFFERENCE, DIFFERENCES, true, wide);
    filter_down(lines.q_noise, at.q_noise[0] + first, MEAN, MEANS, true, wide);
    for (int32_t i = 0; i < CANDIDATES; i++)
        try_candidate(&s->square[i], &CANDIDATE[i], &lines, worth + first, n);
}

/* A step near the golden section of `count`.  It visits all rows, each far from the last. */
static int32_t scattering_step(int32_t count)
{
    int32_t step = (int32_t) ((int64_t) count * 40503 / 65536);
    for (;; step++) {
        int32_t a = count, b = step;
        while (b > 0) { /* Euclid: the two must have no common divisor */
            int32_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1)
            return step;
    }
}

/* Adds points of up to MOST_ROWS rows, until there are enough.  Of a wide row it takes MOST_COLUMNS
 * columns, which begin at another place in each row. */
static void add_rows(sums *s, const ntp_const_image *src, uint32_t touch)
{
    int32_t across_all = src->width - 2 * EDGE, down_all = src->height - 2 * EDGE;
    if (across_all < 1 || down_all < 1)
        return;
    int32_t count = down_all < MOST_ROWS ? down_all : MOST_ROWS, step = scattering_step(count);
    int32_t columns = across_all < MOST_COLUMNS ? across_all : MOST_COLUMNS;
    for (int32_t k = 0, i = 0; k < count && s->points < ENOUGH_POINTS;
         k++, i = (i + step) % count) {
        int32_t y = EDGE + (int32_t) ((int64_t) i * down_all / count);
        /* multiples of the golden section scatter the beginnings */
        int32_t x = EDGE + (int32_t) ((int64_t) i * 40503 % 65536 * (across_all - columns) / 65536);
        for (int32_t c = 0; c < columns; c += POINTS)
            add_stretch(s, src, touch, x + c, y, columns - c < POINTS ? columns - c : POINTS);
    }
}

/* The candidate that fits best, other than `but`. */
static int32_t best_of(const double misfit[CANDIDATES], int32_t but)
{
    int32_t best = but == 0 ? 1 : 0;
    for (int32_t i = best + 1; i < CANDIDATES; i++)
        best = i != but && misfit[i] < misfit[best] ? i : best;
    return best;
}

/* What fits damaged slopes best that show no kernel, and do not lie between texels. */
static ntp_kernel least_harm(const double misfit[NTP_KERNELS])
{
    double central = misfit[NTP_KERNEL_CENTRAL], baked = misfit[NTP_KERNEL_BAKED];
    double sobel = misfit[NTP_KERNEL_SOBEL3];
    bool blurred = sobel < LESS_BLUR * misfit[NTP_KERNEL_SCHARR3] && baked < NO_BLUR * central &&
                   sobel > HIDES * central;
    return !blurred && baked < AS_GOOD * central ? NTP_KERNEL_BAKED : NTP_KERNEL_CENTRAL;
}

ntp_status ntp_find_kernel(ntp_kernel_fit *fit, const ntp_const_image *src, uint32_t touch_unused)
{
    if (fit == NULL || touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    sums s;
    memset(&s, 0, sizeof s);
    add_rows(&s, src, touch_unused);
    fit->decided = 0;
    fit->kernel = NTP_KERNEL_CENTRAL;
    fit->points = s.points;
    for (int32_t i = 0; i < NTP_KERNELS; i++)
        fit->misfit[i] = -1;
    if (s.points < LEAST_POINTS)
        return NTP_OK;
    double misfit[CANDIDATES];
    for (int32_t i = 0; i < CANDIDATES; i++) {
        misfit[i] = s.square[i] / (double) s.points;
        fit->misfit[CANDIDATE[i].kernel] = misfit[i];
    }
    int32_t best = best_of(misfit, -1), next = best_of(misfit, best), last = CANDIDATES - 1;
    double least = misfit[best] > 1 ? misfit[best] : 1;
    if (misfit[best] <= USABLE_MISFIT && misfit[0] > BETTER * least)
        fit->kernel = CANDIDATE[best].kernel;
    bool fits = misfit[best] <= MOST_MISFIT && misfit[best] >= LEAST_MISFIT;
    double clearly = best == last ? CLEARLY_BAKED : CLEARLY;
    if (next == last && best != last) { /* on smooth surfaces baked is near every kernel */
        double rest[CANDIDATES];
        memcpy(rest, misfit, sizeof rest);
        rest[last] = misfit[best] * 1e9;
        next = best_of(rest, best);
    }
    fit->decided = fits && misfit[next] >= clearly * least;
    /* Damage hides kernels, and smooth ground, where all give the same slopes. */
    bool damaged = misfit[best] > MOST_MISFIT;
    if (fit->decided)
        fit->kernel = CANDIDATE[best].kernel;
    else if (fit->kernel == NTP_KERNEL_CENTRAL || (fit->kernel == NTP_KERNEL_FORWARD && damaged))
        fit->kernel = ntp__lie_between(src) ? NTP_KERNEL_FORWARD
                      : damaged             ? least_harm(fit->misfit)
                                            : NTP_KERNEL_CENTRAL;
    /* Solved as baked, heights would bend to edges that are level only by a mirror. */
    if (!fit->decided && fit->kernel == NTP_KERNEL_BAKED &&
        (ntp__edges_are_level(src, false) || ntp__edges_are_level(src, true)))
        fit->kernel = NTP_KERNEL_CENTRAL;
    return NTP_OK;
}
