/* SPDX-License-Identifier: MIT */
/*
 * exact16_avx512.c - counts 16-bit texels with the derived blue, or close to it, with AVX-512
 *
 * As exact16_tmpl.h, which says why the numbers are right.  Here a list is made of the exact texels that are
 * nearly flat, and one of those that are steeper, from the pixels in registers; then each list is placed
 * sixteen texels at a time, and counted.  A loop for all of this at once took twice as long: it would branch on
 * what no processor foresees, and leave room for few steps in flight.
 *
 * z and t say all of a steeper texel, v = K - 1 - z, t and the sum of sizes of one that is nearly flat.  With
 * these in 32 bits, a neighbor in Z-zero is 2 pair + s > (K - 2)(v - 1), and rounded pair + s > (K - 1) v - K/2:
 * as many, as s is even, never below 3 - K where v is 0, and sums are below 36000.
 *
 * Lengths are those of close_length in close_tmpl.h, with a better first guess and fewer roundings.
 * So are close texels counted as there, but one by one: masks leave out others.
 */
#include "texel/kernels_avx512.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "texel/angle.h"
#include "texel/survey_avx512_tmpl.h"

#include <math.h>

enum { K = 32768, ROOM = NTP__EXACT_AT_ONCE + LANES_512, LIMIT = 16390 };

/* Exact texels of a block; and sums of those that are not nearly flat. */
typedef struct exact_texels {
    int32_t near[ROOM]; /* t, below a word of v and pair; then where to count in exact (close.h) */
    int32_t far[ROOM];  /* t, below z; the same */
    int32_t off[ROOM];  /* where to count in exact_off */
    __m512i longer, squares, shortest, longest, most;
} exact_texels;

static inline __m512i plus(__m512i v, __m512i w)
{
    return _mm512_add_epi32(v, w);
}

static inline __m512i minus(__m512i v, __m512i w)
{
    return _mm512_sub_epi32(v, w);
}

static inline __m512i plus_if(__mmask16 which, __m512i v, int32_t more)
{
    return _mm512_mask_add_epi32(v, which, v, all(more));
}

static inline __mmask16 is_above(__m512i v, int32_t w)
{
    return _mm512_cmpgt_epi32_mask(v, all(w));
}

/* Whose copies lanes count in. */
static inline __m512i copies(int32_t of)
{
    return _mm512_and_si512(steps_of(1, 0), all(of - 1));
}

static inline int32_t keep(int32_t *to, __mmask16 these, __m512i v)
{
    store(to, _mm512_maskz_compress_epi32(these, v));
    return __builtin_popcount(these);
}

/* floor(64 xy / A_M), as in close_tmpl.h */
static inline __m512i steepness(__m512i xy)
{
    return _mm512_srli_epi32(plus(xy, plus(_mm512_srli_epi32(xy, 15), all(1))), 24);
}

/* Low words of these, and those as high ones. */
static inline __m512i both_words(__m512i low, __m512i high)
{
    return _mm512_mask_mov_epi16(_mm512_slli_epi32(high, 16), 0x55555555, low);
}

/* Low words with their sign. */
static inline __m512i low_words(__m512i v)
{
    return _mm512_srai_epi32(_mm512_slli_epi32(v, 16), 16);
}

/* Where to count texels that are nearly flat. */
static inline void place_near(int32_t *near, int32_t n)
{
    enum { BY = NTP__EXACT_NEAR_COPIES, ONE = (BY << NTP__EXACT_OFF_BIT) + BY };
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __m512i of = load(near + i), t = low_words(of), pair = _mm512_srli_epi32(of, 20);
        const __m512i v = _mm512_and_si512(_mm512_srli_epi32(of, 16), all(15));
        const __m512i sum = minus(plus(pair, all(1)), t), q = plus(t, all(LIMIT));
        const __m512i neighbor = _mm512_madd_epi16(minus(v, all(1)), all(K - 2));
        const __m512i rounded = minus(_mm512_madd_epi16(v, all(K - 1)), all(K / 2));
        __m512i at = plus(_mm512_slli_epi32(v, NTP__EXACT_OFF_BIT + 3), copies(BY));
        at = plus_if(is_above(t, 0), at, BY);
        at = plus_if(is_above(q, -1), at, ONE);
        at = plus_if(is_above(q, K - 1), at, ONE);
        at = plus_if(_mm512_cmpgt_epi32_mask(plus(sum, pair), neighbor), at,
                     BY * NTP__EXACT_NEIGHBOR);
        at = plus_if(_mm512_cmpgt_epi32_mask(sum, rounded), at, BY * NTP__EXACT_ROUNDED);
        store(near + i, at);
    }
    store(near + n, copies(BY));
}

