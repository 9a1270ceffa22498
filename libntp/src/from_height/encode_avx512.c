/* SPDX-License-Identifier: MIT */
/*
 * encode_avx512.c - packed RGB with derived blue from 3 x 3 heights, with AVX-512
 *
 * As encode_avx2.c, but 16 texels at a time, and in one loop.  Fused products only make errors smaller,
 * so its bounds hold, and a difference of 0 still makes no slope.
 */
#include "from_height/gradient.h"

#include "base/lanes_avx2.h"
#include "texel/packed_avx512_tmpl.h"

enum { STEP = LANES_512 };
enum { UNIT_BITS = 16, UNITS = 1 << UNIT_BITS, ERROR_BITS = 5 };
enum { ANY = 0xfe /* a | b | c */ };
static const __mmask32 UPPER = 0xaaaaaaaa; /* halves */

typedef struct constants {
    __m512 side, middle, half, square, flip; /* as in encode_avx2.c */
    __m512i off, zeros, zero;
    __mmask16 sides, exact;
} constants;

typedef struct sums {
    __m512 x, y;
} sums;

/* Eight and more places that belong to three rows. */
typedef struct place {
    const float *above, *at, *below;
} place;

static inline __m512 difference(const float *a, const float *b)
{
    return _mm512_sub_ps(_mm512_loadu_ps(a), _mm512_loadu_ps(b));
}

static inline __m512 weighted(__m512 sides, __m512 middle, const constants *c)
{
    return _mm512_fmadd_ps(sides, c->side, _mm512_mul_ps(middle, c->middle));
}

static inline sums sums_of_integers(place p, const constants *c)
{
    const __m512 falling = difference(p.below + 2, p.above);
    const __m512 rising = difference(p.below, p.above + 2);
    return (
        sums) { weighted(_mm512_sub_ps(falling, rising), difference(p.at + 2, p.at), c),
                weighted(_mm512_add_ps(falling, rising), difference(p.below + 1, p.above + 1), c) };
}

/* The sum of differences, of which two count only if there are sides.  It is 0 only where all these are:
 * what cancels out becomes TINY, or their bits where that is less. */
static inline __m512 marked(__m512 first, __m512 middle, __m512 last, const constants *c)
{
    const __m512i sum = _mm512_castps_si512(weighted(_mm512_add_ps(first, last), middle, c));
    const __m512i any =
        _mm512_mask_ternarylogic_epi32(_mm512_castps_si512(middle), c->sides,
                                       _mm512_castps_si512(first), _mm512_castps_si512(last), ANY);
    const __m512i tiny = _mm512_castps_si512(_mm512_set1_ps(NTP__TINY));
    return _mm512_castsi512_ps(_mm512_max_epu32(sum, _mm512_min_epu32(any, tiny)));
}

static inline sums sums_of_floats(place p, const constants *c)
{
    return (sums) {
        marked(difference(p.above + 2, p.above), difference(p.at + 2, p.at),
               difference(p.below + 2, p.below), c),
        marked(difference(p.below, p.above), difference(p.below + 1, p.above + 1),
               difference(p.below + 2, p.above + 2), c),
    };
}

static inline __m512i halves(__m512i low, __m512i high)
{
    return _mm512_mask_mov_epi16(low, UPPER, high);
}

static inline __m512i units_of(__m512 sum, __m512 factor)
{
    return _mm512_cvtps_epi32(_mm512_mul_ps(sum, factor));
}

/* Where differences of 0 are 0 and this sum is, `over` has the greatest of these bits. */
static inline __m512i sure_of_zero(__m512i over, __m512 sum, const constants *c, int32_t bits)
{
    const __m512i v = _mm512_castps_si512(sum);
    return _mm512_mask_or_epi32(over, _mm512_mask_testn_epi32_mask(c->exact, v, v), over,
                                _mm512_set1_epi32(bits));
}

