/* SPDX-License-Identifier: MIT */
/*
 * convert_words_tmpl.h - the most common conversions of packed RGB; a part of convert_avx2.c
 *
 * Sixteen texels a step, whose levels of 8 bit are words, as are their exactness and their roots.  Each
 * half of a vector is of eight texels.
 */

/* Steps that are looked at before their roots are taken: of one chain of all that, few would be in
 * flight.  There is a bit for each. */
enum { STEPS = 32 };

enum { AHEAD = 8192 /* bytes, as processors themselves fetch no more than the page */ };

static inline void store_whole(uint8_t *d, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) d, v);
}

/* t where z is 2t + 1 or -(2t + 1), of blues with their first bit set or not, as `up` says. */
static inline __m256i size_of_z(__m256i b, __m256i up, int16_t most)
{
    return _mm256_andnot_si256(_mm256_xor_si256(b, up), _mm256_set1_epi16(most));
}

/* Marks texels that are exact: d = e - t^2 is from 0 to 2t. */
static inline __m256i exact_words(__m256i d, __m256i t)
{
    const __m256i twice = _mm256_add_epi16(t, t);
    return _mm256_cmpeq_epi16(_mm256_max_epu16(d, twice), twice);
}

/* Sixteen texels of 8 bit: their bytes as they lie, pairs, 257 times their blues, t of these, e and
 * d = e - t^2, which is never below -2^15.  `up`: -1 where z > 0. */
typedef struct byte_words {
    __m256i low, high, rg, b, up, t, e, d;
} byte_words;

static inline byte_words words_of(__m256i low, __m256i high)
{
    byte_words in = { .low = low, .high = high };
    in.rg = pairs_of(in.low, in.high);
    in.b = _mm256_or_si256(SHUFFLE(in.low, 2, 2, 5, 5, 8, 8, 11, 11, 14, 14, N, N, N, N, N, N),
                           SHUFFLE(in.high, N, N, N, N, N, N, N, N, N, N, 9, 9, 12, 12, 15, 15));
    in.up = _mm256_srai_epi16(in.b, 15);
    in.t = size_of_z(in.b, in.up, 127);
    in.e = rest_words(in.rg);
    in.d = _mm256_sub_epi16(in.e, _mm256_mullo_epi16(in.t, in.t));
    return in;
}

static inline byte_words take_bytes(const uint8_t *s)
{
    return words_of(load_apart(s, 24), load_apart(s + 8, 24));
}

/*
 * From 8 bit to 16, T = floor(257 sqrt(e + 3/4)).  Where t^2 <= e <= t^2 + 2t that is within 128 of
 * 257t + 128, which is that of 257 times the blue, and nowhere else.  So T tells which texels are exact.
 * e < 0 are words from 49279 on, and get the greatest T, which is that of the blues 0 and 255.
 */
enum { WITHIN = 128 };

/* With this for 3/4, floats give T of all e that pairs of levels have. */
#define THREE_QUARTERS 0x1.7fbp-1F

/* Sixteen texels, half of them at a time: e, and 257 times their blues, in the order in which blues lie in
 * the words of three vectors, where each place is that of one vector only. */
typedef struct wide_words {
    __m256i e, b;
} wide_words;

static inline wide_words look_wide(const uint8_t *s)
{
    const __m256i low = load_apart(s, 24), high = load_apart(s + 8, 24);
    const wide_words w = { rest_words(_mm256_or_si256(
                               SHUFFLE(low, 6, 7, N, N, 0, 1, 9, 10, N, N, 3, 4, 12, 13, N, N),
                               SHUFFLE(high, N, N, 7, 8, N, N, N, N, 10, 11, N, N, N, N, 13, 14))),
                           _mm256_or_si256(
                               SHUFFLE(low, 8, 8, N, N, 2, 2, 11, 11, N, N, 5, 5, 14, 14, N, N),
                               SHUFFLE(high, N, N, 9, 9, N, N, N, N, 12, 12, N, N, N, N, 15, 15)) };
    return w;
}

static inline __m256i deep_root(__m256i e)
{
    const __m256 v = _mm256_add_ps(_mm256_cvtepi32_ps(e), _mm256_set1_ps(THREE_QUARTERS));
    return _mm256_cvttps_epi32(_mm256_sqrt_ps(_mm256_mul_ps(v, _mm256_set1_ps(257 * 257))));
}

