/* SPDX-License-Identifier: MIT */
/*
 * turn_avx2_tmpl.h - angles between 16-bit texels and their clean vectors, with AVX2
 *
 * The same as angles_tmpl.h, which says why angles that are not in doubt are right.  Short loops follow
 * each other, for their steps are long chains: of a longer loop, few steps would be in flight.
 */
#ifndef NTP_TURN_AVX2_TMPL_H
#define NTP_TURN_AVX2_TMPL_H

#include "texel/angle.h"
#include "texel/angle_series.h"
#include "texel/blue_avx2_tmpl.h"
#include "texel/direction.h"
#include "texel/level.h"

#include <immintrin.h>
#include <math.h>
#include <stdbool.h>

static inline __m128i load_four(const int32_t *p)
{
    return _mm_loadu_si128((const __m128i *) (const void *) p);
}

static inline void store_four(int32_t *p, __m128i v)
{
    _mm_storeu_si128((__m128i *) (void *) p, v);
}

/* |v x w|^2 and v . w of n vectors that differ in z alone, whose x and y are known as x(x + 1) + y(y + 1): as in
 * judge_tmpl.h. */
static inline void flat_products(double *s2, double *d, const int32_t *xy, const int32_t *z,
                                 const int32_t *w, int32_t n)
{
    for (int32_t i = 0; i < n; i += 4) {
        const __m256d flat = _mm256_cvtepi32_pd(load_four(xy + i));
        const __m256d z1 = _mm256_cvtepi32_pd(load_four(z + i));
        const __m256d z2 = _mm256_cvtepi32_pd(load_four(w + i)), far = _mm256_sub_pd(z1, z2);
        const __m256d rho2 =
            _mm256_add_pd(_mm256_mul_pd(flat, _mm256_set1_pd(4)), _mm256_set1_pd(2));
        _mm256_storeu_pd(s2 + i, _mm256_mul_pd(_mm256_mul_pd(rho2, far), far));
        _mm256_storeu_pd(d + i, _mm256_add_pd(rho2, _mm256_mul_pd(z1, z2)));
    }
}

/* |X| or |Y| of four levels. */
static inline __m128i size_of(const int32_t *level)
{
    const __m128i c = load_four(level);
    return _mm_abs_epi32(_mm_sub_epi32(_mm_add_epi32(c, c), _mm_set1_epi32(65535)));
}

/* Pulls four pairs as pull() in judge_tmpl.h; a and c are (|X| + 1)/2 and (|Y| + 1)/2 of what they
 * become. */
static inline void pull_four(int32_t a[4], int32_t c[4], __m128i ax, __m128i ay, const int32_t *r,
                             const int32_t *g)
{
    enum { LAST = (1 << 15) - 1 };
    const __m256d x = _mm256_cvtepi32_pd(ax), y = _mm256_cvtepi32_pd(ay);
    const __m256d square = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
    const __m256d half = _mm256_set1_pd(0.5 * (LAST + 1));
    const __m256d factor =
        _mm256_div_pd(_mm256_set1_pd(0.5 * (LAST + 1) * 65535), _mm256_sqrt_pd(square));
    const __m128i s = _mm256_cvttpd_epi32(_mm256_add_pd(_mm256_mul_pd(x, factor), half));
    const __m128i t = _mm256_cvttpd_epi32(_mm256_add_pd(_mm256_mul_pd(y, factor), half));
    const __m128i u = _mm_srli_epi32(s, 15), v = _mm_srli_epi32(t, 15);
    const __m128i same = _mm_cmpeq_epi32(ax, ay), wider = _mm_cmpgt_epi32(ax, ay);
    /* u(u + 1) + v(v - 1) < A_M, and u(u - 1) + v(v + 1) < A_M */
    const __m128i rest = _mm_sub_epi32(_mm_set1_epi32(REST_16 + 1),
                                       _mm_add_epi32(_mm_mullo_epi32(u, u), _mm_mullo_epi32(v, v)));
    const __m128i more = _mm_sub_epi32(u, v);
    const __m128i right = _mm_andnot_si128(same, _mm_cmpgt_epi32(rest, more));
    const __m128i down =
        _mm_andnot_si128(same, _mm_cmpgt_epi32(_mm_add_epi32(rest, more), _mm_setzero_si128()));
    /* where both are inside, the greater one of |X| and |Y| grows */
    const __m128i only_down = _mm_andnot_si128(wider, down),
                  only_right = _mm_and_si128(wider, right);
    store_four(a, _mm_sub_epi32(u, _mm_andnot_si128(only_down, right)));
    store_four(c, _mm_sub_epi32(v, _mm_andnot_si128(only_right, down)));
    const __m128i last = _mm_set1_epi32(LAST), one = _mm_set1_epi32(1);
    const __m128i sure =
        _mm_and_si128(_mm_cmpgt_epi32(_mm_and_si128(_mm_add_epi32(s, one), last), one),
                      _mm_cmpgt_epi32(_mm_and_si128(_mm_add_epi32(t, one), last), one));
    for (int i = 0; _mm_movemask_epi8(sure) != 65535 && i < 4; i++) {
        int32_t to[2] = { r[i], g[i] };
        ntp__pull_seldom(&to[0], &to[1], 65535);
        a[i] = (ntp__abs(ntp__num(to[0], 65535)) + 1) / 2;
        c[i] = (ntp__abs(ntp__num(to[1], 65535)) + 1) / 2;
    }
}

