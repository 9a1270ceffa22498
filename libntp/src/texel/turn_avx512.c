/* SPDX-License-Identifier: MIT */
/*
 * turn_avx512.c - angles between vectors and clean ones, from what is made of them, with AVX-512
 *
 * turn_avx512_tmpl.h says why the numbers are right.
 */
#include "texel/turn_avx512.h"

#include "base/lanes_avx2.h"
#include "texel/turn_avx512_tmpl.h"

/* |v x w| and v . w of vectors that differ in z alone; rho is the length of x and y. */
static inline void flat_products(__m512d *s, __m512d *d, __m512d rho, __m512d rho2, __m512d z,
                                 __m512d w)
{
    *s = _mm512_mul_pd(rho, _mm512_abs_pd(_mm512_sub_pd(z, w)));
    *d = _mm512_fmadd_pd(z, w, rho2);
}

int32_t ntp__flat_vectors_avx512(double *s8, double *d8, const int32_t *xy, const int32_t *z8,
                                 const int32_t *root, const __mmask16 *is_lower, int32_t n)
{
    int32_t lower = n;
    for (int32_t i = 0; i < n; i += 8) {
        const __m512d z = doubles_of(z8 + i), w = doubles_of(root + i), zero = _mm512_setzero_pd();
        const __m512d rho2 = _mm512_fmadd_pd(doubles_of(xy + i), eight(4), eight(2));
        const __m512d rho = root_of_doubles(rho2);
        const __mmask8 negative = _mm512_cmp_pd_mask(z, eight(-1), _CMP_LT_OQ);
        const __mmask8 these = (__mmask8) (is_lower[group_of(i)] >> i % LANES_512);
        __m512d s, d;
        flat_products(&s, &d, rho, rho2, z, _mm512_mask_sub_pd(w, negative, zero, z));
        _mm512_storeu_pd(s8 + i, s);
        _mm512_storeu_pd(d8 + i, d);
        flat_products(&s, &d, rho, rho2, z, w);
        _mm512_storeu_pd(s8 + lower, _mm512_maskz_compress_pd(these, s));
        _mm512_storeu_pd(d8 + lower, _mm512_maskz_compress_pd(these, d));
        lower += __builtin_popcount(these);
    }
    end_lanes();
    return lower;
}

/* Angles are `base` and the arc tangent of what s becomes. */
static inline void quotients_of(double *s8, double *base, const double *d, int32_t n)
{
    const __m512d zero = _mm512_setzero_pd();
    for (int32_t i = 0; i < n; i += 8) {
        const __m512d s = _mm512_loadu_pd(s8 + i), d8 = _mm512_loadu_pd(d + i);
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
        _mm512_storeu_pd(s8 + i, _mm512_mask_sub_pd(quotient, steep ^ back, zero, quotient));
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

int32_t ntp__turns_avx512(int32_t *angle, int32_t *at, double *base, double *s, const double *d,
                          int32_t n)
{
    int32_t found = 0;
    quotients_of(s, base, d, n);
    for (int32_t i = 0; i < n; i += 8) {
        uint32_t doubt = arcs_of(angle + i, _mm512_loadu_pd(s + i), _mm512_loadu_pd(base + i));
        for (; doubt != 0; doubt &= doubt - 1) {
            const int32_t place = i + __builtin_ctz(doubt);
            at[found] = place;
            found += place < n;
        }
    }
    end_lanes();
    return found;
}
