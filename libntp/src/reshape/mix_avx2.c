/* SPDX-License-Identifier: MIT */
/*
 * mix_avx2.c - packed RGB made stronger, or blended, with AVX2
 *
 * The bytes are those of directions_tmpl.h.  Floats decide the levels at 16 bit too; the caller does
 * those that are in doubt in double.
 *
 * The bound of floats, where u = 2^-24 and squares of it are left out.  The components of a blended
 * vector are off by u as floats.  So their squares are by 3u, the sum by 5u, the root by 3.5u, the
 * quotient by 4.5u, and the product with a component by 6.5u.  A vector that is made stronger is
 * (x, y, z/S): x and y are exact, z/S is off by 2u, so the sum of squares is by 6u, the root by 4u, and
 * the product by 6u.  Less than 8u is 2^-21.
 *
 * Vectors are blended in double, which is exact where the strength of a detail is 1 or -1.  Else
 * components are off by less than 2^-49 of `size`, which is not below what is added up for one.  The
 * length is at least 2^-16 of it, or the texel is in doubt.  So a component over the length is off by
 * 2^-33, and that by three times as much because the length is.  This is below 2^-16 levels.
 *
 * Of 8 bit, where that strength is 1 or -1, floats are as good.  They hold whole numbers up to 2^24, up
 * to twice that if these are even, and up to four times that if these are multiples of 4.  M is odd, and
 * so are all numerators; hence t.z, t.u and t.z M are even.  Where t.u is at most 2^17, all products
 * are whole: t.u times an odd number below 2^8, t.z M times such, and t.u t.z, a multiple of 4.  So
 * their sums are off by u at most, with the right sign.
 */
#include "reshape/mix_avx2.h"

#include "texel/packed_avx2_tmpl.h"

#include <math.h>
#include <string.h>

enum { HALF = 8, STEP = 16 /* texels */, MOST_PRODUCT = 1 << 17 };

typedef struct constants {
    bool deep;
    __m256i m, white, rest, zero, zeros; /* M, red and green of white; REST; levels of 0 */
    __m256 half;                         /* M/2 */
    __m256 less, least2, least_z; /* what x or y may be off by; the least square of a length; z */
} constants;

static constants levels_of(bool deep)
{
    constants c;
    memset(&c, 0, sizeof c);
    c.deep = deep;
    c.m = _mm256_set1_epi32(deep ? 65535 : 255);
    c.white = _mm256_or_si256(c.m, _mm256_slli_epi32(c.m, 16));
    c.rest = _mm256_set1_epi32(deep ? REST_16 : REST_8);
    c.zero = _mm256_set1_epi32(deep ? 32768 : 128);
    c.zeros = _mm256_or_si256(c.zero, _mm256_slli_epi32(c.zero, 16));
    c.half = _mm256_set1_ps(deep ? 32767.5F : 127.5F);
    return c;
}

/* Vectors of a run, of any length; pairs of levels of x, y less that of 0; negative where a texel is
 * left to the caller.  Each loop does one thing: while a processor waits for a root it does others. */
typedef struct planes {
    float x[NTP__BLOCK], y[NTP__BLOCK], z[NTP__BLOCK];
    int32_t pair[NTP__BLOCK], left[NTP__BLOCK];
} planes;

static inline __m256i load_ints(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) from);
}

static inline void store_ints(int32_t *to, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) to, v);
}

static inline __m256 absolute(__m256 v)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), v);
}

/* ------------------------------------------------------------------------------------- texels */

static inline texels take(const ntp__mix_run *s, int32_t i, bool deep)
{
    const uint8_t *bytes = (const uint8_t *) s->c;
    return deep ? take16(bytes + 6 * (ptrdiff_t) i) : take8(bytes + 3 * (ptrdiff_t) i);
}

/* Numerators over M of eight texels. */
typedef struct numerators {
    __m256i x, y, z;
} numerators;