/* The lengths in Z-zero, less 65536, as close_length of close_tmpl.h; those in doubt again. */
static inline __m512i longer_of(__m512i b, __m512i e)
{
    const float m = 65535, margin = 0x1p-16f;
    const __m512i g = minus(_mm512_mullo_epi32(b, b), _mm512_slli_epi32(e, 2));
    const __m512 s = _mm512_add_ps(_mm512_cvtepi32_ps(g), _mm512_set1_ps(m * m));
    const __m512 guess = _mm512_rsqrt14_ps(s), half = _mm512_mul_ps(s, _mm512_set1_ps(0.5f));
    const __m512 more = _mm512_fnmadd_ps(_mm512_mul_ps(half, guess), guess, _mm512_set1_ps(1.5f));
    const __m512 r = _mm512_mul_ps(guess, more);
    const __m512i k = _mm512_cvtps_epi32(_mm512_mul_ps(s, r));
    const __m512i square = plus(g, all((int32_t) (65535U * 65535U - 3U)));
    const __m512 rest = _mm512_cvtepi32_ps(minus(square, _mm512_mullo_epi32(k, k)));
    const __m512 up = _mm512_fmadd_ps(_mm512_cvtepi32_ps(k), _mm512_set1_ps(1.0f / m),
                                      _mm512_set1_ps(0.5f - margin));
    const __m512 part = _mm512_fmadd_ps(rest, _mm512_mul_ps(r, _mm512_set1_ps(32768.0f / m)), up);
    const __m512i down = _mm512_cvttps_epi32(part);
    const __m512i other = _mm512_cvttps_epi32(_mm512_add_ps(part, _mm512_set1_ps(2 * margin)));
    __m512i length = plus(k, down);
    if (_mm512_cmpneq_epi32_mask(down, other) != 0) {
        int32_t blue[LANES_512], rest_of[LANES_512];
        store(blue, b);
        store(rest_of, e);
        for (int32_t i = 0; i < LANES_512; i++)
            blue[i] = ntp__fixed_length(
                4.0 * (REST_16 - rest_of[i]) + 2.0 + (double) blue[i] * blue[i], 65535);
        length = load(blue);
    }
    return minus(length, all(NTP__LENGTH_ONE));
}

/* Where to count those that are steeper, which are summed. */
static inline void place_far(exact_texels *to, int32_t n)
{
    enum { BY = NTP__CLOSE_COPIES };
    __m512i sum = _mm512_setzero_si512(), squares = sum, longest = sum, most = sum;
    __m512i shortest = all(-1);
    store(to->far + n, all((K - 1) << 16)); /* of length 1, and off by least */
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __m512i of = load(to->far + i), t = low_words(of), z = _mm512_srli_epi32(of, 16);
        const __m512i e = minus(_mm512_mullo_epi32(z, plus(z, all(1))), t);
        const __m512i longer = longer_of(plus(z, all(K)), e);
        const __m512i xy = minus(all(REST_16), e), t2 = plus(t, t);
        const __m512i steep = steepness(xy);
        __m512i off = minus(all(K - 1 + NTP__EXACT_LESS - 1), z);
        off = plus_if(_mm512_cmpgt_epi32_mask(t2, plus(z, all(1))), off, 1);
        off = plus_if(is_above(plus(t2, z), 0), off, 1);
        store(to->off + i, off);
        sum = plus(sum, longer);
        squares = plus(squares, _mm512_madd_epi16(longer, longer));
        most = _mm512_max_epi32(most, off);
        shortest = _mm512_min_epu32(shortest, minus(longer, all(1))); /* where it is not 0 */
        longest = _mm512_max_epi32(longest, longer);
        __m512i at =
            plus(_mm512_slli_epi32(_mm512_srli_epi32(longer, 9), 10), _mm512_slli_epi32(steep, 4));
        at = plus(at, plus(copies(BY), all(NTP__EXACT_FAR)));
        at = plus_if(is_above(t, -16383), at, BY);
        at = plus_if(is_above(t, 0), at, BY);
        store(to->far + i, plus_if(is_above(t, 16384), at, BY));
    }
    store(to->far + n, copies(8));
    store(to->off + n, copies(8));
    to->longer = sum;
    to->squares = squares;
    to->shortest = shortest;
    to->longest = longest;
    to->most = most;
}

