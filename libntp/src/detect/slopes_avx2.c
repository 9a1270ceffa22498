/* SPDX-License-Identifier: MIT */
/*
 * slopes_avx2.c - the slopes of a row, and sums of rows, with AVX2
 */
#include "detect/filter.h"
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
