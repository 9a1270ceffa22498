/* SPDX-License-Identifier: MIT */
/*
 * lengths_avx2_tmpl.h - lengths of 16-bit texels, with AVX2
 *
 * The same floats as in judge_lengths_quickly (judge_tmpl.h), in two loops: of chains that wait for a
 * root and then for a quotient, few would be in flight.
 */
#ifndef NTP_LENGTHS_AVX2_TMPL_H
#define NTP_LENGTHS_AVX2_TMPL_H

#include "texel/judged.h"

#include <immintrin.h>
#include <stdbool.h>

static inline __m256i load_eight(const int32_t *p)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) p);
}

static inline void store_eight(void *p, __m256i v)
{
    _mm256_storeu_si256((__m256i *) p, v);
}

/* The whole number next to the root; what is left, and what it is over. */
static inline void roots_of(int32_t *whole, float *rest, float *over, const int32_t *xy8,
                            const int32_t *b8, int32_t n, int32_t doubled, int32_t less)
{
    for (int32_t i = 0; i < n; i += 8) {
        const __m256i b = load_eight(b8 + i), xy = load_eight(xy8 + i);
        const __m256i twice = _mm256_and_si256(b, _mm256_set1_epi32(doubled));
        const __m256i z = _mm256_sub_epi32(_mm256_add_epi32(b, twice), _mm256_set1_epi32(less));
        const __m256 zf = _mm256_cvtepi32_ps(z);
        const __m256 by4 = _mm256_mul_ps(_mm256_cvtepi32_ps(xy), _mm256_set1_ps(4));
        const __m256 flat = _mm256_add_ps(by4, _mm256_set1_ps(2));
        const __m256 root = _mm256_sqrt_ps(_mm256_add_ps(flat, _mm256_mul_ps(zf, zf)));
        const __m256i k = _mm256_cvttps_epi32(_mm256_add_ps(root, _mm256_set1_ps(0.5f)));
        const __m256i xy4 = _mm256_add_epi32(_mm256_slli_epi32(xy, 2), _mm256_set1_epi32(2));
        const __m256i square = _mm256_add_epi32(xy4, _mm256_mullo_epi32(z, z));
        store_eight(whole + i, k);
        _mm256_storeu_ps(rest + i,
                         _mm256_cvtepi32_ps(_mm256_sub_epi32(square, _mm256_mullo_epi32(k, k))));
        _mm256_storeu_ps(over + i, _mm256_add_ps(root, _mm256_cvtepi32_ps(k)));
    }
}

/* n lengths, and up to whole lanes of eight, of vectors with x(x + 1) + y(y + 1) and z, which is
 * b + (b & doubled) - less.  `rest` and `over` are working memory. */
static inline void lengths_of(int32_t *length, float *rest, float *over, const int32_t *xy,
                              const int32_t *b, int32_t n, int32_t doubled, int32_t less)
{
    const float m = 65535, more = 1.0f / m, by = (float) NTP__LENGTH_ONE / m;
    roots_of(length, rest, over, xy, b, n, doubled, less);
    for (int32_t i = 0; i < n; i += 8) {
        const __m256i k = load_eight(length + i);
        const __m256 quotient = _mm256_div_ps(_mm256_loadu_ps(rest + i), _mm256_loadu_ps(over + i));
        const __m256 part = _mm256_mul_ps(quotient, _mm256_set1_ps(by));
        const __m256 up = _mm256_mul_ps(_mm256_cvtepi32_ps(k), _mm256_set1_ps(more));
        const __m256 beyond = _mm256_add_ps(_mm256_add_ps(up, part), _mm256_set1_ps(4.5f));
        const __m256i down = _mm256_cvttps_epi32(beyond);
        const __m256 fraction = _mm256_sub_ps(beyond, _mm256_cvtepi32_ps(down));
        const __m256 from_half =
            _mm256_andnot_ps(_mm256_set1_ps(-0.0f), _mm256_sub_ps(fraction, _mm256_set1_ps(0.5f)));
        const __m256 doubt = _mm256_cmp_ps(from_half, _mm256_set1_ps(0.5f - 0x1p-16f), _CMP_GT_OQ);
        store_eight(length + i, _mm256_add_epi32(k, _mm256_sub_epi32(down, _mm256_set1_epi32(4))));
        for (int32_t j = 0; _mm256_movemask_ps(doubt) != 0 && j < 8; j++) {
            const double z = b[i + j] + (b[i + j] & doubled) - less;
            length[i + j] = ntp__fixed_length(4.0 * xy[i + j] + 2.0 + z * z, 65535);
        }
    }
}

#endif
