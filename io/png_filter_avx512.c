/* SPDX-License-Identifier: MIT */
/*
 * png_filter_avx512.c - 64 bytes at once, with AVX-512: row filters done, and their sums
 *
 * The last 64 bytes of a row overlap those before them: of the sums, only the new ones count.
 */
#include <immintrin.h>
#include <stdbool.h>

#include "png_filter.h"

enum { NONE, SUB, UP, AVERAGE, PAETH, AT_ONCE = 64 };

typedef __m512i wide; /* 64 bytes */

static inline wide load_wide(const uint8_t *from)
{
    return _mm512_loadu_si512(from);
}

static inline wide average(wide a, wide b)
{
    const wide odd = _mm512_and_si512(_mm512_xor_si512(a, b), _mm512_set1_epi8(1));
    return _mm512_sub_epi8(_mm512_avg_epu8(a, b), odd); /* avg rounds up */
}

static inline __mmask64 is_zero(wide v)
{
    return _mm512_testn_epi8_mask(v, v);
}

/* As paeth_bytes with SSE2, which says why. */
static inline wide paeth(wide a, wide b, wide c)
{
    const wide under_b = _mm512_subs_epu8(b, c), over_b = _mm512_subs_epu8(c, b);
    const wide under_a = _mm512_subs_epu8(a, c), over_a = _mm512_subs_epu8(c, a);
    const wide to_a = _mm512_or_si512(under_b, over_b), to_b = _mm512_or_si512(under_a, over_a);
    const wide apart = _mm512_or_si512(_mm512_subs_epu8(to_a, to_b), _mm512_subs_epu8(to_b, to_a));
    const wide to_c =
        _mm512_mask_mov_epi8(apart, is_zero(under_b) ^ is_zero(over_a), _mm512_set1_epi8(-1));
    const wide b_or_c = _mm512_mask_mov_epi8(c, _mm512_cmple_epu8_mask(to_b, to_c), b);
    return _mm512_mask_mov_epi8(b_or_c, _mm512_cmple_epu8_mask(to_a, _mm512_min_epu8(to_b, to_c)),
                                a);
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
static inline void filter_kind(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                               size_t texel, int kind)
{
    for (size_t i = 0; i < size; i += AT_ONCE) {
        const size_t at = i + AT_ONCE <= size ? i : size - AT_ONCE;
        const wide a = load_wide(row + at - texel), b = load_wide(above + at);
        const wide told = foretold(a, b, load_wide(above + at - texel), kind);
        _mm512_storeu_si512(out + at, _mm512_sub_epi8(load_wide(row + at), told));
    }
}

size_t ntpio__filter_avx512(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                            size_t texel, int kind)
{
    if (size < AT_ONCE || kind == NONE)
        return 0;
    switch (kind) {
    case SUB:
        filter_kind(out, row, above, size, texel, SUB);
        break;
    case UP:
        filter_kind(out, row, above, size, texel, UP);
        break;
    case AVERAGE:
        filter_kind(out, row, above, size, texel, AVERAGE);
        break;
    default:
        filter_kind(out, row, above, size, texel, PAETH);
        break;
    }
    return size;
}

/* Adds the distances of the bytes that count from 0 modulo 256; eight sums, whose sum counts. */
static inline wide add_distances(wide sum, wide value, bool all, __mmask64 which)
{
    const wide distances = all ? _mm512_abs_epi8(value) : _mm512_maskz_abs_epi8(which, value);
    return _mm512_add_epi64(sum, _mm512_sad_epu8(distances, _mm512_setzero_si512()));
}

static inline void add_block(wide *sums, const uint8_t *row, const uint8_t *above, size_t texel,
                             bool all, __mmask64 which)
{
    const wide value = load_wide(row), a = load_wide(row - texel);
    const wide b = load_wide(above), c = load_wide(above - texel);
    sums[NONE] = add_distances(sums[NONE], value, all, which);
    for (int kind = SUB; kind <= PAETH; kind++)
        sums[kind] =
            add_distances(sums[kind], _mm512_sub_epi8(value, foretold(a, b, c, kind)), all, which);
}

size_t ntpio__filter_sums_avx512(const uint8_t *row, const uint8_t *above, size_t size,
                                 size_t texel, uint64_t *of_kinds)
{
    wide sums[NTPIO__FILTERS];
    size_t i = 0;
    if (size < AT_ONCE)
        return 0;
    for (int kind = NONE; kind <= PAETH; kind++)
        sums[kind] = _mm512_setzero_si512();
    for (; i + AT_ONCE <= size; i += AT_ONCE)
        add_block(sums, row + i, above + i, texel, true, 0);
    if (i < size) {
        const size_t at = size - AT_ONCE;
        add_block(sums, row + at, above + at, texel, false, ~(__mmask64) 0 << (i - at));
    }
    for (int kind = NONE; kind <= PAETH; kind++)
        of_kinds[kind] = (uint64_t) _mm512_reduce_add_epi64(sums[kind]);
    return size;
}