/* Sixteen texels; *left: bits of those that are in doubt, or too long. */
static inline texels encoded(sums s, const constants *c, bool deep, uint32_t *left)
{
    const __m512 square = _mm512_fmadd_ps(s.x, s.x, _mm512_fmadd_ps(s.y, s.y, c->square));
    const __m512 factor = _mm512_div_ps(c->half, _mm512_sqrt_ps(square));
    const __m512i u = units_of(s.x, factor);
    const __m512i v =
        units_of(s.y, _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(factor),
                                                           _mm512_castps_si512(c->flip))));
    const __m512i a = halves(_mm512_srli_epi32(u, UNIT_BITS), v);
    __m512i over = _mm512_abs_epi16(halves(u, _mm512_slli_epi32(v, UNIT_BITS)));
    over = sure_of_zero(over, s.x, c, INT16_MAX);
    over = sure_of_zero(over, s.y, c, (int32_t) 0x7fff0000);
    const __m512i error =
        _mm512_add_epi16(_mm512_srli_epi16(_mm512_abs_epi16(a), ERROR_BITS), c->off);
    const __m512i near = _mm512_subs_epu16(error, over);
    const texels t = { _mm512_add_epi16(a, c->zeros), c->zero };
    const __m512i e = rest_of(t.rg, deep);
    *left = (uint32_t) _mm512_test_epi32_mask(near, near) |
            _mm512_cmplt_epi32_mask(e, _mm512_setzero_si512());
    return (texels) { t.rg, _mm512_add_epi32(root_of(e, deep), c->zero) };
}

static inline void encode(uint8_t *d, uint32_t *left, place p, bool floats, int32_t n,
                          const constants *c, bool deep)
{
    for (int32_t i = 0; i < n; i += STEP) {
        const place here = { p.above + i, p.at + i, p.below + i };
        const texels t =
            encoded(floats ? sums_of_floats(here, c) : sums_of_integers(here, c), c, deep, left++);
        if (deep)
            put16(d + 6 * i, t);
        else
            put8(d + 3 * i, t);
    }
}

ntp__encode_packed_fn ntp__encode_avx2, ntp__encode_avx512;

int32_t ntp__encode_avx512(uint8_t *d, int32_t *at, const void *const from[3],
                           ntp__packed_from which, int32_t n, const ntp__encode *e, bool deep)
{
    const place p = { from[0], from[1], from[2] };
    const bool floats = which == NTP__FROM_FLOATS;
    const float over = (float) (1 / e->cx), half = (float) (e->half * UNITS);
    const int32_t zero = deep ? 32768 : 128, more = floats ? ntp__off_of_floats(e) : 0;
    if (more < 0)
        return -1;
    const constants c = { _mm512_set1_ps(e->side),
                          _mm512_set1_ps(e->middle),
                          _mm512_set1_ps(e->cx < 0 ? -half : half),
                          _mm512_set1_ps(over * over),
                          _mm512_set1_ps(e->cx == e->cy ? 0.0F : -0.0F),
                          _mm512_set1_epi16((short) (2 * e->off + more)),
                          _mm512_set1_epi16((short) zero),
                          _mm512_set1_epi32(zero),
                          e->side > 0 ? UINT16_MAX : 0,
                          floats || e->off <= 1 ? UINT16_MAX : 0 };
    const int32_t done = n & -STEP;
    uint32_t left[NTP__BLOCK / STEP];
    int32_t found = 0;
    encode(d, left, p, floats, done, &c, deep);
    /* Not in the loop: whether there is a bit cannot be foretold. */
    for (int32_t i = 0; i < done; i += STEP) {
        for (uint32_t bits = left[i / STEP]; bits != 0; bits &= bits - 1)
            at[found++] = i + __builtin_ctz(bits);
    }
    if (done < n) {
        const void *const rest[3] = { p.above + done, p.at + done, p.below + done };
        const int32_t others =
            ntp__encode_avx2(d + (deep ? 6 : 3) * done, at + found, rest, which, n - done, e, deep);
        for (const int32_t end = found + others; found < end; found++)
            at[found] += done;
    }
    end_lanes();
    return found;
}
