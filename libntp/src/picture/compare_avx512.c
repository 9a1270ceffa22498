/* SPDX-License-Identifier: MIT */
/*
 * compare_avx512.c - differences of packed RGB in levels, and its small angles, with AVX-512
 *
 * As compare_avx2.c, which says why these angles are right, but 16 texels at a time, and one for one:
 * masks leave out equal texels, and leave large angles and those in doubt to texel/angles_tmpl.h.
 * Fused products only make errors smaller.  The squares of 16 bit have none, for they are handed on.
 */
#include "picture/compare_avx2.h"

#include <string.h>

#include "picture/small_angles.h"
#include "texel/packed_avx512_tmpl.h"

enum { STEP = LANES_512 };

/* s^2 and d of a block, times a power of 4 or 2, u0 and g, and bits of texels that are
 * different. */
typedef struct pairs {
    _Alignas(64) double s2[NTP__BLOCK];
    double d[NTP__BLOCK];
    float u0[NTP__BLOCK], g[NTP__BLOCK];
    uint32_t different[NTP__BLOCK / STEP];
    /* Where 16 begin some of which are left, and bits of these */
    int32_t some[NTP__BLOCK / STEP];
    uint32_t left[NTP__BLOCK / STEP];
} pairs;

/* |Differences| of levels, as the loops below have them. */
typedef struct sums {
    __m512i low, high, most_low, most_high;
} sums;

static inline __m512 to_floats(const double *v)
{
    const __m256 low = _mm512_cvtpd_ps(_mm512_load_pd(v));
    const __m256 high = _mm512_cvtpd_ps(_mm512_load_pd(v + STEP / 2));
    return _mm512_castpd_ps(_mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_castps_pd(low)),
                                               _mm256_castps_pd(high), 1));
}

/* In loops of their own, and without branches: roots and quotients are long waited for. */
static void find_first(pairs *p, int32_t n)
{
    for (int32_t i = 0; i < n; i += STEP) {
        const __m512 s2 = to_floats(p->s2 + i), d = to_floats(p->d + i);
        const __m512 s = _mm512_max_ps(_mm512_sqrt_ps(s2), _mm512_set1_ps(0x1p-20F));
        const __m512 g = _mm512_div_ps(_mm512_set1_ps(0.5F), _mm512_mul_ps(s, d));
        _mm512_store_ps(p->u0 + i, _mm512_mul_ps(s2, _mm512_add_ps(g, g)));
        _mm512_store_ps(p->g + i, g);
    }
}

/* atan(u) + 1/2 in units of 2^-PART_BITS micro-degrees, with other bits above those of 180 degrees. */
static inline __m512i angle_of(__m512d u)
{
    const __m512d w = _mm512_mul_pd(u, u), w2 = _mm512_mul_pd(w, w);
    const __m512d p = _mm512_fmadd_pd(_mm512_set1_pd(C1), w, _mm512_set1_pd(C0));
    const __m512d q = _mm512_fmadd_pd(_mm512_set1_pd(C3), w, _mm512_set1_pd(C2));
    const __m512d r = _mm512_fmadd_pd(_mm512_set1_pd(C4), w2, q);
    return _mm512_castpd_si512(
        _mm512_fmadd_pd(_mm512_fmadd_pd(r, w2, p), u, _mm512_set1_pd(0x1.8p39 + 0.5)));
}

/* Stores of nothing, all to one place, are slow: these are not with those of the angles. */
static void leave(ntp__compared *out, const pairs *p, int32_t some)
{
    int32_t left = 0;
    for (int32_t i = 0; i < 2 * some; i++) {
        const int32_t at = p->some[i / 2] + STEP / 2 * (i & 1);
        const __mmask8 these = (__mmask8) (p->left[i / 2] >> 8 * (i & 1));
        const __m512d s2 = _mm512_load_pd(p->s2 + at), d = _mm512_load_pd(p->d + at);
        _mm512_storeu_pd(out->s2 + left, _mm512_maskz_compress_pd(these, s2));
        _mm512_storeu_pd(out->d + left, _mm512_maskz_compress_pd(these, d));
        left += __builtin_popcount(these);
    }
    out->left = left;
}