ONE_COPY static void count_at(uint32_t *counts, const int32_t *at, int32_t n)
{
    for (int32_t i = 0; i < n; i += 8) {
        UNROLLED
        for (int32_t k = 0; k < 8; k++)
            counts[at[i + k]]++;
    }
}

/* Those of sixteen texels that are close, as close_standard() and close_zzero() in close_tmpl.h have it. */
typedef struct close_lanes {
    __mmask16 close, turned; /* turned: not exact, too */
    __m512i at, at_zz, off;  /* places in the counts, and how far blue is from that of Z-zero */
    __m512i length;          /* in Z-zero */
    __m512i z, e, t;
} close_lanes;

enum { ROOM_CLOSE = NTP__BLOCK + LANES_512 };

/* What the angles in doubt are made of: the pair, and d - M^2 as below. */
typedef struct doubtful {
    int32_t n, pair[ROOM_CLOSE], along[ROOM_CLOSE];
} doubtful;

#define M2      (65535.0 * 65535.0)
#define DEGREES (180e6 / NTP__PI)

/* In floats: with rho = 2 sqrt(xy + 1/2), |z - z'| = 2 and d = rho^2 + z z', less than M^2/10000 from M^2, the
 * angle is 2 rho/d, and 1/d is (2 - d/M^2)/M^2 to 1e-8 of it.  With six roundings, and those of what is added,
 * this is off by less than 0x1p-10 micro-degrees.  Those in doubt are 0, and noted. */
static inline __m512i turn_of(doubtful *others, const close_lanes *v)
{
    const double by = 4 * DEGREES / M2;
    const float margin = 0x1p-10f;
    const __m512i xy = minus(all(REST_16), v->e), t4 = _mm512_slli_epi32(v->t, 2);
    const __m512i z4 = plus(_mm512_slli_epi32(v->z, 2), all(2));
    /* d - M^2; z' is 2 less than z where t is positive */
    const __mmask16 negative = _mm512_cmplt_epi32_mask(v->t, _mm512_setzero_si512());
    const __m512i d =
        _mm512_mask_add_epi32(minus(minus(t4, z4), all(2)), negative, plus(t4, z4), all(-2));
    const __m512 half_rho =
        _mm512_sqrt_ps(_mm512_add_ps(_mm512_cvtepi32_ps(xy), _mm512_set1_ps(0.5f)));
    const __m512 factor = _mm512_fmadd_ps(_mm512_cvtepi32_ps(d), _mm512_set1_ps((float) (-by / M2)),
                                          _mm512_set1_ps((float) by));
    const __m512 up = _mm512_fmadd_ps(half_rho, factor, _mm512_set1_ps(0.5f - margin));
    const __m512i turn = _mm512_cvttps_epi32(up);
    const __m512i other = _mm512_cvttps_epi32(_mm512_add_ps(up, _mm512_set1_ps(2 * margin)));
    const __mmask16 doubt = _mm512_mask_cmpneq_epi32_mask(v->turned, turn, other);
    keep(others->pair + others->n, doubt, xy);
    others->n += keep(others->along + others->n, doubt, d);
    return _mm512_maskz_mov_epi32(v->turned & (__mmask16) ~doubt, turn);
}