/* Standard, 8 bit to 16. */
static inline void widen_step(uint8_t *d, const uint8_t *s, const wide_words *of)
{
    const __m256i low = load_apart(s, 24), high = load_apart(s + 8, 24), b = of->b;
    const __m256i zero = _mm256_setzero_si256();
    const __m256i t = _mm256_packs_epi32(deep_root(_mm256_unpacklo_epi16(of->e, zero)),
                                         deep_root(_mm256_unpackhi_epi16(of->e, zero)));
    /* 32768 + T, or 32767 - T */
    const __m256i sign = _mm256_xor_si256(_mm256_srai_epi16(b, 15), _mm256_set1_epi16(32767));
    const __m256i want = _mm256_xor_si256(t, sign);
    const __m256i off = _mm256_abs_epi16(_mm256_sub_epi16(want, b));
    const __m256i z =
        _mm256_blendv_epi8(want, b, _mm256_cmpgt_epi16(off, _mm256_set1_epi16(WITHIN)));
    const __m256i first =
        _mm256_blend_epi16(SHUFFLE(low, 0, 0, 1, 1, N, N, 3, 3, 4, 4, N, N, 6, 6, 7, 7), z, 0x24);
    const __m256i next = _mm256_blend_epi16(
        SHUFFLE(low, N, N, 9, 9, 10, 10, N, N, 12, 12, 13, 13, N, N, 15, 15), z, 0x49);
    const __m256i last = _mm256_blend_epi16(
        SHUFFLE(high, 8, 8, N, N, 10, 10, 11, 11, N, N, 13, 13, 14, 14, N, N), z, 0x92);
    store_whole(d, _mm256_permute2x128_si256(first, next, 0x20));
    store_whole(d + 32, _mm256_blend_epi32(last, first, 0xf0));
    store_whole(d + 64, _mm256_permute2x128_si256(next, last, 0x31));
}

/* Sixteen texels of 16 bit: their bytes as they lie, red and green of half of them, blues, t of these and
 * d = e - t^2 where that is from 0 to 2t, and no such number elsewhere. */
typedef struct deep_words {
    __m256i v[3], low, high, b, up, t, d;
} deep_words;

/* e + 1 - t^2 of half of them, t in halves of 32 bits. */
static inline __m256i deep_rest(__m256i rg, __m256i t)
{
    return _mm256_sub_epi32(_mm256_add_epi32(rest_of(rg, true), _mm256_set1_epi32(1)),
                            _mm256_madd_epi16(t, t));
}

static inline deep_words take_deep(const uint8_t *s)
{
    const __m256i p = load_apart(s, 48), q = load_apart(s + 16, 48);
    const __m256i r = load_apart(s + 32, 48), zero = _mm256_setzero_si256();
    deep_words in = { .v = { p, q, r } };
    in.low = _mm256_or_si256(SHUFFLE(p, 0, 1, 2, 3, 6, 7, 8, 9, 12, 13, 14, 15, N, N, N, N),
                             SHUFFLE(q, N, N, N, N, N, N, N, N, N, N, N, N, 2, 3, 4, 5));
    in.high = _mm256_or_si256(SHUFFLE(q, 8, 9, 10, 11, 14, 15, N, N, N, N, N, N, N, N, N, N),
                              SHUFFLE(r, N, N, N, N, N, N, 0, 1, 4, 5, 6, 7, 10, 11, 12, 13));
    in.b = SHUFFLE(_mm256_blend_epi16(_mm256_blend_epi16(p, q, 0x49), r, 0x92), 4, 5, 10, 11, 0, 1,
                   6, 7, 12, 13, 2, 3, 8, 9, 14, 15);
    in.up = _mm256_srai_epi16(in.b, 15);
    in.t = size_of_z(in.b, in.up, 32767);
    /* d + 1 has no sign: what is below 1 becomes 0, and -1 then is beyond all. */
    in.d =
        _mm256_add_epi16(_mm256_packus_epi32(deep_rest(in.low, _mm256_unpacklo_epi16(in.t, zero)),
                                             deep_rest(in.high, _mm256_unpackhi_epi16(in.t, zero))),
                         _mm256_set1_epi16(-1));
    return in;
}

