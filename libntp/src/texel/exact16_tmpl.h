/* SPDX-License-Identifier: MIT */
/*
 * exact16_tmpl.h - counts packed 16-bit texels with the derived blue; a part of kernels.c
 *
 * Notation is that of close_tmpl.h.  Exact is |t| <= z, and then root is z and d is z - t.  So blue
 * in Z-zero is w - (2t <= z + 1) - (2t <= -z) above its derived one, with w = K - z.  Where w is 1, t
 * is at least 1.  So this is never negative, and G is above 3, as it is 4t + 1 for w = 1, 4(z + t) + 4
 * for w = 2, and greater beyond.
 *
 * Nearly all normals are nearly flat: there w is at most NEAR.  Then both limits of t above, those of
 * the standard length (-16382 and 16385), and those at which the length in Z-zero is rounded up, lie
 * close together, at -16383.5 and 16383.5 or up to 7 below or (w - 1)^2 above.  Texels in there wait
 * for others; of these few, unit tests look at each.  So with q = t + 16390, floor(q/2^15) says all
 * but the sign of t: the length in Z-zero is as many 65536ths above 1 as blue is levels off, which is
 * w - 1 + floor(q/2^15).
 *
 * Beyond, G >= 4K(w - 2) - 3w*w + 8w is more than neighbors have, as P is below 2K + 16 sqrt(K w).
 *
 * Words hold z and -t, 16 texels at once.  Where -t is beyond a word, it becomes -K, which is never
 * above -1 - z; or K - 1, which is above z, or else z is K - 1 too, and there t is at least 1.
 * Of odd texels (ntp__survey) few are exact.  Of those of 8 bit times 257 none is: three odd squares
 * are 3 modulo 8, and 255^2 is 1, so that 4t - 2 is 257^2 times 2, -6 or more.  No gray one is: x would
 * have to be between 18917 and 18918.  The four flat ones have t = 1, as few others do.
 */

#ifdef __AVX2__

enum { EXACT_STEP = 16, EVERY = 0x55555555 };

/* What is kept of the texels of a block between the steps. */
typedef struct exact_texels {
    int16_t s[256];            /* 1 - t, or 0: not exact, odd, or t = 1 */
    int16_t z[256], pair[256]; /* half_up of x and of y, less 2 */
    int16_t steep_s[256 + EXACT_STEP],
        steep_z[256 + EXACT_STEP]; /* of those that are steeper than nearly flat */
    uint8_t wait[256];             /* all bits: this one waits */
    /* Where to count in exact: nearly flat ones, and steeper ones; and these in exact_off (close.h). */
    uint16_t at[256], far[256], off[256];
    int32_t steep, near_ones; /* how many; of the latter, with those of none */
} exact_texels;

/* Of red, green and blue: sums of eight lanes, and extremes of 16. */
typedef struct exact_survey {
    __m256i sum[3], least[3], greatest[3];
} exact_survey;

/* Of texels that are steeper than nearly flat: sums of eight lanes, and extremes of 16: the least is 1 less, and
 * of distances there is EXACT_LESS more. */
typedef struct far_sums {
    __m256i longer, squares, shortest, longest, most;
} far_sums;

static inline uint32_t lanes_of(__m256i mask)
{
    return (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(mask));
}

/* Two bits of each of 16 words, less the second ones. */
static inline uint32_t bits_of(__m256i mask)
{
    return (uint32_t) _mm256_movemask_epi8(mask) & EVERY;
}

static inline __m256i kept(__m256i v, __m256i bad)
{
    return _mm256_andnot_si256(bad, v);
}