/* Twice as much, or one more. */
static inline __m512i with_flag(__m512i v, __mmask16 flag)
{
    v = plus(v, v);
    return _mm512_mask_sub_epi32(v, flag, v, all(-1));
}

static inline __m512i one_if(__mmask16 which, __m512i v)
{
    return _mm512_mask_sub_epi32(v, which, v, all(-1));
}

/* Places of four copies. */
static inline __m512i with_copies(__m512i v)
{
    return plus(_mm512_slli_epi32(v, 2), copies(NTP__CLOSE_COPIES));
}

static inline void judge_close(close_lanes *v, __m512i r, __m512i g, __m512i b, __mmask16 some)
{
    const __m512i ones = all(-1), p = _mm512_xor_si512(both_words(r, g), all((int32_t) 0x80008000));
    const __m512i q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15));
    const __m512i sizes = _mm512_madd_epi16(q, all(0x00010001)); /* 2 less than half_up of both */
    const __m512i z = minus(b, all(K)), z1 = minus(z, ones);
    const __m512i e = plus(all(REST_16), _mm512_madd_epi16(q, _mm512_xor_si512(q, ones)));
    const __m512i t = minus(_mm512_mullo_epi32(z, z1), e), off = _mm512_abs_epi32(t);
    const __m512i beyond = _mm512_abs_epi32(plus(t, all(2))), reach = plus(plus(z, z), z1);
    some = _mm512_mask_cmple_epi32_mask(some, beyond, reach);
    some = _mm512_mask_cmple_epi32_mask(some, off, all(NTP__CLOSE_T_MOST));
    v->close = some = _mm512_mask_cmpgt_epi32_mask(some, e, ones);
    v->turned = _mm512_mask_cmpgt_epi32_mask(some, off, z);
    v->z = z;
    v->t = t;
    v->e = e;
    __m512i at = with_flag(steepness(minus(all(REST_16), e)), v->turned);
    at = with_flag(at, _mm512_cmpgt_epi32_mask(plus(sizes, plus(z1, all(1))), off));
    at = with_flag(at, is_above(t, 0));
    at = _mm512_slli_epi32(at, 2);
    at = one_if(is_above(t, NTP__CLOSE_T_ONE - 1), at);
    v->at = with_copies(one_if(is_above(t, NTP__CLOSE_T_LONGER - 1), at));
    /* z, or one less where t is positive, or one more */
    const __m512i sign = _mm512_or_si512(_mm512_srai_epi32(t, 31), all(1));
    const __m512i root = _mm512_mask_sub_epi32(z, v->turned, z, sign), twice = plus(root, root);
    const __m512i d = minus(e, _mm512_madd_epi16(root, root)), d2 = plus(d, d);
    __m512i want = one_if(_mm512_cmpgt_epi32_mask(plus(d2, all(2)), root), twice);
    want = one_if(_mm512_cmpge_epi32_mask(d2, plus(twice, root)), want);
    v->off = _mm512_abs_epi32(minus(b, want));
    const __m512i gap = plus(minus(_mm512_mullo_epi32(b, b), _mm512_slli_epi32(e, 2)), all(3));
    const __m512i reach_zz = plus(plus(b, all(8)), _mm512_slli_epi32(sizes, 2));
    /* Others are as (0, 0, 0) here. */
    const __m512i longer =
        longer_of(_mm512_maskz_mov_epi32(some, b), _mm512_maskz_mov_epi32(some, e));
    v->length = plus(longer, all(NTP__LENGTH_ONE));
    at = minus(_mm512_srli_epi32(v->length, 9), all(NTP__CLOSE_ZZ_SHORTEST));
    at = with_flag(at, is_above(gap, 6));
    at = with_flag(at, _mm512_cmpeq_epi32_mask(b, want));
    at = with_flag(at, _mm512_cmpgt_epi32_mask(reach_zz, gap));
    at = with_flag(at, _mm512_cmpgt_epi32_mask(plus(reach_zz, reach_zz), plus(gap, all(10))));
    v->at_zz = with_copies(at);
}

