/* SPDX-License-Identifier: MIT */
/*
 * rgb_avx2.c - packed RGB to planes and back, and turns of it, with AVX2
 *
 * Shuffles of bytes do in one step of eight texels what other processors do texel by texel in
 * view.c.  Planes are written and read in whole steps, for which a block has room.  At the end of a
 * run, where a step would go beyond the caller's bytes, a copy of the last ones is used.
 */
#include "base/rgb_avx2.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"

#include <immintrin.h>
#include <string.h>

enum {
    STEP = 8 /* texels */,
    LANE = 16, /* bytes */
    HELD = 12  /* of pixels in a lane */
};

static inline void store_plane(int32_t *plane, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) plane, v);
}

static inline __m256i load_plane(const int32_t *plane)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) plane);
}

/* A call: compilers make branches of copies of so few bytes, and these are at the ends of runs. */
ONE_COPY static void copy(void *to, const void *from, size_t size)
{
    memcpy(to, from, size);
}

#define TAKE8(k)                                                                                   \
    store_plane(b->c[k] + i, SHUFFLE(v, (k), -1, -1, -1, (k) + 3, -1, -1, -1, (k) + 6, -1, -1, -1, \
                                     (k) + 9, -1, -1, -1))

static inline void take8(ntp__block *b, int32_t i, const uint8_t *s)
{
    const __m256i v = load_two(s, s + 12);
    TAKE8(0);
    TAKE8(1);
    TAKE8(2);
}

/* Texels 0 and 1 of four lie in the first eight bytes after these are loaded, 2 and 3 in others. */
#define TAKE16(k)                                                                                  \
    store_plane(b->c[k] + i,                                                                       \
                _mm256_or_si256(SHUFFLE(v, 2 * (k), 2 * (k) + 1, -1, -1, 2 * (k) + 6, 2 * (k) + 7, \
                                        -1, -1, -1, -1, -1, -1, -1, -1, -1, -1),                   \
                                SHUFFLE(w, -1, -1, -1, -1, -1, -1, -1, -1, 2 * (k) + 4,            \
                                        2 * (k) + 5, -1, -1, 2 * (k) + 10, 2 * (k) + 11, -1, -1)))

static inline void take16(ntp__block *b, int32_t i, const uint8_t *s)
{
    const __m256i v = load_two(s, s + 24), w = load_two(s + 8, s + 32);
    TAKE16(0);
    TAKE16(1);
    TAKE16(2);
}