/* 16 texels: red, green and blue. */
static inline void load_exact(__m256i c[3], const uint16_t *s)
{
    enum { LOW = 0x49, MIDDLE = 0x92, HIGH = 0x24 }; /* words 0, 3, 6; 1, 4, 7; 2, 5 */
    const __m256i v = load_two(s, s + 24), w = load_two(s + 8, s + 32),
                  u = load_two(s + 16, s + 40);
    const __m256i r = _mm256_blend_epi16(_mm256_blend_epi16(v, w, MIDDLE), u, HIGH);
    const __m256i g = _mm256_blend_epi16(_mm256_blend_epi16(v, w, HIGH), u, LOW);
    const __m256i b = _mm256_blend_epi16(_mm256_blend_epi16(v, w, LOW), u, MIDDLE);
    c[0] = SHUFFLE(r, 0, 1, 6, 7, 12, 13, 2, 3, 8, 9, 14, 15, 4, 5, 10, 11);
    c[1] = SHUFFLE(g, 2, 3, 8, 9, 14, 15, 4, 5, 10, 11, 0, 1, 6, 7, 12, 13);
    c[2] = SHUFFLE(b, 4, 5, 10, 11, 0, 1, 6, 7, 12, 13, 2, 3, 8, 9, 14, 15);
}

static inline __m256i words(int32_t v)
{
    return _mm256_set1_epi16((int16_t) v);
}

/* -t, from x, y and blue: v(v + 1) is -v(-1 - v), and neither factor is beyond a word. */
static inline __m256i minus_t(__m256i xy, __m256i not_xy, __m256i blue)
{
    const __m256i rest = _mm256_add_epi32(blue, eight(CLOSE_AM - 1));
    return _mm256_add_epi32(_mm256_madd_epi16(xy, not_xy), rest);
}

/* Which of 16 texels are exact. */
static inline void judge_exact(exact_texels *to, const __m256i c[3], int32_t i)
{
    const __m256i sign = words(INT16_MIN), most = words(INT16_MAX);
    const __m256i x = _mm256_xor_si256(c[0], sign), not_x = _mm256_xor_si256(c[0], most);
    const __m256i y = _mm256_xor_si256(c[1], sign), not_y = _mm256_xor_si256(c[1], most);
    const __m256i z = _mm256_xor_si256(c[2], sign), not_z = _mm256_xor_si256(c[2], most);
    const __m256i low = _mm256_mullo_epi16(z, not_z), high = _mm256_mulhi_epi16(z, not_z);
    const __m256i t =
        _mm256_packs_epi32(minus_t(_mm256_unpacklo_epi16(x, y), _mm256_unpacklo_epi16(not_x, not_y),
                                   _mm256_unpacklo_epi16(low, high)),
                           minus_t(_mm256_unpackhi_epi16(x, y), _mm256_unpackhi_epi16(not_x, not_y),
                                   _mm256_unpackhi_epi16(low, high)));
    const __m256i exact =
        _mm256_andnot_si256(_mm256_cmpgt_epi16(t, z), _mm256_cmpgt_epi16(t, not_z));
    store_eight(to->s + i, _mm256_and_si256(_mm256_sub_epi16(t, words(-1)), exact));
    store_eight(to->z + i, z);
    store_eight(to->pair + i,
                _mm256_adds_epi16(_mm256_max_epi16(x, not_x), _mm256_max_epi16(y, not_y)));
}

/*
 * Where to count 16 texels that are nearly flat, and which are too near to a limit.  With v = w - 1
 * and s = 1 - t, G = 4K v - 3v*v - 2v + 5 - 4s, and b = 2K - 1 - v.  So in Z-zero a neighbor is
 * 2 pair + s > K(v - 1) - 3v*v/4 + 1, and rounded pair + s > K v - K/2 - (3v*v + v - 1)/4, whose right
 * sides as whole numbers are
 *     v = 0: 1 - K and -K/2;  1: 0 and K/2 - 1;  2: K - 2 and more than sums are;  3: more than sums are.
 * Sums are at most K - 1, the greatest that a word holds; pair is below 1400 here.
 */
