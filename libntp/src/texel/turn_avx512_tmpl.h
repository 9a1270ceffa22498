/* SPDX-License-Identifier: MIT */
/*
 * turn_avx512_tmpl.h - angles between 16-bit texels and their clean vectors, with AVX-512
 *
 * As turn_avx2_tmpl.h, eight at a time.  Where a sum of products is one instruction it is rounded once less:
 * d and the products of components below 2^53 are exact in both, and what angles_tmpl.h says of the
 * polynomial still holds.  So an angle that is not in doubt is the same, and others are done by angle.c
 * from the same numbers.
 */
#ifndef NTP_TURN_AVX512_TMPL_H
#define NTP_TURN_AVX512_TMPL_H

#include "texel/angle.h"
#include "texel/angle_series.h"
#include "texel/direction.h"

#include <immintrin.h>
#include <math.h>
#include <stdint.h>

static inline __m512d eight(double v)
{
    return _mm512_set1_pd(v);
}

static inline __m512d doubles_of(const int32_t *p)
{
    return _mm512_cvtepi32_pd(_mm256_loadu_si256((const void *) p));
}

/* |v x w|^2 and v . w of n vectors that differ in z alone. */
static inline void flat_products(double *s2, double *d, const int32_t *xy, const int32_t *z,
                                 const int32_t *w, int32_t n)
{
    for (int32_t i = 0; i < n; i += 8) {
        const __m512d z1 = doubles_of(z + i), z2 = doubles_of(w + i), far = _mm512_sub_pd(z1, z2);
        const __m512d rho2 = _mm512_fmadd_pd(doubles_of(xy + i), eight(4), eight(2));
        _mm512_storeu_pd(s2 + i, _mm512_mul_pd(_mm512_mul_pd(rho2, far), far));
        _mm512_storeu_pd(d + i, _mm512_fmadd_pd(z1, z2, rho2));
    }
}

/* Angles are `base` and the arc tangent of u. */
static inline void quotients_of(double *u, double *base, const double *s2, const double *d,
                                int32_t n)
{
    const __m512d zero = _mm512_setzero_pd();
    for (int32_t i = 0; i < n; i += 8) {
        const __m512d s = _mm512_sqrt_pd(_mm512_loadu_pd(s2 + i)), d8 = _mm512_loadu_pd(d + i);
        const __m512d a = _mm512_abs_pd(d8);
        const __m512d low = _mm512_min_pd(s, a), high = _mm512_max_pd(s, a);
        const __mmask8 beyond =
            _mm512_cmp_pd_mask(low, _mm512_mul_pd(high, eight(TAN_22_)), _CMP_GT_OQ);
        const __mmask8 steep = _mm512_cmp_pd_mask(s, a, _CMP_GE_OQ);
        const __mmask8 back = _mm512_cmp_pd_mask(d8, zero, _CMP_LT_OQ);
        const __m512d up = _mm512_mask_sub_pd(low, beyond, low, high);
        const __m512d down = _mm512_mask_add_pd(high, beyond, high, low);
        const __m512d quotient = _mm512_div_pd(up, down);
        /* 90 degrees less that where s is greater, and 180 degrees less where d is negative */
        __m512d t = _mm512_maskz_mov_pd(beyond, eight(45e6));
        t = _mm512_mask_sub_pd(t, steep, eight(90e6), t);
        t = _mm512_mask_sub_pd(t, back, eight(180e6), t);
        _mm512_storeu_pd(base + i, t);
        _mm512_storeu_pd(u + i, _mm512_mask_sub_pd(quotient, steep ^ back, zero, quotient));
    }
}

/* In micro-degrees; returns which are in doubt.  Sums of products are rounded once less. */
static inline __mmask8 arcs_of(int32_t *angle, __m512d u, __m512d base)
{
    const __m512d w = _mm512_mul_pd(u, u), w2 = _mm512_mul_pd(w, w);
#define PAIR(a, b) _mm512_fmadd_pd(eight(b), w, eight(a))
    const __m512d p = _mm512_fmadd_pd(PAIR(C2, C3), w2, PAIR(C0, C1));
    const __m512d q = _mm512_fmadd_pd(PAIR(C6, C7), w2, PAIR(C4, C5));
#undef PAIR
    const __m512d sum = _mm512_fmadd_pd(q, _mm512_mul_pd(w2, w2), p);
    const __m512d t = _mm512_add_pd(_mm512_fmadd_pd(sum, u, base), eight(0.5 - MARGIN));
    const __m256i down = _mm512_cvttpd_epi32(t);
    const __m256i more = _mm512_cvttpd_epi32(_mm512_add_pd(t, eight(2 * MARGIN)));
    _mm256_storeu_si256((void *) angle, down);
    return (__mmask8) ~_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(down, more)));
}

/* n angles, and up to whole lanes of eight.  `u` and `base` are working memory. */
static inline void turns_of(int32_t *angle, double *u, double *base, const double *s2,
                            const double *d, int32_t n)
{
    quotients_of(u, base, s2, d, n);
    for (int32_t i = 0; i < n; i += 8) {
        uint32_t doubt = arcs_of(angle + i, _mm512_loadu_pd(u + i), _mm512_loadu_pd(base + i));
        for (; doubt != 0; doubt &= doubt - 1) {
            const int32_t k = i + __builtin_ctz(doubt);
            angle[k] = (int32_t) (ntp__radians(sqrt(s2[k]), d[k]) * (180e6 / NTP__PI) + 0.5);
        }
    }
}

#endif
