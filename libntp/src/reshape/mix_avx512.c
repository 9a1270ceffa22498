/* SPDX-License-Identifier: MIT */
/*
 * mix_avx512.c - vectors blended in double, and their levels, as mix_avx2.c does it, with AVX-512
 */
#include "reshape/mix_avx2.h"

#include "base/lanes_avx2.h"

#include <immintrin.h>

#define NUMBER       __m512d
#define ELEMENT      double
#define OP(op)       _mm512_##op##_pd
#define MIXED        mixed
#define LOAD(from)   _mm512_cvtps_pd(_mm256_loadu_ps(from))
#define STORE(to, v) _mm256_storeu_ps(to, _mm512_cvtpd_ps(v))
#include "reshape/mixed_tmpl.h"

void ntp__mix_doubles_avx512(ntp__mix_planes v, ntp__mix_planes base, ntp__mix_planes detail,
                             int32_t n, const ntp__mix_terms *t)
{
    mixed(v, base, detail, n, t);
    end_lanes();
}

/* Is the floor of s in doubt?  That of 0 is only where it may be off. */
static inline __mmask16 in_doubt(__m512 s, __m512 less)
{
    const __m512 most = _mm512_fmadd_ps(_mm512_abs_ps(s), _mm512_set1_ps(0x1p-21F), less);
    const __m512 off = _mm512_sub_ps(s, _mm512_roundscale_ps(s, _MM_FROUND_TO_NEAREST_INT));
    return _mm512_cmp_ps_mask(_mm512_abs_ps(off), most, _CMP_LT_OQ);
}

static inline __m512i floor_of(__m512 s)
{
    return _mm512_cvt_roundps_epi32(s, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

void ntp__round_pairs_avx512(int32_t *pair, int32_t *left, ntp__mix_planes v, int32_t n,
                             const ntp__mix_rounding *how)
{
    const __m512 less = _mm512_set1_ps(how->less);
    for (int32_t i = 0; i < n; i += 16) {
        const __m512 x = _mm512_loadu_ps(v[0] + i), y = _mm512_loadu_ps(v[1] + i);
        const __m512 z = _mm512_loadu_ps(v[2] + i);
        const __m512 square = _mm512_fmadd_ps(z, z, _mm512_fmadd_ps(y, y, _mm512_mul_ps(x, x)));
        const __m512 factor = _mm512_div_ps(_mm512_set1_ps(how->half), _mm512_sqrt_ps(square));
        const __m512 s = _mm512_mul_ps(x, factor), t = _mm512_mul_ps(y, factor);
        const __mmask16 doubt = in_doubt(s, less) | in_doubt(t, less) |
                                _mm512_cmp_ps_mask(square, _mm512_set1_ps(how->least2), _CMP_LT_OQ);
        const __m512i low = floor_of(s), high = _mm512_slli_epi32(floor_of(t), 16);
        _mm512_storeu_si512(pair + i, _mm512_mask_mov_epi16(low, 0xaaaaaaaa, high));
        _mm512_storeu_si512(left + i, _mm512_mask_mov_epi32(_mm512_loadu_si512(left + i), doubt,
                                                            _mm512_set1_epi32(-1)));
    }
    end_lanes();
}