static inline __m256i place_near(__m256i *between, __m256i s, __m256i z, __m256i pair)
{
    enum { K = 32768, ONE = 8 * (16 + 1), TOP = K - 1 };
    const __m256i limits = _mm256_broadcastsi128_si256(
        _mm_setr_epi16(1 - K, 0, K - 2, TOP, -K / 2, K / 2 - 1, TOP, TOP));
    const __m256i v = _mm256_xor_si256(z, words(TOP)), v2 = _mm256_mullo_epi16(v, v);
    const __m256i q = _mm256_sub_epi16(words(16391), s), passed = _mm256_srai_epi16(q, 15);
    *between = _mm256_cmpgt_epi16(_mm256_add_epi16(v2, words(7)), _mm256_and_si256(q, words(TOP)));
    const __m256i of = _mm256_add_epi16(
        _mm256_mullo_epi16(_mm256_min_epi16(v, words(3)), words(0x202)), words(0x100));
    const __m256i limit = _mm256_shuffle_epi8(limits, of);
    const __m256i less = _mm256_shuffle_epi8(limits, _mm256_or_si256(of, words(0x808)));
    const __m256i sum = _mm256_adds_epi16(s, pair);
    const __m256i neighbor = _mm256_cmpgt_epi16(_mm256_adds_epi16(sum, pair), limit);
    const __m256i rounded = _mm256_cmpgt_epi16(sum, less);
    /* distances plus 1 above, -1 to 2 below, and what each has more */
    const __m256i part = _mm256_sign_epi16(_mm256_and_si256(passed, words(-ONE)), s);
    const __m256i is_long = _mm256_and_si256(_mm256_srai_epi16(s, 15), words(8));
    /* 128 (v + 1) + 8 is as much, modulo 2^16 */
    __m256i at = _mm256_sub_epi16(words(8), _mm256_slli_epi16(z, 7));
    at = _mm256_add_epi16(_mm256_add_epi16(at, is_long), part);
    at = _mm256_or_si256(at, _mm256_and_si256(neighbor, words(8 * NTP__EXACT_NEIGHBOR)));
    return _mm256_or_si256(at, _mm256_and_si256(rounded, words(8 * NTP__EXACT_ROUNDED)));
}

/* Eight of these, of which words hold z and t, z + 1 and -1, 0 and z: their lengths in Z-zero, less 65536, and
 * 64 xy / A_M.  `sure`: all bits, or that of close_length is in doubt.  It is done as there, but for what follows.
 * s is G - 2^30, off by 32 or less, and M*M + 2^30, whose sum is off by 256.  And (s r)/M stands for k/M, which
 * is off by 2^-17 and a little. */
static inline __m256i far_length(__m256i *sure, __m256i *steep, __m256i zt, __m256i by,
                                 __m256i high)
{
    enum { MORE = 1 << 30, M2_LESS_3 = (int32_t) (65535U * 65535U - 3U) };
    const float m = 65535, margin = 0x1p-16f;
    const __m256i e = _mm256_madd_epi16(zt, by);
    const __m256i rest_g = _mm256_add_epi32(high, _mm256_madd_epi16(zt, eight(0x1ffff)));
    const __m256i g = _mm256_sub_epi32(_mm256_sub_epi32(rest_g, e), _mm256_add_epi32(e, e));
    *steep = steepness(_mm256_sub_epi32(eight(CLOSE_AM - 1), e));
    const __m256 s = _mm256_add_ps(_mm256_cvtepi32_ps(g), _mm256_set1_ps(m * m + MORE));
    const __m256 guess = _mm256_rsqrt_ps(s), half = _mm256_mul_ps(s, _mm256_set1_ps(0.5f));
    const __m256 error = _mm256_mul_ps(_mm256_mul_ps(half, guess), guess);
    const __m256 r = _mm256_mul_ps(guess, _mm256_sub_ps(_mm256_set1_ps(1.5f), error));
    const __m256 root = _mm256_mul_ps(s, r);
    const __m256i k = _mm256_cvtps_epi32(root);
    const __m256i square = _mm256_add_epi32(g, eight(M2_LESS_3 + MORE));
    const __m256 rest = _mm256_cvtepi32_ps(_mm256_sub_epi32(square, _mm256_mullo_epi32(k, k)));
    const __m256 part = _mm256_mul_ps(rest, _mm256_mul_ps(r, _mm256_set1_ps(32768.0f / m)));
    const __m256 more =
        _mm256_add_ps(_mm256_mul_ps(root, _mm256_set1_ps(1.0f / m)), _mm256_set1_ps(0.5f - margin));
    const __m256 up = _mm256_add_ps(part, more);
    const __m256i down = _mm256_cvttps_epi32(up);
    *sure = _mm256_cmpeq_epi32(down,
                               _mm256_cvttps_epi32(_mm256_add_ps(up, _mm256_set1_ps(2 * margin))));
    return _mm256_add_epi32(_mm256_sub_epi32(k, eight(NTP__LENGTH_ONE)), down);
}

