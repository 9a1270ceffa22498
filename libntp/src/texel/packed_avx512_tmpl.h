/* SPDX-License-Identifier: MIT */
/*
 * packed_avx512_tmpl.h - packed RGB in registers, with AVX-512: pixels to levels and back
 *
 * As packed_avx2_tmpl.h and blue_avx2_tmpl.h, which say why the numbers are right, but 16 texels at a
 * time.  Files that are compiled for AVX-512 (F, BW and VBMI) include it.
 */
#ifndef NTP_PACKED_AVX512_TMPL_H
#define NTP_PACKED_AVX512_TMPL_H

#include "base/inlining.h"

#include <immintrin.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LANES_512 = 16 /* texels */ };

/* Sixteen texels: r | g << 16, and b. */
typedef struct texels {
    __m512i rg, b;
} texels;

/* i * by + first, for i from 0 to 15.  Of bytes, as compilers do not make a constant of each result. */
static inline __m512i steps_of(int32_t by, int32_t first)
{
    const __m512i i =
        _mm512_cvtepu8_epi32(_mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    return _mm512_add_epi32(_mm512_mullo_epi32(i, _mm512_set1_epi32(by)), _mm512_set1_epi32(first));
}

/* 48 bytes and zeros.  A load with a mask takes longer. */
static inline __m512i load_48(const uint8_t *s)
{
    const __m256i low = _mm256_loadu_si256((const void *) s);
    return _mm512_inserti32x4(_mm512_zextsi256_si512(low), _mm_loadu_si128((const void *) (s + 32)),
                              2);
}

/* Sixteen texels of 8 bit, after which there are zeros: byte 48 is one. */
static inline texels spread8(__m512i v)
{
    return (texels) { _mm512_permutexvar_epi8(steps_of(0x030003, 0x30013000), v),
                      _mm512_permutexvar_epi8(steps_of(3, 0x30303002), v) };
}

static inline texels take8(const uint8_t *s)
{
    return spread8(load_48(s));
}

static ALWAYS_INLINE texels take16(const uint8_t *s)
{
    const __m512i v = _mm512_loadu_si512(s);
    const __m512i w = _mm512_zextsi256_si512(_mm256_loadu_si256((const void *) (s + 64)));
    const __m512i rg = steps_of(0x030003, 0x010000), b = steps_of(3, 2);
    return (texels) { _mm512_permutex2var_epi16(v, rg, w),
                      _mm512_maskz_permutex2var_epi16(0x55555555, v, b, w) };
}

/* Sixteen texels, not a byte more: dst may be src. */
static inline void put8(uint8_t *d, texels t)
{
    static const _Alignas(64) uint8_t from[64] = {
        0,  2,  1,  4,  6,  5,  8,  10, 9,  12, 14, 13, 16, 18, 17, 20,
        22, 21, 24, 26, 25, 28, 30, 29, 32, 34, 33, 36, 38, 37, 40, 42,
        41, 44, 46, 45, 48, 50, 49, 52, 54, 53, 56, 58, 57, 60, 62, 61,
    };
    const __m512i v = _mm512_permutexvar_epi8(_mm512_load_si512(from),
                                              _mm512_or_si512(t.rg, _mm512_slli_epi32(t.b, 8)));
    _mm256_storeu_si256((void *) d, _mm512_castsi512_si256(v));
    _mm_storeu_si128((void *) (d + 32), _mm512_extracti32x4_epi32(v, 2));
}

static ALWAYS_INLINE void put16(uint8_t *d, texels t)
{
    /* 32 and more: of blue */
    static const uint8_t from[64] = {
        0,  1,  32, 2,  3,  34, 4,  5,  36, 6,  7,  38, 8,  9,  40, 10,
        11, 42, 12, 13, 44, 14, 15, 46, 16, 17, 48, 18, 19, 50, 20, 21,
        52, 22, 23, 54, 24, 25, 56, 26, 27, 58, 28, 29, 60, 30, 31, 62,
    };
    __m512i v[2];
    for (int k = 0; k < 2; k++) {
        const __m256i bytes = _mm256_loadu_si256((const void *) (from + 32 * k));
        v[k] = _mm512_permutex2var_epi16(t.rg, _mm512_cvtepu8_epi16(bytes), t.b);
    }
    _mm512_storeu_si512(d, v[0]);
    _mm256_storeu_si256((void *) (d + 64), _mm512_castsi512_si256(v[1]));
}

enum { REST_8 = (255 * 255 - 5) / 4, REST_16 = 1073709055 /* (65535^2 - 5) / 4 */ };

/* e = (S - 3) / 4 of pairs; negative where they are too long. */
static inline __m512i rest_of(__m512i rg, bool deep)
{
    const __m512i a = _mm512_sub_epi16(rg, _mm512_set1_epi16((short) (deep ? -32768 : 128)));
    const __m512i c = _mm512_sub_epi16(_mm512_set1_epi16(deep ? 32767 : 127), rg);
    return _mm512_add_epi32(_mm512_set1_epi32(deep ? REST_16 : REST_8), _mm512_madd_epi16(a, c));
}

/* The same of 32 pairs of bytes, as words.  p is the greater one of a = r - 128 and -1 - a. */
static inline __m512i rest_words(__m512i pairs)
{
    const __m512i p = _mm512_max_epi8(_mm512_xor_si512(pairs, _mm512_set1_epi8(-128)),
                                      _mm512_xor_si512(pairs, _mm512_set1_epi8(127)));
    return _mm512_sub_epi16(_mm512_set1_epi16(REST_8),
                            _mm512_maddubs_epi16(_mm512_add_epi8(p, _mm512_set1_epi8(1)), p));
}

/* As in blue_avx2_tmpl.h. */
static inline __m512i onto_disc(__m512i sizes, __m512i from, bool deep)
{
    const __m512i other = _mm512_rol_epi32(sizes, 16), beside = _mm512_rol_epi32(from, 16);
    const __m512i ones = _mm512_set1_epi16(1), least = _mm512_sub_epi16(sizes, ones);
    const __m512i e = _mm512_sub_epi32(_mm512_set1_epi32(deep ? REST_16 : REST_8),
                                       _mm512_madd_epi16(sizes, least));
    const __m512i low = _mm512_madd_epi16(_mm512_min_epi16(sizes, other), ones);
    const __m512i high = _mm512_madd_epi16(_mm512_max_epi16(sizes, other), ones);
    const __m512i by_lesser =
        _mm512_mask_mov_epi16(least, _mm512_cmplt_epi16_mask(from, beside), sizes);
    const __m512i by_greater =
        _mm512_mask_mov_epi16(least, _mm512_cmpgt_epi16_mask(from, beside), sizes);
    const __m512i to = _mm512_mask_mov_epi32(least, _mm512_cmple_epi32_mask(low, e), by_lesser);
    return _mm512_mask_mov_epi32(to, _mm512_cmple_epi32_mask(high, e), by_greater);
}

/* floor(sqrt(e)), any number where e is negative. */
static inline __m512i root_of(__m512i e, bool deep)
{
    const __m512i t = _mm512_cvttps_epi32(_mm512_sqrt_ps(_mm512_cvtepi32_ps(e)));
    if (!deep)
        return t;
    const __mmask16 over = _mm512_cmpgt_epi32_mask(_mm512_madd_epi16(t, t), e);
    return _mm512_mask_sub_epi32(t, over, t, _mm512_set1_epi32(1));
}

#endif
