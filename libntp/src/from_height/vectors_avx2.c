/* SPDX-License-Identifier: MIT */
/*
 * vectors_avx2.c - vectors_tmpl.h with AVX2: two registers hold eight doubles
 */
#include "from_height/gradient.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"

#include <math.h>
#include <string.h>

#define PD          __m256d
#define PARTS       2
#define SET(v)      _mm256_set1_pd(v)
#define LOAD(p)     _mm256_loadu_pd(p)
#define STORE(p, v) _mm256_store_pd(p, v)
#define OF_FLOATS(v, k)                                                                            \
    _mm256_cvtps_pd((k) ? _mm256_extractf128_ps(v, 1) : _mm256_castps256_ps128(v))
#define OF_SAMPLES(p)   _mm256_cvtps_pd(_mm_loadu_ps(p))
#define OF_INTEGERS(p)  _mm256_cvtepi32_pd(_mm_loadu_si128((const void *) (p)))
#define FUSED(a, b, c)  _mm256_fmadd_pd(a, b, c)
#define REST(a, b, c)   _mm256_fnmadd_pd(a, b, c)
#define MULTIPLY(a, b)  _mm256_mul_pd(a, b)
#define DIVIDE(a, b)    _mm256_div_pd(a, b)
#define ADD(a, b)       _mm256_add_pd(a, b)
#define SUBTRACT(a, b)  _mm256_sub_pd(a, b)
#define LESSER(a, b)    _mm256_min_pd(a, b)
#define ROOT(v)         _mm256_sqrt_pd(v)
#define MAGNITUDE(v)    _mm256_andnot_pd(_mm256_set1_pd(-0.0), v)
#define TO_FLOATS(v)    _mm256_set_m128(_mm256_cvtpd_ps(v[1]), _mm256_cvtpd_ps(v[0]))
#define DIFFERING(a, b) (uint32_t) _mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_NEQ_UQ))
#define GUESS(v)        _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(v)))
#define NAME            ntp__vectors_avx2

static inline void put_floats(float *d, __m256 x, __m256 y, __m256 z)
{
    x = _mm256_permutevar8x32_ps(x, _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5));
    y = _mm256_permutevar8x32_ps(y, _mm256_setr_epi32(5, 0, 3, 6, 1, 4, 7, 2));
    z = _mm256_permutevar8x32_ps(z, _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7));
    _mm256_storeu_ps(d, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x92), z, 0x24));
    _mm256_storeu_ps(d + 8, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x24), z, 0x49));
    _mm256_storeu_ps(d + 16, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x49), z, 0x92));
}

/* Bits of texels with a component whose last 29 bits, which floats have not, are those of a middle, give or
 * take 2^8: that is 2^-45 of it or more.  Shifted up, a middle is the least integer. */
static ALWAYS_INLINE uint32_t near_middle(__m256d v[3][2])
{
    __m256i most = _mm256_setzero_si256();
    for (int32_t k = 0; k < 3; k++) {
        const __m256 low =
            _mm256_shuffle_ps(_mm256_castpd_ps(v[k][0]), _mm256_castpd_ps(v[k][1]), 0x88);
        const __m256i size = _mm256_abs_epi32(_mm256_slli_epi32(_mm256_castps_si256(low), 3));
        most = _mm256_max_epu32(most, size);
    }
    const __m256i near = _mm256_add_epi32(most, _mm256_set1_epi32(8 << 8));
    const uint32_t left = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(near));
    return (left & 0xc3) | (left & 0x0c) << 2 | (left & 0x30) >> 2;
}

ntp__encode_vectors_fn ntp__vectors_avx2;

#include "from_height/vectors_tmpl.h"
