/* SPDX-License-Identifier: MIT */
/*
 * compare_avx512.c - differences of packed RGB in levels, and its angles, with AVX-512
 *
 * As compare_avx2.c, but 16 texels at a time, and one for one: masks leave out equal texels and unused
 * ones.
 *
 * r, as near to 1/sqrt(y), y = s^2 d^2, as the processor has it, is off by less than 2^-14 of it.  Then
 * u0 = s^2 r is about s/d, and with e = 1 - y r^2 two terms of the series of (1 - e)^(-1/2) after the
 * first make it u, off by less than 2^-40.6: 5/16 |e|^3.  That is less than 1e-5 micro-degrees of small
 * angles, whose other errors are those of compare_avx2.c.  Of any angle the arc tangent of
 * min(s, |d|)/max(s, |d|) is found to 1.6e-5 for that, 3.3e-5 for a polynomial of 14 terms, 6.1e-5 for
 * rounding to PART_BITS places, and 1e-6 for all else: less than two of the last place in all.  So what
 * processors make of r changes nothing but which angles are left, as in doubt, to texel/angles_tmpl.h.
 *
 * Of a block with many large angles all are found as any; else the few large ones are left, and found
 * when there are many of them.
 *
 * Each loop takes few steps that wait for each other, so that many of its turns are under way at once: one has
 * the products, one tangents, one their arc tangents, one adds these up, and bins are counted along with the
 * products of the next block.
 *
 * Fused products only make errors smaller.  The squares of 16 bit have none, for they are handed on.
 */
#include "picture/compare_avx2.h"

#include "base/lanes_avx2.h"
#include "picture/small_angles.h"
#include "texel/packed_avx512_tmpl.h"

enum {
    STEP = LANES_512,
    MANY =
        16 /* times as many as are large in a sample of a quarter: as many as there are, if a quarter is */
};

/* What is kept of a block. */
typedef struct pairs {
    /* s^2 and d, times a power of 4 or 2 */
    _Alignas(64) double s2[NTP__BLOCK];
    double d[NTP__BLOCK];
    /* Of these or of those that are left: tangents, or angles as small_angle has them, and bits of texels that
     * have one */
    double angle[LEFT + STEP];
    uint16_t different[LEFT / STEP];
    int32_t n, listed, counted, bin[NTP__BLOCK + LEFT + STEP];
    /* Texels that have one, and those that are black in one image and white in the other: their angle is 0 */
    int32_t texels, unused;
    uint32_t *bins;
} pairs;

/* |Differences| of levels, as the loops below have them. */
typedef struct sums {
    __m512i low, high, most_low, most_high;
} sums;

/* low / (s |d|); s or d may be 0 where low is.  Else y is at least 2^-4, and what is added is nothing. */
static inline __m512d quotient(__m512d low, __m512d s2, __m512d d2)
{
    const __m512d y = _mm512_fmadd_pd(s2, d2, _mm512_set1_pd(0x1p-100));
    const __m512d r = _mm512_rsqrt14_pd(y), u = _mm512_mul_pd(low, r);
    const __m512d e = _mm512_fnmadd_pd(y, _mm512_mul_pd(r, r), _mm512_set1_pd(1));
    const __m512d by = _mm512_fmadd_pd(e, _mm512_set1_pd(0.375), _mm512_set1_pd(0.5));
    return _mm512_fmadd_pd(_mm512_mul_pd(u, e), by, u);
}

/* atan(u) + ROUND_BIN + 1/2 + 2^-PART_BITS in units of 2^-PART_BITS micro-degrees, with other bits above those of 180
 * degrees; 0, as one in doubt, if u is not small, or d not positive. */
static inline __m512d small_angle(__m512d u, __m512d d)
{
    const __mmask8 ahead = _mm512_cmp_pd_mask(d, _mm512_setzero_pd(), _CMP_GT_OQ);
    const __mmask8 small = _mm512_mask_cmp_pd_mask(ahead, u, _mm512_set1_pd(SMALL), _CMP_LE_OQ);
    const __m512d w = _mm512_mul_pd(u, u);
    __m512d t = _mm512_fmadd_pd(_mm512_set1_pd(C4), w, _mm512_set1_pd(C3));
    t = _mm512_fmadd_pd(t, w, _mm512_set1_pd(C2));
    t = _mm512_fmadd_pd(t, w, _mm512_set1_pd(C1));
    t = _mm512_fmadd_pd(t, w, _mm512_set1_pd(C0));
    return _mm512_maskz_fmadd_pd(small, t, u, _mm512_set1_pd(TO_PARTS));
}

