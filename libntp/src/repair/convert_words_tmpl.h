/* SPDX-License-Identifier: MIT */
/*
 * convert_words_tmpl.h - the most common conversions of packed RGB; a part of convert_avx2.c
 *
 * Sixteen texels a step, whose levels of 8 bit are words, as are their exactness and their roots.  Each
 * half of a vector is of eight texels.
 */

/* t where z is 2t + 1 or -(2t + 1), given the level of blue as words of either depth. */
static inline __m256i size_of_z(__m256i b, bool deep, __m256i *minus)
{
    const __m256i z = _mm256_sub_epi16(b, _mm256_set1_epi16((short) (deep ? -32768 : 128)));
    *minus = _mm256_srai_epi16(z, 15);
    return _mm256_xor_si256(z, *minus);
}

/* Marks texels of 8 bit that are exact: d = e - t^2 is from 0 to 2t.  It is never below -2^15. */
static inline __m256i exact_words(__m256i e, __m256i t, __m256i *d)
{
    const __m256i twice = _mm256_add_epi16(t, t);
    *d = _mm256_sub_epi16(e, _mm256_mullo_epi16(t, t));
    return _mm256_cmpeq_epi16(_mm256_max_epu16(*d, twice), twice);
}

/* The same of 16 bit, in halves of 32 bits. */
static inline __m256i exact_deep(__m256i e, __m256i t, __m256i *d)
{
    const __m256i twice = _mm256_add_epi32(t, t);
    *d = _mm256_sub_epi32(e, _mm256_madd_epi16(t, t));
    return _mm256_cmpeq_epi32(_mm256_max_epu32(*d, twice), twice);
}

/* e of 16 bits for e of 8 bit (words with 2 above each).  257 X: S is 257^2 times as much, and
 * e' = 257^2 e + 3 (257^2 - 1) / 4; the multiplier is 2^16 + 513. */
static inline __m256i deep_rest(__m256i with_2, __m256i above)
{
    const __m256i by = _mm256_set1_epi32(513 | 3 * (257 * 257 - 1) / 8 << 16);
    return _mm256_add_epi32(_mm256_madd_epi16(with_2, by), above);
}

/* Steps that are looked at before their roots are taken: of one chain of all that, few would be in
 * flight. */
enum { STEPS = 16 };

/* Sixteen texels at 16 bit: e, and blue by value.  32768 + t, or 32767 - t, is t ^ sign. */
typedef struct wide_words {
    __m256i e[2], b, sign, exact;
} wide_words;

/* Standard, 8 bit to 16. */
static inline wide_words look_wide(const uint8_t *s)
{
    const __m256i low = load_two(s, s + 24), high = load_two(s + 8, s + 32);
    const __m256i two = _mm256_set1_epi16(2), zero = _mm256_setzero_si256();
    const __m256i e = rest_words(pairs_of(low, high));
    const __m256i b =
        _mm256_or_si256(SHUFFLE(low, 2, N, 5, N, 8, N, 11, N, 14, N, N, N, N, N, N, N),
                        SHUFFLE(high, N, N, N, N, N, N, N, N, N, N, 9, N, 12, N, 15, N));
    __m256i minus, rest;
    const __m256i exact = exact_words(e, size_of_z(b, false, &minus), &rest);
    const wide_words w = {
        .e = { deep_rest(_mm256_unpacklo_epi16(e, two), _mm256_unpacklo_epi16(zero, e)),
               deep_rest(_mm256_unpackhi_epi16(e, two), _mm256_unpackhi_epi16(zero, e)) },
        .b = _mm256_or_si256(b, _mm256_slli_epi16(b, 8)),
        .sign = _mm256_xor_si256(minus, _mm256_set1_epi16(-32768)),
        .exact = exact,
    };
    return w;
}