/* The angles of the texels that are different. */
static void find_angles(ntp__compared *out, pairs *p, int32_t n)
{
    const __m512i evens =
        _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    int32_t found = 0, some = 0;
    for (int32_t i = 0; i < n; i += STEP) {
        const uint32_t different = p->different[i / STEP];
        const __m512 u0 = _mm512_load_ps(p->u0 + i), g = _mm512_load_ps(p->g + i);
        __m512d s2[2], d[2];
        __m512i v[2];
        for (int k = 0; k < 2; k++) {
            const int32_t at = i + STEP / 2 * k;
            const __m512d u = _mm512_cvtps_pd(_mm256_load_ps(p->u0 + at));
            s2[k] = _mm512_load_pd(p->s2 + at);
            d[k] = _mm512_load_pd(p->d + at);
            const __m512d s = _mm512_mul_pd(u, d[k]), rest = _mm512_fnmadd_pd(s, s, s2[k]);
            const __m512d by = _mm512_cvtps_pd(_mm256_load_ps(p->g + at));
            v[k] = angle_of(_mm512_fmadd_pd(rest, by, u));
        }
        const __m512i angle = _mm512_permutex2var_epi32(_mm512_srli_epi64(v[0], PART_BITS), evens,
                                                        _mm512_srli_epi64(v[1], PART_BITS));
        /* The places, so that those in doubt are the lowest integers */
        const __m512i low = _mm512_permutex2var_epi32(v[0], evens, v[1]);
        const __m512i part =
            _mm512_add_epi32(_mm512_slli_epi32(low, 32 - PART_BITS), _mm512_set1_epi32(UNIT));
        const uint32_t sure = _mm512_cmpgt_epu32_mask(part, _mm512_set1_epi32(2 * UNIT));
        /* g has the sign of d. */
        const uint32_t small = _mm512_cmp_ps_mask(u0, _mm512_set1_ps(SMALL), _CMP_LE_OQ) &
                               _mm512_cmp_ps_mask(g, _mm512_setzero_ps(), _CMP_GT_OQ);
        const uint32_t here = different & sure & small, other = different & ~here;
        _mm512_storeu_si512(out->angle + found,
                            _mm512_maskz_compress_epi32((__mmask16) here, angle));
        found += __builtin_popcount(here);
        p->some[some] = i;
        p->left[some] = other;
        some += other != 0;
        out->different += __builtin_popcount(different);
    }
    out->found = found;
    leave(out, p, some);
}

static void add_channel(ntp__compared *out, int k, __m512i sum, __m512i most)
{
    out->sum[k] = (uint32_t) _mm512_reduce_add_epi32(sum);
    out->most[k] = (uint32_t) _mm512_reduce_max_epi32(most);
}

/* ------------------------------------------------------------------------------ 8 bit */

static inline __m512i dot8(texels v, texels w)
{
    return _mm512_add_epi32(_mm512_madd_epi16(v.rg, w.rg), _mm512_madd_epi16(v.b, w.b));
}

static inline __m512d to_doubles(__m512i v, int k)
{
    return _mm512_cvtepi32_pd(k == 0 ? _mm512_castsi512_si256(v) : _mm512_extracti64x4_epi64(v, 1));
}