/* As small_angle, of any vectors: u is the tangent of the angle to the nearest of 0, 90 and 180 degrees.  Terms of
 * odd and of even powers are added apart. */
static inline __m512d any_angle(__m512d u, __m512d s2, __m512d d)
{
    const double *const terms = ntp__atan_terms;
    const __m512d w = _mm512_mul_pd(u, u), w2 = _mm512_mul_pd(w, w);
    const __mmask8 beside = _mm512_cmp_pd_mask(s2, _mm512_mul_pd(d, d), _CMP_GT_OQ);
    const __mmask8 behind = _mm512_cmp_pd_mask(d, _mm512_setzero_pd(), _CMP_LT_OQ);
    __m512d odd = _mm512_set1_pd(terms[0]), even = _mm512_set1_pd(terms[1]);
#pragma GCC unroll 1
    for (size_t k = 2; k < NTP__ATAN_TERMS; k += 2) {
        odd = _mm512_fmadd_pd(odd, w2, _mm512_set1_pd(terms[k]));
        even = _mm512_fmadd_pd(even, w2, _mm512_set1_pd(terms[k + 1]));
    }
    __m512d t = _mm512_mul_pd(_mm512_fmadd_pd(odd, w, even), u);
    t = _mm512_mask_sub_pd(t, beside, _mm512_set1_pd(90e6), t);
    t = _mm512_mask_sub_pd(t, behind, _mm512_set1_pd(180e6), t);
    return _mm512_add_pd(t, _mm512_set1_pd(TO_PARTS));
}

/* Lanes are unsigned 32 bits. */
ONE_COPY static void add_channel(ntp__compared *out, int k, __m512i sum, __m512i most)
{
    const __m512i low = _mm512_and_si512(sum, _mm512_set1_epi64(UINT32_MAX));
    const uint32_t greatest = _mm512_reduce_max_epu32(most);
    out->sum[k] +=
        (uint64_t) _mm512_reduce_add_epi64(_mm512_add_epi64(low, _mm512_srli_epi64(sum, 32)));
    out->most[k] = greatest > out->most[k] ? greatest : out->most[k];
}

/* Puts s2 and d of those in bits of 16 side by side; returns how many. */
static inline int32_t gather(double *to_s2, double *to_d, const double *s2, const double *d,
                             uint32_t bits)
{
    int32_t n = 0;
    for (int k = 0; k < 2; k++, s2 += STEP / 2, d += STEP / 2, bits >>= 8) {
        const __m512d v = _mm512_loadu_pd(s2), w = _mm512_loadu_pd(d);
        _mm512_storeu_pd(to_s2 + n, _mm512_maskz_compress_pd((__mmask8) bits, v));
        _mm512_storeu_pd(to_d + n, _mm512_maskz_compress_pd((__mmask8) bits, w));
        n += __builtin_popcount(bits & 255);
    }
    return n;
}

/* Adds those of n angles that are not in doubt.  s2 and d of all others are left, behind `left`
 * of them; they may be there, too. */
