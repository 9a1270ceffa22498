/* SPDX-License-Identifier: MIT */
/*
 * filter_avx2.c - weighted sums of rows and columns of floats with AVX2
 */
#include "detect/filter.h"

#include <immintrin.h>

void ntp__filter_avx2(float *out, const float *in, ptrdiff_t stride, const float *taps,
                      int32_t count, int32_t n)
{
    enum { LANES = 8 };
    const __m256i place = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const float *row[LANES];
    float tap[LANES];
    int32_t used = 0, i = 0;
    for (int32_t k = 0; k < count; k++) {
        row[used] = in + k * stride;
        tap[used] = taps[k];
        used += taps[k] != 0;
    }
    for (; i + 4 * LANES <= n; i += 4 * LANES) {
        __m256 a = _mm256_loadu_ps(out + i), b = _mm256_loadu_ps(out + i + LANES);
        __m256 c = _mm256_loadu_ps(out + i + 2 * LANES), d = _mm256_loadu_ps(out + i + 3 * LANES);
        for (int32_t k = 0; k < used; k++) {
            const __m256 weight = _mm256_broadcast_ss(tap + k);
            const float *at = row[k] + i;
            a = _mm256_add_ps(a, _mm256_mul_ps(weight, _mm256_loadu_ps(at)));
            b = _mm256_add_ps(b, _mm256_mul_ps(weight, _mm256_loadu_ps(at + LANES)));
            c = _mm256_add_ps(c, _mm256_mul_ps(weight, _mm256_loadu_ps(at + 2 * LANES)));
            d = _mm256_add_ps(d, _mm256_mul_ps(weight, _mm256_loadu_ps(at + 3 * LANES)));
        }
        _mm256_storeu_ps(out + i, a);
        _mm256_storeu_ps(out + i + LANES, b);
        _mm256_storeu_ps(out + i + 2 * LANES, c);
        _mm256_storeu_ps(out + i + 3 * LANES, d);
    }
    for (; i < n; i += LANES) {
        const __m256i mask = _mm256_cmpgt_epi32(_mm256_set1_epi32(n - i), place);
        __m256 sum = _mm256_maskload_ps(out + i, mask);
        for (int32_t k = 0; k < used; k++) {
            const __m256 some = _mm256_maskload_ps(row[k] + i, mask);
            sum = _mm256_add_ps(sum, _mm256_mul_ps(_mm256_broadcast_ss(tap + k), some));
        }
        _mm256_maskstore_ps(out + i, mask, sum);
    }
}