void ntp__count_close_avx512(ntp__close_block *out, ntp__close_counts *counts, uint32_t *levels_off,
                             int32_t *const c[3], int32_t n)
{
    doubtful doubt;
    int32_t at[ROOM_CLOSE], at_zz[ROOM_CLOSE], off[ROOM_CLOSE], close = 0, left = 0, from_1 = 0,
                                                                from_2 = 0;
    __m512i sum = _mm512_setzero_si512(), squares = sum, most = sum, turns = sum, widest = sum;
    __m512i inverted_least = sum, greatest = sum;
    doubt.n = 0;
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __mmask16 some = n - i < LANES_512 ? (__mmask16) ((1U << (n - i)) - 1) : 0xFFFF;
        const __m512i r = load(c[0] + i), g = load(c[1] + i), b = load(c[2] + i);
        close_lanes v;
        judge_close(&v, r, g, b, some);
        const __mmask16 others = some & (__mmask16) ~v.close;
        keep(c[0] + left, others, r);
        keep(c[1] + left, others, g);
        left += keep(c[2] + left, others, b);
        if (v.turned != 0) {
            const __m512i turn = turn_of(&doubt, &v);
            turns = plus(turns, turn);
            widest = _mm512_max_epi32(widest, turn);
            from_1 += __builtin_popcount(is_above(turn, 499));
            from_2 += __builtin_popcount(is_above(turn, 1499));
        }
        keep(at + close, v.close, v.at);
        keep(at_zz + close, v.close, v.at_zz);
        close += keep(off + close, v.close, v.off);
        const __m512i size = _mm512_abs_epi32(minus(v.length, all(NTP__LENGTH_ONE)));
        sum = _mm512_mask_add_epi32(sum, v.close, sum, v.length);
        squares = _mm512_mask_add_epi32(squares, v.close, squares, _mm512_madd_epi16(size, size));
        greatest = _mm512_mask_max_epi32(greatest, v.close, greatest, v.length);
        inverted_least = _mm512_mask_max_epu32(inverted_least, v.close, inverted_least,
                                               _mm512_xor_si512(v.length, all(-1)));
        most = _mm512_mask_max_epi32(most, v.close, most, v.off);
    }
    out->texels = close;
    out->left = left;
    out->angle_sum = (uint32_t) sum_of(&turns);
    out->angle_max = greatest_of(&widest);
    for (int32_t i = 0; i < doubt.n; i++) {
        const double s = 2 * sqrt(4.0 * doubt.pair[i] + 2.0), d = M2 + doubt.along[i];
        const uint32_t turn = (uint32_t) (int32_t) (ntp__radians(s, d) * DEGREES + 0.5);
        out->angle_sum += turn;
        out->angle_max = turn > out->angle_max ? turn : out->angle_max;
        from_1 += turn >= 500;
        from_2 += turn >= 1500;
    }
    out->angle_bins[0] = close - from_1;
    out->angle_bins[1] = from_1 - from_2;
    out->angle_bins[2] = from_2;
    /* squares are below 2^27, and there are 16 of each lane */
    out->length_sum = (int32_t) sum_of(&sum) - close * NTP__LENGTH_ONE;
    out->length_error2 = sum_of(&squares);
    out->least = ~greatest_of(&inverted_least);
    out->greatest = greatest_of(&greatest);
    out->levels_off_max = greatest_of(&most);
    end_lanes();
    for (int32_t i = 0; i < close; i++) {
        (&counts->standard[0][0])[at[i]]++;
        (&counts->zzero[0][0])[at_zz[i]]++;
        levels_off[off[i]]++;
    }
}

uint64_t ntp__sum_of_wide_avx512(const __m512i *v)
{
    return (uint64_t) _mm512_reduce_add_epi64(*v);
}

uint64_t ntp__sum_of_avx512(const __m512i *v)
{
    const __m512i even = _mm512_and_si512(*v, _mm512_set1_epi64(UINT32_MAX));
    const __m512i both = _mm512_add_epi64(even, _mm512_srli_epi64(*v, 32));
    return sum_of_wide(&both);
}

uint32_t ntp__greatest_of_avx512(const __m512i *v)
{
    return _mm512_reduce_max_epu32(*v);
}