ONE_COPY static void add_angles(ntp__compared *out, pairs *p, const double *s2, const double *d,
                                int32_t n, int32_t left)
{
    const __m512i evens = steps_of(2, 0), odds = steps_of(2, 1);
    const __m512i parts = _mm512_set1_epi64(SURE_BITS), by = _mm512_set1_epi32(BY_1000);
    /* Of micro-degrees + ROUND_BIN: no lane gets more than LEFT / STEP angles, below 2^32 */
    __m512i sum = _mm512_setzero_si512(), most = sum;
    int32_t *const bin = p->bin + p->listed;
    int32_t bins = 0, some = 0, full = 0, at[LEFT / STEP];
    uint16_t bits[LEFT / STEP];
    for (int32_t i = 0; i < n; i += STEP) {
        const __m512i v0 = _mm512_load_si512(p->angle + i);
        const __m512i v1 = _mm512_load_si512(p->angle + i + STEP / 2);
        const __m512i a0 = _mm512_srli_epi64(v0, PART_BITS), a1 = _mm512_srli_epi64(v1, PART_BITS);
        const __mmask16 clear =
            _mm512_kunpackb(_mm512_test_epi64_mask(v1, parts), _mm512_test_epi64_mask(v0, parts));
        const __mmask16 sure = _kand_mask16(clear, _cvtu32_mask16(p->different[i / STEP]));
        const __m512i angle = _mm512_permutex2var_epi32(a0, evens, a1);
        const __m512i b = _mm512_srli_epi32(
            _mm512_permutex2var_epi32(_mm512_mul_epu32(a0, by), odds, _mm512_mul_epu32(a1, by)),
            BY_BITS);
        /* Many of one bin would wait for each other. */
        const __mmask16 listed =
            _mm512_mask_cmpneq_epi32_mask(sure, b, _mm512_set1_epi32(out->fullest));
        const __m512i others = _mm512_maskz_compress_epi32(listed, b);
        const uint32_t found = _cvtmask16_u32(sure), more = _cvtmask16_u32(listed);
        sum = _mm512_mask_add_epi32(sum, sure, sum, angle);
        most = _mm512_mask_max_epu32(most, sure, most, angle);
        _mm512_storeu_si512(bin + bins, others);
        bins += __builtin_popcount(more);
        full += __builtin_popcount(found ^ more);
        const __m512i first = _mm512_broadcastd_epi32(_mm512_castsi512_si128(others));
        if (__builtin_popcount(_mm512_mask_cmpeq_epi32_mask(listed, b, first)) >= STEP / 2) {
            out->bins[out->fullest] += (uint32_t) full;
            out->fullest = _mm512_cvtsi512_si32(first);
            full = 0;
        }
        /* No branch, for it would be taken at random.  Stores of nothing, all to one place, are slow: those
         * that are left are gathered later. */
        at[some] = i;
        bits[some] = (uint16_t) (p->different[i / STEP] & ~found);
        some += bits[some] != 0;
    }
    for (int32_t i = 0; i < some; i++)
        left += gather(out->s2 + left, out->d + left, s2 + at[i], d + at[i], bits[i]);
    add_channel(out, ANGLES, sum, most);
    out->bins[out->fullest] += (uint32_t) full;
    out->left = left;
    p->listed += bins;
}

/* Any angles of texels that are different. */
ONE_COPY static void find_any(ntp__compared *out, pairs *p, const double *s2, const double *d,
                              int32_t n, int32_t left)
{
    for (int32_t i = 0; i < n; i += STEP / 2) {
        const __m512d v = _mm512_loadu_pd(s2 + i), w = _mm512_loadu_pd(d + i);
        const __m512d w2 = _mm512_mul_pd(w, w);
        _mm512_store_pd(p->angle + i, quotient(_mm512_min_pd(v, w2), v, w2));
    }
    for (int32_t i = 0; i < n; i += STEP / 2) {
        const __m512d u = _mm512_load_pd(p->angle + i);
        _mm512_store_pd(p->angle + i,
                        any_angle(u, _mm512_loadu_pd(s2 + i), _mm512_loadu_pd(d + i)));
    }
    add_angles(out, p, s2, d, n, left);
}

/* Their small angles. */
static void find_small(ntp__compared *out, pairs *p)
{
    for (int32_t i = 0; i < p->n; i += STEP / 2) {
        const __m512d s2 = _mm512_load_pd(p->s2 + i), d = _mm512_load_pd(p->d + i);
        _mm512_store_pd(p->angle + i, quotient(s2, s2, _mm512_mul_pd(d, d)));
    }
    for (int32_t i = 0; i < p->n; i += STEP / 2) {
        const __m512d u = _mm512_load_pd(p->angle + i), d = _mm512_load_pd(p->d + i);
        _mm512_store_pd(p->angle + i, small_angle(u, d));
    }
    add_angles(out, p, p->s2, p->d, p->n, out->left);
}

/* Are so many angles of a block large that it is quicker to take all as any?  Every fourth eight tell. */
static bool are_large(const pairs *p)
{
    const int32_t apart = 2 * STEP;
    int32_t large = 0;
    for (int32_t i = 0; i < p->n; i += apart) {
        const __m512d d = _mm512_load_pd(p->d + i), s2 = _mm512_load_pd(p->s2 + i);
        const __m512d ahead = _mm512_max_pd(d, _mm512_setzero_pd());
        const __m512d least = _mm512_mul_pd(_mm512_mul_pd(d, ahead), _mm512_set1_pd(SMALL * SMALL));
        large += __builtin_popcount(_mm512_cmp_pd_mask(s2, least, _CMP_GE_OQ));
    }
    return MANY * large > p->n;
}

/* The angles of a block. */
static void find_block(ntp__compared *out, pairs *p)
{
    if (are_large(p))
        find_any(out, p, p->s2, p->d, p->n, out->left);
    else
        find_small(out, p);
}

