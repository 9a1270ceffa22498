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
#include "texel/sums_avx512_tmpl.h"

/* Of sixteen. */
ONE_COPY static uint64_t sum_of(const __m512i *v)
{
    const __m512i even = _mm512_and_si512(*v, _mm512_set1_epi64(UINT32_MAX));
    const __m512i both = _mm512_add_epi64(even, _mm512_srli_epi64(*v, 32));
    return sum_of_wide(&both);
}

/* Extremes and sums so far: of levels, and of those inverted; red and green in one. */
typedef struct surveyed {
    __m512i most, most_b, inverted, inverted_b, sum[3];
} surveyed;

/* Adds n packed texels, a multiple of 16, of 2^20 in all; tells which are odd, of each 16. */
static inline void survey(surveyed *of, __mmask16 *odd, const uint16_t *rgb, int32_t n)
{
    enum { AHEAD = NTP__BLOCK };
    const __m512i ones = all(-1), low = all(65535);
    surveyed v = *of;
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
        v.most = _mm512_max_epu16(v.most, t.rg);
        v.inverted = _mm512_max_epu16(v.inverted, other);
        v.most_b = _mm512_max_epu16(v.most_b, t.b);
        v.inverted_b = _mm512_max_epu16(v.inverted_b, _mm512_xor_si512(t.b, low));
        v.sum[0] = _mm512_add_epi32(v.sum[0], _mm512_and_si512(t.rg, low));
        v.sum[1] = _mm512_add_epi32(v.sum[1], _mm512_srli_epi32(t.rg, 16));
        v.sum[2] = _mm512_add_epi32(v.sum[2], t.b);
        odd[group_of(i)] = _mm512_testn_epi32_mask(narrow, all(0x00FF00FF)) |
                           _mm512_testn_epi32_mask(flat, flat) |
                           _mm512_cmpeq_epi32_mask(t.rg, grays);
    }
    *of = v;
}

static void end_survey(ntp__survey *to, const surveyed *of)
{
    const __m512i low = all(65535);
    const __m512i extremes[6] = {
        _mm512_and_si512(of->most, low),     _mm512_srli_epi32(of->most, 16),     of->most_b,
        _mm512_and_si512(of->inverted, low), _mm512_srli_epi32(of->inverted, 16), of->inverted_b,
    };
    for (int32_t k = 0; k < 3; k++) {
        to->sum[k] = (uint32_t) sum_of(&of->sum[k]);
        to->greatest[k] = greatest_of(&extremes[k]);
        to->least[k] = 65535 - greatest_of(&extremes[3 + k]);
    }
    to->odd = 0;
}

#endif
