/* SPDX-License-Identifier: MIT */
/*
 * compare_avx2.c - differences of packed RGB in levels, and its angles, with AVX2
 *
 * Eight texels at a time.  Those whose angles are all small are found with fewer terms, apart from others.
 * Eight are left to the loops of texel/angles_tmpl.h where one is in doubt.
 *
 * With s^2 = |v x w|^2, d = v . w and a = |d|, the angle to the nearest of 0, 90 and 180 degrees is
 * atan(u), u = min(s, a)/max(s, a).  Floats give u0, off by at most 2^-21 of u, and g, as near to
 * 1/(2 s a).  Then u0 + (min(s^2, d^2) - u0^2 max(s^2, d^2)) g is off by less than 2^-41 of u: a step of
 * Newton's method, in doubles.  That is less than 1.4e-5 micro-degrees.  A polynomial of 5 terms gives the
 * arc tangent of up to 0.201 to 1.0e-4 micro-degrees, one of 14 terms any to 3.3e-5, and roundings and
 * angle.c add less than 2e-6.  It is rounded to PART_BITS binary places, which is off by half of the
 * last.  In all this is less than two of that.  So an angle of which these places are at least two from
 * the middle between two whole ones is rounded as there.  Of opposite vectors u is 0, and the angle exact.
 *
 * An unused texel, black or white, has no angle to the other of them: their product vector is 0, and the
 * sign of d is made that of equal ones.
 *
 * Fused products only make errors smaller.  The squares of 16 bit have none, for they are handed on.
 */
#include "picture/compare_avx2.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "picture/small_angles.h"

#include <immintrin.h>

enum {
    STEP = 8, /* texels */
    FEW = 16  /* eights: angles of 180 degrees of so many add up in lanes of 32 bits */
};

/* s^2 and d of n texels, times a power of 4 or 2, u0 and g.  `small` and `large` are where eight of them
 * begin whose angles are all small, or not. */
typedef struct pairs {
    _Alignas(32) double s2[NTP__BLOCK];
    double d[NTP__BLOCK];
    float u0[NTP__BLOCK], g[NTP__BLOCK];
    int32_t small[NTP__BLOCK / 8], large[NTP__BLOCK / 8];
    int32_t n, smalls, larges, different;
    int32_t listed, counted, bin[NTP__BLOCK + 1];
    uint32_t *bins;
} pairs;

/* |Differences| of levels, as the loops below have them. */
typedef struct sums {
    __m256i low, high, most_low, most_high;
} sums;

/* A shuffle of each half; -1: a byte that becomes 0. */
#define SHUFFLES(v, ...) _mm256_shuffle_epi8((v), _mm256_setr_epi8(__VA_ARGS__))

/* Words k and k + 2 of each half of two vectors. */
#define WORDS(v, w, k)                                                                             \
    _mm256_castps_si256(                                                                           \
        _mm256_shuffle_ps(_mm256_castsi256_ps(v), _mm256_castsi256_ps(w), 0x88 + 0x55 * (k)))

/* v + 2^52 - less of integers from 0 on, below 2^52. */
static inline __m256d to_doubles(__m256i v, double less)
{
    const __m256i base = _mm256_castpd_si256(_mm256_set1_pd(0x1p52));
    return _mm256_sub_pd(_mm256_castsi256_pd(_mm256_or_si256(v, base)), _mm256_set1_pd(less));
}

/* (v - 2^31)/2 of integers below 2^32. */
static inline __m256d to_halves(__m256i v)
{
    const __m256i base = _mm256_castpd_si256(_mm256_set1_pd(0x1p51));
    return _mm256_sub_pd(_mm256_castsi256_pd(_mm256_or_si256(v, base)),
                         _mm256_set1_pd(0x1p51 + 0x1p30));
}

/* Eight doubles. */
typedef struct eight {
    __m256d half[2];
} eight;

static inline eight load_eight(const double *from)
{
    return (eight) { { _mm256_loadu_pd(from), _mm256_loadu_pd(from + STEP / 2) } };
}

static inline void store_eight(double *to, eight v)
{
    _mm256_storeu_pd(to, v.half[0]);
    _mm256_storeu_pd(to + STEP / 2, v.half[1]);
}