static inline numerators numerators_of(texels t, const constants *c)
{
    const __m256i x = _mm256_srli_epi32(_mm256_slli_epi32(t.rg, 16), 15);
    const __m256i y = _mm256_slli_epi32(_mm256_srli_epi32(t.rg, 16), 1);
    const numerators v = { _mm256_sub_epi32(x, c->m), _mm256_sub_epi32(y, c->m),
                           _mm256_sub_epi32(_mm256_slli_epi32(t.b, 1), c->m) };
    return v;
}

/* Red and green are those of black or of white. */
static inline __m256i suspect(texels t, const constants *c)
{
    return _mm256_or_si256(_mm256_cmpeq_epi32(t.rg, _mm256_setzero_si256()),
                           _mm256_cmpeq_epi32(t.rg, c->white));
}

/* ------------------------------------------------------------------------------------ vectors */

/* The strength of n texels. */
static void boost(planes *p, const ntp__mix_run *s, int32_t n, const ntp__boost *how,
                  const constants *c)
{
    const __m256 over = _mm256_set1_ps((float) (1 / how->strength));
    const __m256 mirror_x = _mm256_set1_ps(how->mirror_x ? -0.0F : 0.0F);
    const __m256 mirror_y = _mm256_set1_ps(how->mirror_y ? -0.0F : 0.0F);
    float *const x = how->swap ? p->y : p->x, *const y = how->swap ? p->x : p->y;
    for (int32_t i = 0; i < n; i += HALF) {
        const texels t = take(s, i, c->deep);
        const numerators v = numerators_of(t, c);
        store_ints(p->left + i, suspect(t, c));
        _mm256_storeu_ps(x + i, _mm256_xor_ps(_mm256_cvtepi32_ps(v.x), mirror_x));
        _mm256_storeu_ps(y + i, _mm256_xor_ps(_mm256_cvtepi32_ps(v.y), mirror_y));
        _mm256_storeu_ps(p->z + i, _mm256_mul_ps(_mm256_cvtepi32_ps(v.z), over));
    }
}

/* What a blend is made with, as in blend_kernels.h. */
typedef struct terms {
    double strength, turn, m, base_z, detail_z, product;
    bool reoriented, in_float;
} terms;

#define NUMBER __m256d
#define OP(op) _mm256_##op##_pd
#define MIXED  mixed_doubles
#include "reshape/mixed_tmpl.h"
#undef NUMBER
#undef OP
#undef MIXED

#define NUMBER __m256
#define OP(op) _mm256_##op##_ps
#define MIXED  mixed_floats
#include "reshape/mixed_tmpl.h"

static inline __m256d low_half(__m256i v)
{
    return _mm256_cvtepi32_pd(_mm256_castsi256_si128(v));
}

static inline __m256d high_half(__m256i v)
{
    return _mm256_cvtepi32_pd(_mm256_extracti128_si256(v, 1));
}

static inline void blend_in_double(__m256 v[3], numerators b, numerators d, const terms *t)
{
    const __m256d low_b[3] = { low_half(b.x), low_half(b.y), low_half(b.z) };
    const __m256d low_d[3] = { low_half(d.x), low_half(d.y), low_half(d.z) };
    const __m256d high_b[3] = { high_half(b.x), high_half(b.y), high_half(b.z) };
    const __m256d high_d[3] = { high_half(d.x), high_half(d.y), high_half(d.z) };
    __m256d low[3], high[3], product;
    mixed_doubles(low, &product, low_b, low_d, t);
    mixed_doubles(high, &product, high_b, high_d, t);
    for (int32_t k = 0; k < 3; k++)
        v[k] = _mm256_set_m128(_mm256_cvtpd_ps(high[k]), _mm256_cvtpd_ps(low[k]));
}

