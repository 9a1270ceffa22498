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
    /* Of those that are steeper than nearly flat, in groups of eight; an s of 0: of none. */
    int16_t steep_s[256 + 8], steep_z[256 + 8];
    uint8_t from[256], few[256]; /* where these are; where those are that are in no group yet */
    /* Where to count in exact: nearly flat ones, and steeper ones; and these in exact_off (close.h). */
    uint16_t at[256], far[256], off[256];
    int32_t few_ones, steep, near_ones; /* how many; of the latter two, with those of none */
} exact_texels;

/* Of red, green and blue: sums of eight lanes, and extremes of 16. */
typedef struct exact_survey {
    __m256i sum[3], least[3], greatest[3];
} exact_survey;

/* Of texels that are steeper than nearly flat. */
typedef struct far_sums {
    __m256i longer, squares, shortest, longest, most, texels;
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

static inline __m256i words_of(const int16_t *p)
{
    return _mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i *) (const void *) p));
}

static inline void store_words(uint16_t *p, __m256i v)
{
    const __m256i two = _mm256_packus_epi32(v, v);
    _mm_storeu_si128((__m128i *) (void *) p,
                     _mm256_castsi256_si128(_mm256_permute4x64_epi64(two, 0x08)));
}

/* Eight steeper texels but bad ones. */
static inline void add_far(far_sums *s, __m256i off, __m256i longer, __m256i bad)
{
    const __m256i length = kept(longer, bad);
    s->most = _mm256_max_epi32(s->most, off);
    s->longer = _mm256_add_epi32(s->longer, length);
    s->squares = _mm256_add_epi32(s->squares, _mm256_madd_epi16(length, length));
    s->shortest = _mm256_min_epu32(s->shortest, _mm256_or_si256(length, bad));
    s->longest = _mm256_max_epi32(s->longest, length);
    s->texels = _mm256_add_epi32(s->texels, kept(eight(1), bad));
}

/* The same of the texels that are steeper; also sums them.  Puts those in doubt behind `left` others, and
 * returns how many these are then.  Lengths are at most 2/sqrt(3), which is 10,139 above 65536: the squares
 * of 32 fit. */