static inline __m256 to_floats(eight v)
{
    return _mm256_set_m128(_mm256_cvtpd_ps(v.half[1]), _mm256_cvtpd_ps(v.half[0]));
}

/* There are no branches, for they would be taken at random. */
static void find_first(pairs *p)
{
    int32_t smalls = 0, larges = 0;
    for (int32_t i = 0; i < p->n; i += STEP) {
        const __m256 s2 = to_floats(load_eight(p->s2 + i)), d = to_floats(load_eight(p->d + i));
        const __m256 least = _mm256_set1_ps(0x1p-20F), d2 = _mm256_mul_ps(d, d);
        const __m256 s = _mm256_max_ps(_mm256_sqrt_ps(s2), least);
        const __m256 a = _mm256_max_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0F), d), least);
        const __m256 g = _mm256_div_ps(_mm256_set1_ps(0.5F), _mm256_mul_ps(s, a));
        const __m256 u0 = _mm256_mul_ps(_mm256_min_ps(s2, d2), _mm256_add_ps(g, g));
        /* Or d is negative */
        const __m256 large = _mm256_cmp_ps(_mm256_mul_ps(d, _mm256_set1_ps(SMALL)), s, _CMP_LT_OQ);
        const bool all = _mm256_movemask_ps(large) == 0;
        _mm256_storeu_ps(p->u0 + i, u0);
        _mm256_storeu_ps(p->g + i, g);
        p->small[smalls] = p->large[larges] = i;
        smalls += all;
        larges += !all;
    }
    p->smalls = smalls;
    p->larges = larges;
}

const double ntp__atan_terms[NTP__ATAN_TERMS] = {
    -0x1.a66f351242a8cp+13, 0x1.b565140a561e2p+16, -0x1.a9e3b031273a9p+18, 0x1.07445610b8cecp+20,
    -0x1.db5647d014acap+20, 0x1.59d3927db7955p+21, -0x1.b96529c6dcc5ep+21, 0x1.098ad90ad6303p+22,
    -0x1.3d3af1a59b439p+22, 0x1.84785c0f2d600p+22, -0x1.f3925dc7bdfadp+22, 0x1.5db49b6394bcep+23,
    -0x1.236be1079ab1bp+24, 0x1.b521d1c18d4afp+25,
};

/* atan(u) */
static inline __m256d small_angle(__m256d u)
{
    const __m256d w = _mm256_mul_pd(u, u);
    __m256d t = _mm256_fmadd_pd(_mm256_set1_pd(C4), w, _mm256_set1_pd(C3));
    t = _mm256_fmadd_pd(t, w, _mm256_set1_pd(C2));
    t = _mm256_fmadd_pd(t, w, _mm256_set1_pd(C1));
    t = _mm256_fmadd_pd(t, w, _mm256_set1_pd(C0));
    return _mm256_fmadd_pd(t, u, _mm256_set1_pd(TO_PARTS));
}

/* atan(u) of s <= |d|, and atan(1/u) of others; of d < 0 180 degrees less that.  Terms of odd and of even powers are
 * added apart. */
static inline __m256d any_angle(__m256d u, __m256d s2, __m256d d)
{
    const double *const terms = ntp__atan_terms;
    const __m256d w = _mm256_mul_pd(u, u), w2 = _mm256_mul_pd(w, w);
    const __m256d beside = _mm256_cmp_pd(s2, _mm256_mul_pd(d, d), _CMP_GT_OQ);
    __m256d odd = _mm256_set1_pd(terms[0]), even = _mm256_set1_pd(terms[1]);
#pragma GCC unroll 2
    for (size_t k = 2; k < NTP__ATAN_TERMS; k += 2) {
        odd = _mm256_fmadd_pd(odd, w2, _mm256_set1_pd(terms[k]));
        even = _mm256_fmadd_pd(even, w2, _mm256_set1_pd(terms[k + 1]));
    }
    __m256d t = _mm256_mul_pd(_mm256_fmadd_pd(odd, w, even), u);
    t = _mm256_blendv_pd(t, _mm256_sub_pd(_mm256_set1_pd(90e6), t), beside);
    t = _mm256_blendv_pd(t, _mm256_sub_pd(_mm256_set1_pd(180e6), t), d);
    return _mm256_add_pd(t, _mm256_set1_pd(TO_PARTS));
}

