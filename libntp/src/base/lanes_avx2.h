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
#  include <stddef.h>
#  include <stdint.h>

/* Zeros the upper halves of registers: call this last in files that are compiled with -Os, as GCC does so
 * only at other levels.  Code for SSE takes up to 2.6 times as long where they are not zero. */
static inline void end_lanes(void)
{
    _mm256_zeroupper();
}

/* Two loads of 16 bytes, or two stores. */
static inline __m256i load_two(const void *low, const void *high)
{
    return _mm256_inserti128_si256(_mm256_castsi128_si256(_mm_loadu_si128(low)),
                                   _mm_loadu_si128(high), 1);
}

/* load_two of 16 bytes that lie `apart`, from 16 on; all between them are read.  Of two whole loads, as a
 * blend is done in more places than what puts 16 bytes into a vector. */
static inline __m256i load_apart(const uint8_t *s, ptrdiff_t apart)
{
    return _mm256_blend_epi32(_mm256_loadu_si256((const void *) s),
                              _mm256_loadu_si256((const void *) (s + apart - 16)), 0xf0);
}

static inline void store_two(void *low, void *high, __m256i v)
{
    _mm_storeu_si128(low, _mm256_castsi256_si128(v));
    _mm_storeu_si128(high, _mm256_extracti128_si256(v, 1));
}

/* The shuffle of both halves; -1: a byte that becomes 0. */
#  define SHUFFLE(v, ...) _mm256_shuffle_epi8((v), _mm256_setr_epi8(__VA_ARGS__, __VA_ARGS__))

/* Stores 16 packed pixels.  `rg` holds red and green as bytes, `b` blue as words; the low half of each is
 * of the first eight. */
static inline void store_pixels(uint8_t *d, __m256i rg, __m256i b)
{
    store_two(
        d, d + 24,
        _mm256_or_si256(SHUFFLE(rg, 0, 1, -1, 2, 3, -1, 4, 5, -1, 6, 7, -1, 8, 9, -1, 10),
                        SHUFFLE(b, -1, -1, 0, -1, -1, 2, -1, -1, 4, -1, -1, 6, -1, -1, 8, -1)));
    store_two(
        d + 8, d + 32,
        _mm256_or_si256(SHUFFLE(rg, -1, 6, 7, -1, 8, 9, -1, 10, 11, -1, 12, 13, -1, 14, 15, -1),
                        SHUFFLE(b, 4, -1, -1, 6, -1, -1, 8, -1, -1, 10, -1, -1, 12, -1, -1, 14)));
}

#endif
#endif