/* The lengths of 16, where any is in doubt. */
SELDOM static void far_lengths_again(int16_t *longer, const int16_t *z, const int16_t *s)
{
    for (int32_t i = 0; i < EXACT_STEP; i++) {
        const int32_t e = z[i] * (z[i] + 1) - 1 + s[i];
        const double b = CLOSE_K + z[i];
        const int32_t length = ntp__fixed_length(4.0 * (CLOSE_AM - 1 - e) + 2.0 + b * b, 65535);
        longer[i] = (int16_t) (length - NTP__LENGTH_ONE);
    }
}

/* The same of the texels that are steeper, 16 at a time; also sums them.  Lengths are at most 2/sqrt(3), which
 * is 10,139 above 65536: the squares of 34 fit. */
static void place_far(far_sums *sums, exact_texels *v)
{
    enum { BY = NTP__CLOSE_COPIES };
    const __m256i zero = _mm256_setzero_si256(), ones = eight(-1);
    const __m256i copies = _mm256_and_si256(
        _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7), words(BY - 1));
    far_sums f = { zero, zero, ones, zero, zero };
    for (int32_t i = 0; i < v->steep; i += EXACT_STEP) {
        const __m256i s = load_eight(v->steep_s + i), z = load_eight(v->steep_z + i);
        const __m256i none = _mm256_cmpeq_epi16(s, zero), t = _mm256_sub_epi16(words(1), s);
        const __m256i t2 = _mm256_adds_epi16(t, t), z1 = _mm256_sub_epi16(z, ones);
        __m256i sure[2], steep[2];
        __m256i longer = _mm256_packs_epi32(
            far_length(&sure[0], &steep[0], _mm256_unpacklo_epi16(z, t),
                       _mm256_unpacklo_epi16(z1, ones), _mm256_unpacklo_epi16(zero, z)),
            far_length(&sure[1], &steep[1], _mm256_unpackhi_epi16(z, t),
                       _mm256_unpackhi_epi16(z1, ones), _mm256_unpackhi_epi16(zero, z)));
        if (lanes_of(_mm256_and_si256(sure[0], sure[1])) != 255) {
            int16_t again[EXACT_STEP];
            far_lengths_again(again, v->steep_z + i, v->steep_s + i);
            longer = load_eight(again);
        }
        longer = kept(longer, none);
        f.longer = _mm256_add_epi32(f.longer, _mm256_madd_epi16(longer, words(1)));
        f.squares = _mm256_add_epi32(f.squares, _mm256_madd_epi16(longer, longer));
        f.shortest = _mm256_min_epu16(f.shortest, _mm256_add_epi16(longer, ones)); /* none is 0 */
        f.longest = _mm256_max_epu16(f.longest, longer);
        __m256i off = _mm256_sub_epi16(words(CLOSE_K - 1 + NTP__EXACT_LESS - 1), z);
        off = _mm256_sub_epi16(off, _mm256_cmpgt_epi16(t2, z1));
        off = _mm256_sub_epi16(off, _mm256_cmpgt_epi16(t2, _mm256_sub_epi16(zero, z)));
        off = kept(off, none);
        f.most = _mm256_max_epu16(f.most, off);
        store_eight(v->off + i, off);
        /* how many limits t has passed, negative */
        const __m256i passed = _mm256_add_epi16(
            _mm256_add_epi16(_mm256_cmpgt_epi16(t, words(NTP__CLOSE_T_ONE - 1)),
                             _mm256_cmpgt_epi16(t, words(NTP__CLOSE_T_LONGER - 1))),
            _mm256_cmpgt_epi16(t, zero));
        __m256i at = _mm256_slli_epi16(_mm256_srli_epi16(longer, 9), 10);
        at = _mm256_add_epi16(at, _mm256_slli_epi16(_mm256_packs_epi32(steep[0], steep[1]), 4));
        at = _mm256_sub_epi16(_mm256_add_epi16(at, words(NTP__EXACT_FAR)),
                              _mm256_slli_epi16(passed, 2));
        /* what is forgotten has places as copies have */
        store_eight(v->far + i, _mm256_add_epi16(kept(at, none), copies));
    }
    *sums = f;
}

