/* SPDX-License-Identifier: MIT */
/*
 * line_loops_tmpl.h - the loops of find_seams.c and ends_meet.c over texels; compiled for AVX2 too (loops_avx2.c)
 */
#ifndef NTP_LINE_LOOPS_TMPL_H
#define NTP_LINE_LOOPS_TMPL_H

#include "base/view.h"
#include "texel/level.h"

#include <math.h>

/* Steeper slopes count as this one: such a texel tells little. */
static const double STEEPEST = 8;

/* A stretch of a line. */
typedef struct ntp__line {
    double p[NTP__BLOCK + 1], q[NTP__BLOCK + 1]; /* slopes along and across, from index 1 on */
    bool bad[NTP__BLOCK];                        /* no normal */
    double step[NTP__BLOCK], noise[NTP__BLOCK];
    ntp__block block;
} ntp__line;

enum {
    NTP__WINDOWS = 3, /* means of 1, 2 and 4 slopes on each side of a place */
    NTP__WIDEST = 4,
    PLACES = 8 /* from place to place: edges of the blocks of JPEG, as a seam is one */
};

/* For each window: squares of differences; sums of means and of their squares. */
typedef struct ntp__windows {
    double within[NTP__WINDOWS], mean[NTP__WINDOWS][2], mean2[NTP__WINDOWS];
    double places;
} ntp__windows;

typedef struct ntp__line_sums {
    double height, sum, sum2; /* of slopes so far; of all heights, and their squares */
    double noise;             /* the variance that rounding adds to slopes along */
    double inside;            /* steps */
    int64_t larger;           /* than at the seam: such steps count 2, as large ones 1 */
} ntp__line_sums;

/* Slopes are x/z and y/z. */
static inline void ntp__line_slopes(double *restrict p, double *restrict q,
                                    const int32_t *restrict x, const int32_t *restrict y, int32_t m,
                                    int32_t n)
{
    double m2 = (double) m * m, least = m2 / (STEEPEST * STEEPEST);
    for (int32_t i = 0; i < n; i++) {
        double u = ntp__num(x[i], m), v = ntp__num(y[i], m), rest = m2 - u * u - v * v;
        double inverse = 1 / sqrt(rest < least ? least : rest);
        p[i] = u * inverse;
        q[i] = v * inverse;
    }
}

/* Means of 1, 2 and 4 slopes before v and from v on. */
static inline void ntp__means_of(double before[NTP__WINDOWS], double after[NTP__WINDOWS],
                                 const double *v)
{
    before[0] = v[-1];
    before[1] = (v[-2] + v[-1]) / 2;
    before[2] = (v[-4] + v[-3] + v[-2] + v[-1]) / 4;
    after[0] = v[0];
    after[1] = (v[0] + v[1]) / 2;
    after[2] = (v[0] + v[1] + v[2] + v[3]) / 4;
}

/* Adds the squares of how far the means of slopes before and after p, q are apart. */
static inline void ntp__add_differences(double sum[NTP__WINDOWS], double after[2][NTP__WINDOWS],
                                        const double *p, const double *q)
{
    double before[2][NTP__WINDOWS];
    ntp__means_of(before[0], after[0], p);
    ntp__means_of(before[1], after[1], q);
    for (int32_t k = 0; k < NTP__WINDOWS; k++) {
        double x = after[0][k] - before[0][k], y = after[1][k] - before[1][k];
        sum[k] += x * x + y * y;
    }
}

static inline void ntp__add_windows(ntp__windows *w, const ntp__line *l, int32_t n)
{
    double mean[2][NTP__WINDOWS];
    for (int32_t i = PLACES; i + NTP__WIDEST <= n; i += PLACES) {
        w->places++;
        ntp__add_differences(w->within, mean, l->p + 1 + i, l->q + 1 + i);
        for (int32_t k = 0; k < NTP__WINDOWS; k++) {
            double x = mean[0][k], y = mean[1][k];
            w->mean[k][0] += x;
            w->mean[k][1] += y;
            w->mean2[k] += x * x + y * y;
        }
    }
}

/* Adds a stretch of a line; first: the line begins with it.  jump: the step at the seam. */
static inline void ntp__sum_line(ntp__line_sums *sums, ntp__windows *windows, ntp__line *l,
                                 bool first, double jump, int32_t n)
{
    double *restrict step = l->step, *restrict noise = l->noise;
    const double *restrict p = l->p, *restrict q = l->q;
    ntp__line_sums s = *sums;
    for (int32_t i = 0; i < ((n + 7) & -8); i++) { /* in whole lanes; a line has place for them */
        double u = p[i + 1], v = q[i + 1], uu = u * u, vv = v * v;
        step[i] = fabs(u - p[i]) + fabs(v - q[i]);
        noise[i] = (1 + uu + vv) * ((1 + uu) * (1 + uu) + uu * vv);
    }
    ntp__add_windows(windows, l, n);
    if (first) { /* there is no step before the first texel */
        step[0] = 0;
        s.larger -= 0 >= jump;
    }
    for (int32_t i = 0; i < n; i++) {
        s.height += p[i + 1];
        s.sum += s.height;
        s.sum2 += s.height * s.height;
        s.noise += noise[i];
        s.inside += step[i];
        s.larger += (step[i] > jump) + (step[i] >= jump);
    }
    *sums = s;
}

static inline void ntp__add_floats(double *restrict sum, const float *restrict v, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += (double) v[i];
}

#ifdef NTP_HAVE_AVX2
void ntp__add_floats_avx2(double *sum, const float *v, int32_t n);
void ntp__sum_line_avx2(ntp__line_sums *sums, ntp__windows *windows, ntp__line *l, bool first,
                        double jump, int32_t n);

/* Of whole lanes: red and green change beyond n. */
void ntp__line_slopes_avx2(ntp__line *l, int32_t along, int32_t m, int32_t n);
#endif

#endif
