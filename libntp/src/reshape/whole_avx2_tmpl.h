/* SPDX-License-Identifier: MIT */
/*
 * whole_avx2_tmpl.h - exact sums of rows of int16_t, with AVX2
 *
 * Files that are compiled for AVX2 alone include it.
 */
#ifndef NTP_WHOLE_AVX2_TMPL_H
#define NTP_WHOLE_AVX2_TMPL_H

#include "reshape/resize_kernels.h"

#include <immintrin.h>
#include <string.h>

/* 16 sums of two numbers */
static inline __m256i load_both(const float *row, const float *other, int32_t i)
{
    const int16_t *a = (const void *) row, *b = (const void *) other;
    return _mm256_add_epi16(_mm256_loadu_si256((const void *) (a + i)),
                            _mm256_loadu_si256((const void *) (b + i)));
}

static inline __m256i two_weights(const int16_t *weight)
{
    int32_t two;
    memcpy(&two, weight, sizeof two);
    return _mm256_set1_epi32(two);
}

/* Of both halves of 16 numbers: sums of upper parts of weights, and of lower ones. */
typedef struct both_parts {
    __m256i high[2], low[2];
} both_parts;

/* With n weights; few registers are enough for 16 numbers. */
static inline both_parts sum_parts(const ntp__whole_weights *from, int32_t n, int32_t i)
{
    both_parts p;
    p.high[0] = p.high[1] = p.low[0] = p.low[1] = _mm256_setzero_si256();
    for (int32_t t = 0; t < n; t += 2) {
        const __m256i w = two_weights(from->upper + t), x = two_weights(from->lower + t);
        const __m256i a = load_both(from->row[t], from->other[t], i);
        const __m256i b = load_both(from->row[t + 1], from->other[t + 1], i);
        const __m256i c[2] = { _mm256_unpacklo_epi16(a, b), _mm256_unpackhi_epi16(a, b) };
        for (int32_t m = 0; m < 2; m++) {
            p.high[m] = _mm256_add_epi32(p.high[m], _mm256_madd_epi16(c[m], w));
            p.low[m] = _mm256_add_epi32(p.low[m], _mm256_madd_epi16(c[m], x));
        }
    }
    return p;
}

#endif