ONE_COPY static uint32_t least_of_words(__m256i v)
{
    const __m128i half = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return (uint32_t) _mm_cvtsi128_si32(_mm_minpos_epu16(half)) & 65535;
}

static void survey_exact(ntp__survey *out, exact_texels *to, const uint16_t *src, int32_t n)
{
    const __m256i zero = _mm256_setzero_si256(), ones = eight(-1);
    exact_survey s = { { zero, zero, zero }, { ones, ones, ones }, { zero, zero, zero } };
    __m256i c[3];
    for (int32_t i = 0; i < n; i += EXACT_STEP) {
        load_exact(c, src + 3 * i);
        judge_exact(to, c, i);
        UNROLLED
        for (int k = 0; k < 3; k++) {
            const __m256i signed_level = _mm256_xor_si256(c[k], words(INT16_MIN));
            s.sum[k] = _mm256_add_epi32(s.sum[k], _mm256_madd_epi16(signed_level, words(1)));
            s.least[k] = _mm256_min_epu16(s.least[k], c[k]);
            s.greatest[k] = _mm256_max_epu16(s.greatest[k], c[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        out->sum[k] = (uint32_t) (sum_of_eight(s.sum[k]) + CLOSE_K * n);
        out->least[k] = least_of_words(s.least[k]);
        out->greatest[k] = 65535 - least_of_words(_mm256_xor_si256(s.greatest[k], ones));
    }
}

static void end_far(ntp__exact_block *out, const far_sums *s)
{
    const __m256i ones = eight(-1);
    out->length_sum = (uint32_t) sum_of_eight(s->longer);
    out->length_error2 = sum_of_squares(s->squares);
    out->least = least_of_words(s->shortest) + 1;
    out->greatest = 65535 - least_of_words(_mm256_xor_si256(s->longest, ones));
    out->levels_off_max = 65535 - NTP__EXACT_LESS - least_of_words(_mm256_xor_si256(s->most, ones));
}

/* Counts at n places, whole groups. */
ONE_COPY static void count_at(uint32_t *counts, const uint16_t *at, int32_t n)
{
    for (int32_t i = 0; i < n; i += 8) {
        UNROLLED
        for (int32_t k = 0; k < 8; k++)
            counts[at[i + k]]++;
    }
}

/* Brings up 16 texels of the next block, if there is one, while this one is counted. */
static inline void prefetch_exact(const uint16_t *p)
{
    _mm_prefetch((const char *) p, _MM_HINT_T0);
    _mm_prefetch((const char *) p + 64, _MM_HINT_T0);
}

/* Which words of four are kept, for each mask of four. */
#  define KEEP(a, b, c, d)                                                                         \
      { 2 * (a), 2 * (a) + 1, 2 * (b), 2 * (b) + 1, 2 * (c), 2 * (c) + 1, 2 * (d), 2 * (d) + 1 }
static const uint8_t KEPT[16][8] = {
    KEEP(0, 0, 0, 0), KEEP(0, 0, 0, 0), KEEP(1, 0, 0, 0), KEEP(0, 1, 0, 0),
    KEEP(2, 0, 0, 0), KEEP(0, 2, 0, 0), KEEP(1, 2, 0, 0), KEEP(0, 1, 2, 0),
    KEEP(3, 0, 0, 0), KEEP(0, 3, 0, 0), KEEP(1, 3, 0, 0), KEEP(0, 1, 3, 0),
    KEEP(2, 3, 0, 0), KEEP(0, 2, 3, 0), KEEP(1, 2, 3, 0), KEEP(0, 1, 2, 3),
};
#  undef KEEP

static inline void keep_words(int16_t *to, const int16_t *from, __m128i which)
{
    const __m128i four = _mm_loadl_epi64((const __m128i *) (const void *) from);
    _mm_storel_epi64((__m128i *) (void *) to, _mm_shuffle_epi8(four, which));
}

/* Takes those of 16 texels from i on that are steep.  Branches would be taken at random. */
static inline void take_steep(exact_texels *v, int32_t i, __m256i far)
{
    const __m128i bytes =
        _mm_packs_epi16(_mm256_castsi256_si128(far), _mm256_extracti128_si256(far, 1));
    uint32_t bits = (uint32_t) _mm_movemask_epi8(bytes);
    for (int32_t k = 0; k < EXACT_STEP; k += 4, bits >>= 4) {
        const __m128i which = _mm_loadl_epi64((const __m128i *) (const void *) KEPT[bits & 15]);
        keep_words(v->steep_s + v->steep, v->s + i + k, which);
        keep_words(v->steep_z + v->steep, v->z + i + k, which);
        v->steep += (int32_t) (COUNTS >> 4 * (bits & 15) & 15);
    }
}

/* Places 16 texels, but steep ones, which are taken or noted, and notes which wait. */
static inline void place_exact(exact_texels *v, int32_t i)
{
    const __m256i lanes = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i s = load_eight(v->s + i), z = load_eight(v->z + i);
    const __m256i bad = _mm256_cmpeq_epi16(s, _mm256_setzero_si256());
    const __m256i far = kept(_mm256_cmpgt_epi16(words(CLOSE_K - NTP__EXACT_NEAR), z), bad);
    const __m256i others = _mm256_or_si256(bad, far);
    __m256i wait = bad;
    if (bits_of(others) != EVERY) {
        __m256i between;
        const __m256i at = place_near(&between, s, z, load_eight(v->pair + i));
        const __m256i none = _mm256_or_si256(others, between);
        store_eight(v->at + v->near_ones, _mm256_add_epi16(kept(at, none), lanes));
        v->near_ones += EXACT_STEP;
        wait = kept(none, far);
    }
    _mm_storeu_si128(
        (__m128i *) (void *) (v->wait + i),
        _mm_packs_epi16(_mm256_castsi256_si128(wait), _mm256_extracti128_si256(wait, 1)));
    if (bits_of(far) != 0)
        take_steep(v, i, far);
}

/* The places of those that wait; many at once, as the end of a loop is not foreseen. */
static inline int32_t list_waiting(int32_t *left, const exact_texels *v, int32_t n)
{
    enum { AT_ONCE = 64 };
    int32_t found = 0;
    for (int32_t i = 0; i < n; i += AT_ONCE) {
        const uint32_t low = (uint32_t) _mm256_movemask_epi8(load_eight(v->wait + i));
        const uint32_t high = (uint32_t) _mm256_movemask_epi8(load_eight(v->wait + i + 32));
        for (uint64_t all = low | (uint64_t) high << 32; all != 0; all &= all - 1)
            left[found++] = i + __builtin_ctzll(all);
    }
    return found;
}

static int32_t count_exact(ntp__exact_block *out, ntp__close_counts *counts, const uint16_t *src,
                           int32_t n)
{
    enum { BLOCK = 256 };
    exact_texels v;
    n = n < BLOCK ? n & -EXACT_STEP : BLOCK;
    v.near_ones = v.steep = 0;
    if (n < BLOCK)
        memset(v.wait, 0, sizeof v.wait);
    survey_exact(&out->survey, &v, src, n);
    for (int32_t i = 0; i < n; i += EXACT_STEP) {
        prefetch_exact(src + 3 * (n + i));
        place_exact(&v, i);
    }
    out->far = v.steep;
    memset(v.steep_s + v.steep, 0, EXACT_STEP * sizeof v.steep_s[0]);
    memset(v.steep_z + v.steep, 0, EXACT_STEP * sizeof v.steep_z[0]);
    count_at(counts->exact, v.at, v.near_ones);
    if (v.steep > 0) {
        far_sums s;
        place_far(&s, &v);
        count_at(counts->exact, v.far, v.steep);
        count_at(counts->exact_off, v.off, v.steep);
        end_far(out, &s);
    }
    out->texels = n - list_waiting(out->left, &v, n);
    return n;
}
#else
#  define count_exact NULL
#endif