/* Micro-degrees + ROUND_BIN */
typedef struct added {
    __m256i sum, most;
} added;

/* u of four pairs from i on. */
static inline __m256d tangents_of(const pairs *p, int32_t i)
{
    const __m256d u0 = _mm256_cvtps_pd(_mm_loadu_ps(p->u0 + i));
    const __m256d g = _mm256_cvtps_pd(_mm_loadu_ps(p->g + i));
    const __m256d s2 = _mm256_loadu_pd(p->s2 + i), d = _mm256_loadu_pd(p->d + i);
    const __m256d d2 = _mm256_mul_pd(d, d), low = _mm256_min_pd(s2, d2),
                  high = _mm256_max_pd(s2, d2);
    const __m256d rest = _mm256_fnmadd_pd(_mm256_mul_pd(u0, u0), high, low);
    return _mm256_fmadd_pd(rest, g, u0);
}

/* Adds eight angles; false: one is not sure. */
static inline bool add_eight(int32_t *bins, added *to, const __m256d angles[2])
{
    const __m256i v0 = _mm256_castpd_si256(angles[0]), v1 = _mm256_castpd_si256(angles[1]);
    const __m256i a0 = _mm256_srli_epi64(v0, PART_BITS), a1 = _mm256_srli_epi64(v1, PART_BITS);
    const __m256i angle = WORDS(a0, a1, 0), by = _mm256_set1_epi32(BY_1000);
    const __m256i part = _mm256_and_si256(WORDS(v0, v1, 0), _mm256_set1_epi32(SURE_BITS));
    const __m256i doubt = _mm256_cmpeq_epi32(part, _mm256_setzero_si256());
    const __m256i bin = WORDS(_mm256_mul_epu32(a0, by), _mm256_mul_epu32(a1, by), 1);
    if (_mm256_movemask_ps(_mm256_castsi256_ps(doubt)) != 0)
        return false;
    _mm256_storeu_si256((void *) bins, _mm256_srli_epi32(bin, BY_BITS));
    to->sum = _mm256_add_epi32(to->sum, angle);
    to->most = _mm256_max_epi32(to->most, angle);
    return true;
}

/* Lanes are unsigned 32 bits. */
ONE_COPY static void add_channel(ntp__compared *out, int k, __m256i sum, __m256i most)
{
    int32_t each[STEP], highest[STEP];
    _mm256_storeu_si256((void *) each, sum);
    _mm256_storeu_si256((void *) highest, most);
    for (int i = 0; i < STEP; i++) {
        out->sum[k] += (uint32_t) each[i];
        out->most[k] = (uint32_t) highest[i] > out->most[k] ? (uint32_t) highest[i] : out->most[k];
    }
}

/* Of up to FEW eights, which begin where `at` says. */
ONE_COPY static void find_few(ntp__compared *out, pairs *p, const int32_t *at, int32_t n, bool any)
{
    added to = { _mm256_setzero_si256(), _mm256_setzero_si256() };
    int32_t listed = p->listed, left = out->left;
    __m256d four[2 * FEW];

    /* In three loops, for of one long chain few steps would be in flight. */
    for (int32_t i = 0; i < n; i++) {
        four[2 * i] = tangents_of(p, at[i]);
        four[2 * i + 1] = tangents_of(p, at[i] + STEP / 2);
    }
    for (int32_t i = 0; i < 2 * n && !any; i++)
        four[i] = small_angle(four[i]);
    for (int32_t i = 0; i < 2 * n && any; i++) {
        const int32_t k = at[i / 2] + i % 2 * (STEP / 2);
        four[i] = any_angle(four[i], _mm256_loadu_pd(p->s2 + k), _mm256_loadu_pd(p->d + k));
    }
    for (int32_t i = 0; i < n; i++) {
        if (add_eight(p->bin + listed, &to, four + 2 * i)) {
            listed += STEP;
        } else {
            store_eight(out->s2 + left, load_eight(p->s2 + at[i]));
            store_eight(out->d + left, load_eight(p->d + at[i]));
            left += STEP;
        }
    }
    add_channel(out, ANGLES, to.sum, to.most);
    out->found += listed - p->listed;
    p->listed = listed;
    out->left = left;
}