static inline void widen_step(uint8_t *d, const uint8_t *s, const wide_words *of)
{
    const __m256i low = load_two(s, s + 24), high = load_two(s + 8, s + 32);
    const __m256i t = _mm256_packs_epi32(root_of(of->e[0], true), root_of(of->e[1], true));
    const __m256i want = _mm256_xor_si256(t, of->sign);
    /* Blues as they lie in the words of three vectors, where each place is that of one vector only. */
    const __m256i z = SHUFFLE(_mm256_blendv_epi8(of->b, want, of->exact), 4, 5, 10, 11, 0, 1, 6, 7,
                              12, 13, 2, 3, 8, 9, 14, 15);
    store_two(
        d, d + 48,
        _mm256_blend_epi16(SHUFFLE(low, 0, 0, 1, 1, N, N, 3, 3, 4, 4, N, N, 6, 6, 7, 7), z, 0x24));
    store_two(d + 16, d + 64,
              _mm256_blend_epi16(
                  SHUFFLE(low, N, N, 9, 9, 10, 10, N, N, 12, 12, 13, 13, N, N, 15, 15), z, 0x49));
    store_two(d + 32, d + 80,
              _mm256_blend_epi16(
                  SHUFFLE(high, 8, 8, N, N, 10, 10, 11, 11, N, N, 13, 13, 14, 14, N, N), z, 0x92));
}

/* Sixteen texels of 16 bit: their bytes as they lie, red and green of half of them, blues, and t of
 * these. */
typedef struct deep_words {
    __m256i v[3], low, high, b, t, minus;
} deep_words;

static inline deep_words take_deep(const uint8_t *s)
{
    const __m256i p = load_two(s, s + 48), q = load_two(s + 16, s + 64);
    const __m256i r = load_two(s + 32, s + 80);
    deep_words in = { .v = { p, q, r } };
    in.low = _mm256_or_si256(SHUFFLE(p, 0, 1, 2, 3, 6, 7, 8, 9, 12, 13, 14, 15, N, N, N, N),
                             SHUFFLE(q, N, N, N, N, N, N, N, N, N, N, N, N, 2, 3, 4, 5));
    in.high = _mm256_or_si256(SHUFFLE(q, 8, 9, 10, 11, 14, 15, N, N, N, N, N, N, N, N, N, N),
                              SHUFFLE(r, N, N, N, N, N, N, 0, 1, 4, 5, 6, 7, 10, 11, 12, 13));
    in.b = SHUFFLE(_mm256_blend_epi16(_mm256_blend_epi16(p, q, 0x49), r, 0x92), 4, 5, 10, 11, 0, 1,
                   6, 7, 12, 13, 2, 3, 8, 9, 14, 15);
    in.t = size_of_z(in.b, true, &in.minus);
    return in;
}

/* Marks exact ones as words, and finds d = e - t^2 of these. */
static inline __m256i exact_of(const deep_words *in, __m256i *d)
{
    const __m256i zero = _mm256_setzero_si256();
    __m256i low, high;
    const __m256i exact = _mm256_packs_epi32(
        exact_deep(rest_of(in->low, true), _mm256_unpacklo_epi16(in->t, zero), &low),
        exact_deep(rest_of(in->high, true), _mm256_unpackhi_epi16(in->t, zero), &high));
    *d = _mm256_packus_epi32(low, high);
    return exact;
}

/* Sixteen texels at 8 bit: red and green, e of these, and blue by value.  128 + t, or 127 - t, is
 * 128 + (t ^ minus). */
typedef struct narrow_words {
    __m256i rg, e, b, minus, exact;
} narrow_words;

/* Standard, 16 bit to 8.  False where an exact texel has to be pulled. */
static inline bool look_narrow(narrow_words *to, const uint8_t *s)
{
    const __m256i half = _mm256_set1_epi16(128);
    const deep_words in = take_deep(s);
    __m256i rest;
    to->exact = exact_of(&in, &rest);
    to->rg = _mm256_packus_epi16(over257(_mm256_adds_epu16(in.low, half)),
                                 over257(_mm256_adds_epu16(in.high, half)));
    to->e = rest_words(to->rg);
    to->b = over257(_mm256_adds_epu16(in.b, half));
    to->minus = in.minus;
    return _mm256_testz_si256(_mm256_and_si256(to->exact, to->e), _mm256_set1_epi16(-32768));
}

