/* SPDX-License-Identifier: MIT */
/*
 * encode_avx2.c - tap sums to packed RGB with derived blue, with AVX2
 *
 * The bytes are those of gradient_kernels.c, but no level goes through memory on its way.  Where the
 * texels are as wide as they are high, the normal is (D, E, 1/cx) over its length, with signs.
 *
 * The bound of floats, where u = 2^-24 and squares of it are left out.  D, E and 1/cx are off by u at
 * most, and their squares by 3u.  The sum of the first two squares is off by 4u, that of three by 5u,
 * its root by 3.5u, the quotient by 4.5u, and the product with D by 6.5u.  That is less than 8u, so
 * less than v 2^-21 of v units, or than 2^-6 of v levels.  Of 8 bit there are less than 2^22 units, so
 * it is less than two.  Another half is for units that are not whole.
 * Squares that are below the normal range are nothing beside that of 1/cx.
 */
#include "from_height/gradient.h"

#include "texel/packed_avx2_tmpl.h"

enum { HALF = 8, STEP = 16 /* texels */ };
enum { UNIT_BITS = 15, UNITS = 1 << UNIT_BITS, ERROR_BITS = 6 };

typedef struct constants {
    __m256 half, square;       /* M/2 in units with the sign of cx; the square of 1/cx */
    __m256 flip;               /* the sign of cx cy */
    __m256i off, exact;        /* exact: -1 where sums of 0 are 0 */
    __m256i rest, zero, zeros; /* REST_8 or REST_16; the level of 0, and those of pairs */
} constants;

static constants constants_of(const ntp__encode *e, bool deep)
{
    const float over = (float) (1 / e->cx), half = (float) (e->half * UNITS);
    const int32_t zero = deep ? 32768 : 128;
    const constants c = { _mm256_set1_ps(e->cx < 0 ? -half : half),
                          _mm256_set1_ps(over * over),
                          _mm256_set1_ps(e->cx == e->cy ? 0.0F : -0.0F),
                          _mm256_set1_epi16((short) (e->off + (deep ? 1 : 2))),
                          _mm256_set1_epi32(e->off <= 1 ? -1 : 0),
                          _mm256_set1_epi32(deep ? REST_16 : REST_8),
                          _mm256_set1_epi32(zero),
                          _mm256_set1_epi16((short) zero) };
    return c;
}

static inline __m256i units_of(__m256 sum, __m256 factor)
{
    return _mm256_cvtps_epi32(_mm256_mul_ps(sum, factor));
}

/* The upper halves of words are those of the second, the lower ones those of the first. */
static inline __m256i halves(__m256i low, __m256i high)
{
    return _mm256_blend_epi16(low, high, 0xaa);
}

static inline __m256i is_zero(__m256 v)
{
    return _mm256_castps_si256(_mm256_cmp_ps(v, _mm256_setzero_ps(), _CMP_EQ_OQ));
}

/* Eight texels; *left: bits of those that are in doubt, or too long. */
static inline texels encoded(__m256 x, __m256 y, __m256 factor, const constants *c, uint32_t *left)
{
    const __m256i u = units_of(x, factor), v = units_of(y, _mm256_xor_ps(factor, c->flip));
    /* Levels less that of 0, which are floors, and what is left of units. */
    const __m256i a = halves(_mm256_srli_epi32(u, UNIT_BITS), _mm256_slli_epi32(v, 16 - UNIT_BITS));
    const __m256i part = halves(u, _mm256_slli_epi32(v, 16));
    const __m256i error =
        _mm256_add_epi16(_mm256_srli_epi16(_mm256_abs_epi16(a), ERROR_BITS), c->off);
    const __m256i over =
        _mm256_and_si256(_mm256_add_epi16(part, error), _mm256_set1_epi16(UNITS - 1));
    const __m256i none = _mm256_and_si256(halves(is_zero(x), is_zero(y)), c->exact);
    const __m256i near =
        _mm256_andnot_si256(none, _mm256_cmpgt_epi16(_mm256_add_epi16(error, error), over));
    const __m256i e = _mm256_sub_epi32(c->rest, sum_of_pair(a));
    const texels t = { _mm256_add_epi16(a, c->zeros), _mm256_add_epi32(root_of(e, true), c->zero) };
    const __m256i any = _mm256_or_si256(_mm256_or_si256(near, _mm256_slli_epi32(near, 16)), e);
    *left = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(any));
    return t;
}

static inline __m256 take_sums(const void *sums, int32_t i, bool ints)
{
    if (ints)
        return _mm256_cvtepi32_ps(
            _mm256_loadu_si256((const __m256i *) (const void *) ((const int32_t *) sums + i)));
    const double *s = (const double *) sums + i;
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(_mm256_loadu_pd(s))),
                                _mm256_cvtpd_ps(_mm256_loadu_pd(s + HALF / 2)), 1);
}

/* Sums as floats, and M/2L of their normals. */
typedef struct planes {
    float x[NTP__BLOCK], y[NTP__BLOCK], factor[NTP__BLOCK];
} planes;

/* All factors come first: while a processor waits for a root it does others. */
static void prepare(planes *p, const void *const sums[2], bool ints, int32_t n, const constants *c)
{
    for (int32_t i = 0; i < n; i += HALF) {
        const __m256 x = take_sums(sums[0], i, ints), y = take_sums(sums[1], i, ints);
        const __m256 square =
            _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), c->square);
        _mm256_storeu_ps(p->x + i, x);
        _mm256_storeu_ps(p->y + i, y);
        _mm256_storeu_ps(p->factor + i, _mm256_div_ps(c->half, _mm256_sqrt_ps(square)));
    }
    for (int32_t i = n; i % STEP != 0; i++)
        p->x[i] = p->y[i] = p->factor[i] = 0;
}

ntp__encode_packed_fn ntp__encode_avx2;

int32_t ntp__encode_avx2(uint8_t *d, int32_t *at, const void *const sums[2], bool ints, int32_t n,
                         const ntp__encode *e, bool deep)
{
    const constants c = constants_of(e, deep);
    int32_t found = 0;
    planes p;
    prepare(&p, sums, ints, n, &c);
    for (int32_t i = 0; i < n; i += STEP) {
        uint32_t bits[2];
        texels t[2];
        for (int32_t k = 0; k < 2; k++) {
            const int32_t from = i + HALF * k;
            t[k] = encoded(_mm256_loadu_ps(p.x + from), _mm256_loadu_ps(p.y + from),
                           _mm256_loadu_ps(p.factor + from), &c, &bits[k]);
        }
        put_step(d, i, n, t, deep);
        found += add_places(at + found, i, n, bits);
    }
    return found;
}
