/* SPDX-License-Identifier: MIT */
/*
 * png_filter_sse2_tmpl.h - texels and 16 bytes at once for filters, with SSE2; a part of png_filter.c
 */
#include <emmintrin.h>

typedef __m128i bytes; /* of a texel, in the low half; the rest is anything */
typedef __m128i wide;  /* 16 bytes */
typedef __m128i sums;  /* two sums, whose sum counts */

/* In two parts at most, which stay in registers. */
static inline bytes load(const uint8_t *from, size_t texel)
{
    if (texel == 4) {
        int32_t four;
        memcpy(&four, from, sizeof four);
        return _mm_cvtsi32_si128(four);
    }
    if (texel == 8)
        return _mm_loadl_epi64((const __m128i *) (const void *) from);
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    uint32_t low = 0, high = 0;
    memcpy(&low, from, whole);
    memcpy(&high, from + whole, rest);
    return _mm_cvtsi64_si128((long long) (low | (uint64_t) high << 8 * whole));
}

static inline void store(uint8_t *to, bytes value, size_t texel)
{
    if (texel == 4) {
        const int32_t four = _mm_cvtsi128_si32(value);
        memcpy(to, &four, sizeof four);
        return;
    }
    if (texel == 8) {
        _mm_storel_epi64((__m128i *) (void *) to, value);
        return;
    }
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    const uint64_t all = (uint64_t) _mm_cvtsi128_si64(value);
    const uint64_t above = all >> 8 * whole;
    memcpy(to, &all, whole);
    memcpy(to + whole, &above, rest);
}

static inline bytes average(bytes a, bytes b)
{
    const bytes odd = _mm_and_si128(_mm_xor_si128(a, b), _mm_set1_epi8(1)); /* avg rounds up */
    return _mm_sub_epi8(_mm_avg_epu8(a, b), odd);
}

static inline __m128i absolute(__m128i v)
{
    return _mm_max_epi16(v, _mm_sub_epi16(_mm_setzero_si128(), v));
}

static inline __m128i choose(__m128i mask, __m128i yes, __m128i no)
{
    return _mm_or_si128(_mm_and_si128(mask, yes), _mm_andnot_si128(mask, no));
}

/* Of eight numbers of 16 bits.  Of a, b and c the one that is nearest to a + b - c. */
static inline __m128i paeth16(__m128i a16, __m128i b16, __m128i c16)
{
    const __m128i b_c = _mm_sub_epi16(b16, c16), a_c = _mm_sub_epi16(a16, c16);
    const __m128i to_a = absolute(b_c), to_b = absolute(a_c);
    const __m128i to_c = absolute(_mm_add_epi16(b_c, a_c));
    const __m128i least = _mm_min_epi16(to_c, _mm_min_epi16(to_a, to_b));
    const __m128i b_or_c = choose(_mm_cmpeq_epi16(least, to_b), b16, c16);
    return choose(_mm_cmpeq_epi16(least, to_a), a16, b_or_c);
}

static inline wide load16(const uint8_t *from)
{
    return _mm_loadu_si128((const __m128i *) (const void *) from);
}

static inline void store16(uint8_t *to, wide value)
{
    _mm_storeu_si128((__m128i *) (void *) to, value);
}

static inline wide add16(wide a, wide b)
{
    return _mm_add_epi8(a, b);
}

static inline wide subtract16(wide a, wide b)
{
    return _mm_sub_epi8(a, b);
}

static inline wide foretold16(wide a, wide b, wide c, int kind)
{
    const __m128i zero = _mm_setzero_si128();
    if (kind == NONE || kind == SUB || kind == UP)
        return kind == NONE ? zero : kind == SUB ? a : b;
    if (kind == AVERAGE)
        return average(a, b);
    return _mm_packus_epi16(
        paeth16(_mm_unpacklo_epi8(a, zero), _mm_unpacklo_epi8(b, zero), _mm_unpacklo_epi8(c, zero)),
        paeth16(_mm_unpackhi_epi8(a, zero), _mm_unpackhi_epi8(b, zero),
                _mm_unpackhi_epi8(c, zero)));
}

static inline sums no_sums(void)
{
    return _mm_setzero_si128();
}

/* Adds the distance of each byte from 0 modulo 256. */
static inline sums add_distances(sums sum, wide value)
{
    const __m128i zero = _mm_setzero_si128();
    const __m128i away = _mm_min_epu8(value, _mm_sub_epi8(zero, value));
    return _mm_add_epi64(sum, _mm_sad_epu8(away, zero));
}

static inline uint64_t total(sums sum)
{
    return (uint64_t) _mm_cvtsi128_si64(sum) +
           (uint64_t) _mm_cvtsi128_si64(_mm_unpackhi_epi64(sum, sum));
}