/* The angles of those that were left from `first` on; then those in doubt are. */
static void find_others(ntp__compared *out, pairs *p, int32_t first)
{
    const int32_t n = out->left - first;
    for (int32_t i = 0; i < n; i += STEP)
        p->different[i / STEP] = (uint16_t) (n - i < STEP ? (1U << (n - i)) - 1 : UINT16_MAX);
    find_any(out, p, out->s2 + first, out->d + first, n, first);
}

/* s2 and d of the next 16, and bits of those that are different. */
static inline void keep(pairs *p, const __m512d s2[2], const __m512d d[2], uint32_t different)
{
    const uint32_t n = (uint32_t) p->n;
    for (uint32_t k = 0; k < 2; k++) {
        _mm512_store_pd(p->s2 + n + STEP / 2 * k, s2[k]);
        _mm512_store_pd(p->d + n + STEP / 2 * k, d[k]);
    }
    p->different[n / STEP] = (uint16_t) different;
    p->texels += __builtin_popcount(different);
    p->n = (int32_t) (n + STEP);
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

/* With v of a, and w = v + 2 off: half of v x w = 2 v x off and of v . w = v . v + 2 v . off.  Returns
 * |off|^2. */
static inline __m512i multiply8(__m512d s2[2], __m512d d[2], texels a, texels off)
{
    const texels v = {
        .rg = _mm512_sub_epi16(_mm512_add_epi16(a.rg, a.rg), _mm512_set1_epi16(255)),
        .b = _mm512_sub_epi16(_mm512_add_epi16(a.b, a.b), _mm512_set1_epi32(255)),
    };
    const __m512i k = dot8(v, v), l = dot8(off, off), e = dot8(v, off);
    for (int i = 0; i < 2; i++) {
        const __m512d m = to_doubles(k, i), f = to_doubles(e, i);
        s2[i] = _mm512_fnmadd_pd(f, f, _mm512_mul_pd(m, to_doubles(l, i)));
        d[i] = _mm512_fmadd_pd(m, _mm512_set1_pd(0.5), f);
    }
    return l;
}

static inline void step8(pairs *p, sums *sum, const uint8_t *pa, const uint8_t *pb)
{
    const __m512i va = load_48(pa), vb = load_48(pb);
    const texels a = spread8(va), b = spread8(vb);
    const texels off = { _mm512_sub_epi16(b.rg, a.rg), _mm512_sub_epi16(b.b, a.b) };
    const __m512i rg = _mm512_abs_epi16(off.rg), blue = _mm512_abs_epi16(off.b);
    sum->low = _mm512_add_epi16(sum->low, rg);
    sum->high = _mm512_add_epi16(sum->high, blue);
    sum->most_low = _mm512_max_epi16(sum->most_low, rg);
    sum->most_high = _mm512_max_epi16(sum->most_high, blue);
    __m512d s2[2], d[2];
    const __m512i l = multiply8(s2, d, a, off);
    uint32_t different = _mm512_test_epi32_mask(l, l);
    if (different == 0)
        return;
    /* Of all opposite corners */
    const __mmask16 corners = _mm512_cmpeq_epi32_mask(l, _mm512_set1_epi32(3 * 255 * 255));
    if (corners != 0) {
        const __m512i gray = _mm512_or_si512(a.b, _mm512_slli_epi32(a.b, 16));
        const uint32_t unused = _mm512_mask_cmpeq_epi32_mask(corners, a.rg, gray);
        p->unused += __builtin_popcount(unused);
        different &= ~unused;
    }
    keep(p, s2, d, different);
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
static inline void multiply16(__m512d *s2, __m512d *d, __m512i a, __m512i b)
{
    const __m512d x1 = numerators(a, 0), y1 = numerators(a, 1), z1 = numerators(a, 2);
    const __m512d x2 = numerators(b, 0), y2 = numerators(b, 1), z2 = numerators(b, 2);
    const __m512d x = _mm512_fmsub_pd(y1, z2, _mm512_mul_pd(z1, y2));
    const __m512d y = _mm512_fmsub_pd(z1, x2, _mm512_mul_pd(x1, z2));
    const __m512d z = _mm512_fmsub_pd(x1, y2, _mm512_mul_pd(y1, x2));
    const __m512d xy = _mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y));
    *s2 = _mm512_add_pd(xy, _mm512_mul_pd(z, z));
    *d = _mm512_fmadd_pd(z1, z2, _mm512_fmadd_pd(y1, y2, _mm512_mul_pd(x1, x2)));
}

