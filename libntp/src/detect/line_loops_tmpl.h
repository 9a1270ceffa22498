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

/* Slopes are x/z and y/z. */
static inline void ntp__line_slopes(double *restrict p, double *restrict q,
                                    const int32_t *restrict x, const int32_t *restrict y,
                                    int32_t m, int32_t n)
{
    double m2 = (double) m * m, least = m2 / (STEEPEST * STEEPEST);
    for (int32_t i = 0; i < n; i++) {
        double u = ntp__num(x[i], m), v = ntp__num(y[i], m), rest = m2 - u * u - v * v;
        double inverse = 1 / sqrt(rest < least ? least : rest);
        p[i] = u * inverse;
        q[i] = v * inverse;
    }
}

/* From the texel before to each one: the step, and the variance that rounding adds to p. */
static inline void ntp__line_steps(double *restrict step, double *restrict noise,
                                   const double *restrict p, const double *restrict q, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        double u = p[i + 1], v = q[i + 1], uu = u * u, vv = v * v;
        step[i] = fabs(u - p[i]) + fabs(v - q[i]);
        noise[i] = (1 + uu + vv) * ((1 + uu) * (1 + uu) + uu * vv);
    }
}

static inline void ntp__add_floats(double *restrict sum, const float *restrict v, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += (double) v[i];
}

#ifdef NTP_HAVE_AVX2
void ntp__add_floats_avx2(double *sum, const float *v, int32_t n);

/* The same of whole lanes: red and green change beyond n. */
void ntp__line_slopes_avx2(ntp__line *l, int32_t along, int32_t m, int32_t n);
void ntp__line_steps_avx2(ntp__line *l, int32_t n);
#endif

#endif
