/* SPDX-License-Identifier: MIT */
/*
 * slopes_avx2.c - the slopes of a row, and sums of rows, with AVX2
 */
#include "detect/filter.h"
#include "detect/kernel_loops_tmpl.h"
#include "detect/slopes_tmpl.h"

#include <immintrin.h>

void ntp__add_slopes_avx2(columns *sums, float *p, float *q, ntp__block *block, int32_t n,
                          int32_t m, float steep, float smooth)
{
    enum { LANES = 8 };
    const int32_t filled = (n + LANES - 1) & -LANES; /* so that no loop has a remainder */
    for (int32_t i = n; i < filled; i++)
        block->c[0][i] = block->c[1][i] = 0;
    ntp__add_slopes(sums, p, q, block->c[0], block->c[1], filled, m, steep, smooth);
}

/* Adds `lanes` floats times 8. */
static inline void add_lanes(float *out, const float *const *row, const float *taps, int32_t count,
                             ptrdiff_t at, const int lanes)
{
    __m256 sum[4];
    for (int l = 0; l < lanes; l++)
        sum[l] = _mm256_loadu_ps(out + at + 8 * l);
    for (int32_t k = 0; k < count; k++) {
        const __m256 tap = _mm256_broadcast_ss(taps + k);
        for (int l = 0; l < lanes; l++)
            sum[l] =
                _mm256_add_ps(sum[l], _mm256_mul_ps(tap, _mm256_loadu_ps(row[k] + at + 8 * l)));
    }
    for (int l = 0; l < lanes; l++)
        _mm256_storeu_ps(out + at + 8 * l, sum[l]);
}

void ntp__filter_avx2(float *out, const float *in, ptrdiff_t stride, const float *taps,
                      int32_t count, int32_t n)
{
    const float *row[8];
    float tap[8];
    int32_t used = 0, i = 0;
    for (int32_t k = 0; k < count; k++) {
        row[used] = in + k * stride;
        tap[used] = taps[k];
        used += taps[k] != 0;
    }
    for (; i + 32 <= n; i += 32)
        add_lanes(out, row, tap, used, i, 4);
    for (; i + 8 <= n; i += 8)
        add_lanes(out, row, tap, used, i, 1);
    for (; i < n; i++) {
        for (int32_t k = 0; k < used; k++)
            out[i] += tap[k] * row[k][i];
    }
}

/* These round n up to whole lanes: NTP__BLOCK numbers have place for them. */

void ntp__to_slopes_avx2(float *p, float *q, int32_t *bad, ntp__block *b, int32_t m, float sign,
                         int32_t n)
{
    const int32_t filled = (n + 7) & -8;
    for (int32_t i = n; i < filled; i++)
        b->c[0][i] = b->c[1][i] = 0;
    ntp__to_slopes(p, q, bad, b, m, sign, filled);
}

void ntp__to_noise_avx2(float *p_noise, float *q_noise, const float *p_row, const float *q_row,
                        float level, int32_t n)
{
    ntp__to_noise(p_noise, q_noise, p_row, q_row, level, (n + 7) & -8);
}

void ntp__to_worth_avx2(int32_t *worth, const float *u, const float *v, const int32_t *bad,
                        int32_t taps, float level, int32_t n)
{
    ntp__to_worth(worth, u, v, bad, taps, level, (n + 7) & -8);
}

double ntp__sum_squares_avx2(float *e, const float *expected, const int32_t *worth, int32_t n)
{
    return ntp__sum_squares(e, expected, worth, (n + 7) & -8);
}
