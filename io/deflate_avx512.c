/* SPDX-License-Identifier: MIT */
/*
 * deflate_avx512.c - sums of the costs of literals with AVX-512, 64 bytes at once
 */
#include <immintrin.h>

#include "deflate_state.h"

enum {
    AT_ONCE = 64,
    HALF = 32,
    ENTRIES = 64, /* of the table, in a register */
    LAST = 0x0f0e /* bytes of the last word of 16 bytes */
};

typedef __m512i wide;

/* 64 costs, each in a byte. */
static inline wide part_of(const uint32_t *costs)
{
    uint8_t bytes[ENTRIES];
    for (int i = 0; i < ENTRIES; i += 16)
        _mm_storeu_si128((__m128i *) (void *) (bytes + i),
                         _mm512_cvtepi32_epi8(_mm512_loadu_si512(costs + i)));
    return _mm512_loadu_si512(bytes);
}

/* Sums of 32 words, each with all words before it. */
static inline wide running(wide words)
{
    const wide zero = _mm512_setzero_si512();
    wide v = _mm512_add_epi16(words, _mm512_bslli_epi128(words, 2));
    v = _mm512_add_epi16(v, _mm512_bslli_epi128(v, 4));
    v = _mm512_add_epi16(v, _mm512_bslli_epi128(v, 8));
    /* Of four parts; each gets the last words of the one, two and three parts before it. */
    const wide one = _mm512_alignr_epi64(_mm512_shuffle_epi8(v, _mm512_set1_epi16(LAST)), zero, 6);
    const wide two = _mm512_alignr_epi64(one, zero, 6), three = _mm512_alignr_epi64(one, zero, 4);
    return _mm512_add_epi16(_mm512_add_epi16(v, one), _mm512_add_epi16(two, three));
}

size_t ntpio__sum_costs_avx512(const uint8_t *bytes, size_t size, const uint32_t *costs,
                               uint32_t *sum, uint16_t *sums)
{
    const wide parts[] = { part_of(costs), part_of(costs + ENTRIES), part_of(costs + 2 * ENTRIES),
                           part_of(costs + 3 * ENTRIES) };
    const wide last = _mm512_set1_epi16(HALF - 1);
    wide before = _mm512_set1_epi16((short) *sum), all = _mm512_setzero_si512();
    size_t i = 0;
    for (; i + AT_ONCE <= size; i += AT_ONCE) {
        _mm_prefetch((const void *) ((uintptr_t) bytes + i + AHEAD), _MM_HINT_T0);
        const wide v = _mm512_loadu_si512(bytes + i);
        const wide cost = _mm512_mask_blend_epi8(_mm512_movepi8_mask(v),
                                                 _mm512_permutex2var_epi8(parts[0], v, parts[1]),
                                                 _mm512_permutex2var_epi8(parts[2], v, parts[3]));
        const wide first = _mm512_cvtepu8_epi16(_mm512_castsi512_si256(cost));
        const wide second = _mm512_cvtepu8_epi16(_mm512_extracti64x4_epi64(cost, 1));
        const wide to_first = running(first), to_second = running(second);
        all = _mm512_add_epi64(all, _mm512_sad_epu8(cost, _mm512_setzero_si512()));
        _mm512_storeu_si512(sums + i, _mm512_add_epi16(before, _mm512_sub_epi16(to_first, first)));
        before = _mm512_add_epi16(before, _mm512_permutexvar_epi16(last, to_first));
        _mm512_storeu_si512(sums + i + HALF,
                            _mm512_add_epi16(before, _mm512_sub_epi16(to_second, second)));
        before = _mm512_add_epi16(before, _mm512_permutexvar_epi16(last, to_second));
    }
    *sum += (uint32_t) _mm512_reduce_add_epi64(all);
    return i;
}