static void find_angles(ntp__compared *out, pairs *p)
{
    for (int32_t i = 0; i < p->smalls; i += FEW)
        find_few(out, p, p->small + i, p->smalls - i < FEW ? p->smalls - i : FEW, false);
    for (int32_t i = 0; i < p->larges; i += FEW)
        find_few(out, p, p->large + i, p->larges - i < FEW ? p->larges - i : FEW, true);
}

/* ------------------------------------------------------------------------------ 8 bit */

static inline bool are_equal(__m256i a, __m256i b)
{
    const __m256i off = _mm256_xor_si256(a, b);
    return _mm256_testz_si256(off, off) != 0;
}

/* Red and green of eight texels as pairs of 16 bits, and blue. */
typedef struct texels8 {
    __m256i rg, b;
} texels8;

static inline texels8 spread8(__m256i v)
{
    return (texels8) {
        .rg = SHUFFLES(v, 0, -1, 1, -1, 3, -1, 4, -1, 6, -1, 7, -1, 9, -1, 10, -1, 4, -1, 5, -1, 7,
                       -1, 8, -1, 10, -1, 11, -1, 13, -1, 14, -1),
        .b = SHUFFLES(v, 2, -1, -1, -1, 5, -1, -1, -1, 8, -1, -1, -1, 11, -1, -1, -1, 6, -1, -1, -1,
                      9, -1, -1, -1, 12, -1, -1, -1, 15, -1, -1, -1),
    };
}

static inline __m256i dot8(texels8 v, texels8 w)
{
    return _mm256_add_epi32(_mm256_madd_epi16(v.rg, w.rg), _mm256_madd_epi16(v.b, w.b));
}

/* Where any are unused, l and e become 0. */
static inline void leave_unused8(__m256i *l, __m256i *e, texels8 a)
{
    /* Of all opposite corners */
    const __m256i corners = _mm256_cmpeq_epi32(*l, _mm256_set1_epi32(3 * 255 * 255));
    if (_mm256_movemask_ps(_mm256_castsi256_ps(corners)) == 0)
        return;
    const __m256i gray = _mm256_or_si256(a.b, _mm256_slli_epi32(a.b, 16));
    const __m256i unused = _mm256_and_si256(corners, _mm256_cmpeq_epi32(a.rg, gray));
    *l = _mm256_andnot_si256(unused, *l);
    *e = _mm256_andnot_si256(unused, *e);
}

/* k l - e^2: no product reaches 2^36. */
static inline __m256d square8(__m256i k, __m256i l, __m256i e)
{
    const __m256i off = _mm256_sub_epi64(_mm256_mul_epu32(k, l), _mm256_mul_epi32(e, e));
    return to_doubles(off, 0x1p52);
}

/* With v of a, and w = v + 2 off, v x w = 2 v x off and v . w = v . v + 2 v . off.  Half of both is
 * taken, of the even texels and of the odd ones. */
static inline void multiply8(pairs *p, texels8 a, texels8 off)
{
    const texels8 v = {
        .rg = _mm256_sub_epi16(_mm256_add_epi16(a.rg, a.rg), _mm256_set1_epi16(255)),
        .b = _mm256_sub_epi16(_mm256_add_epi16(a.b, a.b), _mm256_set1_epi32(255)),
    };
    const __m256i k = dot8(v, v);
    __m256i l = dot8(off, off), e = dot8(v, off);
    leave_unused8(&l, &e, a);
    const __m256i k1 = _mm256_srli_epi64(k, 32), l1 = _mm256_srli_epi64(l, 32);
    const __m256i e1 = _mm256_srli_epi64(e, 32);
    const __m256i d = _mm256_add_epi32(_mm256_add_epi32(e, e), k);
    /* d + 2^31 is never negative. */
    const __m256i more = _mm256_xor_si256(d, _mm256_set1_epi32(INT32_MIN));
    const __m256i more0 = _mm256_and_si256(more, _mm256_set1_epi64x(UINT32_MAX));
    const __m256i more1 = _mm256_srli_epi64(more, 32);
    store_eight(p->s2 + p->n, (eight) { { square8(k, l, e), square8(k1, l1, e1) } });
    store_eight(p->d + p->n, (eight) { { to_halves(more0), to_halves(more1) } });
    p->n += STEP;
}

