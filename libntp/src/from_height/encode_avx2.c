/* SPDX-License-Identifier: MIT */
/*
 * encode_avx2.c - tap sums to packed RGB with derived blue, with AVX2; of 3 x 3 texels from their heights
 *
 * The bytes are those of gradient_kernels.c, but no level goes through memory on its way.  Where the
 * texels are as wide as they are high, the normal is (D, E, 1/cx) over its length, with signs.
 *
 * The bound of floats, where u = 2^-24 and squares of it are left out.  D, E and 1/cx are off by u at
 * most, and their squares by 3u.  The sum of the first two squares is off by 4u, that of three by 5u,
 * its root by 3.5u, the quotient by 4.5u, and the product with D by 6.5u.  That is less than 8u, so
 * less than v 2^-21 of v units, or |a|/32 and less than 1 more, with a as the level.  Another half is for
 * units that are not whole: a boundary that may be on the other side is no farther than |a|/32 + 1 of
 * these, with a quotient that is rounded down.
 * Squares that are below the normal range are nothing beside that of 1/cx.
 *
 * Of integers, the sums of 3 x 3 heights are exact in floats.  Of floats, each difference of two is off
 * by u of itself.  With no difference beyond d, and taps of side and middle, D and E are off by
 * u (8 side + 3 middle) d; and by less than NTP__TINY where that stands for a smaller one, so that they are
 * 0 only if all differences are.  As a vector both are off by less than 1.5 times the sum of the two.  A
 * normal changes by no more than that over its length, which is at least 1/cx.
 *
 * Fused products only make errors smaller.
 */
#include "from_height/gradient.h"

#include "texel/packed_avx2_tmpl.h"

enum { HALF = 8, STEP = 16 /* texels */ };
enum { UNIT_BITS = 16, UNITS = 1 << UNIT_BITS, ERROR_BITS = 5 };

typedef struct constants {
    __m256 half, square;       /* M/2 in units with the sign of cx; the square of 1/cx */
    __m256 flip;               /* the sign of cx cy */
    __m256i off, exact;        /* exact: -1 where differences of 0 are 0 */
    __m256i rest, zero, zeros; /* REST_8 or REST_16; the level of 0, and those of pairs */
} constants;

static constants constants_of(const ntp__encode *e, bool deep)
{
    const float over = (float) (1 / e->cx), half = (float) (e->half * UNITS);
    const int32_t zero = deep ? 32768 : 128;
    const constants c = { _mm256_set1_ps(e->cx < 0 ? -half : half),
                          _mm256_set1_ps(over * over),
                          _mm256_set1_ps(e->cx == e->cy ? 0.0F : -0.0F),
                          _mm256_set1_epi16((short) (2 * e->off)),
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

/* Bits, because a processor may be told to take numbers below the normal range for 0. */
static inline __m256i is_zero(__m256 v)
{
    return _mm256_cmpeq_epi32(_mm256_castps_si256(v), _mm256_setzero_si256());
}

/* Sums as floats, and M/2L of their normals. */
typedef struct planes {
    float x[NTP__BLOCK], y[NTP__BLOCK], factor[NTP__BLOCK];
} planes;

/* Eight texels; *left: bits of those that are in doubt, or too long. */
static inline texels encoded(const planes *p, int32_t i, const constants *c, uint32_t *left)
{
    const __m256 x = _mm256_loadu_ps(p->x + i), y = _mm256_loadu_ps(p->y + i);
    const __m256 factor = _mm256_loadu_ps(p->factor + i);
    const __m256i u = units_of(x, factor), v = units_of(y, _mm256_xor_ps(factor, c->flip));
    /* Levels less that of 0, which are floors; and how far units are from the nearest of these. */
    const __m256i a = halves(_mm256_srli_epi32(u, UNIT_BITS), v);
    const __m256i over = _mm256_abs_epi16(halves(u, _mm256_slli_epi32(v, UNIT_BITS)));
    const __m256i error =
        _mm256_add_epi16(_mm256_srli_epi16(_mm256_abs_epi16(a), ERROR_BITS), c->off);
    const __m256i none = _mm256_and_si256(halves(is_zero(x), is_zero(y)), c->exact);
    const __m256i near = _mm256_andnot_si256(none, _mm256_cmpgt_epi16(error, over));
    /* a(a + 1) is -a(-1 - a). */
    const __m256i e =
        _mm256_add_epi32(c->rest, _mm256_madd_epi16(a, _mm256_xor_si256(a, _mm256_set1_epi16(-1))));
    const texels t = { _mm256_add_epi16(a, c->zeros), _mm256_add_epi32(root_of(e, true), c->zero) };
    const __m256i all = _mm256_or_si256(_mm256_or_si256(near, _mm256_slli_epi32(near, 16)), e);
    *left = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(all));
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

static inline void put_sums(planes *p, int32_t i, __m256 x, __m256 y, const constants *c)
{
    const __m256 square = _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, c->square));
    _mm256_storeu_ps(p->x + i, x);
    _mm256_storeu_ps(p->y + i, y);
    _mm256_storeu_ps(p->factor + i, _mm256_div_ps(c->half, _mm256_sqrt_ps(square)));
}

