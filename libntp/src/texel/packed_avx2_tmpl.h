/* SPDX-License-Identifier: MIT */
/*
 * packed_avx2_tmpl.h - packed RGB in registers, with AVX2: pixels to levels and back
 *
 * Red and green are the halves of 32 bits, so pmaddwd adds up their squares.  Files that are compiled
 * for AVX2 alone include it.
 */
#ifndef NTP_PACKED_AVX2_TMPL_H
#define NTP_PACKED_AVX2_TMPL_H

#include "libntp.h"
#include "texel/blue_avx2_tmpl.h"

#include <immintrin.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Eight texels: r | g << 16, and b. */
typedef struct texels {
    __m256i rg, b;
} texels;

static inline texels take8(const uint8_t *s)
{
    const __m256i v = load_two(s, s + 12);
    const texels t = { SHUFFLE(v, 0, N, 1, N, 3, N, 4, N, 6, N, 7, N, 9, N, 10, N),
                       SHUFFLE(v, 2, N, N, N, 5, N, N, N, 8, N, N, N, 11, N, N, N) };
    return t;
}

__attribute__((always_inline)) static inline texels take16(const uint8_t *s)
{
    const __m256i v = load_two(s, s + 24), w = load_two(s + 8, s + 32);
    const texels t = {
        _mm256_or_si256(SHUFFLE(v, 0, 1, 2, 3, 6, 7, 8, 9, N, N, N, N, N, N, N, N),
                        SHUFFLE(w, N, N, N, N, N, N, N, N, 4, 5, 6, 7, 10, 11, 12, 13)),
        _mm256_or_si256(SHUFFLE(v, 4, 5, N, N, 10, 11, N, N, N, N, N, N, N, N, N, N),
                        SHUFFLE(w, N, N, N, N, N, N, N, N, 8, 9, N, N, 14, 15, N, N))
    };
    return t;
}

static inline void store(uint8_t *d, __m128i v)
{
    _mm_storeu_si128((__m128i *) (void *) d, v);
}

static inline void put16(uint8_t *d, texels t)
{
    const __m256i first =
        _mm256_or_si256(SHUFFLE(t.rg, 0, 1, 2, 3, N, N, 4, 5, 6, 7, N, N, 8, 9, 10, 11),
                        SHUFFLE(t.b, N, N, N, N, 0, 1, N, N, N, N, 4, 5, N, N, N, N));
    /* Bytes 8 to 23 of four texels */
    const __m256i last =
        _mm256_or_si256(SHUFFLE(t.rg, 6, 7, N, N, 8, 9, 10, 11, N, N, 12, 13, 14, 15, N, N),
                        SHUFFLE(t.b, N, N, 4, 5, N, N, N, N, 8, 9, N, N, N, N, 12, 13));
    store(d, _mm256_castsi256_si128(first));
    store(d + 8, _mm256_castsi256_si128(last));
    store(d + 24, _mm256_extracti128_si256(first, 1));
    store(d + 32, _mm256_extracti128_si256(last, 1));
}

/* Sixteen texels, not a byte more: dst may be src. */
static inline void put8(uint8_t *d, texels t, texels u)
{
    const __m256i v = SHUFFLE(_mm256_or_si256(t.rg, _mm256_slli_epi32(t.b, 8)), 0, 2, 1, 4, 6, 5, 8,
                              10, 9, 12, 14, 13, N, N, N, N);
    const __m256i w = SHUFFLE(_mm256_or_si256(u.rg, _mm256_slli_epi32(u.b, 8)), 0, 2, 1, 4, 6, 5, 8,
                              10, 9, 12, 14, 13, N, N, N, N);
    const __m128i v0 = _mm256_castsi256_si128(v), v1 = _mm256_extracti128_si256(v, 1);
    const __m128i w0 = _mm256_castsi256_si128(w), w1 = _mm256_extracti128_si256(w, 1);
    store(d, _mm_or_si128(v0, _mm_slli_si128(v1, 12)));
    store(d + 16, _mm_or_si128(_mm_srli_si128(v1, 4), _mm_slli_si128(w0, 8)));
    store(d + 32, _mm_or_si128(_mm_srli_si128(w0, 8), _mm_slli_si128(w1, 4)));
}

/* Texels i to i + 15 of the n of a row, not a byte beyond these. */
static inline void put_step(uint8_t *d, int32_t i, int32_t n, const texels t[2], bool deep)
{
    const ptrdiff_t size = deep ? 6 : 3;
    uint8_t few[6 * 16], *to = n - i < 16 ? few : d + size * i;
    if (deep) {
        put16(to, t[0]);
        put16(to + size * 8, t[1]);
    } else {
        put8(to, t[0], t[1]);
    }
    if (to == few)
        memcpy(d + size * i, few, (size_t) (size * (n - i)));
}

/* Adds the places of those of the texels i to i + 15 that have their bit; returns how many. */
static inline int32_t add_places(int32_t *at, int32_t i, int32_t n, const uint32_t bits[2])
{
    uint32_t left = bits[0] | bits[1] << 8;
    int32_t found = 0;
    left &= n - i < 16 ? (1U << (n - i)) - 1 : left;
    for (; left != 0; left &= left - 1)
        at[found++] = i + __builtin_ctz(left);
    return found;
}

/* The blue of unused colors whose red and green are those of black or of white; -1: none are unused. */
typedef struct unused_blues {
    int32_t black, white;
} unused_blues;

static inline unused_blues blues_of_unused(int32_t m, uint32_t touch_unused)
{
    return (unused_blues) { touch_unused & NTP_UNUSED_BLACK ? -1 : 0,
                            touch_unused & NTP_UNUSED_WHITE ? -1 : m };
}

static inline __m256i unused_of(texels t, const unused_blues *ends)
{
    const __m256i black = _mm256_and_si256(_mm256_cmpeq_epi32(t.rg, _mm256_setzero_si256()),
                                           _mm256_cmpeq_epi32(t.b, _mm256_set1_epi32(ends->black)));
    const __m256i white = _mm256_and_si256(_mm256_cmpeq_epi32(t.rg, _mm256_set1_epi32(-1)),
                                           _mm256_cmpeq_epi32(t.b, _mm256_set1_epi32(ends->white)));
    return _mm256_or_si256(black, white);
}

/* a(a + 1) + c(c + 1) of pairs, less the level of 0. */
static inline __m256i sum_of_pair(__m256i pair)
{
    return _mm256_add_epi32(_mm256_madd_epi16(pair, pair),
                            _mm256_madd_epi16(pair, _mm256_set1_epi16(1)));
}

static inline __m256i rest_of_pair(__m256i pair, bool deep)
{
    return _mm256_sub_epi32(_mm256_set1_epi32(deep ? REST_16 : REST_8), sum_of_pair(pair));
}

/* Pulls those of eight rounded pairs that are too long, whose e is negative: as level.c says, none is more than
 * (1, 1) above the least of the four. */
static inline __m256i pulled(__m256i pair, __m256i *e, bool deep)
{
    const __m256i sign = _mm256_srai_epi16(pair, 15), q = _mm256_xor_si256(pair, sign);
    const __m256i to = _mm256_blendv_epi8(q, onto_disc(q, q, deep), _mm256_srai_epi32(*e, 31));
    *e = rest_of_pair(to, deep);
    return _mm256_xor_si256(to, sign);
}

#endif