static inline void narrow_step(uint8_t *d, const narrow_words *of)
{
    const __m256i t = _mm256_xor_si256(root_words(of->e), of->minus);
    const __m256i want = _mm256_add_epi16(t, _mm256_set1_epi16(128));
    store_pixels(d, of->rg, _mm256_blendv_epi8(of->b, want, of->exact));
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

/* Of 16 bit.  False, with nothing written, where a texel is black. */
static inline bool deep_zzero_step(uint8_t *d, const uint8_t *s, uint64_t *negative)
{
    const deep_words in = take_deep(s);
    const __m256i zero = _mm256_setzero_si256();
    const __m256i none =
        _mm256_packs_epi32(_mm256_cmpeq_epi32(in.low, zero), _mm256_cmpeq_epi32(in.high, zero));
    if (!_mm256_testz_si256(none, _mm256_cmpeq_epi16(in.b, zero)))
        return false;
    __m256i rest;
    const __m256i exact = exact_of(&in, &rest);
    *negative += (uint64_t) __builtin_popcount((uint32_t) _mm256_movemask_epi8(in.minus)) / 2;
    /* Back to where blues lie in the three vectors. */
    const __m256i z = SHUFFLE(zzero_of(in.t, rest, exact, true), 4, 5, 10, 11, 0, 1, 6, 7, 12, 13,
                              2, 3, 8, 9, 14, 15);
    store_two(d, d + 48, _mm256_blend_epi16(in.v[0], z, 0x24));
    store_two(d + 16, d + 64, _mm256_blend_epi16(in.v[1], z, 0x49));
    store_two(d + 32, d + 80, _mm256_blend_epi16(in.v[2], z, 0x92));
    return true;
}

/* 8 bit, standard to Z-zero.  False, with nothing written, where a texel is black. */
static inline bool zzero_step(uint8_t *d, const uint8_t *s, uint64_t *negative)
{
    __m256i low = load_two(s, s + 24), high = load_two(s + 8, s + 32);
    const __m256i rg = pairs_of(low, high);
    const __m256i b =
        _mm256_or_si256(SHUFFLE(low, 2, N, 5, N, 8, N, 11, N, 14, N, N, N, N, N, N, N),
                        SHUFFLE(high, N, N, N, N, N, N, N, N, N, N, 9, N, 12, N, 15, N));
    const __m256i black = _mm256_cmpeq_epi16(_mm256_or_si256(rg, b), _mm256_setzero_si256());
    if (!_mm256_testz_si256(black, black))
        return false;
    __m256i minus, rest;
    const __m256i t = size_of_z(b, false, &minus);
    const __m256i exact = exact_words(rest_words(rg), t, &rest);
    *negative += (uint64_t) __builtin_popcount((uint32_t) _mm256_movemask_epi8(minus)) / 2;
    put_words(d, &low, &high, zzero_of(t, rest, exact, false));
    return true;
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

static int32_t narrow(uint8_t *d, const uint8_t *s, int32_t n)
{
    narrow_words steps[STEPS];
    const int32_t all = n / STEP;
    for (int32_t i = 0; i < all; i += STEPS) {
        const int32_t most = all - i < STEPS ? all - i : STEPS;
        int32_t count = 0;
        while (count < most && look_narrow(&steps[count], s + (ptrdiff_t) 6 * STEP * (i + count)))
            count++;
        for (int32_t k = 0; k < count; k++)
            narrow_step(d + (ptrdiff_t) 3 * STEP * (i + k), &steps[k]);
        if (count < most)
            return STEP * (i + count);
    }
    return STEP * all;
}

FOR_EACH_DEPTH int32_t to_zzero(uint8_t *d, const uint8_t *s, int32_t n, bool deep,
                                uint64_t *negative)
{
    const ptrdiff_t size = deep ? 6 : 3;
    uint64_t count = 0; /* not in memory, where each step would wait for the one before */
    int32_t i = 0;
    while (i + STEP <= n && (deep ? deep_zzero_step(d + size * i, s + size * i, &count)
                                  : zzero_step(d + size * i, s + size * i, &count)))
        i += STEP;
    *negative += count;
    return i;
}