/* All factors come first: while a processor waits for a root it does others. */
static void prepare(planes *p, const void *const sums[2], bool ints, int32_t n, const constants *c)
{
    for (int32_t i = 0; i < n; i += HALF)
        put_sums(p, i, take_sums(sums[0], i, ints), take_sums(sums[1], i, ints), c);
}

static inline __m256 difference(const float *a, const float *b)
{
    return _mm256_sub_ps(_mm256_loadu_ps(a), _mm256_loadu_ps(b));
}

static inline __m256 weighted(__m256 sides, __m256 middle, const ntp__encode *e)
{
    return _mm256_fmadd_ps(sides, _mm256_set1_ps(e->side),
                           _mm256_mul_ps(middle, _mm256_set1_ps(e->middle)));
}

/* The same from heights that are integers: sums are exact in any order. */
static void prepare_integers(planes *p, const float *const rows[3], int32_t n, const ntp__encode *e,
                             const constants *c)
{
    for (int32_t i = 0; i < n; i += HALF) {
        const float *above = rows[0] + i, *at = rows[1] + i, *below = rows[2] + i;
        const __m256 falling = difference(below + 2, above), rising = difference(below, above + 2);
        put_sums(p, i, weighted(_mm256_sub_ps(falling, rising), difference(at + 2, at), e),
                 weighted(_mm256_add_ps(falling, rising), difference(below + 1, above + 1), e), c);
    }
}

/* A sum that is 0 only where `any`, bits of all that it is made of, is: what cancels out becomes NTP__TINY, or
 * `any` where that is less.  The square of NTP__TINY is in the normal range, for processors take long below. */
static inline __m256 marked(__m256 sum, __m256 any)
{
    const __m256i least =
        _mm256_min_epu32(_mm256_castps_si256(any), _mm256_castps_si256(_mm256_set1_ps(NTP__TINY)));
    return _mm256_castsi256_ps(_mm256_max_epu32(_mm256_castps_si256(sum), least));
}

/* From floats: differences only of what a slope is made of. */
static void prepare_floats(planes *p, const float *const rows[3], int32_t n, const ntp__encode *e,
                           const constants *c)
{
    const __m256 sides = _mm256_castsi256_ps(_mm256_set1_epi32(e->side > 0 ? -1 : 0));
    for (int32_t i = 0; i < n; i += HALF) {
        const float *above = rows[0] + i, *at = rows[1] + i, *below = rows[2] + i;
        const __m256 x0 = difference(above + 2, above), x1 = difference(at + 2, at),
                     x2 = difference(below + 2, below);
        const __m256 y0 = difference(below, above), y1 = difference(below + 1, above + 1),
                     y2 = difference(below + 2, above + 2);
        const __m256 x = _mm256_or_ps(_mm256_and_ps(_mm256_or_ps(x0, x2), sides), x1),
                     y = _mm256_or_ps(_mm256_and_ps(_mm256_or_ps(y0, y2), sides), y1);
        put_sums(p, i, marked(weighted(_mm256_add_ps(x0, x2), x1, e), x),
                 marked(weighted(_mm256_add_ps(y0, y2), y1, e), y), c);
    }
}