static inline void step8(pairs *p, sums *sum, const uint8_t *pa, const uint8_t *pb)
{
    const __m256i va = load_two(pa, pa + 8), vb = load_two(pb, pb + 8);
    if (are_equal(va, vb))
        return;
    const texels8 a = spread8(va), b = spread8(vb);
    const texels8 off = { _mm256_sub_epi16(b.rg, a.rg), _mm256_sub_epi16(b.b, a.b) };
    const __m256i rg = _mm256_abs_epi16(off.rg), blue = _mm256_abs_epi16(off.b);
    const __m256i same = _mm256_cmpeq_epi32(_mm256_or_si256(rg, blue), _mm256_setzero_si256());
    const uint32_t equal = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(same));
    sum->low = _mm256_add_epi16(sum->low, rg);
    sum->high = _mm256_add_epi16(sum->high, blue);
    sum->most_low = _mm256_max_epi16(sum->most_low, rg);
    sum->most_high = _mm256_max_epi16(sum->most_high, blue);
    multiply8(p, a, off);
    p->different += STEP - __builtin_popcount(equal);
}

static void finish8(ntp__compared *out, const sums *sum)
{
    const __m256i first = _mm256_set1_epi32(65535);
    add_channel(out, 0, _mm256_and_si256(sum->low, first), _mm256_and_si256(sum->most_low, first));
    add_channel(out, 1, _mm256_srli_epi32(sum->low, 16), _mm256_srli_epi32(sum->most_low, 16));
    add_channel(out, 2, sum->high, sum->most_high);
}

/* ------------------------------------------------------------------------------ 16 bit */

/* Samples as doubles, which are 128 times the numerators: only so are all steps exact.  The second
 * two of four texels are loaded 4 bytes earlier than a half would begin, so that none beyond is. */
#define NUMERATORS(v, k)                                                                           \
    to_doubles(SHUFFLES(v, -1, 2 * (k), 2 * (k) + 1, -1, -1, -1, -1, -1, -1, 2 * (k) + 6,          \
                        2 * (k) + 7, -1, -1, -1, -1, -1, -1, 2 * (k) + 4, 2 * (k) + 5, -1, -1, -1, \
                        -1, -1, -1, 2 * (k) + 10, 2 * (k) + 11, -1, -1, -1, -1, -1),               \
               0x1p52 + 128 * 65535)

/* x^2, y^2 and z^2 of the product vector are rounded as in texel/angles_tmpl.h. */
static inline void multiply16(pairs *p, int half, __m256i a, __m256i b)
{
    double *const s2 = p->s2 + p->n + STEP / 2 * half, *const d = p->d + p->n + STEP / 2 * half;
    const __m256d x1 = NUMERATORS(a, 0), y1 = NUMERATORS(a, 1), z1 = NUMERATORS(a, 2);
    const __m256d x2 = NUMERATORS(b, 0), y2 = NUMERATORS(b, 1), z2 = NUMERATORS(b, 2);
    const __m256d x = _mm256_fmsub_pd(y1, z2, _mm256_mul_pd(z1, y2));
    const __m256d y = _mm256_fmsub_pd(z1, x2, _mm256_mul_pd(x1, z2));
    const __m256d z = _mm256_fmsub_pd(x1, y2, _mm256_mul_pd(y1, x2));
    const __m256d xy = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
    const __m256d dot = _mm256_fmadd_pd(y1, y2, _mm256_mul_pd(x1, x2));
    _mm256_storeu_pd(s2, _mm256_add_pd(xy, _mm256_mul_pd(z, z)));
    _mm256_storeu_pd(d, _mm256_fmadd_pd(z1, z2, dot));
}

/* Samples of four texels, 64 bits each. */
static inline __m256i spread16(__m256i v)
{
    return SHUFFLES(v, 0, 1, 2, 3, 4, 5, -1, -1, 6, 7, 8, 9, 10, 11, -1, -1, 4, 5, 6, 7, 8, 9, -1,
                    -1, 10, 11, 12, 13, 14, 15, -1, -1);
}

