/* SPDX-License-Identifier: MIT */
/*
 * lengths_avx512_tmpl.h - lengths of 16-bit texels, with AVX-512
 *
 * As lengths_avx2_tmpl.h, sixteen at a time.  Sums of products are rounded once less, so they are off by
 * less; a length that is in doubt there is found in the same way.
 */
#ifndef NTP_LENGTHS_AVX512_TMPL_H
#define NTP_LENGTHS_AVX512_TMPL_H

#include "texel/judged.h"
#include "texel/packed_avx512_tmpl.h"

#include <immintrin.h>
#include <stdint.h>

static inline __m512i all(int32_t v)
{
    return _mm512_set1_epi32(v);
}

/* Of sixteen texels. */
static inline uint32_t group_of(int32_t texel)
{
    return (uint32_t) texel / LANES_512;
}

static inline __m512i load(const void *p)
{
    return _mm512_loadu_si512(p);
}

static inline void store(void *p, __m512i v)
{
    _mm512_storeu_si512(p, v);
}

/* The whole number next to the root of 4 xy + 2 + z*z; what is left, and what it is over. */
static inline void roots_of(int32_t *whole, float *rest, float *over, const int32_t *xy16,
                            const int32_t *z16, int32_t n)
{
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __m512i z = load(z16 + i), xy = load(xy16 + i);
        const __m512 zf = _mm512_cvtepi32_ps(z);
        const __m512 flat =
            _mm512_fmadd_ps(_mm512_cvtepi32_ps(xy), _mm512_set1_ps(4), _mm512_set1_ps(2));
        const __m512 root = _mm512_sqrt_ps(_mm512_fmadd_ps(zf, zf, flat));
        const __m512i k = _mm512_cvtps_epi32(root);
        const __m512i beyond = _mm512_mullo_epi32(_mm512_sub_epi32(z, k), _mm512_add_epi32(z, k));
        const __m512i xy4 = _mm512_add_epi32(_mm512_slli_epi32(xy, 2), all(2));
        store(whole + i, k);
        _mm512_storeu_ps(rest + i, _mm512_cvtepi32_ps(_mm512_add_epi32(xy4, beyond)));
        _mm512_storeu_ps(over + i, _mm512_add_ps(root, _mm512_cvtepi32_ps(k)));
    }
}

/* Sixteen lengths, as in lengths_avx2_tmpl.h; those in doubt again. */
static inline __m512i lengths_of(__m512i k, __m512 rest, __m512 over, const int32_t *xy,
                                 const int32_t *z)
{
    const float m = 65535, more = 1.0f / m, by = (float) NTP__LENGTH_ONE / m, margin = 0x1p-16f;
    const __m512 up =
        _mm512_fmadd_ps(_mm512_cvtepi32_ps(k), _mm512_set1_ps(more), _mm512_set1_ps(4.5f - margin));
    const __m512 beyond = _mm512_fmadd_ps(_mm512_div_ps(rest, over), _mm512_set1_ps(by), up);
    const __m512i down = _mm512_cvttps_epi32(beyond);
    const __m512i other = _mm512_cvttps_epi32(_mm512_add_ps(beyond, _mm512_set1_ps(2 * margin)));
    uint32_t doubt = _mm512_cmpneq_epi32_mask(down, other);
    __m512i length = _mm512_add_epi32(k, _mm512_sub_epi32(down, all(4)));
    for (; doubt != 0; doubt &= doubt - 1) {
        const int32_t j = __builtin_ctz(doubt);
        const int32_t slow = ntp__fixed_length(4.0 * xy[j] + 2.0 + (double) z[j] * z[j], 65535);
        length = _mm512_mask_mov_epi32(length, (__mmask16) (1U << j), all(slow));
    }
    return length;
}

#endif
