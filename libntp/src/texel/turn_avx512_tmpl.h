/* SPDX-License-Identifier: MIT */
/*
 * turn_avx512_tmpl.h - angles between 16-bit texels and their clean vectors, with AVX-512
 *
 * As turn_avx2_tmpl.h, but eight or sixteen at a time, and with roots that take a fifth of the time: those of an
 * instruction are off by no more than 2^-53 of them, these by 2^-51 at most.  Where a sum of products is one
 * instruction it is rounded once less: d and the products of components below 2^53 are exact in both.  What
 * angles_tmpl.h says of roundings and of the polynomial still holds: they move an angle by less than 1e-6
 * micro-degrees.  So an angle that is not in doubt is the same, and others are done by angle.c from the same
 * numbers as there.
 */
#ifndef NTP_TURN_AVX512_TMPL_H
#define NTP_TURN_AVX512_TMPL_H

#include "texel/angle.h"
#include "texel/angle_series.h"
#include "texel/direction.h"
#include "texel/level.h"
#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"

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

/* 1/sqrt(v).  y is that but for 2^-14 of it, so e = 1 - v y^2 is below 2^-12.9, and 1/sqrt(v) =
 * y (1 + e/2 + 3 e^2/8 + 5 e^3/16 + ...).  What follows is less than 2^-53. */
static inline __m512d inverse_root(__m512d v)
{
    const __m512d y = _mm512_rsqrt14_pd(v);
    const __m512d e = _mm512_fnmadd_pd(_mm512_mul_pd(v, y), y, eight(1));
    const __m512d p = _mm512_fmadd_pd(e, eight(0.3125), eight(0.375));
    return _mm512_fmadd_pd(_mm512_mul_pd(y, e), _mm512_fmadd_pd(p, e, eight(0.5)), y);
}

static inline __m512d root_of_doubles(__m512d v)
{
    return _mm512_mul_pd(v, inverse_root(v));
}

/* The place of a vector below the horizon, by its place among these. */
static inline int32_t find_lower(const __mmask16 *is_lower, int32_t left)
{
    const __mmask16 *these = is_lower;
    for (; left >= __builtin_popcount(*these); these++)
        left -= __builtin_popcount(*these);
    uint32_t lower = *these;
    for (; left > 0; left--)
        lower &= lower - 1;
    return (int32_t) (these - is_lower) * LANES_512 + __builtin_ctz(lower);
}

/* v / d of numbers below 2^28, where `by` is 2^shift / d, rounded up: as compilers have it. */
static inline __m512i divided(__m512i v, uint32_t by, unsigned shift)
{
    const __m512i factor = all((int32_t) by);
    const __m512i even = _mm512_srli_epi64(_mm512_mul_epu32(v, factor), shift);
    const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(v, 32), factor);
    return _mm512_or_si512(even, _mm512_slli_epi64(_mm512_srli_epi64(odd, shift), 32));
}

/* 2 v + 1. */
static inline __m512i odd_of(__m512i v)
{
    return _mm512_add_epi32(_mm512_add_epi32(v, v), all(1));
}

static inline __m512i words_of(__m512i low, __m512i high)
{
    return _mm512_or_si512(low, _mm512_slli_epi32(high, 16));
}

enum { LONG_ROOM = NTP__BLOCK + LANES_512, PULLED_LAST = (1 << 15) - 1 };

/* Numerators of vectors whose x and y are too long, without the signs of these, which do not matter; and of what
 * they become. */
typedef struct long_vectors {
    int32_t from[3][LONG_ROOM], to[3][LONG_ROOM];
} long_vectors;

/* Sixteen pairs. */
static inline void set_long(long_vectors *v, int32_t i, __m512i rg, __m512i b)
{
    const __m512i p = _mm512_xor_si512(rg, all((int32_t) 0x80008000));
    const __m512i q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15));
    store(v->from[0] + i, odd_of(_mm512_and_si512(q, all(65535))));
    store(v->from[1] + i, odd_of(_mm512_srli_epi32(q, 16)));
    store(v->from[2] + i, odd_of(_mm512_sub_epi32(b, all(32768))));
}

/* Shortens eight pairs: (|X| + 1)/2 in 2^-15, as in pull_four. */
static inline void shorten(long_vectors *v, int32_t i)
{
    const __m512d x = doubles_of(v->from[0] + i), y = doubles_of(v->from[1] + i);
    const __m512d square = _mm512_fmadd_pd(x, x, _mm512_mul_pd(y, y));
    const __m512d half = eight(0.5 * (PULLED_LAST + 1));
    const __m512d factor =
        _mm512_mul_pd(inverse_root(square), eight(0.5 * (PULLED_LAST + 1) * 65535));
    _mm256_storeu_si256((void *) (v->to[0] + i),
                        _mm512_cvttpd_epi32(_mm512_fmadd_pd(x, factor, half)));
    _mm256_storeu_si256((void *) (v->to[1] + i),
                        _mm512_cvttpd_epi32(_mm512_fmadd_pd(y, factor, half)));
}