/* With v of a, and w = v + 2 off: half of v x w = 2 v x off and of v . w = v . v + 2 v . off. */
static inline void multiply8(double *s2, double *d, texels a, texels off)
{
    const texels v = {
        .rg = _mm512_sub_epi16(_mm512_add_epi16(a.rg, a.rg), _mm512_set1_epi16(255)),
        .b = _mm512_sub_epi16(_mm512_add_epi16(a.b, a.b), _mm512_set1_epi32(255)),
    };
    const __m512i k = dot8(v, v), l = dot8(off, off), e = dot8(v, off);
    for (int i = 0; i < 2; i++) {
        const __m512d m = to_doubles(k, i), f = to_doubles(e, i);
        _mm512_store_pd(s2 + STEP / 2 * i,
                        _mm512_fnmadd_pd(f, f, _mm512_mul_pd(m, to_doubles(l, i))));
        _mm512_store_pd(d + STEP / 2 * i, _mm512_fmadd_pd(m, _mm512_set1_pd(0.5), f));
    }
}

static inline uint32_t step8(double *s2, double *d, sums *sum, const uint8_t *pa, const uint8_t *pb)
{
    const texels a = take8(pa), b = take8(pb);
    const texels off = { _mm512_sub_epi16(b.rg, a.rg), _mm512_sub_epi16(b.b, a.b) };
    const __m512i rg = _mm512_abs_epi16(off.rg), blue = _mm512_abs_epi16(off.b);
    const __m512i any = _mm512_or_si512(rg, blue);
    sum->low = _mm512_add_epi16(sum->low, rg);
    sum->high = _mm512_add_epi16(sum->high, blue);
    sum->most_low = _mm512_max_epi16(sum->most_low, rg);
    sum->most_high = _mm512_max_epi16(sum->most_high, blue);
    multiply8(s2, d, a, off);
    return _mm512_test_epi32_mask(any, any);
}

static void finish8(ntp__compared *out, const sums *sum)
{
    const __m512i first = _mm512_set1_epi32(65535);
    add_channel(out, 0, _mm512_and_si512(sum->low, first), _mm512_and_si512(sum->most_low, first));
    add_channel(out, 1, _mm512_srli_epi32(sum->low, 16), _mm512_srli_epi32(sum->most_low, 16));
    add_channel(out, 2, sum->high, sum->most_high);
}

/* ------------------------------------------------------------------------------ 16 bit */

/* Samples k of eight texels as doubles, which are 128 times the numerators. */
static inline __m512d numerators(__m512i v, int k)
{
    const __m512i base = _mm512_castpd_si512(_mm512_set1_pd(0x1p52));
    const __m512i first = _mm512_setr_epi64(0, 6, 12, 18, 24, 30, 36, 42);
    /* Of each 64 bits bytes 1 and 2. */
    const __m512i from =
        _mm512_add_epi64(_mm512_or_si512(_mm512_slli_epi64(first, 8), _mm512_slli_epi64(first, 16)),
                         _mm512_set1_epi64(0x010000 + 0x020200 * k));
    const __m512i level = _mm512_mask_permutexvar_epi8(base, 0x0606060606060606, from, v);
    return _mm512_sub_pd(_mm512_castsi512_pd(level), _mm512_set1_pd(0x1p52 + 128 * 65535));
}

/* x^2, y^2 and z^2 of the product vector are rounded as in texel/angles_tmpl.h; all else is exact. */
static inline void multiply16(double *s2, double *d, __m512i a, __m512i b)
{
    const __m512d x1 = numerators(a, 0), y1 = numerators(a, 1), z1 = numerators(a, 2);
    const __m512d x2 = numerators(b, 0), y2 = numerators(b, 1), z2 = numerators(b, 2);
    const __m512d x = _mm512_fmsub_pd(y1, z2, _mm512_mul_pd(z1, y2));
    const __m512d y = _mm512_fmsub_pd(z1, x2, _mm512_mul_pd(x1, z2));
    const __m512d z = _mm512_fmsub_pd(x1, y2, _mm512_mul_pd(y1, x2));
    const __m512d xy = _mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y));
    _mm512_store_pd(s2, _mm512_add_pd(xy, _mm512_mul_pd(z, z)));
    _mm512_store_pd(d, _mm512_fmadd_pd(z1, z2, _mm512_fmadd_pd(y1, y2, _mm512_mul_pd(x1, x2))));
}

