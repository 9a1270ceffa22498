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

enum { AHEAD = NTP__BLOCK }; /* fetched while others are worked on */

/* Extremes and sums so far; red and green in one. */
typedef struct surveyed {
    __m512i most, most_b, least, least_b, sum[3];
    int32_t gray; /* texels */
} surveyed;

static inline void begin_survey(surveyed *of)
{
    const __m512i zero = _mm512_setzero_si512(), ones = all(-1);
    *of = (surveyed) { zero, zero, ones, ones, { zero, zero, zero }, 0 };
}

/* Adds sixteen texels. */
static inline void see(surveyed *v, texels t)
{
    v->most = _mm512_max_epu16(v->most, t.rg);
    v->least = _mm512_min_epu16(v->least, t.rg);
    v->most_b = _mm512_max_epu16(v->most_b, t.b);
    v->least_b = _mm512_min_epu32(v->least_b, t.b);
    v->sum[0] = _mm512_add_epi32(v->sum[0], _mm512_and_si512(t.rg, all(65535)));
    v->sum[1] = _mm512_add_epi32(v->sum[1], _mm512_srli_epi32(t.rg, 16));
    v->sum[2] = _mm512_add_epi32(v->sum[2], t.b);
}

/* Adds n packed texels, a multiple of 16, of 2^20 in all; tells which are odd for something else than gray, of
 * each 16. */
static inline void survey(surveyed *of, __mmask16 *odd, const uint16_t *rgb, int32_t n)
{
    const __m512i ones = all(-1);
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
        see(&v, t);
        odd[group_of(i)] =
            _mm512_testn_epi32_mask(narrow, all(0x00FF00FF)) | _mm512_testn_epi32_mask(flat, flat);
        v.gray += __builtin_popcount(_mm512_cmpeq_epi32_mask(t.rg, grays));
    }
    *of = v;
}

/* In exact16_avx512.c, for all files. */
void ntp__end_survey_avx512(ntp__survey *to, const surveyed *of);

#endif