/* Negative where t.u is too much. */
static inline __m256i blend_in_float(__m256 v[3], numerators b, numerators d, const terms *t)
{
    const __m256 of_b[3] = { _mm256_cvtepi32_ps(b.x), _mm256_cvtepi32_ps(b.y),
                             _mm256_cvtepi32_ps(b.z) };
    const __m256 of_d[3] = { _mm256_cvtepi32_ps(d.x), _mm256_cvtepi32_ps(d.y),
                             _mm256_cvtepi32_ps(d.z) };
    __m256 product;
    mixed_floats(v, &product, of_b, of_d, t);
    return _mm256_castps_si256(
        _mm256_cmp_ps(absolute(product), _mm256_set1_ps(MOST_PRODUCT), _CMP_GT_OQ));
}

static void blend(planes *p, const ntp__mix_run *base, const ntp__mix_run *detail, int32_t n,
                  const terms *how, const constants *c)
{
    for (int32_t i = 0; i < n; i += HALF) {
        const texels from = take(base, i, c->deep), other = take(detail, i, c->deep);
        const numerators b = numerators_of(from, c), d = numerators_of(other, c);
        __m256i left = _mm256_or_si256(suspect(from, c), suspect(other, c));
        __m256 v[3];
        if (how->in_float)
            left = _mm256_or_si256(left, blend_in_float(v, b, d, how));
        else
            blend_in_double(v, b, d, how);
        /* A steep detail, reoriented on a steep base, can point below the horizon.  -0 does not. */
        const __m256i z = _mm256_castps_si256(_mm256_add_ps(v[2], _mm256_setzero_ps()));
        const __m256i below = _mm256_andnot_si256(_mm256_or_si256(b.z, d.z), z);
        const __m256i unsure =
            _mm256_castps_si256(_mm256_cmp_ps(absolute(v[2]), c->least_z, _CMP_LT_OQ));
        store_ints(p->left + i, _mm256_or_si256(left, unsure));
        _mm256_storeu_ps(p->x + i, v[0]);
        _mm256_storeu_ps(p->y + i, v[1]);
        _mm256_storeu_ps(p->z + i,
                         _mm256_castsi256_ps(_mm256_andnot_si256(_mm256_srai_epi32(below, 31), z)));
    }
}

/* ------------------------------------------------------------------------------------- levels */

/* Is the floor of s in doubt?  That of 0 is only where it may be off. */
static inline __m256i in_doubt(__m256 s, __m256 less)
{
    enum { NEAREST = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC };
    const __m256 most = _mm256_add_ps(_mm256_mul_ps(absolute(s), _mm256_set1_ps(0x1p-21F)), less);
    const __m256 off = absolute(_mm256_sub_ps(s, _mm256_round_ps(s, NEAREST)));
    return _mm256_castps_si256(_mm256_cmp_ps(off, most, _CMP_LT_OQ));
}

static inline __m256i floor_of(__m256 s)
{
    enum { DOWN = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC };
    return _mm256_cvtps_epi32(_mm256_round_ps(s, DOWN));
}

static void round_pairs(planes *p, int32_t n, const constants *c)
{
    for (int32_t i = 0; i < n; i += HALF) {
        const __m256 x = _mm256_loadu_ps(p->x + i), y = _mm256_loadu_ps(p->y + i);
        const __m256 z = _mm256_loadu_ps(p->z + i);
        const __m256 square = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)),
                                            _mm256_mul_ps(z, z));
        const __m256 factor = _mm256_div_ps(c->half, _mm256_sqrt_ps(square));
        const __m256 s = _mm256_mul_ps(x, factor), t = _mm256_mul_ps(y, factor);
        const __m256i small = _mm256_castps_si256(_mm256_cmp_ps(square, c->least2, _CMP_LT_OQ));
        const __m256i doubt = _mm256_or_si256(in_doubt(s, c->less), in_doubt(t, c->less));
        store_ints(p->pair + i,
                   _mm256_blend_epi16(floor_of(s), _mm256_slli_epi32(floor_of(t), 16), 0xaa));
        store_ints(p->left + i,
                   _mm256_or_si256(load_ints(p->left + i), _mm256_or_si256(doubt, small)));
    }
}

