/* SPDX-License-Identifier: MIT */
/*
 * lanes_avx2.h - loads, stores and shuffles by the halves of a vector
 *
 * Packed pixels do not fill a vector, so most loops read and write two lots of 16 bytes.
 */
#ifndef NTP_LANES_AVX2_H
#define NTP_LANES_AVX2_H

#ifdef __AVX2__
#  include <immintrin.h>

/* Two loads of 16 bytes, or two stores. */
static inline __m256i load_two(const void *low, const void *high)
{
    return _mm256_inserti128_si256(_mm256_castsi128_si256(_mm_loadu_si128(low)),
                                   _mm_loadu_si128(high), 1);
}

static inline void store_two(void *low, void *high, __m256i v)
{
    _mm_storeu_si128(low, _mm256_castsi256_si128(v));
    _mm_storeu_si128(high, _mm256_extracti128_si256(v, 1));
}

/* The shuffle of both halves; -1: a byte that becomes 0. */
#  define SHUFFLE(v, ...) _mm256_shuffle_epi8((v), _mm256_setr_epi8(__VA_ARGS__, __VA_ARGS__))

#endif
#endif