/* floor((c + 128) / 257) */
static inline __m256i narrowed(__m256i c)
{
    return over257(_mm256_adds_epu16(c, _mm256_set1_epi16(128)));
}

/* Sixteen texels, 16 bit to 8, by value.  Returns whether all blues are the derived ones at 8 bit, and so
 * are right. */
static inline bool narrow_step(uint8_t *d, const uint8_t *s)
{
    const __m256i p = narrowed(load_apart(s, 48)), q = narrowed(load_apart(s + 16, 48));
    const __m256i r = narrowed(load_apart(s + 32, 48));
    const byte_words to = words_of(_mm256_packus_epi16(p, q), _mm256_packus_epi16(q, r));
    _mm_prefetch((const char *) s + AHEAD, _MM_HINT_T0);
    _mm_prefetch((const char *) s + AHEAD + 64, _MM_HINT_T0);
    const __m128i last = _mm256_extracti128_si256(to.low, 1);
    store(d, _mm256_castsi256_si128(to.low));
    store(d + 16, _mm_alignr_epi8(last, _mm256_castsi256_si128(to.high), 8));
    store(d + 32, _mm256_extracti128_si256(to.high, 1));
    return _mm256_movemask_epi8(exact_words(to.d, to.t)) == -1;
}

/* Derives blues anew where they were exact.  False where such a texel has to be pulled. */
static inline bool renew_step(uint8_t *d, const uint8_t *s)
{
    const deep_words in = take_deep(s);
    const __m256i exact = exact_words(in.d, in.t);
    if (_mm256_testz_si256(exact, exact))
        return true;
    byte_words to = take_bytes(d);
    const __m256i t = _mm256_xor_si256(root_words(to.e), to.up);
    const __m256i want = _mm256_xor_si256(t, _mm256_set1_epi16(127));
    if (!_mm256_testz_si256(_mm256_and_si256(exact, to.e), _mm256_set1_epi16(-32768)))
        return false;
    put_words(d, &to.low, &to.high, _mm256_blendv_epi8(to.b, want, exact));
    return true;
}

/* Blues of Z-zero, as blue_of where texels are exact: 2t, 2t + 1 or 2t + 2; else |Z| = 2t + 1.  With
 * d = e - t^2 and h = floor(t / 2), 2d < t - 1 is d < h, and 2d < 3t is d < 2t - h.  Words of 16 bit
 * have no sign. */
static inline __m256i zzero_of(__m256i t, __m256i d, __m256i exact, bool deep)
{
    const __m256i sign = _mm256_set1_epi16(deep ? -32768 : 0), one = _mm256_set1_epi16(1);
    const __m256i twice = _mm256_add_epi16(t, t), half = _mm256_srli_epi16(t, 1);
    const __m256i at = _mm256_xor_si256(d, sign);
    const __m256i below1 = _mm256_cmpgt_epi16(_mm256_xor_si256(half, sign), at);
    const __m256i below2 =
        _mm256_cmpgt_epi16(_mm256_xor_si256(_mm256_sub_epi16(twice, half), sign), at);
    const __m256i more = _mm256_add_epi16(_mm256_add_epi16(below1, below2), one);
    return _mm256_add_epi16(_mm256_add_epi16(twice, one), _mm256_and_si256(more, exact));
}

static inline void count_up(__m256i up, __m256i black, uint64_t *bytes)
{
    const uint32_t bits = (uint32_t) _mm256_movemask_epi8(_mm256_or_si256(up, black));
    *bytes += (uint64_t) __builtin_popcount(bits);
}

