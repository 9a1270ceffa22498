/* SPDX-License-Identifier: MIT */
/*
 * survey_avx512_tmpl.h - extremes and sums of packed 16-bit texels, with AVX-512
 *
 * As survey() in judge_tmpl.h, straight from the pixels.
 */
#ifndef NTP_SURVEY_AVX512_TMPL_H
#define NTP_SURVEY_AVX512_TMPL_H

#include "base/view.h"
#include "texel/judged.h"
#include "texel/kernels.h"
#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"

ONE_COPY static uint64_t sum_of(const __m512i *v)
{
    const __m512i odd = _mm512_srli_epi64(*v, 32),
                  even = _mm512_and_si512(*v, _mm512_set1_epi64(UINT32_MAX));
    return (uint64_t) _mm512_reduce_add_epi64(_mm512_add_epi64(odd, even));
}

ONE_COPY static uint32_t greatest_of(const __m512i *v)
{
    return _mm512_reduce_max_epu32(*v);
}

/* Extremes and sums of n packed texels, a multiple of 16; and which are odd, of each 16. */
static void survey(ntp__survey *to, __mmask16 *odd, const uint16_t *rgb, int32_t n)
{
    enum { AHEAD = NTP__BLOCK };
    const __m512i zero = _mm512_setzero_si512(), ones = all(-1), low = all(65535);
    __m512i most = zero, most_b = zero, inverted = zero, inverted_b = zero;
    __m512i sum[3] = { zero, zero, zero };
    for (int32_t i = 0; i < n; i += LANES_512) {
        const texels t = take16((const uint8_t *) (rgb + (size_t) 3 * i));
        const __m512i other = _mm512_xor_si512(t.rg, ones);
        const char *const ahead = (const char *) (rgb + (size_t) 3 * (i + AHEAD));
        _mm_prefetch(ahead, _MM_HINT_T0);
        _mm_prefetch(ahead + 64, _MM_HINT_T0);
        const __m512i grays = _mm512_or_si512(t.b, _mm512_slli_epi32(t.b, 16));
        const __m512i narrow = _mm512_or_si512(_mm512_xor_si512(t.rg, _mm512_srli_epi16(t.rg, 8)),
                                               _mm512_xor_si512(t.b, _mm512_srli_epi16(t.b, 8)));
        /* 32767 and 32768 */
        const __m512i flat = _mm512_min_epu16(_mm512_xor_si512(t.rg, all(0x7FFF7FFF)),
                                              _mm512_xor_si512(other, all(0x7FFF7FFF)));
        most = _mm512_max_epu16(most, t.rg);
        inverted = _mm512_max_epu16(inverted, other);
        most_b = _mm512_max_epu16(most_b, t.b);
        inverted_b = _mm512_max_epu16(inverted_b, _mm512_xor_si512(t.b, low));
        sum[0] = _mm512_add_epi32(sum[0], _mm512_and_si512(t.rg, low));
        sum[1] = _mm512_add_epi32(sum[1], _mm512_srli_epi32(t.rg, 16));
        sum[2] = _mm512_add_epi32(sum[2], t.b);
        odd[group_of(i)] = _mm512_testn_epi32_mask(narrow, all(0x00FF00FF)) |
                           _mm512_testn_epi32_mask(flat, flat) |
                           _mm512_cmpeq_epi32_mask(t.rg, grays);
    }
    const __m512i extremes[6] = {
        _mm512_and_si512(most, low),     _mm512_srli_epi32(most, 16),     most_b,
        _mm512_and_si512(inverted, low), _mm512_srli_epi32(inverted, 16), inverted_b,
    };
    for (int32_t k = 0; k < 3; k++) {
        to->sum[k] = (uint32_t) sum_of(&sum[k]);
        to->greatest[k] = greatest_of(&extremes[k]);
        to->least[k] = 65535 - greatest_of(&extremes[3 + k]);
    }
}

#endif
