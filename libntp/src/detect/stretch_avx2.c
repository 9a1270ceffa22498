/* SPDX-License-Identifier: MIT */
/*
 * stretch_avx2.c - the loops of a stretch of texels with AVX2
 *
 * It adds what add_stretch of orientation.c adds: the comments there say what that is, and why it is exact.
 */
#include "detect/stretch.h"

#include "base/cpu.h"
#include "base/inlining.h"
#include "base/lanes_avx2.h"

#include <string.h>

/* What loops add, in planes; 0 for those that count for nothing. */
typedef struct products {
    int32_t size[COLUMNS], cross[COLUMNS];
    uint32_t energy[COLUMNS];
} products;

/* Sums of many loops, four in each. */
typedef struct square_sums {
    __m256i along, both, either;
    uint32_t used, steep;
} square_sums;

static inline __m256i load(const int32_t *from)
{
    return _mm256_loadu_si256((const void *) from);
}

static inline void store(void *to, __m256i v)
{
    _mm256_storeu_si256(to, v);
}

static inline __m256 plus(__m256 sum, __m256 v, const float *times)
{
    return _mm256_add_ps(sum, _mm256_mul_ps(v, _mm256_broadcast_ss(times)));
}

static inline __m256 slope(__m256i x, __m128i bits, __m256 z)
{
    const __m256 slope = _mm256_div_ps(_mm256_cvtepi32_ps(_mm256_sll_epi32(x, bits)), z);
    return _mm256_round_ps(slope, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
}

/* Where the texels of six rows are. */
typedef struct texel_rows {
    const uint8_t *packed[TAPS]; /* of 8 bit */
    ntp__block planes[TAPS];     /* others; all are if there are few */
    int32_t channels;            /* of packed ones; 0: they are in planes */
} texel_rows;

typedef struct levels {
    __m256i r, g, a;
} levels;

/* Texels i to i + 7 of a row.  `places` are those of red in the halves of 8 packed texels. */
static inline levels take8(const texel_rows *rows, int32_t k, int32_t i, __m256i places)
{
    if (rows->channels == 0) {
        const int32_t(*const c)[NTP__BLOCK] = rows->planes[k].c;
        return (levels) { load(c[0] + i), load(c[1] + i), load(c[3] + i) };
    }
    const uint8_t *const s = rows->packed[k] + (ptrdiff_t) i * rows->channels;
    const __m256i v = load_two(s, s + COLUMN_LANES * rows->channels - 16);
    const __m256i one = _mm256_set1_epi32(1), green = _mm256_add_epi32(places, one);
    return (levels) { _mm256_shuffle_epi8(v, places), _mm256_shuffle_epi8(v, green),
                      _mm256_shuffle_epi8(v, _mm256_add_epi32(green, _mm256_add_epi32(one, one))) };
}

static inline __m256i places_of(int32_t channels)
{
    const int32_t c = channels, high = 16 - 4 * c; /* what the second half begins with */
    return _mm256_or_si256(
        _mm256_setr_epi32(0, c, 2 * c, 3 * c, high, high + c, high + 2 * c, high + 3 * c),
        _mm256_set1_epi32((int32_t) 0x80808000));
}

/* Filters n columns down the rows.  Packed texels beyond these are not read: the last are filtered again. */
static void filter_down(columns *to, const texel_rows *rows, int32_t n, int32_t m, bool alpha)
{
    const __m256i one = _mm256_set1_epi32(1), max = _mm256_set1_epi32(m);
    const __m256i clear = _mm256_set1_epi32(alpha ? NO_NORMAL : 0);
    const __m256i square = _mm256_mullo_epi32(max, max), places = places_of(rows->channels);
    const __m256i least = _mm256_set1_epi32((int32_t) ntp__least_rest(m));
    const __m256i far = _mm256_set1_epi32(ntp__far_sum(m));
    const int32_t half = m == 255 ? 0 : 1;
    const __m128i shift = _mm_cvtsi32_si128(2 * half),
                  bits = _mm_cvtsi32_si128(SLOPE_ONE_BITS - half);
    for (int32_t first = 0; first < n; first += COLUMN_LANES) {
        const int32_t i =
            rows->channels != 0 && first > n - COLUMN_LANES ? n - COLUMN_LANES : first;
        __m256 u = _mm256_setzero_ps(), v = u, p_smooth = u, q_steep = u;
        __m256i bad = _mm256_setzero_si256();
        for (int32_t k = 0; k < TAPS; k++) {
            const levels c = take8(rows, k, i, places);
            const __m256i x = _mm256_sub_epi32(_mm256_add_epi32(c.r, c.r), max);
            const __m256i y = _mm256_sub_epi32(_mm256_add_epi32(c.g, c.g), max);
            const __m256i most = _mm256_sub_epi32(square, _mm256_mullo_epi32(x, x));
            const __m256i y2 = _mm256_mullo_epi32(y, y);
            const __m256i s = _mm256_sub_epi32(_mm256_max_epu32(most, y2), y2);
            const __m256i rest = _mm256_max_epu32(s, least);
            const __m256i end = _mm256_cmpgt_epi32(_mm256_abs_epi32(_mm256_add_epi32(x, y)), far);
            bad = _mm256_or_si256(
                bad, _mm256_andnot_si256(_mm256_cmpeq_epi32(rest, s), _mm256_sub_epi32(one, end)));
            const __m256i hidden = _mm256_cmpeq_epi32(c.a, _mm256_setzero_si256());
            bad = _mm256_or_si256(bad, _mm256_and_si256(hidden, clear));
            const __m256 z = _mm256_sqrt_ps(_mm256_cvtepi32_ps(_mm256_srl_epi32(rest, shift)));
            const __m256 p = slope(x, bits, z), q = slope(y, bits, z);
            u = plus(u, p, &STEEP[TAPS - 1 - k]); /* its other sign */
            q_steep = plus(q_steep, q, &STEEP[TAPS - 1 - k]);
            v = plus(v, q, &SMOOTH[k]);
            p_smooth = plus(p_smooth, p, &SMOOTH[k]);
            if (k == BEFORE || k == BEFORE + 1) {
                _mm256_storeu_ps(to->p[k - BEFORE] + i, p);
                _mm256_storeu_ps(to->q[k - BEFORE] + i, q);
            }
        }
        _mm256_storeu_ps(to->u + i, u);
        _mm256_storeu_ps(to->v + i, v);
        _mm256_storeu_ps(to->p_smooth + i, p_smooth);
        _mm256_storeu_ps(to->q_steep + i, q_steep);
        store(to->bad + i, bad);
    }
}

static inline __m256 smoothed(const float *a)
{
    __m256 v[3];
    for (int32_t k = 0; k < 3; k++)
        v[k] = _mm256_add_ps(_mm256_loadu_ps(a + k), _mm256_loadu_ps(a + TAPS - 1 - k));
    return plus(plus(v[0], v[1], &SMOOTH[1]), v[2], &SMOOTH[2]);
}

static inline __m256 derived(const float *a)
{
    __m256 v[3];
    for (int32_t k = 0; k < 3; k++)
        v[k] = _mm256_sub_ps(_mm256_loadu_ps(a + TAPS - 1 - k), _mm256_loadu_ps(a + k));
    return plus(plus(v[0], v[1], &STEEP[4]), v[2], &STEEP[3]);
}

static void multiply(products *to, int32_t i, __m256 u, __m256 v, __m256i used)
{
    enum { MANTISSA_BITS = 23, ONE = 127, HALF = 126 };
    const __m256i sign = _mm256_set1_epi32(INT32_MIN);
    const __m256i most = _mm256_max_epi32(_mm256_andnot_si256(sign, _mm256_castps_si256(u)),
                                          _mm256_andnot_si256(sign, _mm256_castps_si256(v)));
    const __m256i size =
        _mm256_subs_epu16(_mm256_srli_epi32(most, MANTISSA_BITS), _mm256_set1_epi32(HALF));
    const __m256i shift = _mm256_subs_epu16(size, _mm256_set1_epi32(BITS));
    const __m256 part = _mm256_castsi256_ps(
        _mm256_slli_epi32(_mm256_sub_epi32(_mm256_set1_epi32(ONE), shift), MANTISSA_BITS));
    const __m256i a = _mm256_cvttps_epi32(_mm256_mul_ps(u, part));
    const __m256i b = _mm256_and_si256(_mm256_cvttps_epi32(_mm256_mul_ps(v, part)), used);
    const __m256i low = _mm256_and_si256(a, _mm256_srli_epi32(used, 16));
    const __m256i pair = _mm256_or_si256(low, _mm256_slli_epi32(b, 16));
    store(to->size + i, _mm256_and_si256(size, used));
    store(to->cross + i, _mm256_madd_epi16(low, b));
    store(to->energy + i, _mm256_madd_epi16(pair, pair));
}

/* Adds numbers without a sign. */
static inline __m256i plus_wide(__m256i sum, __m256i v)
{
    const __m256i even = _mm256_and_si256(v, _mm256_set1_epi64x(UINT32_MAX));
    return _mm256_add_epi64(sum, _mm256_add_epi64(even, _mm256_srli_epi64(v, 32)));
}

static inline __m256i magnitude(__m256 v, __m256i used)
{
    return _mm256_and_si256(_mm256_abs_epi32(_mm256_cvttps_epi32(v)), used);
}

static inline __m256i squared(__m256i v)
{
    return _mm256_mullo_epi32(v, v);
}

/* Squares and products are below 2^31, as magnitudes are below 41000, and, in units, 61500. */
static inline void add_squares(square_sums *to, const columns *c, int32_t i, __m256i used)
{
    enum { UNIT_BITS = 8 };
    const __m256i a = _mm256_srli_epi32(magnitude(derived(c->p_smooth + i), used), UNIT_BITS);
    const __m256i b = _mm256_srli_epi32(magnitude(smoothed(c->q_steep + i), used), UNIT_BITS);
    const __m256i p = magnitude(_mm256_loadu_ps(c->p[0] + i + BEFORE), used);
    const __m256i q = magnitude(_mm256_loadu_ps(c->q[0] + i + BEFORE), used);
    to->along = plus_wide(plus_wide(to->along, squared(a)), squared(b));
    to->both = plus_wide(to->both, _mm256_mullo_epi32(_mm256_add_epi32(p, p), q));
    to->either = plus_wide(to->either, _mm256_add_epi32(squared(p), squared(q)));
}

static inline uint32_t count(__m256i lanes)
{
    return (uint32_t) __builtin_popcount((uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(lanes)));
}

/* n loops of columns. */
static void filter_along(products of[FILTERS], square_sums *sums, const columns *c, int32_t n)
{
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    for (int32_t i = 0; i < n; i += COLUMN_LANES) {
        __m256i bad = _mm256_cmpgt_epi32(lanes, _mm256_set1_epi32(n - i - 1));
        for (int32_t k = 0; k < TAPS; k++)
            bad = _mm256_or_si256(bad, load(c->bad + i + k));
        const __m256i used = _mm256_cmpeq_epi32(bad, _mm256_setzero_si256());
        sums->used += count(used);
        sums->steep += count(_mm256_cmpeq_epi32(bad, _mm256_set1_epi32(TOO_STEEP)));
        multiply(&of[WIDE], i, smoothed(c->u + i), derived(c->v + i), used);
        const float *const p = c->p[0] + i + BEFORE, *const q = c->q[0] + i + BEFORE;
        const float *const p1 = c->p[1] + i + BEFORE, *const q1 = c->q[1] + i + BEFORE;
        const __m256 u = _mm256_sub_ps(_mm256_add_ps(_mm256_loadu_ps(p), _mm256_loadu_ps(p + 1)),
                                       _mm256_add_ps(_mm256_loadu_ps(p1), _mm256_loadu_ps(p1 + 1)));
        const __m256 v =
            _mm256_sub_ps(_mm256_add_ps(_mm256_loadu_ps(q + 1), _mm256_loadu_ps(q1 + 1)),
                          _mm256_add_ps(_mm256_loadu_ps(q), _mm256_loadu_ps(q1)));
        multiply(&of[NARROW], i, u, v, used);
        add_squares(sums, c, i, used);
    }
}

/* Numbers of loops stand above their energy, which is below 2^25 each. */
enum { ENERGY_BITS = 40 };
typedef struct counted {
    uint64_t of[FILTERS][2][SIZES];
} counted;

static ALWAYS_INLINE void add_loop(ntp_orientation *acc, counted *to, const products of[FILTERS],
                                   int32_t half, int32_t i, int32_t cell)
{
    for (int32_t f = 0; f < FILTERS; f++) {
        const int32_t size = of[f].size[i];
        to->of[f][half][size] += (uint64_t) 1 << ENERGY_BITS | of[f].energy[i];
        acc->sums[f].cross[size][cell] += of[f].cross[i];
    }
}

static void end_counts(ntp_orientation *acc, const counted *from, uint32_t unused)
{
    for (int32_t f = 0; f < FILTERS; f++) {
        for (int32_t half = 0; half < 2; half++) {
            for (int32_t k = 0; k < SIZES; k++) {
                const uint64_t v = from->of[f][half][k];
                acc->sums[f].loops[k] += v >> ENERGY_BITS;
                acc->sums[f].energy[k] += v & (((uint64_t) 1 << ENERGY_BITS) - 1);
            }
        }
        acc->sums[f].loops[0] -= unused;
    }
}

/* Loops of one half, and where the next block begins. */
typedef struct place {
    int32_t cell, left;
} place;

static inline place place_at(int32_t x, int32_t side)
{
    return (place) { x / side, side - x % side };
}

static inline place moved(place at, int32_t n, int32_t side)
{
    at.left -= n;
    return at.left > 0 ? at : (place) { at.cell + 1, side };
}

static inline int32_t lesser(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* Neighbors are often of one size and block, and an addition to what was just stored waits for that: so the
 * two halves are added in turn.  The last of an odd number is added with one that is none. */
static void add_products(ntp_orientation *acc, const products of[FILTERS], int32_t x, int32_t n,
                         int32_t cell, int32_t side, uint32_t used)
{
    counted sums;
    const int32_t half = (n + 1) / 2;
    place a = place_at(x, side), b = place_at(x + half, side);
    memset(&sums, 0, sizeof sums);
    for (int32_t i = 0, next; i < half; i = next) {
        const int32_t some = lesser(half - i, lesser(a.left, b.left));
        next = i + some;
        for (; i < next; i++) {
            add_loop(acc, &sums, of, 0, i, cell + a.cell);
            add_loop(acc, &sums, of, 1, i + half, cell + b.cell);
        }
        a = moved(a, some, side);
        b = moved(b, some, side);
    }
    end_counts(acc, &sums, (uint32_t) (2 * half) - used);
}

ONE_COPY static uint64_t sum_of(const __m256i *v)
{
    uint64_t lane[4];
    memcpy(lane, v, sizeof lane);
    return lane[0] + lane[1] + lane[2] + lane[3];
}

/* Floats that are no vector */
static void add_broken(columns *to, const ntp__block *block, int32_t n)
{
    for (int32_t i = 0; block->any_broken && i < n; i++)
        to->bad[i] |= block->broken[i] ? NO_NORMAL : 0;
}

void ntp__add_stretch_avx2(ntp_orientation *acc, const ntp_const_image *src, uint32_t touch,
                           int32_t x, int32_t y, int32_t n)
{
    columns c;
    products of[FILTERS];
    texel_rows rows;
    const __m256i none = _mm256_setzero_si256();
    square_sums sums = { none, none, none, 0, 0 };
    const bool alpha = src->channels == 4 && !(touch & NTP_UNUSED_TRANSPARENT);
    const int32_t texels = n + TAPS - 1, side = ntp__cell_side(src->width);
    const int32_t cell = y / ntp__cell_side(src->height) * SIDE;
    const bool packed = src->type == NTP_TYPE_U8 && src->channels >= 3 && ntp__is_packed(src) &&
                        texels >= COLUMN_LANES;
    rows.channels = packed ? src->channels : 0;
    for (int32_t k = 0; k < TAPS; k++) {
        rows.packed[k] = ntp__at(src, x - BEFORE, y - BEFORE + k);
        if (!packed)
            ntp__unpack(&rows.planes[k], src, x - BEFORE, y - BEFORE + k, texels);
    }
#ifdef NTP_HAVE_AVX512
    if (packed && texels >= 2 * COLUMN_LANES && ntp__cpu_has_avx512(NTP__CPU_ALL))
        ntp__filter_down8_avx512(&c, rows.packed, src->channels, texels, alpha);
    else
#endif
        filter_down(&c, &rows, texels, ntp__max(src->type), alpha);
    for (int32_t k = 0; !packed && k < TAPS; k++)
        add_broken(&c, &rows.planes[k], texels);
    filter_along(of, &sums, &c, n);
    acc->steep += sums.steep;
    acc->along += sum_of(&sums.along);
    acc->both += sum_of(&sums.both);
    acc->either += sum_of(&sums.either);
    add_products(acc, of, x, n, cell, side, sums.used);
    end_lanes();
}
