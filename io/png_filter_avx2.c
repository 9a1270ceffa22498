/* SPDX-License-Identifier: MIT */
/*
 * png_filter_avx2.c - 32 bytes at once, with AVX2: row filters done, and their sums
 */
#include <immintrin.h>

#include "png_filter.h"

enum { NONE, SUB, UP, AVERAGE, PAETH, AT_ONCE = 32 };

typedef __m256i wide; /* 32 bytes */

static inline wide load_wide(const uint8_t *from)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) from);
}

static inline wide average(wide a, wide b)
{
    const wide odd = _mm256_and_si256(_mm256_xor_si256(a, b), _mm256_set1_epi8(1));
    return _mm256_sub_epi8(_mm256_avg_epu8(a, b), odd); /* avg rounds up */
}

/* As paeth_bytes with SSE2, which says why. */
static inline wide paeth(wide a, wide b, wide c)
{
    const wide under_b = _mm256_subs_epu8(b, c), over_b = _mm256_subs_epu8(c, b);
    const wide under_a = _mm256_subs_epu8(a, c), over_a = _mm256_subs_epu8(c, a);
    const wide to_a = _mm256_or_si256(under_b, over_b), to_b = _mm256_or_si256(under_a, over_a);
    const wide zero = _mm256_setzero_si256();
    const wide same = _mm256_xor_si256(_mm256_cmpeq_epi8(under_b, zero), //
                                       _mm256_cmpeq_epi8(over_a, zero));
    const wide apart = _mm256_or_si256(_mm256_subs_epu8(to_a, to_b), _mm256_subs_epu8(to_b, to_a));
    const wide to_c = _mm256_or_si256(apart, same);
    const wide least = _mm256_min_epu8(to_c, _mm256_min_epu8(to_a, to_b));
    const wide b_or_c = _mm256_blendv_epi8(c, b, _mm256_cmpeq_epi8(least, to_b));
    return _mm256_blendv_epi8(b_or_c, a, _mm256_cmpeq_epi8(least, to_a));
}

static inline wide foretold(wide a, wide b, wide c, int kind)
{
    switch (kind) {
    case SUB:
        return a;
    case UP:
        return b;
    case AVERAGE:
        return average(a, b);
    default:
        return paeth(a, b, c);
    }
}

/* The kind is known to the compiler. */
static inline size_t filter_kind(uint8_t *out, const uint8_t *row, const uint8_t *above,
                                 size_t size, size_t texel, int kind)
{
    size_t i = 0;
    for (; i + AT_ONCE <= size; i += AT_ONCE) {
        const wide a = load_wide(row + i - texel), b = load_wide(above + i);
        const wide told = foretold(a, b, load_wide(above + i - texel), kind);
        _mm256_storeu_si256((__m256i *) (void *) (out + i),
                            _mm256_sub_epi8(load_wide(row + i), told));
    }
    return i;
}

size_t ntpio__filter_avx2(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                          size_t texel, int kind)
{
    switch (kind) {
    case NONE:
        return 0;
    case SUB:
        return filter_kind(out, row, above, size, texel, SUB);
    case UP:
        return filter_kind(out, row, above, size, texel, UP);
    case AVERAGE:
        return filter_kind(out, row, above, size, texel, AVERAGE);
    default:
        return filter_kind(out, row, above, size, texel, PAETH);
    }
}

/* Adds the distance of each byte from 0 modulo 256; four sums, whose sum counts. */
static inline wide add_distances(wide sum, wide value)
{
    return _mm256_add_epi64(sum, _mm256_sad_epu8(_mm256_abs_epi8(value), _mm256_setzero_si256()));
}

static inline uint64_t total(wide sums)
{
    uint64_t of[4];
    _mm256_storeu_si256((__m256i *) (void *) of, sums);
    return of[0] + of[1] + of[2] + of[3];
}

size_t ntpio__filter_sums_avx2(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                               uint64_t *of_kinds)
{
    wide sums[NTPIO__FILTERS];
    size_t i = 0;
    for (int kind = NONE; kind <= PAETH; kind++)
        sums[kind] = _mm256_setzero_si256();
    for (; i + AT_ONCE <= size; i += AT_ONCE) {
        const wide value = load_wide(row + i), a = load_wide(row + i - texel);
        const wide b = load_wide(above + i), c = load_wide(above + i - texel);
        sums[NONE] = add_distances(sums[NONE], value);
        sums[SUB] = add_distances(sums[SUB], _mm256_sub_epi8(value, a));
        sums[UP] = add_distances(sums[UP], _mm256_sub_epi8(value, b));
        sums[AVERAGE] = add_distances(sums[AVERAGE], _mm256_sub_epi8(value, average(a, b)));
        sums[PAETH] = add_distances(sums[PAETH], _mm256_sub_epi8(value, paeth(a, b, c)));
    }
    for (int kind = NONE; kind <= PAETH; kind++)
        of_kinds[kind] = total(sums[kind]);
    return i;
}