/* The same of n vectors whose x and y are too long, and those with the pulled pairs and their derived
 * blues.  The signs of x and y do not matter.  `a` and `c` are working memory. */
static inline void long_products(double *s2, double *d, int32_t *a, int32_t *c, const int32_t *r,
                                 const int32_t *g, const int32_t *b, int32_t n)
{
    for (int32_t i = 0; i < n; i += 4)
        pull_four(a + i, c + i, size_of(r + i), size_of(g + i), r + i, g + i);
    for (int32_t i = 0; i < n; i += 4) {
        const __m128i ax = size_of(r + i), ay = size_of(g + i), one = _mm_set1_epi32(1);
        const __m128i u = load_four(a + i), u1 = _mm_sub_epi32(u, one), blue = load_four(b + i);
        const __m128i v = load_four(c + i), v1 = _mm_sub_epi32(v, one);
        const __m128i squares = _mm_add_epi32(_mm_mullo_epi32(u, u1), _mm_mullo_epi32(v, v1));
        const __m128i e = _mm_sub_epi32(_mm_set1_epi32(REST_16), squares);
        const __m128i root = _mm256_castsi256_si128(root_of(_mm256_castsi128_si256(e), true));
        const __m128i up = _mm_sub_epi32(_mm_add_epi32(blue, blue), _mm_set1_epi32(65535));
        const __m256d x1 = _mm256_cvtepi32_pd(ax), x2 = _mm256_cvtepi32_pd(_mm_add_epi32(u, u1));
        const __m256d y1 = _mm256_cvtepi32_pd(ay), y2 = _mm256_cvtepi32_pd(_mm_add_epi32(v, v1));
        const __m256d z1 = _mm256_cvtepi32_pd(up);
        const __m256d z2 = _mm256_cvtepi32_pd(_mm_add_epi32(_mm_add_epi32(root, root), one));
        const __m256d x = _mm256_sub_pd(_mm256_mul_pd(y1, z2), _mm256_mul_pd(z1, y2));
        const __m256d y = _mm256_sub_pd(_mm256_mul_pd(z1, x2), _mm256_mul_pd(x1, z2));
        const __m256d z = _mm256_sub_pd(_mm256_mul_pd(x1, y2), _mm256_mul_pd(y1, x2));
        const __m256d square = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
        const __m256d dot = _mm256_add_pd(_mm256_mul_pd(x1, x2), _mm256_mul_pd(y1, y2));
        _mm256_storeu_pd(s2 + i, _mm256_add_pd(square, _mm256_mul_pd(z, z)));
        _mm256_storeu_pd(d + i, _mm256_add_pd(dot, _mm256_mul_pd(z1, z2)));
    }
}