ntp__encode_packed_fn ntp__encode_avx2;

int32_t ntp__encode_avx2(uint8_t *d, int32_t *at, const void *const from[3], ntp__packed_from which,
                         int32_t n, const ntp__encode *e, bool deep)
{
    const float *const rows[3] = { from[0], from[1], from[2] };
    constants c = constants_of(e, deep);
    int32_t found = 0;
    planes p;
    if (which == NTP__FROM_FLOATS) {
        const int32_t more = ntp__off_of_floats(e);
        if (more < 0)
            return -1;
        c.off = _mm256_add_epi16(c.off, _mm256_set1_epi16((short) more));
        c.exact = _mm256_set1_epi32(-1);
        prepare_floats(&p, rows, n, e, &c);
    } else if (which == NTP__FROM_INTEGERS) {
        prepare_integers(&p, rows, n, e, &c);
    } else {
        prepare(&p, from, which == NTP__FROM_SUMS_I, n, &c);
    }
    for (int32_t i = (n + HALF - 1) / HALF * HALF; i % STEP != 0; i++)
        p.x[i] = p.y[i] = p.factor[i] = 0;
    for (int32_t i = 0; i < n; i += STEP) {
        uint32_t bits[2];
        texels t[2];
        for (int32_t k = 0; k < 2; k++)
            t[k] = encoded(&p, i + HALF * k, &c, &bits[k]);
        put_step(d, i, n, t, deep);
        found += add_places(at + found, i, n, bits);
    }
    return found;
}

ntp__take_heights_fn ntp__take_heights_avx2;

/* The ends of ranges of eight numbers */
static inline float least_of(__m256 v)
{
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
}

static inline uint32_t least_bits(__m256i v)
{
    const __m128i four = _mm_min_epu32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_min_epu32(four, _mm_unpackhi_epi64(four, four));
    return (uint32_t) _mm_cvtsi128_si32(_mm_min_epu32(two, _mm_srli_epi64(two, 32)));
}

/* Some of the last eight are taken twice.  Bits of magnitudes are kept less 1: those of 0 are the most of
 * all without a sign, and the least with one. */
static inline void take_floats(float *to, const float *s, int32_t n, ntp__magnitudes *m)
{
    const __m256i ones = _mm256_set1_epi32(-1), sign = _mm256_set1_epi32(INT32_MAX);
    __m256i least = sign, most = ones;
    __m256 low = _mm256_set1_ps(m->low), high = _mm256_set1_ps(m->high);
    for (int32_t k = 0; k < n; k += HALF) {
        const int32_t i = k < n - HALF ? k : n - HALF;
        const __m256 v = _mm256_loadu_ps(s + i);
        const __m256i below =
            _mm256_add_epi32(_mm256_and_si256(_mm256_castps_si256(v), sign), ones);
        least = _mm256_min_epu32(least, below);
        most = _mm256_max_epi32(most, below);
        low = _mm256_min_ps(low, v);
        high = _mm256_max_ps(high, v);
        _mm256_storeu_ps(to + i, v);
    }
    const int32_t first = (int32_t) least_bits(least);
    const int32_t last = (int32_t) (0x80000000 - least_bits(_mm256_sub_epi32(sign, most)));
    m->least = first < m->least ? first : m->least;
    m->most = last > m->most ? last : m->most;
    m->low = least_of(low);
    m->high = -least_of(_mm256_xor_ps(high, _mm256_set1_ps(-0.0F)));
}

void ntp__take_heights_avx2(float *to, const void *s, ntp_type type, int32_t n, ntp__magnitudes *m)
{
    const char *from = s;
    if (type == NTP_TYPE_F32) {
        take_floats(to, s, n, m);
        return;
    }
    for (int32_t k = 0; k < n; k += HALF) {
        const int32_t i = k < n - HALF ? k : n - HALF;
        const __m256i v =
            type == NTP_TYPE_U8
                ? _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *) (from + i)))
                : _mm256_cvtepu16_epi32(_mm_loadu_si128((const void *) (from + 2 * i)));
        _mm256_storeu_ps(to + i, _mm256_cvtepi32_ps(v));
    }
}