/* The samples of eight texels, 64 bits each. */
static inline __m512i spread16(__m512i v)
{
    const __m512i first = _mm512_setr_epi64(0, 3, 6, 9, 12, 15, 18, 21);
    const __m512i from =
        _mm512_add_epi64(_mm512_or_si512(_mm512_or_si512(first, _mm512_slli_epi64(first, 16)),
                                         _mm512_slli_epi64(first, 32)),
                         _mm512_set1_epi64(0x000200010000));
    return _mm512_maskz_permutexvar_epi16(0x77777777, from, v);
}

/* |a - b| of eight texels; returns bits of those that are different and not unused. */
static inline uint32_t add_levels16(pairs *p, sums *sum, __m512i a, __m512i b)
{
    const __m512i white = _mm512_set1_epi64(0xffffffffffff);
    const __m512i v = spread16(_mm512_or_si512(_mm512_subs_epu16(a, b), _mm512_subs_epu16(b, a)));
    sum->low = _mm512_add_epi32(sum->low, _mm512_and_si512(v, _mm512_set1_epi32(65535)));
    sum->high = _mm512_add_epi32(sum->high, _mm512_srli_epi32(v, 16));
    sum->most_low = _mm512_max_epu16(sum->most_low, v);
    uint32_t different = _mm512_test_epi64_mask(v, v);
    const __mmask8 corners = _mm512_cmpeq_epi64_mask(v, white);
    if (corners != 0) {
        const __m512i w = spread16(a);
        const __mmask8 black = _mm512_mask_cmpeq_epi64_mask(corners, w, _mm512_setzero_si512());
        const uint32_t unused = black | _mm512_mask_cmpeq_epi64_mask(corners, w, white);
        p->unused += __builtin_popcount(unused);
        different &= ~unused;
    }
    return different;
}

static inline void step16(pairs *p, sums *sum, const uint8_t *pa, const uint8_t *pb)
{
    enum { HALF = 48 /* bytes */ };
    __m512d s2[2], d[2];
    const __m512i a0 = load_48(pa), b0 = load_48(pb);
    const __m512i a1 = load_48(pa + HALF), b1 = load_48(pb + HALF);
    const uint32_t low = add_levels16(p, sum, a0, b0), high = add_levels16(p, sum, a1, b1);
    if ((low | high) == 0)
        return;
    multiply16(&s2[0], &d[0], a0, b0);
    multiply16(&s2[1], &d[1], a1, b1);
    keep(p, s2, d, low | high << 8);
}

static void finish16(ntp__compared *out, const sums *sum)
{
    const __m512i first = _mm512_set1_epi64(UINT32_MAX), least = _mm512_set1_epi64(65535);
    const __m512i green = _mm512_and_si512(_mm512_srli_epi64(sum->most_low, 16), least);
    add_channel(out, 0, _mm512_and_si512(sum->low, first), _mm512_and_si512(sum->most_low, least));
    add_channel(out, 1, sum->high, green);
    add_channel(out, 2, _mm512_srli_epi64(sum->low, 32), _mm512_srli_epi64(sum->most_low, 32));
}

#include "picture/compare_steps_tmpl.h"

int32_t ntp__compare_rgb_avx512(ntp__compared *out, const void *a, const void *b, int32_t n,
                                bool deep)
{
    const __m512i zero = _mm512_setzero_si512();
    const int32_t span = n < SPAN ? n : SPAN, texel = deep ? 6 : 3;
    int32_t rest = span, kept = 0;
    sums sum = { zero, zero, zero, zero };
    pairs p;
    p.listed = p.counted = p.texels = p.unused = 0;
    p.bins = out->bins;
    memset(out, 0, offsetof(ntp__compared, fullest));
    do {
        const uint8_t *const va = (const uint8_t *) a + texel * (span - rest);
        const uint8_t *const vb = (const uint8_t *) b + texel * (span - rest);
        rest = take_steps(&p, &sum, va, vb, rest, deep);
        count_rest(&p);
        find_block(out, &p);
        if (rest == 0 || out->left > KEPT) {
            find_others(out, &p, kept);
            kept = out->left;
        }
    } while (rest > 0 && out->left <= KEPT);
    if (deep)
        finish16(out, &sum);
    else
        finish8(out, &sum);
    count_rest(&p);
    out->found = p.texels - out->left;
    out->different = p.texels + p.unused;
    end_lanes();
    return span - rest;
}