/* Angles are `base` and the arc tangent of u. */
static inline void quotients_of(double *u, double *base, const double *s2, const double *d,
                                int32_t n)
{
    const __m256d sign = _mm256_set1_pd(-0.0);
    for (int32_t i = 0; i < n; i += 4)
        _mm256_storeu_pd(u + i, _mm256_sqrt_pd(_mm256_loadu_pd(s2 + i)));
    for (int32_t i = 0; i < n; i += 4) {
        const __m256d s = _mm256_loadu_pd(u + i), d4 = _mm256_loadu_pd(d + i);
        const __m256d a = _mm256_andnot_pd(sign, d4);
        const __m256d low = _mm256_min_pd(s, a), high = _mm256_max_pd(s, a);
        const __m256d limit = _mm256_mul_pd(high, _mm256_set1_pd(TAN_22_));
        const __m256d beyond = _mm256_cmp_pd(low, limit, _CMP_GT_OQ);
        const __m256d up = _mm256_sub_pd(low, _mm256_and_pd(beyond, high));
        const __m256d down = _mm256_add_pd(high, _mm256_and_pd(beyond, low));
        /* 90 degrees less that where s is greater, and 180 degrees less where d is negative */
        const __m256d steep = _mm256_cmp_pd(s, a, _CMP_GE_OQ), back = _mm256_and_pd(d4, sign);
        const __m256d from_90 = _mm256_and_pd(steep, sign);
        __m256d t = _mm256_xor_pd(_mm256_and_pd(beyond, _mm256_set1_pd(45e6)), from_90);
        t = _mm256_add_pd(t, _mm256_and_pd(steep, _mm256_set1_pd(90e6)));
        t = _mm256_add_pd(_mm256_xor_pd(t, back),
                          _mm256_blendv_pd(_mm256_setzero_pd(), _mm256_set1_pd(180e6), d4));
        const __m256d flip = _mm256_xor_pd(from_90, back);
        _mm256_storeu_pd(base + i, t);
        _mm256_storeu_pd(u + i, _mm256_xor_pd(_mm256_div_pd(up, down), flip));
    }
}

/* In micro-degrees, one more in `greater` where they are in doubt. */
static inline __m128i arcs_of(__m128i *greater, const double *u4, const double *base)
{
    const __m256d u = _mm256_loadu_pd(u4), w = _mm256_mul_pd(u, u), w2 = _mm256_mul_pd(w, w);
#define PAIR(a, b) _mm256_add_pd(_mm256_set1_pd(a), _mm256_mul_pd(_mm256_set1_pd(b), w))
    const __m256d p = _mm256_add_pd(PAIR(C0, C1), _mm256_mul_pd(PAIR(C2, C3), w2));
    const __m256d q = _mm256_add_pd(PAIR(C4, C5), _mm256_mul_pd(PAIR(C6, C7), w2));
#undef PAIR
    const __m256d sum = _mm256_add_pd(p, _mm256_mul_pd(q, _mm256_mul_pd(w2, w2)));
    __m256d t = _mm256_add_pd(_mm256_mul_pd(sum, u), _mm256_loadu_pd(base));
    t = _mm256_add_pd(t, _mm256_set1_pd(0.5 - MARGIN));
    *greater = _mm256_cvttpd_epi32(_mm256_add_pd(t, _mm256_set1_pd(2 * MARGIN)));
    return _mm256_cvttpd_epi32(t);
}

/* n angles, and up to whole lanes of four.  `u` and `base` are working memory. */
static inline void turns_of(int32_t *angle, double *u, double *base, const double *s2,
                            const double *d, int32_t n)
{
    quotients_of(u, base, s2, d, n);
    for (int32_t i = 0; i < n; i += 4) {
        __m128i more;
        const __m128i down = arcs_of(&more, u + i, base + i);
        const __m128i doubt = _mm_xor_si128(down, more);
        store_four(angle + i, down);
        /* behind the last one are any numbers, of which there may be no angle */
        for (int32_t k = 0; !_mm_testz_si128(doubt, doubt) && k < 4 && i + k < n; k++)
            angle[i + k] =
                (int32_t) (ntp__radians(sqrt(s2[i + k]), d[i + k]) * (180e6 / NTP__PI) + 0.5);
    }
}

#endif
