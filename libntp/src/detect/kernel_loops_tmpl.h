/* SPDX-License-Identifier: MIT */
/*
 * kernel_loops_tmpl.h - the loops of find_kernel.c over texels; compiled for AVX2 too (loops_avx2.c)
 */
#ifndef NTP_KERNEL_LOOPS_TMPL_H
#define NTP_KERNEL_LOOPS_TMPL_H

#include "base/view.h"
#include "texel/level.h"

#include <math.h>

/* Squares count less the larger they are, and never more than so many times the expected one.  So a
 * few scratches do not decide. */
static const float LARGE_SQUARE = 100;

/* Slopes from red and green.  bad: those that are too steep, or no normal, and those that were it.  Short
 * loops, which compilers vectorize; near 0 only doubles have the digits of 16 bits. */
static inline void ntp__to_slopes(float *restrict p, float *restrict q, int32_t *restrict bad,
                                  const ntp__block *restrict b, int32_t m, float sign, int32_t n)
{
    double m2 = (double) m * m;
    float least = (float) (m2 / 100), rest[NTP__BLOCK];
    for (int32_t i = 0; i < n; i++) {
        double x = ntp__num(b->c[0][i], m), y = ntp__num(b->c[1][i], m);
        rest[i] = (float) (m2 - x * x - y * y);
    }
    for (int32_t i = 0; i < n; i++) {
        float far = 1 / sqrtf(rest[i] < least ? least : rest[i]);
        bad[i] |= rest[i] < least;
        p[i] = -(float) ntp__num(b->c[0][i], m) * far;
        q[i] = sign * (float) ntp__num(b->c[1][i], m) * far;
    }
}

/* The variance of their rounding errors. */
static inline void ntp__to_noise(float *restrict p_noise, float *restrict q_noise,
                                 const float *restrict p_row, const float *restrict q_row,
                                 float level, int32_t n)
{
    float noise = level * level / 12;
    for (int32_t i = 0; i < n; i++) {
        float p = p_row[i], q = q_row[i];
        float pp = p * p, qq = q * q, common = noise * (1 + pp + qq);
        p_noise[i] = common * ((1 + pp) * (1 + pp) + pp * qq);
        q_noise[i] = common * ((1 + qq) * (1 + qq) + pp * qq);
    }
}

/* Which points can tell: where both mixed differences are more than a level, and no texel is bad. */
static inline void ntp__to_worth(int32_t *restrict worth, const float *restrict u,
                                 const float *restrict v, const int32_t *restrict bad, int32_t taps,
                                 float level, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        worth[i] = (u[i] * u[i] > level * level) & (v[i] * v[i] > level * level);
    for (int32_t k = 0; k < taps; k++) {
        for (int32_t i = 0; i < n; i++)
            worth[i] &= bad[i + k] ^ 1;
    }
}

/* The sum of e^2 over what is expected of it, where it is worth anything; n has no remainder by 4. */
static inline double ntp__sum_squares(float *restrict e, const float *restrict expected,
                                      const int32_t *restrict worth, int32_t n)
{
    enum { LANES = 4 }; /* of a sum, which would wait for itself */
    double lanes[LANES] = { 0 };
    for (int32_t i = 0; i < n; i++) {
        float square = e[i] * e[i] / expected[i];
        square = square / (1 + square / LARGE_SQUARE);
        e[i] = worth[i] ? square : 0;
    }
    for (int32_t i = 0; i < n; i += LANES) {
        for (int32_t k = 0; k < LANES; k++)
            lanes[k] += (double) e[i + k];
    }
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

#ifdef NTP_HAVE_AVX2
void ntp__to_slopes_avx2(float *p, float *q, int32_t *bad, ntp__block *b, int32_t m, float sign,
                         int32_t n);
void ntp__to_noise_avx2(float *p_noise, float *q_noise, const float *p_row, const float *q_row,
                        float level, int32_t n);
void ntp__to_worth_avx2(int32_t *worth, const float *u, const float *v, const int32_t *bad,
                        int32_t taps, float level, int32_t n);
double ntp__sum_squares_avx2(float *e, const float *expected, const int32_t *worth, int32_t n);
#endif

#endif
