/* SPDX-License-Identifier: MIT */
/*
 * vectors_avx512.c - vectors_tmpl.h with AVX-512: a register holds eight doubles
 */
#include "from_height/gradient.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"

#include <math.h>
#include <string.h>

enum { MIDDLE = 1 << 28, NEAR = 1 << 8 };

#define PD              __m512d
#define PARTS           1
#define SET(v)          _mm512_set1_pd(v)
#define LOAD(p)         _mm512_loadu_pd(p)
#define STORE(p, v)     _mm512_store_pd(p, v)
#define OF_FLOATS(v, k) _mm512_cvtps_pd(v)
#define OF_SAMPLES(p)   _mm512_cvtps_pd(_mm256_loadu_ps(p))
#define OF_INTEGERS(p)  _mm512_cvtepi32_pd(_mm256_loadu_si256((const void *) (p)))
#define FUSED(a, b, c)  _mm512_fmadd_pd(a, b, c)
#define REST(a, b, c)   _mm512_fnmadd_pd(a, b, c)
#define MULTIPLY(a, b)  _mm512_mul_pd(a, b)
#define DIVIDE(a, b)    _mm512_div_pd(a, b)
#define ADD(a, b)       _mm512_add_pd(a, b)
#define SUBTRACT(a, b)  _mm512_sub_pd(a, b)
#define LESSER(a, b)    _mm512_min_pd(a, b)
#define ROOT(v)         _mm512_sqrt_pd(v)
#define MAGNITUDE(v)    _mm512_abs_pd(v)
#define TO_FLOATS(v)    _mm512_cvtpd_ps(v[0])
#define DIFFERING(a, b)                                                                            \
    _mm512_mask_cmpneq_epi32_mask(0xff, _mm512_castsi256_si512(_mm256_castps_si256(a)),            \
                                  _mm512_castsi256_si512(_mm256_castps_si256(b)))
#define GUESS(v) _mm512_rsqrt14_pd(v)
#define NAME     ntp__vectors_avx512

static ALWAYS_INLINE void put_floats(float *d, __m256 x, __m256 y, __m256 z)
{
    static const _Alignas(64)
        int32_t first[16] = { 0, 8, 16, 1, 9, 17, 2, 10, 18, 3, 11, 19, 4, 12, 20, 5 };
    static const _Alignas(32) int32_t last[8] = { 13, 21, 6, 14, 22, 7, 15, 23 };
    const __m512 xy = _mm512_castpd_ps(
        _mm512_insertf64x4(_mm512_castps_pd(_mm512_castps256_ps512(x)), _mm256_castps_pd(y), 1));
    const __m512 all = _mm512_castps256_ps512(z);
    _mm512_storeu_ps(d, _mm512_permutex2var_ps(xy, _mm512_load_si512(first), all));
    _mm256_storeu_ps(d + 16,
                     _mm512_castps512_ps256(_mm512_permutex2var_ps(
                         xy, _mm512_castsi256_si512(_mm256_load_si256((const void *) last)), all)));
}

/* Bits of texels with a component whose last 29 bits, which floats have not, are those of a middle, give or
 * take 2^8: that is 2^-45 of it or more. */
static ALWAYS_INLINE uint32_t near_middle(__m512d v[3][1])
{
    const __m512i off = _mm512_set1_epi64(MIDDLE + NEAR),
                  all = _mm512_set1_epi64(2 * MIDDLE - 2 * NEAR);
    uint32_t left = 0;
    for (int32_t k = 0; k < 3; k++)
        left |= _mm512_testn_epi64_mask(_mm512_add_epi64(_mm512_castpd_si512(v[k][0]), off), all);
    return left;
}

ntp__encode_vectors_fn ntp__vectors_avx512;

#include "from_height/vectors_tmpl.h"