static inline void put8(uint8_t *d, const ntp__block *b, int32_t i)
{
    __m256i v = load_plane(b->c[0] + i);
    v = _mm256_or_si256(v, _mm256_slli_epi32(load_plane(b->c[1] + i), 8));
    v = _mm256_or_si256(v, _mm256_slli_epi32(load_plane(b->c[2] + i), 16));
    store_two(d, d + 12, SHUFFLE(v, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
}

static inline void put16(uint8_t *d, const ntp__block *b, int32_t i)
{
    const __m256i g = _mm256_slli_epi32(load_plane(b->c[1] + i), 16);
    const __m256i v = _mm256_or_si256(load_plane(b->c[0] + i), g), w = load_plane(b->c[2] + i);
    /* Bytes 0 to 15 and 8 to 23 of four texels */
    store_two(
        d, d + 24,
        _mm256_or_si256(SHUFFLE(v, 0, 1, 2, 3, -1, -1, 4, 5, 6, 7, -1, -1, 8, 9, 10, 11),
                        SHUFFLE(w, -1, -1, -1, -1, 0, 1, -1, -1, -1, -1, 4, 5, -1, -1, -1, -1)));
    store_two(
        d + 8, d + 32,
        _mm256_or_si256(SHUFFLE(v, 6, 7, -1, -1, 8, 9, 10, 11, -1, -1, 12, 13, 14, 15, -1, -1),
                        SHUFFLE(w, -1, -1, 4, 5, -1, -1, -1, -1, 8, 9, -1, -1, -1, -1, 12, 13)));
}

/* `bytes` a texel, and how many bytes beyond a step it touches. */
#define UNPACK(take, bytes, beyond)                                                                \
    do {                                                                                           \
        int32_t i = 0;                                                                             \
        for (; (bytes) * (n - i) >= (bytes) * STEP + (beyond); i += STEP)                          \
            take(block, i, s + (ptrdiff_t) (bytes) * i);                                           \
        for (; i < n; i += STEP) {                                                                 \
            uint8_t few[(bytes) * STEP + (beyond)] = { 0 };                                        \
            int32_t left = n - i < STEP ? n - i : STEP;                                            \
            copy(few, s + (ptrdiff_t) (bytes) * i, (size_t) left * (bytes));                       \
            take(block, i, few);                                                                   \
        }                                                                                          \
    } while (0)

#define PACK(put, bytes, beyond)                                                                   \
    do {                                                                                           \
        int32_t i = 0;                                                                             \
        for (; (bytes) * (n - i) >= (bytes) * STEP + (beyond); i += STEP)                          \
            put(d + (ptrdiff_t) (bytes) * i, block, i);                                            \
        for (; i < n; i += STEP) {                                                                 \
            uint8_t few[(bytes) * STEP + (beyond)];                                                \
            int32_t left = n - i < STEP ? n - i : STEP;                                            \
            put(few, block, i);                                                                    \
            copy(d + (ptrdiff_t) (bytes) * i, few, (size_t) left * (bytes));                       \
        }                                                                                          \
    } while (0)

void ntp__unpack_rgb_avx2(ntp__block *block, const void *src, int32_t n, bool deep)
{
    const uint8_t *s = src;
    if (deep)
        UNPACK(take16, 6, 0);
    else
        UNPACK(take8, 3, 4);
}

void ntp__pack_rgb_avx2(void *dst, const ntp__block *block, int32_t n, bool deep)
{
    uint8_t *d = dst;
    if (deep)
        PACK(put16, 6, 0);
    else
        PACK(put8, 3, 4);
    /* GCC leaves this out after copy(), and then plain C is slow. */
    _mm256_zeroupper();
}

/* Pixels as numbers, and the range of their samples. */
typedef struct placing {
    __m256i shuffle[2], twice, less;
    __m256i least, most;
} placing;

/* The first and the last 16 bytes of 24: of these lie the pixels in the first and the last 12. */
static inline __m256i load_ends(const uint8_t *s, placing *p, bool deep)
{
    const __m256i v = load_two(s, s + 2 * HELD - LANE);
    p->least = deep ? _mm256_min_epu16(p->least, v) : _mm256_min_epu8(p->least, v);
    p->most = deep ? _mm256_max_epu16(p->most, v) : _mm256_max_epu8(p->most, v);
    return v;
}

/* Eight pixels */
static inline void place8(int16_t *to, const uint8_t *s, placing *p)
{
    const __m256i v = load_ends(s, p, false);
    const __m256i four[2] = { _mm256_permute4x64_epi64(v, 0x44),
                              _mm256_permute4x64_epi64(v, 0xee) };
    for (int32_t k = 0; k < 2; k++) {
        const __m256i c = _mm256_shuffle_epi8(four[k], p->shuffle[k]);
        const __m256i x = _mm256_sub_epi16(_mm256_mullo_epi16(c, p->twice), p->less);
        _mm256_storeu_si256((void *) (to + 16 * k), x);
    }
}

/* Four pixels */
static inline void place16(float *to, const uint8_t *s, placing *p)
{
    const __m256i v = load_ends(s, p, true);
    for (int32_t k = 0; k < 2; k++, to += 4) {
        const __m256 f = _mm256_cvtepi32_ps(_mm256_shuffle_epi8(v, p->shuffle[k]));
        const __m256 x = _mm256_sub_ps(_mm256_mul_ps(f, _mm256_castsi256_ps(p->twice)),
                                       _mm256_castsi256_ps(p->less));
        _mm_storeu_ps(to, _mm256_castps256_ps128(x));
        _mm_storeu_ps(to + 8, _mm256_extractf128_ps(x, 1));
    }
}

static inline void place(void *to, const uint8_t *s, int32_t n, placing *p, bool deep)
{
    const int32_t step = deep ? 4 : 8, size = deep ? 6 : 3;
    uint8_t few[2 * HELD];
    for (int32_t k = 0; n < step && k < step; k++) /* no others change the range */
        copy(few + size * k, s + size * (k < n ? k : 0), (size_t) size);
    s = n < step ? few : s;
    n = n < step ? step : n;
    for (int32_t i = 0; i < n; i += step) {
        const int32_t at = i + step < n ? i : n - step;
        if (deep)
            place16((float *) to + 4 * at, s + size * at, p);
        else
            place8((int16_t *) to + 4 * at, s + size * at, p);
    }
}

bool ntp__place_rgb_avx2(void *to, bool *negative, const void *src, int32_t n, bool deep,
                         bool zzero)
{
    const __m128i of8 =
        _mm_setr_epi8(0, -128, 1, -128, 2, -128, -128, -128, 3, -128, 4, -128, 5, -128, -128, -128);
    const __m128i of16 =
        _mm_setr_epi8(0, 1, -128, -128, 2, 3, -128, -128, 4, 5, -128, -128, -128, -128, -128, -128);
    const __m128i first = deep ? of16 : of8, six = _mm_set1_epi8(6), four = _mm_set1_epi8(4);
    const __m128i later = _mm_add_epi8(first, six);
    const int16_t k = zzero ? 1 : 2, z = zzero ? 0 : 255;
    const float deep_k = k, deep_z = zzero ? 0 : 65535;
    placing p = { .least = _mm256_set1_epi8(-1), .most = _mm256_setzero_si256() };
    if (deep) {
        p.shuffle[0] = _mm256_set_m128i(_mm_add_epi8(first, four), first);
        p.shuffle[1] = _mm256_set_m128i(_mm_add_epi8(later, four), later);
        p.twice = _mm256_castps_si256(_mm256_setr_ps(2, 2, deep_k, 1, 2, 2, deep_k, 1));
        p.less =
            _mm256_castps_si256(_mm256_setr_ps(65535, 65535, deep_z, -1, 65535, 65535, deep_z, -1));
    } else {
        p.shuffle[0] = _mm256_set_m128i(later, first);
        p.shuffle[1] = _mm256_add_epi8(p.shuffle[0], _mm256_set1_epi8(4));
        p.twice = _mm256_setr_epi16(2, 2, k, 1, 2, 2, k, 1, 2, 2, k, 1, 2, 2, k, 1);
        p.less =
            _mm256_setr_epi16(255, 255, z, -1, 255, 255, z, -1, 255, 255, z, -1, 255, 255, z, -1);
    }
    if (deep)
        place(to, src, n, &p, true);
    else
        place(to, src, n, &p, false);
    /* Where red lies, and the upper byte of blue. */
    const uint32_t red = deep ? 0x0c3030c3 : 0x24929249, blue = deep ? 0x82080820 : 0x92494924;
    const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi8(-1);
    const __m256i ends =
        deep ? _mm256_or_si256(_mm256_cmpeq_epi16(p.least, zero), _mm256_cmpeq_epi16(p.most, ones))
             : _mm256_or_si256(_mm256_cmpeq_epi8(p.least, zero), _mm256_cmpeq_epi8(p.most, ones));
    *negative = !zzero && (~(uint32_t) _mm256_movemask_epi8(p.least) & blue) != 0;
    return ((uint32_t) _mm256_movemask_epi8(ends) & red) == 0;
}

/* How red and green change. */
typedef struct turning {
    __m256i first, other; /* shuffles: to whole words; the second skips bytes before the pixels */
    __m256i white, inverted;
} turning;

static inline turning turning_of(bool deep, bool swap, bool invert_r, bool invert_g)
{
    enum { NONE = -128 }; /* a byte that becomes 0 */
    static const int8_t WORDS[2][2][LANE] = {
        { { 0, 1, 2, NONE, 3, 4, 5, NONE, 6, 7, 8, NONE, 9, 10, 11, NONE },
          { 1, 0, 2, NONE, 4, 3, 5, NONE, 7, 6, 8, NONE, 10, 9, 11, NONE } },
        { { 0, 1, 2, 3, 4, 5, NONE, NONE, 6, 7, 8, 9, 10, 11, NONE, NONE },
          { 2, 3, 0, 1, 4, 5, NONE, NONE, 8, 9, 6, 7, 10, 11, NONE, NONE } }
    };
    const int8_t *words = WORDS[deep][swap];
    const int64_t twice = deep ? 1 : 0x100000001, r = deep ? 0xffff : 0xff, g = r * (r + 1);
    const int64_t inverted = (invert_r ? r : 0) + (invert_g ? g : 0);
    const __m256i first = load_two(words, words);
    const turning t = { first, _mm256_add_epi8(first, _mm256_set1_epi8(LANE - HELD)),
                        _mm256_set1_epi64x(twice * (r + g + g * (r + 1))),
                        _mm256_set1_epi64x(twice * inverted) };
    return t;
}

/* Pixels from two places as words, turned; black and white ones stay. */
static inline __m256i turned_words(const uint8_t *s, const uint8_t *more, __m256i shuffle,
                                   const turning *t, bool deep)
{
    const __m256i v = _mm256_shuffle_epi8(load_two(s, more), shuffle);
    const __m256i zero = _mm256_setzero_si256();
    const __m256i kept =
        deep ? _mm256_or_si256(_mm256_cmpeq_epi64(v, zero), _mm256_cmpeq_epi64(v, t->white))
             : _mm256_or_si256(_mm256_cmpeq_epi32(v, zero), _mm256_cmpeq_epi32(v, t->white));
    return _mm256_xor_si256(v, _mm256_andnot_si256(kept, t->inverted));
}

static inline void put_words(uint8_t *d, __m256i v, bool deep)
{
    store_two(d, d + HELD,
              deep ? SHUFFLE(v, 0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, -1, -1, -1, -1)
                   : SHUFFLE(v, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
}

static inline void turn(uint8_t *d, const uint8_t *s, int32_t bytes, const turning *t, bool deep)
{
    enum { BYTES = 2 * HELD, BEYOND = LANE - HELD };
    uint8_t few[BYTES + BEYOND] = { 0 };
    for (int32_t i = 0; i < bytes; i += BYTES) {
        const bool whole = i + BYTES + BEYOND <= bytes;
        const size_t left = (size_t) (bytes - i < BYTES ? bytes - i : BYTES);
        const uint8_t *const from = whole ? s + i : few;
        if (!whole)
            copy(few, s + i, left);
        put_words(whole ? d + i : few, turned_words(from, from + HELD, t->first, t, deep), deep);
        if (!whole)
            copy(d + i, few, left);
    }
}

void ntp__turn_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool swap, bool invert_r,
                        bool invert_g)
{
    const turning t = turning_of(deep, swap, invert_r, invert_g);
    if (deep)
        turn(dst, src, 6 * n, &t, true);
    else
        turn(dst, src, 3 * n, &t, false);
}

/* Of 8 rows with 4 pixels of 8 bit, or of 4 rows with 2, columns become rows. */
static inline void turn_cell(uint8_t *d, ptrdiff_t pitch, const uint8_t *s, ptrdiff_t step,
                             __m256i shuffle, const turning *t, bool deep)
{
    __m256i v[4];
    for (int32_t k = 0; k < (deep ? 2 : 4); k++)
        v[k] = turned_words(s + k * step, s + (k + (deep ? 2 : 4)) * step, shuffle, t, deep);
    const __m256i a = deep ? v[0] : _mm256_unpacklo_epi32(v[0], v[1]);
    const __m256i b = deep ? v[1] : _mm256_unpacklo_epi32(v[2], v[3]);
    put_words(d, _mm256_unpacklo_epi64(a, b), deep);
    put_words(d + pitch, _mm256_unpackhi_epi64(a, b), deep);
    if (deep)
        return;
    const __m256i e = _mm256_unpackhi_epi32(v[0], v[1]), f = _mm256_unpackhi_epi32(v[2], v[3]);
    put_words(d + 2 * pitch, _mm256_unpacklo_epi64(e, f), deep);
    put_words(d + 3 * pitch, _mm256_unpackhi_epi64(e, f), deep);
}

/* The last cells overlap those before.  All but the first pixels of a row are loaded with bytes
 * before them, so that none beyond the row is touched. */
static inline void turn_cells(uint8_t *d, ptrdiff_t pitch, const uint8_t *s, ptrdiff_t step,
                              int32_t rows, int32_t columns, const turning *t, bool deep)
{
    enum { LINE = 64, AHEAD = 8 };
    const int32_t high = deep ? 4 : 8, wide = deep ? 2 : 4, size = deep ? 6 : 3;
    for (int32_t i = 0; i < rows; i += high) {
        const int32_t y = i + high < rows ? i : rows - high;
        const uint8_t *from = s + y * step;
        for (int32_t k = 0; k < high; k++) {
            for (int32_t x = 0; x < size * columns; x += LINE)
                _mm_prefetch((const char *) from + (AHEAD + k) * step + x, _MM_HINT_T0);
        }
        for (int32_t x = 0; x < columns; x += wide) {
            const int32_t at = x + wide < columns ? x : columns - wide;
            turn_cell(d + size * y + at * pitch, pitch,
                      from + size * at - (x > 0 ? LANE - HELD : 0), step,
                      x > 0 ? t->other : t->first, t, deep);
        }
    }
}

void ntp__turn_tile_avx2(uint8_t *dst, ptrdiff_t pitch, const void *src, ptrdiff_t step,
                         int32_t rows, int32_t columns, bool deep, bool invert_r, bool invert_g)
{
    const turning t = turning_of(deep, true, invert_r, invert_g);
    if (deep)
        turn_cells(dst, pitch, src, step, rows, columns, &t, true);
    else
        turn_cells(dst, pitch, src, step, rows, columns, &t, false);
}
