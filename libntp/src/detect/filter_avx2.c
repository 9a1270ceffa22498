/* SPDX-License-Identifier: MIT */
/*
 * filter_avx2.c - weighted sums of rows and columns of floats with AVX2
 */
#include "detect/filter.h"

#include "base/lanes_avx2.h"

#include <immintrin.h>

/* out[0..7] + the products of the taps */
static inline __m256 sum_of(__m256 sum, const float *const *row, const float *tap, int32_t used,
                            ptrdiff_t i)
{
    for (int32_t k = 0; k < used; k++)
        sum = _mm256_add_ps(
            sum, _mm256_mul_ps(_mm256_broadcast_ss(tap + k), _mm256_loadu_ps(row[k] + i)));
    return sum;
}

void ntp__filter_avx2(float *out, const float *in, ptrdiff_t stride, const float *taps,
                      int32_t count, int32_t onto, int32_t n)
{
    enum { LANES = NTP__FILTER_LEAST };
    const float *row[LANES];
    float tap[LANES];
    int32_t used = 0, i = 0;
    for (int32_t k = 0; k < count; k++) {
        row[used] = in + k * stride;
        tap[used] = taps[k];
        used += taps[k] != 0;
    }
    /* The last lanes may overlap those before, which are the same both times. */
    const __m256 zero = _mm256_setzero_ps(), last = onto ? _mm256_loadu_ps(out + n - LANES) : zero;
    for (; i + 4 * LANES <= n; i += 4 * LANES) {
        __m256 a = zero, b = zero, c = zero, d = zero;
        if (onto) {
            a = _mm256_loadu_ps(out + i);
            b = _mm256_loadu_ps(out + i + LANES);
            c = _mm256_loadu_ps(out + i + 2 * LANES);
            d = _mm256_loadu_ps(out + i + 3 * LANES);
        }
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
    for (; i + LANES <= n; i += LANES)
        _mm256_storeu_ps(out + i,
                         sum_of(onto ? _mm256_loadu_ps(out + i) : zero, row, tap, used, i));
    if (i < n)
        _mm256_storeu_ps(out + n - LANES, sum_of(last, row, tap, used, n - LANES));
    end_lanes();
}
