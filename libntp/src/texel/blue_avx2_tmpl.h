/* SPDX-License-Identifier: MIT */
/*
 * blue_avx2_tmpl.h - the blue that is derived from red and green, with AVX2
 *
 * Red and green are the halves of 32 bits, so pmaddwd adds up their squares; or, of 8 bit, those of 16
 * bits.  Files that are compiled for AVX2 include it.
 */
#ifndef NTP_BLUE_AVX2_TMPL_H
#define NTP_BLUE_AVX2_TMPL_H

#include "base/lanes_avx2.h"

#include <stdbool.h>

/* A byte that becomes 0 in a shuffle. */
#define N -1

enum { REST_8 = (255 * 255 - 5) / 4, REST_16 = 1073709055 /* (65535^2 - 5) / 4 */ };

/* e = (S - 3) / 4 of pairs, as in kernels.c; negative where they are too long.  a(a + 1) is
 * -a(-1 - a), and neither factor is beyond a word. */
static inline __m256i rest_of(__m256i rg, bool deep)
{
    const __m256i a = _mm256_sub_epi16(rg, _mm256_set1_epi16((short) (deep ? -32768 : 128)));
    const __m256i c = _mm256_sub_epi16(_mm256_set1_epi16(deep ? 32767 : 127), rg);
    return _mm256_add_epi32(_mm256_set1_epi32(deep ? REST_16 : REST_8), _mm256_madd_epi16(a, c));
}

/*
 * Of eight pairs of sizes (|X| + 1)/2, which are (1, 1) above the least of four around a projection, the one that pull
 * takes, as (|X| - 1)/2: the greater one of |X| and |Y| grows by one where it can, else the lesser one.  `from`
 * has these as (|X| - 1)/2 before; where they are equal, none grows.
 */
static inline __m256i onto_disc(__m256i sizes, __m256i from, bool deep)
{
    const __m256i other =
        _mm256_or_si256(_mm256_slli_epi32(sizes, 16), _mm256_srli_epi32(sizes, 16));
    const __m256i beside =
        _mm256_or_si256(_mm256_slli_epi32(from, 16), _mm256_srli_epi32(from, 16));
    const __m256i ones = _mm256_set1_epi16(1), least = _mm256_sub_epi16(sizes, ones);
    /* e of the least pair; a size that grows takes 2 of itself off */
    const __m256i e = _mm256_sub_epi32(_mm256_set1_epi32(deep ? REST_16 : REST_8),
                                       _mm256_madd_epi16(sizes, least));
    const __m256i low = _mm256_madd_epi16(_mm256_min_epi16(sizes, other), ones);
    const __m256i high = _mm256_madd_epi16(_mm256_max_epi16(sizes, other), ones);
    const __m256i stops = _mm256_cmpgt_epi32(high, e), ends = _mm256_cmpgt_epi32(low, e);
    const __m256i grows =
        _mm256_blendv_epi8(_mm256_cmpgt_epi16(from, beside),
                           _mm256_andnot_si256(ends, _mm256_cmpgt_epi16(beside, from)), stops);
    return _mm256_sub_epi16(least, grows);
}

/* floor(sqrt(e)), any number where e is negative; as in root30.h.  Roots of 16 bits are below 2^15, or are
 * 2^15 by rounding: pmaddwd squares that correctly too, although a signed word reads it as -2^15.
 * The root of e < 2^14 (not deep) is more than 2^-8 below a whole number, so the float is never one
 * too great. */
static inline __m256i root_of(__m256i e, bool deep)
{
    const __m256i t = _mm256_cvttps_epi32(_mm256_sqrt_ps(_mm256_cvtepi32_ps(e)));
    return deep ? _mm256_add_epi32(t, _mm256_cmpgt_epi32(_mm256_madd_epi16(t, t), e)) : t;
}

/* The derived blue, as in kernels.c. */
static inline __m256i blue_of(__m256i e, __m256i t, bool deep, bool zzero)
{
    if (!zzero)
        return _mm256_add_epi32(t, _mm256_set1_epi32(deep ? 32768 : 128));
    const __m256i d2 = _mm256_slli_epi32(_mm256_sub_epi32(e, _mm256_madd_epi16(t, t)), 1);
    const __m256i t2 = _mm256_add_epi32(t, t);
    const __m256i below1 = _mm256_cmpgt_epi32(t, _mm256_add_epi32(d2, _mm256_set1_epi32(1)));
    const __m256i below2 = _mm256_cmpgt_epi32(_mm256_add_epi32(t2, t), d2);
    return _mm256_add_epi32(_mm256_add_epi32(t2, _mm256_set1_epi32(2)),
                            _mm256_add_epi32(below1, below2));
}

/* e of 16 pairs of bytes, as words.  For a = r - 128, a(a + 1) is p(p + 1), where p is a or -1 - a,
 * and at most 127.  So two of these fit into a word. */
static inline __m256i rest_words(__m256i pairs)
{
    const __m256i a = _mm256_xor_si256(pairs, _mm256_set1_epi8(-128));
    const __m256i p = _mm256_xor_si256(a, _mm256_cmpgt_epi8(_mm256_setzero_si256(), a));
    const __m256i sum = _mm256_maddubs_epi16(_mm256_sub_epi8(p, _mm256_set1_epi8(-1)), p);
    return _mm256_sub_epi16(_mm256_set1_epi16(REST_8), sum);
}

/* Their roots. */
static inline __m256i root_words(__m256i e)
{
    const __m256i zero = _mm256_setzero_si256();
    return _mm256_packs_epi32(root_of(_mm256_unpacklo_epi16(e, zero), false),
                              root_of(_mm256_unpackhi_epi16(e, zero), false));
}

/* Red and green of sixteen packed pixels of 8 bit, as words of bytes.  Each half is of eight pixels,
 * of which `low` has the bytes 0 to 15, and `high` 8 to 23. */
static inline __m256i pairs_of(__m256i low, __m256i high)
{
    return _mm256_or_si256(SHUFFLE(low, 0, 1, 3, 4, 6, 7, 9, 10, 12, 13, N, N, N, N, N, N),
                           SHUFFLE(high, N, N, N, N, N, N, N, N, N, N, 7, 8, 10, 11, 13, 14));
}

/* Puts blues, which are words, into these bytes, and stores them. */
static inline void put_words(uint8_t *dst, __m256i *low, __m256i *high, __m256i blues)
{
    const __m256i ones = _mm256_set1_epi8(-1);
    *low = _mm256_blendv_epi8(*low, SHUFFLE(blues, N, N, 0, N, N, 2, N, N, N, N, N, N, N, N, N, N),
                              SHUFFLE(ones, N, N, 0, N, N, 0, N, N, N, N, N, N, N, N, N, N));
    *high =
        _mm256_blendv_epi8(*high, SHUFFLE(blues, 4, N, N, 6, N, N, 8, N, N, 10, N, N, 12, N, N, 14),
                           SHUFFLE(ones, 0, N, N, 0, N, N, 0, N, N, 0, N, N, 0, N, N, 0));
    /* The bytes 8 to 15 come from `high`. */
    store_two(dst, dst + 24, *low);
    store_two(dst + 8, dst + 32, *high);
}

#endif