static int32_t place_far(far_sums *sums, exact_texels *v, int32_t *others, int32_t left)
{
    const __m256i zero = _mm256_setzero_si256(), one = eight(1);
    far_sums s = { zero, zero, eight(-1), zero, zero, zero };
    for (int32_t i = 0; i < v->steep; i += 8) {
        const __m256i rest = words_of(v->steep_s + i), z = words_of(v->steep_z + i);
        const __m256i none = _mm256_cmpeq_epi32(rest, zero), t = _mm256_sub_epi32(one, rest);
        const __m256i t2 = _mm256_add_epi32(t, t), z1 = _mm256_add_epi32(z, one);
        const __m256i b = _mm256_add_epi32(z, eight(CLOSE_K));
        const __m256i e = _mm256_sub_epi32(_mm256_mullo_epi32(z, z1), t);
        const __m256i g = _mm256_sub_epi32(_mm256_mullo_epi32(b, b), _mm256_slli_epi32(e, 2));
        __m256i between;
        const __m256i longer = _mm256_sub_epi32(close_length(&between, g), eight(NTP__LENGTH_ONE));
        const __m256i bad = _mm256_or_si256(between, none);
        /* how many limits t has passed, negative */
        __m256i passed = _mm256_add_epi32(_mm256_cmpgt_epi32(t, eight(NTP__CLOSE_T_ONE - 1)),
                                          _mm256_cmpgt_epi32(t, eight(NTP__CLOSE_T_LONGER - 1)));
        passed = _mm256_add_epi32(passed, _mm256_cmpgt_epi32(t, zero));
        __m256i off = _mm256_sub_epi32(eight(CLOSE_K - 1), z);
        off = _mm256_sub_epi32(off, _mm256_cmpgt_epi32(t2, z1));
        off = kept(_mm256_sub_epi32(off, _mm256_cmpgt_epi32(_mm256_add_epi32(t2, z), zero)), bad);
        add_far(&s, off, longer, bad);
        __m256i at = _mm256_slli_epi32(_mm256_srli_epi32(longer, 9), 10);
        at = _mm256_add_epi32(
            at, _mm256_slli_epi32(steepness(_mm256_sub_epi32(eight(CLOSE_AM - 1), e)), 4));
        at = _mm256_sub_epi32(at, _mm256_slli_epi32(passed, 2));
        at = _mm256_add_epi32(at, _mm256_add_epi32(own_copies(), eight(NTP__EXACT_FAR)));
        /* as many places as lanes for what is forgotten */
        const __m256i forgotten = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        store_words(v->far + i, _mm256_blendv_epi8(at, forgotten, bad));
        off = _mm256_add_epi32(off, eight(7));
        store_words(v->off + i, _mm256_blendv_epi8(off, forgotten, bad));
        for (uint32_t doubt = lanes_of(kept(between, none)); doubt != 0; doubt &= doubt - 1)
            others[left++] = v->from[i + __builtin_ctz(doubt)];
    }
    *sums = s;
    return left;
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
    out->far = sum_of_eight(s->texels);
    out->length_sum = (uint32_t) sum_of_eight(s->longer);
    out->length_error2 = sum_of_squares(s->squares);
    out->least = ~greatest_of_eight(_mm256_xor_si256(s->shortest, eight(-1)));
    out->greatest = greatest_of_eight(s->longest);
    out->levels_off_max = greatest_of_eight(s->most) - 1;
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

/* Takes those of eight texels from i on that are steep as a group, or notes them if they are few: a group
 * costs as much as gathering five. */
static inline void take_steep(exact_texels *v, int32_t i, __m128i far)
{
    enum { FEW = 4 };
    const uint64_t places =
        UINT64_C(0x0706050403020100) + UINT64_C(0x0101010101010101) * (uint32_t) i;
    const uint32_t bits = (uint32_t) _mm_movemask_epi8(_mm_packs_epi16(far, far)) & 255;
    if (__builtin_popcount(bits) <= FEW) {
        v->few_ones += find_four_bytes(v->few + v->few_ones, i, bits & 15);
        v->few_ones += find_four_bytes(v->few + v->few_ones, i + 4, bits >> 4);
        return;
    }
    const __m128i *const s = (const __m128i *) (const void *) (v->s + i),
                         *const z = (const __m128i *) (const void *) (v->z + i);
    _mm_storeu_si128((__m128i *) (void *) (v->steep_s + v->steep),
                     _mm_and_si128(_mm_loadu_si128(s), far));
    _mm_storeu_si128((__m128i *) (void *) (v->steep_z + v->steep), _mm_loadu_si128(z));
    memcpy(v->from + v->steep, &places, sizeof places);
    v->steep += 8;
}

/* Makes groups of the few that were noted, and fills up the last one. */
static inline void gather_few(exact_texels *v)
{
    for (int32_t i = 0; i < v->few_ones; i++, v->steep++) {
        v->from[v->steep] = v->few[i];
        v->steep_s[v->steep] = v->s[v->few[i]];
        v->steep_z[v->steep] = v->z[v->few[i]];
    }
    memset(v->steep_s + v->steep, 0, 8 * sizeof v->steep_s[0]);
    memset(v->steep_z + v->steep, 0, 8 * sizeof v->steep_z[0]);
}

/* Places 16 texels, but steep ones, which are taken or noted; returns the bits of those that wait. */
static inline uint32_t place_exact(exact_texels *v, int32_t i)
{
    const __m256i lanes = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i s = load_eight(v->s + i), z = load_eight(v->z + i);
    const __m256i bad = _mm256_cmpeq_epi16(s, _mm256_setzero_si256());
    if (bits_of(bad) == EVERY)
        return EVERY;
    const __m256i far = kept(_mm256_cmpgt_epi16(words(CLOSE_K - NTP__EXACT_NEAR), z), bad);
    __m256i none = _mm256_or_si256(bad, far);
    uint32_t wait = bits_of(bad);
    if (bits_of(none) != EVERY) {
        __m256i between;
        const __m256i at = place_near(&between, s, z, load_eight(v->pair + i));
        none = _mm256_or_si256(none, between);
        store_eight(v->at + v->near_ones, _mm256_add_epi16(kept(at, none), lanes));
        v->near_ones += EXACT_STEP;
        wait = bits_of(kept(none, far));
    }
    if (bits_of(far) != 0) {
        take_steep(v, i, _mm256_castsi256_si128(far));
        take_steep(v, i + 8, _mm256_extracti128_si256(far, 1));
    }
    return wait;
}

static int32_t count_exact(ntp__exact_block *out, ntp__close_counts *counts, const uint16_t *src,
                           int32_t n)
{
    enum { BLOCK = 256 };
    exact_texels v;
    int32_t left = 0;
    n = n < BLOCK ? n & -EXACT_STEP : BLOCK;
    v.near_ones = v.few_ones = v.steep = 0;
    survey_exact(&out->survey, &v, src, n);
    for (int32_t i = 0; i < n; i += EXACT_STEP) {
        prefetch_exact(src + 3 * (n + i));
        for (uint32_t others = place_exact(&v, i); others != 0; others &= others - 1)
            out->left[left++] = i + __builtin_ctz(others) / 2;
    }
    gather_few(&v);
    out->far = 0;
    count_at(counts->exact, v.at, v.near_ones);
    if (v.steep > 0) {
        far_sums s;
        left = place_far(&s, &v, out->left, left);
        count_at(counts->exact, v.far, v.steep);
        count_at(counts->exact_off, v.off, v.steep);
        end_far(out, &s);
    }
    out->texels = n - left;
    return n;
}
#else
#  define count_exact NULL
#endif