/* Eight texels with their blue; *bits: those that are left. */
static inline texels finished(const planes *p, int32_t i, const constants *c, uint32_t *bits)
{
    const __m256i pair = load_ints(p->pair + i);
    const __m256i e = _mm256_sub_epi32(c->rest, sum_of_pair(pair));
    const __m256i down = _mm256_srai_epi32(_mm256_castps_si256(_mm256_loadu_ps(p->z + i)), 31);
    const texels t = { _mm256_add_epi16(pair, c->zeros), /* M - b is M ^ b */
                       _mm256_xor_si256(_mm256_add_epi32(root(e), c->zero),
                                        _mm256_and_si256(down, c->m)) };
    const __m256i left = _mm256_or_si256(load_ints(p->left + i), e);
    *bits = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(left));
    return t;
}

static int32_t put_levels(uint8_t *d, int32_t *at, planes *p, int32_t n, const constants *c)
{
    int32_t found = 0;
    round_pairs(p, (n + STEP - 1) / STEP * STEP, c);
    for (int32_t i = 0; i < n; i += STEP) {
        uint32_t bits[2];
        const texels t[2] = { finished(p, i, c, &bits[0]), finished(p, i + HALF, c, &bits[1]) };
        put_step(d, i, n, t, c->deep);
        found += add_places(at + found, i, n, bits);
    }
    return found;
}

int32_t ntp__strengthen_rgb_avx2(void *d, int32_t *at, const ntp__mix_run *s, int32_t n,
                                 const ntp__boost *how, bool deep)
{
    const constants c = levels_of(deep);
    planes p;
    boost(&p, s, n, how, &c);
    return put_levels(d, at, &p, n, &c);
}

int32_t ntp__blend_rgb_avx2(void *d, int32_t *at, const ntp__mix_run *base,
                            const ntp__mix_run *detail, int32_t n, const ntp__mixture *how,
                            bool reoriented, bool exact, bool deep)
{
    const double m = how->mb, s = fabs(how->strength) < 1 ? 1 : fabs(how->strength);
    /* No component is more than M, and t.z is at most twice that: `size` in blend_kernels.c. */
    const double size = reoriented ? 96 * m * m * m * s : 9 * m * m * s;
    const terms t = { how->strength,     how->turn,    m,          how->base_z * m,
                      how->detail_z * m, how->product, reoriented, exact && !deep };
    constants c = levels_of(deep);
    planes p;
    /* Whole numbers are exact, so only a length of 0 is in doubt. */
    c.less = _mm256_set1_ps(exact ? 0 : 0x1p-16F);
    c.least2 = _mm256_set1_ps(exact ? 0.5F : (float) (size * size * 0x1p-32));
    c.least_z = _mm256_set1_ps(exact ? 0 : (float) (size * 0x1p-48));
    blend(&p, base, detail, n, &t, &c);
    return put_levels(d, at, &p, n, &c);
}

static inline int32_t sample(const void *s, int32_t i, bool deep)
{
    return deep ? ((const uint16_t *) s)[i] : ((const uint8_t *) s)[i];
}

void ntp__take_places(ntp__block *block, const ntp__mix_run *s, const int32_t *at, int32_t n,
                      bool deep)
{
    block->any_broken = false;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t k = 0; k < 3; k++)
            block->c[k][i] = sample(s->c, 3 * at[i] + k, deep);
        block->c[3][i] = deep ? 65535 : 255;
    }
}

void ntp__put_places(void *d, const ntp__block *block, const int32_t *at, int32_t n, bool deep)
{
    for (int32_t i = 0; i < n; i++) {
        for (int32_t k = 0; k < 3; k++) {
            if (deep)
                ((uint16_t *) d)[3 * at[i] + k] = (uint16_t) block->c[k][i];
            else
                ((uint8_t *) d)[3 * at[i] + k] = (uint8_t) block->c[k][i];
        }
    }
}
