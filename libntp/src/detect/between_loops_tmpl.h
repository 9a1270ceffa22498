/* SPDX-License-Identifier: MIT */
/*
 * between_loops_tmpl.h - the loops of between.c over texels; compiled for AVX2 too (loops_avx2.c)
 */
#ifndef NTP_BETWEEN_LOOPS_TMPL_H
#define NTP_BETWEEN_LOOPS_TMPL_H

#include "base/view.h"

#include <math.h>
#include <string.h>

enum {
    BETWEEN_POINTS = 32,                /* a side of a patch */
    BETWEEN_CELL = 8,                   /* a side of what is weighed as one */
    BETWEEN_MOVED = BETWEEN_POINTS + 2, /* with a texel more on every side */
    BETWEEN_SIDE = BETWEEN_MOVED + 6,   /* with what filters read */
    BETWEEN_STEP = 2                    /* texels of a point at most */
};

/* Adds the slopes of a row of texels to sums of `step` of them: -x/z and y/z, green up. */
static inline void ntp__sum_slopes(float *restrict p_sum, float *restrict q_sum,
                                   const ntp__block *restrict b, int32_t m, float sign,
                                   int32_t step)
{
    float m2 = (float) m * (float) m, least = m2 / 100;
    float p[BETWEEN_STEP * BETWEEN_SIDE], q[BETWEEN_STEP * BETWEEN_SIDE];
    for (int32_t i = 0; i < step * BETWEEN_SIDE; i++) {
        float u = (float) (2 * b->c[0][i] - m), v = (float) (2 * b->c[1][i] - m);
        float rest = m2 - u * u - v * v, z = sqrtf(rest < least ? least : rest);
        p[i] = u / z;
        q[i] = sign * v / z;
    }
    for (int32_t k = 0; k < step; k++) {
        for (int32_t i = 0; i < BETWEEN_SIDE; i++) {
            p_sum[i] -= p[i * step + k];
            q_sum[i] += q[i * step + k];
        }
    }
}

/* Products of derivatives, for columns of points: see between.c. */
typedef struct ntp__products {
    float ahead[BETWEEN_POINTS], rise[BETWEEN_POINTS], both[BETWEEN_POINTS], square[BETWEEN_POINTS];
} ntp__products;

/* Adds CELL rows of points up, of which the first has u and v of a texel more above and before. */
static inline void ntp__sum_products(ntp__products *restrict sums,
                                     const float (*restrict u)[BETWEEN_MOVED],
                                     const float (*restrict v)[BETWEEN_MOVED])
{
    memset(sums, 0, sizeof *sums);
    for (int32_t j = 0; j < BETWEEN_CELL; j++) {
        const float *up_u = u[j] + 2, *up_v = v[j] + 2; /* to the right and up */
        const float *here_u = u[j + 1] + 1, *here_v = v[j + 1] + 1;
        const float *down_u = u[j + 2], *down_v = v[j + 2];
        for (int32_t i = 0; i < BETWEEN_POINTS; i++) {
            float by_u = up_u[i] - down_u[i], by_v = up_v[i] - down_v[i];
            sums->ahead[i] += 2 * (here_u[i] - here_v[i]) * (by_u + by_v);
            sums->rise[i] += by_u * by_v;
            sums->both[i] += down_u[i] * here_v[i] + here_u[i] * down_v[i];
            sums->square[i] += here_u[i] * here_u[i] + here_v[i] * here_v[i];
        }
    }
}

#ifdef NTP_HAVE_AVX2
void ntp__sum_slopes_avx2(float *p_sum, float *q_sum, const ntp__block *b, int32_t m, float sign,
                          int32_t step);
void ntp__sum_products_avx2(ntp__products *sums, const float (*u)[BETWEEN_MOVED],
                            const float (*v)[BETWEEN_MOVED]);
#endif

#endif