/* |a - b| of four texels; returns how many are different.  d of those that are unused becomes positive. */
static inline int32_t add_levels16(sums *sum, double *d, __m256i a, __m256i b)
{
    const __m256i white = _mm256_set1_epi64x(0xffffffffffff), zero = _mm256_setzero_si256();
    const __m256i v = spread16(_mm256_or_si256(_mm256_subs_epu16(a, b), _mm256_subs_epu16(b, a)));
    const __m256i same = _mm256_cmpeq_epi64(v, zero), corners = _mm256_cmpeq_epi64(v, white);
    sum->low = _mm256_add_epi32(sum->low, _mm256_and_si256(v, _mm256_set1_epi32(65535)));
    sum->high = _mm256_add_epi32(sum->high, _mm256_srli_epi32(v, 16));
    sum->most_low = _mm256_max_epu16(sum->most_low, v);
    if (_mm256_movemask_pd(_mm256_castsi256_pd(corners)) != 0) {
        const __m256i w = spread16(a);
        const __m256i gray =
            _mm256_or_si256(_mm256_cmpeq_epi64(w, zero), _mm256_cmpeq_epi64(w, white));
        const __m256d unused = _mm256_castsi256_pd(_mm256_and_si256(gray, corners));
        _mm256_storeu_pd(
            d, _mm256_andnot_pd(_mm256_and_pd(unused, _mm256_set1_pd(-0.0)), _mm256_loadu_pd(d)));
    }
    return STEP / 2 - __builtin_popcount((uint32_t) _mm256_movemask_pd(_mm256_castsi256_pd(same)));
}

static inline void step16(pairs *p, sums *sum, const uint8_t *pa, const uint8_t *pb)
{
    enum { HALF = 24 /* bytes */ };
    const __m256i a0 = load_two(pa, pa + 8), b0 = load_two(pb, pb + 8);
    const __m256i a1 = load_two(pa + HALF, pa + HALF + 8), b1 = load_two(pb + HALF, pb + HALF + 8);
    if (are_equal(a0, b0) && are_equal(a1, b1))
        return;
    double *const d = p->d + p->n;
    multiply16(p, 0, a0, b0);
    multiply16(p, 1, a1, b1);
    p->different += add_levels16(sum, d, a0, b0) + add_levels16(sum, d + STEP / 2, a1, b1);
    p->n += STEP;
}

static void finish16(ntp__compared *out, const sums *sum)
{
    const __m256i first = _mm256_set1_epi64x(UINT32_MAX), least = _mm256_set1_epi64x(65535);
    const __m256i green = _mm256_and_si256(_mm256_srli_epi64(sum->most_low, 16), least);
    add_channel(out, 0, _mm256_and_si256(sum->low, first), _mm256_and_si256(sum->most_low, least));
    add_channel(out, 1, sum->high, green);
    add_channel(out, 2, _mm256_srli_epi64(sum->low, 32), _mm256_srli_epi64(sum->most_low, 32));
}

#include "picture/compare_steps_tmpl.h"

int32_t ntp__compare_rgb_avx2(ntp__compared *out, const void *a, const void *b, int32_t n,
                              bool deep)
{
    const __m256i zero = _mm256_setzero_si256();
    const int32_t span = n < SPAN ? n : SPAN, texel = deep ? 6 : 3;
    int32_t rest = span;
    sums sum = { zero, zero, zero, zero };
    pairs p;
    p.different = p.listed = p.counted = 0;
    p.bins = out->bins;
    memset(out, 0, offsetof(ntp__compared, fullest));
    do {
        const uint8_t *const va = (const uint8_t *) a + texel * (span - rest);
        const uint8_t *const vb = (const uint8_t *) b + texel * (span - rest);
        rest = take_steps(&p, &sum, va, vb, rest, deep);
        count_rest(&p);
        find_first(&p);
        find_angles(out, &p);
    } while (rest > 0 && out->left <= KEPT);
    if (deep)
        finish16(out, &sum);
    else
        finish8(out, &sum);
    count_rest(&p);
    out->different = p.different;
    end_lanes();
    return span - rest;
}