void ntp__end_survey_avx512(ntp__survey *to, const surveyed *of)
{
    const __m512i low = all(65535), least = _mm512_xor_si512(of->least, all(-1));
    const __m512i extremes[6] = {
        _mm512_and_si512(of->most, low),
        _mm512_srli_epi32(of->most, 16),
        of->most_b,
        _mm512_and_si512(least, low),
        _mm512_srli_epi32(least, 16),
        _mm512_xor_si512(of->least_b, low),
    };
    for (int32_t k = 0; k < 3; k++) {
        to->sum[k] = (uint32_t) sum_of(&of->sum[k]);
        to->greatest[k] = greatest_of(&extremes[k]);
        to->least[k] = 65535 - greatest_of(&extremes[3 + k]);
    }
    to->odd = 0;
    to->gray = (uint32_t) of->gray;
}

int32_t ntp__count_exact_avx512(ntp__exact_block *out, ntp__close_counts *counts,
                                const uint16_t *src, int32_t n)
{
    const __m512i ones = all(-1);
    exact_texels f;
    surveyed seen;
    __mmask16 others[NTP__EXACT_AT_ONCE / LANES_512];
    int32_t near = 0, far = 0;
    n = n < NTP__EXACT_AT_ONCE ? n & -LANES_512 : NTP__EXACT_AT_ONCE;
    begin_survey(&seen);
    int32_t i = 0;
    do {
        const texels c = take16((const uint8_t *) (src + 3 * i));
        const char *const ahead = (const char *) (src + 3 * (NTP__EXACT_AT_ONCE + i));
        _mm_prefetch(ahead, _MM_HINT_T0);
        _mm_prefetch(ahead + 64, _MM_HINT_T0);
        see(&seen, c);
        const __m512i p = _mm512_xor_si512(c.rg, all((int32_t) 0x80008000));
        const __m512i q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15));
        const __m512i e = plus(all(REST_16), _mm512_madd_epi16(q, _mm512_xor_si512(q, ones)));
        const __m512i z = minus(c.b, all(K)), v = minus(all(K - 1), z);
        const __m512i t = minus(_mm512_mullo_epi32(z, minus(z, ones)), e);
        const __mmask16 exact = _mm512_mask_cmple_epi32_mask(_mm512_cmpneq_epi32_mask(t, all(1)),
                                                             _mm512_abs_epi32(t), z);
        const __mmask16 is_far = _mm512_mask_cmpge_epi32_mask(exact, v, all(NTP__EXACT_NEAR));
        const __mmask16 fine =
            _mm512_mask_cmpge_epi32_mask(exact, _mm512_and_si512(plus(t, all(LIMIT)), all(K - 1)),
                                         plus(_mm512_madd_epi16(v, v), all(7)));
        const __mmask16 is_near = fine & (__mmask16) ~is_far;
        const __m512i pair_v = plus(_mm512_madd_epi16(q, all(0x00100010)), v);
        near += keep(f.near + near, is_near, both_words(t, pair_v));
        far += keep(f.far + far, is_far, both_words(t, z));
        others[group_of(i)] = (__mmask16) ~(is_near | is_far);
        i += LANES_512;
    } while (i < n);
    int32_t left = 0;
    for (i = 0; i < n; i += LANES_512)
        left += keep(out->left + left, others[group_of(i)], steps_of(1, i));
    place_near(f.near, near);
    count_at(counts->exact, f.near, near);
    out->far = far;
    if (far > 0) {
        place_far(&f, far);
        count_at(counts->exact, f.far, far);
        count_at(counts->exact_off, f.off, far);
        const __m512i shortest = _mm512_xor_si512(f.shortest, ones);
        out->length_sum = (uint32_t) sum_of(&f.longer);
        out->length_error2 = sum_of(&f.squares);
        out->least = ~greatest_of(&shortest) + 1;
        out->greatest = greatest_of(&f.longest);
        out->levels_off_max = greatest_of(&f.most) - NTP__EXACT_LESS;
    }
    ntp__end_survey_avx512(&out->survey, &seen);
    out->texels = near + far;
    end_lanes();
    return n;
}