/* Pulls sixteen such pairs, and derives their blues. */
static inline void pull_16(long_vectors *v, int32_t at, const int32_t *rg)
{
    const __m512i one = all(1), last = all(PULLED_LAST);
    const __m512i ax = load(v->from[0] + at), ay = load(v->from[1] + at);
    const __m512i s = load(v->to[0] + at), t = load(v->to[1] + at);
    __m512i u = _mm512_srli_epi32(s, 15), w = _mm512_srli_epi32(t, 15);
    const __mmask16 other = _mm512_cmpneq_epi32_mask(ax, ay),
                    wider = _mm512_cmpgt_epi32_mask(ax, ay);
    const __m512i squares = _mm512_add_epi32(_mm512_mullo_epi32(u, u), _mm512_mullo_epi32(w, w));
    const __m512i rest = _mm512_sub_epi32(all(REST_16 + 1), squares), more = _mm512_sub_epi32(u, w);
    const __mmask16 right = _mm512_cmpgt_epi32_mask(rest, more) & other;
    const __mmask16 down =
        _mm512_cmpgt_epi32_mask(_mm512_add_epi32(rest, more), _mm512_setzero_si512()) & other;
    u = _mm512_mask_add_epi32(u, right & (__mmask16) ~(down & (__mmask16) ~wider), u, one);
    w = _mm512_mask_add_epi32(w, down & (__mmask16) ~(right & wider), w, one);
    __m512i to = words_of(_mm512_sub_epi32(u, one), _mm512_sub_epi32(w, one));
    uint32_t doubt =
        _mm512_cmple_epi32_mask(_mm512_and_si512(_mm512_add_epi32(s, one), last), one) |
        _mm512_cmple_epi32_mask(_mm512_and_si512(_mm512_add_epi32(t, one), last), one);
    for (; doubt != 0; doubt &= doubt - 1) {
        const uint32_t pair = (uint32_t) rg[at + __builtin_ctz(doubt)];
        int32_t r = (int32_t) (pair & 65535), g = (int32_t) (pair >> 16);
        ntp__pull_seldom(&r, &g, 65535);
        r = ntp__abs(ntp__num(r, 65535)) / 2;
        g = ntp__abs(ntp__num(g, 65535)) / 2;
        to = _mm512_mask_mov_epi32(to, (__mmask16) (doubt & -doubt), all(r | g << 16));
    }
    const __m512i e =
        _mm512_add_epi32(all(REST_16), _mm512_madd_epi16(to, _mm512_xor_si512(to, all(-1))));
    store(v->to[0] + at, odd_of(_mm512_and_si512(to, all(65535))));
    store(v->to[1] + at, odd_of(_mm512_srli_epi32(to, 16)));
    store(v->to[2] + at, odd_of(root_of(e, true)));
}

/* |v x w|, its square, and v . w of n vectors whose x and y are too long, and their clean ones; up to whole lanes
 * of sixteen. */
static inline void long_products(double *s, double *s2, double *d, const int32_t *rg,
                                 const int32_t *b, int32_t n)
{
    long_vectors v;
    for (int32_t i = 0; i < n; i += LANES_512)
        set_long(&v, i, load(rg + i), load(b + i));
    const int32_t whole = (n + LANES_512 - 1) & -LANES_512;
    for (int32_t i = 0; i < whole; i += 8)
        shorten(&v, i);
    for (int32_t i = 0; i < n; i += LANES_512)
        pull_16(&v, i, rg);
    for (int32_t i = 0; i < n; i += 8) {
        const __m512d x1 = doubles_of(v.from[0] + i), x2 = doubles_of(v.to[0] + i);
        const __m512d y1 = doubles_of(v.from[1] + i), y2 = doubles_of(v.to[1] + i);
        const __m512d z1 = doubles_of(v.from[2] + i), z2 = doubles_of(v.to[2] + i);
        const __m512d x = _mm512_fmsub_pd(y1, z2, _mm512_mul_pd(z1, y2));
        const __m512d y = _mm512_fmsub_pd(z1, x2, _mm512_mul_pd(x1, z2));
        const __m512d z = _mm512_fmsub_pd(x1, y2, _mm512_mul_pd(y1, x2));
        /* rounded as with AVX2 */
        const __m512d flat = _mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y));
        const __m512d square = _mm512_add_pd(flat, _mm512_mul_pd(z, z));
        const __m512d dot = _mm512_fmadd_pd(x1, x2, _mm512_fmadd_pd(y1, y2, _mm512_mul_pd(z1, z2)));
        _mm512_storeu_pd(s2 + i, square);
        /* 0 has no such root; that of 1 makes no other angle */
        _mm512_storeu_pd(s + i, root_of_doubles(_mm512_max_pd(square, eight(1))));
        _mm512_storeu_pd(d + i, dot);
    }
}

/* As angle.c. */
static inline int32_t slow_turn(double s2, double d)
{
    return (int32_t) (ntp__radians(sqrt(s2), d) * (180e6 / NTP__PI) + 0.5);
}

/* An angle that ntp__flat_vectors_avx512 made d for: one of harm? */
static inline int32_t flat_turn_again(double d, int32_t xy, int32_t z, int32_t root, bool harm)
{
    const double w = harm && z < -1 ? -z : root, far = z - w;
    return slow_turn((4.0 * xy + 2) * far * far, d);
}

#endif