/* |a - b| of eight texels; returns bits of those that are different. */
static inline uint32_t add_levels16(sums *sum, __m512i a, __m512i b)
{
    const __m512i first = _mm512_setr_epi64(0, 3, 6, 9, 12, 15, 18, 21);
    const __m512i from =
        _mm512_add_epi64(_mm512_or_si512(_mm512_or_si512(first, _mm512_slli_epi64(first, 16)),
                                         _mm512_slli_epi64(first, 32)),
                         _mm512_set1_epi64(0x000200010000));
    const __m512i off = _mm512_or_si512(_mm512_subs_epu16(a, b), _mm512_subs_epu16(b, a));
    const __m512i v = _mm512_maskz_permutexvar_epi16(0x77777777, from, off);
    sum->low = _mm512_add_epi32(sum->low, _mm512_and_si512(v, _mm512_set1_epi32(65535)));
    sum->high = _mm512_add_epi32(sum->high, _mm512_srli_epi32(v, 16));
    sum->most_low = _mm512_max_epu16(sum->most_low, v);
    return _mm512_test_epi64_mask(v, v);
}

static inline uint32_t step16(double *s2, double *d, sums *sum, const uint8_t *pa,
                              const uint8_t *pb)
{
    enum { HALF = 48 /* bytes */ };
    uint32_t different = 0;
    for (int k = 0; k < 2; k++) {
        const __m512i a = load_48(pa + HALF * k), b = load_48(pb + HALF * k);
        different |= add_levels16(sum, a, b) << 8 * k;
        multiply16(s2 + STEP / 2 * k, d + STEP / 2 * k, a, b);
    }
    return different;
}

static void finish16(ntp__compared *out, const sums *sum)
{
    const __m512i first = _mm512_set1_epi64(UINT32_MAX), least = _mm512_set1_epi64(65535);
    const __m512i green = _mm512_and_si512(_mm512_srli_epi64(sum->most_low, 16), least);
    add_channel(out, 0, _mm512_and_si512(sum->low, first), _mm512_and_si512(sum->most_low, least));
    add_channel(out, 1, sum->high, green);
    add_channel(out, 2, _mm512_srli_epi64(sum->low, 32), _mm512_srli_epi64(sum->most_low, 32));
}

/* The last texels, with black ones after them. */
static const uint8_t *copy_last(uint8_t few[6 * STEP], const uint8_t *from, int32_t bytes)
{
    memset(few, 0, 6 * STEP);
    return memcpy(few, from, (size_t) bytes);
}

#define STEPS(step, bytes)                                                                         \
    for (int32_t i = 0; i < n; i += STEP) {                                                        \
        const uint8_t *const from[2] = { a + (bytes) * i, b + (bytes) * i };                       \
        const bool last = n - i < STEP;                                                            \
        const int32_t left = (bytes) * (n - i);                                                    \
        p.different[i / STEP] =                                                                    \
            step(p.s2 + i, p.d + i, &sum, last ? copy_last(few[0], from[0], left) : from[0],       \
                 last ? copy_last(few[1], from[1], left) : from[1]);                               \
    }

void ntp__compare_rgb_avx512(ntp__compared *out, const void *pa, const void *pb, int32_t n,
                             bool deep)
{
    const uint8_t *const a = pa, *const b = pb;
    const __m512i zero = _mm512_setzero_si512();
    sums sum = { zero, zero, zero, zero };
    uint8_t few[2][6 * STEP];
    pairs p;
    memset(out, 0, offsetof(ntp__compared, angle));
    if (deep) {
        STEPS(step16, 6)
        finish16(out, &sum);
    } else {
        STEPS(step8, 3)
        finish8(out, &sum);
    }
    find_first(&p, n);
    find_angles(out, &p, n);
}