/* Of 16 bit.  Black ones stay so where these are `unused`. */
static inline void deep_zzero_step(uint8_t *d, const uint8_t *s, __m256i unused, uint64_t *up)
{
    const deep_words in = take_deep(s);
    const __m256i zero = _mm256_setzero_si256();
    const __m256i none =
        _mm256_packs_epi32(_mm256_cmpeq_epi32(in.low, zero), _mm256_cmpeq_epi32(in.high, zero));
    const __m256i black =
        _mm256_and_si256(_mm256_and_si256(none, _mm256_cmpeq_epi16(in.b, zero)), unused);
    count_up(in.up, black, up);
    /* Back to where blues lie in the three vectors. */
    const __m256i sizes = zzero_of(in.t, in.d, exact_words(in.d, in.t), true);
    const __m256i z = SHUFFLE(_mm256_andnot_si256(black, sizes), 4, 5, 10, 11, 0, 1, 6, 7, 12, 13,
                              2, 3, 8, 9, 14, 15);
    store_two(d, d + 48, _mm256_blend_epi16(in.v[0], z, 0x24));
    store_two(d + 16, d + 64, _mm256_blend_epi16(in.v[1], z, 0x49));
    store_two(d + 32, d + 80, _mm256_blend_epi16(in.v[2], z, 0x92));
}

/* 8 bit, standard to Z-zero. */
static inline void zzero_step(uint8_t *d, const uint8_t *s, __m256i unused, uint64_t *up)
{
    byte_words in = take_bytes(s);
    const __m256i none = _mm256_cmpeq_epi16(_mm256_or_si256(in.rg, in.b), _mm256_setzero_si256());
    const __m256i black = _mm256_and_si256(none, unused);
    const __m256i sizes = zzero_of(in.t, in.d, exact_words(in.d, in.t), false);
    count_up(in.up, black, up);
    put_words(d, &in.low, &in.high, _mm256_andnot_si256(black, sizes));
}

static int32_t widen(uint8_t *d, const uint8_t *s, int32_t n)
{
    wide_words steps[STEPS];
    const int32_t all = n / STEP;
    for (int32_t i = 0; i < all; i += STEPS) {
        const int32_t count = all - i < STEPS ? all - i : STEPS;
        for (int32_t k = 0; k < count; k++)
            steps[k] = look_wide(s + (ptrdiff_t) 3 * STEP * (i + k));
        for (int32_t k = 0; k < count; k++)
            widen_step(d + (ptrdiff_t) 6 * STEP * (i + k), s + (ptrdiff_t) 3 * STEP * (i + k),
                       &steps[k]);
    }
    return all * STEP;
}

/* Renews those of the steps that have a bit.  Returns the first one that has to be pulled, or STEPS. */
ONE_COPY static int32_t renew_steps(uint8_t *d, const uint8_t *s, uint32_t left)
{
    for (; left != 0; left &= left - 1) {
        const int32_t k = __builtin_ctz(left);
        if (!renew_step(d + (ptrdiff_t) 3 * STEP * k, s + (ptrdiff_t) 6 * STEP * k))
            return k;
    }
    return STEPS;
}

static int32_t narrow(uint8_t *d, const uint8_t *s, int32_t n)
{
    const int32_t all = n / STEP;
    for (int32_t i = 0; i < all;
         i += STEPS, d += (ptrdiff_t) 3 * STEP * STEPS, s += (ptrdiff_t) 6 * STEP * STEPS) {
        const int32_t count = all - i < STEPS ? all - i : STEPS;
        uint32_t left = 0; /* not a list in memory, whose stores hold up loads */
        for (int32_t k = 0; k < count; k++)
            left |=
                (uint32_t) !narrow_step(d + (ptrdiff_t) 3 * STEP * k, s + (ptrdiff_t) 6 * STEP * k)
                << k;
        const int32_t end = left != 0 ? renew_steps(d, s, left) : STEPS;
        if (end < STEPS)
            return STEP * (i + end);
    }
    return STEP * all;
}

FOR_EACH_DEPTH int32_t to_zzero(uint8_t *d, const uint8_t *s, int32_t n, bool deep,
                                uint32_t black_is_unused, uint64_t *negative)
{
    const ptrdiff_t size = deep ? 6 : 3;
    const __m256i unused = _mm256_set1_epi32((int32_t) black_is_unused);
    uint64_t up = 0; /* bytes; not in memory, where each step would wait for the one before */
    int32_t i = 0;
    for (; i + STEP <= n; i += STEP)
        (deep ? deep_zzero_step : zzero_step)(d + size * i, s + size * i, unused, &up);
    *negative += (uint64_t) i - up / 2;
    return i;
}
