/* SPDX-License-Identifier: MIT */
/*
 * far_lanes_avx512_tmpl.h - what sixteen 16-bit texels are judged by, with AVX-512; a part of far_avx512.c
 *
 * A level v of red or green is p = v - 32768, or q = -1 - p where that is negative: |X| = 2q + 1, and
 * p(p + 1) = q(q + 1) = -q(-1 - q).  Both factors fit into words, so pmaddwd adds up those of red and green.
 * h = half(u - half), with half = floor(u/2), is -half(half - u) for the same reason.
 */
#ifndef NTP_FAR_LANES_AVX512_TMPL_H
#define NTP_FAR_LANES_AVX512_TMPL_H

#include "measure/far_words_tmpl.h"

#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"

/* What sixteen texels are made of; halves of numerators are rounded down. */
typedef struct far_lanes {
    __m512i rg, b, e;       /* e as in judge_tmpl.h */
    __m512i q, z, up;       /* q of red and green in words; b - K, and its q */
    __m512i sizes, off, zz; /* |X| + |Y|, a - A_M, and e - h */
} far_lanes;

/* Returns which are neighbors. */
static inline __mmask16 set_lanes(far_lanes *v, texels t)
{
    const __m512i ones = all(-1), p = _mm512_xor_si512(t.rg, all((int32_t) 0x80008000));
    const __m512i b = t.b, half = _mm512_srli_epi32(b, 1);
    v->rg = t.rg;
    v->b = b;
    v->q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15));
    v->z = _mm512_sub_epi32(b, all(K));
    v->up = _mm512_xor_si512(v->z, _mm512_srai_epi32(v->z, 31));
    v->e = _mm512_add_epi32(all(REST_16), _mm512_madd_epi16(v->q, _mm512_xor_si512(v->q, ones)));
    const __m512i sum = _mm512_madd_epi16(v->q, all(0x00010001));
    v->sizes = _mm512_add_epi32(_mm512_add_epi32(sum, sum), all(2));
    const __m512i less = _mm512_madd_epi16(v->up, _mm512_xor_si512(v->up, ones));
    v->off = _mm512_xor_si512(_mm512_add_epi32(v->e, less), ones);
    v->zz = _mm512_add_epi32(v->e, _mm512_madd_epi16(half, _mm512_sub_epi32(half, b)));
    /* -2k <= off < 2k - 6, with 2k = |X| + |Y| + |Z| + 3; from -2k on, as numbers without a sign */
    const __m512i k2 =
        _mm512_add_epi32(_mm512_add_epi32(v->sizes, all(4)), _mm512_add_epi32(v->up, v->up));
    const __mmask16 near = _mm512_cmplt_epu32_mask(
        _mm512_add_epi32(v->off, k2), _mm512_sub_epi32(_mm512_add_epi32(k2, k2), all(6)));
    /* 2 - sizes - half <= e - h < 2 + sizes + b - half */
    const __m512i from =
        _mm512_add_epi32(_mm512_add_epi32(v->zz, v->sizes), _mm512_sub_epi32(half, all(2)));
    return near |
           _mm512_cmplt_epu32_mask(from, _mm512_add_epi32(_mm512_add_epi32(v->sizes, v->sizes), b));
}

static inline __m512i flagged(__m512i key, __mmask16 where, int32_t flag)
{
    return _mm512_mask_or_epi32(key, where, key, all(flag));
}

static inline __mmask16 is_negative(__m512i v)
{
    return _mm512_cmplt_epi32_mask(v, _mm512_setzero_si512());
}

/* Steepness and flags. */
static inline __m512i key_of(const far_lanes *v, __m512i xy, __mmask16 padding)
{
    const int32_t most = (int32_t) ((NTP__FAR_SQUARED * ((double) M * M) - 2) / 4);
    static const _Alignas(64) uint8_t roots[64] = {
        0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4,
        4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 6,
        6, 6, 6, 6, 6, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7,
    };
    /* floor(64 xy / A_M), as in close_tmpl.h; the root of 64 and more is not used */
    const __m512i more = _mm512_add_epi32(_mm512_srli_epi32(xy, 15), all(1));
    const __m512i steep = _mm512_srli_epi32(_mm512_add_epi32(xy, more), 24);
    __m512i bin =
        _mm512_permutexvar_epi8(_mm512_min_epu32(steep, all(63)), _mm512_load_si512(roots));
    bin = _mm512_mask_mov_epi32(bin, padding, all(NTP__PADDING_BIN));
    __m512i key = _mm512_slli_epi32(bin, 5);
    key = flagged(key, _mm512_cmpgt_epi32_mask(xy, all(most)), NTP__KEY_FAR);
    key = flagged(key, is_negative(v->e), NTP__KEY_TOO_LONG);
    key = flagged(key, is_negative(v->z), NTP__KEY_NEGATIVE);
    key = flagged(key, is_negative(v->off), NTP__KEY_SHORT);
    return flagged(key, is_negative(v->zz), NTP__KEY_ZZ_LONG);
}

#endif
