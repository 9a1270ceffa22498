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

static inline __m128i choose(__m128i mask, __m128i yes, __m128i no)
{
    return _mm_or_si128(_mm_and_si128(mask, yes), _mm_andnot_si128(mask, no));
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

/*
 * Of each of 16 bytes a, b and c the one that is nearest to a + b - c.  Where b - c and a - c have the
 * same sign, c is as far as both others together, and never the nearest before them; else as far as
 * they differ.
 */
static inline wide paeth_bytes(wide a, wide b, wide c)
{
    const wide under_b = _mm_subs_epu8(b, c), over_b = _mm_subs_epu8(c, b);
    const wide under_a = _mm_subs_epu8(a, c), over_a = _mm_subs_epu8(c, a);
    const wide to_a = _mm_or_si128(under_b, over_b), to_b = _mm_or_si128(under_a, over_a);
    const wide zero = _mm_setzero_si128();
    const wide same = _mm_xor_si128(_mm_cmpeq_epi8(under_b, zero), _mm_cmpeq_epi8(over_a, zero));
    const wide apart = _mm_or_si128(_mm_subs_epu8(to_a, to_b), _mm_subs_epu8(to_b, to_a));
    const wide to_c = _mm_or_si128(apart, same);
    const wide least = _mm_min_epu8(to_c, _mm_min_epu8(to_a, to_b));
    const wide b_or_c = choose(_mm_cmpeq_epi8(least, to_b), b, c);
    return choose(_mm_cmpeq_epi8(least, to_a), a, b_or_c);
}

static inline wide foretold16(wide a, wide b, wide c, int kind)
{
    switch (kind) {
    case NONE:
        return _mm_setzero_si128();
    case SUB:
        return a;
    case UP:
        return b;
    case AVERAGE:
        return average(a, b);
    default:
        return paeth_bytes(a, b, c);
    }
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
