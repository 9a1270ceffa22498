/* SPDX-License-Identifier: MIT */
/*
 * flip_rgb_avx2.c - flips of packed RGB and RGBA, with AVX2
 */
#include "base/rgb_avx2.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"

#include <immintrin.h>
#include <string.h>

/* A call: compilers make branches of copies of so few bytes, and these are at the ends of runs. */
ONE_COPY static void copy(void *to, const void *from, size_t size)
{
    memcpy(to, from, size);
}

/* 32 bytes of src with green flipped.  Loaded a sample earlier and later, red and blue lie where
 * green is. */
static inline __m256i flipped(const uint8_t *s, __m256i green, bool deep, __m256i black,
                              __m256i white)
{
    const ptrdiff_t size = deep ? 2 : 1;
    const __m256i r = _mm256_loadu_si256((const void *) (s - size));
    const __m256i g = _mm256_loadu_si256((const void *) s);
    const __m256i b = _mm256_loadu_si256((const void *) (s + size));
    const __m256i none = _mm256_or_si256(_mm256_or_si256(r, g), b), zero = _mm256_setzero_si256();
    const __m256i all = _mm256_and_si256(_mm256_and_si256(r, g), b), ones = _mm256_set1_epi8(-1);
    const __m256i is_none = deep ? _mm256_cmpeq_epi16(none, zero) : _mm256_cmpeq_epi8(none, zero);
    const __m256i is_all = deep ? _mm256_cmpeq_epi16(all, ones) : _mm256_cmpeq_epi8(all, ones);
    const __m256i kept =
        _mm256_or_si256(_mm256_and_si256(is_none, black), _mm256_and_si256(is_all, white));
    return _mm256_xor_si256(g, _mm256_andnot_si256(kept, green));
}

enum {
    FLIP = 96 /* bytes: whole texels, and whole vectors */,
    VECTOR = 32,
    VECTORS = FLIP / VECTOR,
    CAREFUL = 16 /* parts: where one black or white texel may be, more are near */
};

static inline void flip_part(uint8_t *d, const uint8_t *s, const __m256i *green, bool deep,
                             __m256i black, __m256i white)
{
    __m256i out[VECTORS];
    for (int32_t k = 0; k < VECTORS; k++)
        out[k] = flipped(s + VECTOR * k, green[k], deep, black, white);
    for (int32_t k = 0; k < VECTORS; k++)
        _mm256_storeu_si256((void *) (d + VECTOR * k), out[k]);
}

static inline __m256i load_at(const uint8_t *s, int32_t k)
{
    return _mm256_loadu_si256((const void *) (s + VECTOR * k));
}

/* Where green lies in pixels of 8 and of 16 bit. */
static const uint8_t GREENS[2][VECTOR + 6] = {
    { 0,   255, 0, 0,   255, 0, 0,   255, 0, 0,   255, 0, 0,   255, 0, 0,   255, 0, 0,
      255, 0,   0, 255, 0,   0, 255, 0,   0, 255, 0,   0, 255, 0,   0, 255, 0,   0, 255 },
    { 0, 0,   255, 255, 0, 0, 0, 0,   255, 255, 0, 0, 0, 0,   255, 255, 0, 0, 0,
      0, 255, 255, 0,   0, 0, 0, 255, 255, 0,   0, 0, 0, 255, 255, 0,   0, 0, 0 }
};

/* The same for a part; a vector is two samples more than whole texels, or one. */
static inline void load_greens(__m256i green[VECTORS], const uint8_t *pattern, bool deep)
{
    green[0] = load_at(pattern, 0);
    green[1] = load_at(pattern + 2, 0);
    green[2] = load_at(pattern + (deep ? 4 : 1), 0);
}

/* The greens of three vectors lie in places that differ, so one vector holds them all.  So do their blues,
 * each a sample farther on, or at the begin of the next vector. */
static inline __m256i joined(const __m256i v[VECTORS], __m256i second, __m256i third)
{
    return _mm256_blendv_epi8(_mm256_blendv_epi8(v[0], v[1], second), v[2], third);
}

static inline __m256i next_samples(__m256i v, bool deep)
{
    const __m256i other = _mm256_permute2x128_si256(v, v, 1);
    return deep ? _mm256_alignr_epi8(other, v, 2) : _mm256_alignr_epi8(other, v, 1);
}

/* A part where no green is 0 or M and equal to its blue, so that no texel is black or white, is inverted
 * without more.  False, with nothing written, for others. */
static ALWAYS_INLINE bool flip_plain(uint8_t *d, const uint8_t *s, const __m256i *green,
                                     const __m256i *inverted, bool deep)
{
    const __m256i v[VECTORS] = { load_at(s, 0), load_at(s, 1), load_at(s, 2) };
    const __m256i g = joined(v, green[1], green[2]);
    const __m256i b =
        next_samples(deep ? joined(v, green[0], green[1]) : joined(v, green[2], green[0]), deep);
    const __m256i one = deep ? _mm256_set1_epi16(1) : _mm256_set1_epi8(1);
    const __m256i above = deep ? _mm256_add_epi16(g, one) : _mm256_add_epi8(g, one);
    const __m256i end = deep ? _mm256_cmpeq_epi16(_mm256_min_epu16(above, one), above)
                             : _mm256_cmpeq_epi8(_mm256_min_epu8(above, one), above);
    if (!_mm256_testz_si256(end, deep ? _mm256_cmpeq_epi16(g, b) : _mm256_cmpeq_epi8(g, b)))
        return false;
    for (int32_t k = 0; k < VECTORS; k++)
        _mm256_storeu_si256((void *) (d + VECTOR * k), _mm256_xor_si256(v[k], inverted[k]));
    return true;
}

/* Parts that are plain, up to the first that is not; returns how many bytes these are. */
ONE_COPY static int32_t flip_plain_parts(uint8_t *d, const uint8_t *s, int32_t bytes, bool deep,
                                         bool invert_r, bool invert_g)
{
    const __m256i zero = _mm256_setzero_si256();
    __m256i green[VECTORS], red[VECTORS], inverted[VECTORS];
    int32_t i = 0;
    load_greens(green, GREENS[deep], deep);
    load_greens(red, GREENS[deep] + 1 + deep, deep);
    for (int32_t k = 0; k < VECTORS; k++)
        inverted[k] = _mm256_or_si256(invert_r ? red[k] : zero, invert_g ? green[k] : zero);
    if (deep) {
        while (i + FLIP <= bytes && flip_plain(d + i, s + i, green, inverted, true))
            i += FLIP;
    } else {
        while (i + FLIP <= bytes && flip_plain(d + i, s + i, green, inverted, false))
            i += FLIP;
    }
    return i;
}

/* The first and the last part are done in a copy, as they have no neighbors; the first only where it is not
 * plain. */
static inline void flip(uint8_t *d, const uint8_t *s, int32_t bytes, bool deep, __m256i black,
                        __m256i white)
{
    uint8_t around[VECTOR + FLIP + VECTOR] = { 0 }, *const few = around + VECTOR;
    __m256i green[VECTORS];
    load_greens(green, GREENS[deep], deep);
    for (int32_t i = 0; i < bytes;) {
        i += flip_plain_parts(d + i, s + i, bytes - i, deep, false, true);
        for (int32_t parts = 0; parts < CAREFUL && i < bytes; parts++, i += FLIP) {
            const bool inside = i > 0 && i + FLIP < bytes;
            const size_t left = (size_t) (bytes - i < FLIP ? bytes - i : FLIP);
            if (!inside)
                copy(few, s + i, left);
            flip_part(inside ? d + i : few, inside ? s + i : few, green, deep, black, white);
            if (!inside)
                copy(d + i, few, left);
        }
    }
}

void ntp__flip_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool keep_black,
                        bool keep_white)
{
    const __m256i black = _mm256_set1_epi8(keep_black ? -1 : 0);
    const __m256i white = _mm256_set1_epi8(keep_white ? -1 : 0);
    if (deep)
        flip(dst, src, 6 * n, true, black, white);
    else
        flip(dst, src, 3 * n, false, black, white);
}

void ntp__mirror_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool invert_r,
                          bool invert_g)
{
    const int32_t size = deep ? 6 : 3;
    const uint8_t *const s = src;
    uint8_t *const d = dst;
    for (int32_t i = 0, part; i < size * n; i += part) {
        const int32_t left = size * n - i;
        part = flip_plain_parts(d + i, s + i, left, deep, invert_r, invert_g);
        if (part > 0)
            continue;
        part = left < CAREFUL * FLIP ? left : CAREFUL * FLIP;
        ntp__turn_rgb_avx2(d + i, s + i, part / size, deep, false, invert_r, invert_g);
    }
    end_lanes();
}

/* A vector of pixels with alpha. */
static ALWAYS_INLINE __m256i mirrored(__m256i v, __m256i white, __m256i inverted, bool deep)
{
    const __m256i zero = _mm256_setzero_si256(), color = _mm256_and_si256(v, white);
    const __m256i other = _mm256_xor_si256(color, white), alpha = _mm256_andnot_si256(white, v);
    const __m256i kept = deep ? _mm256_or_si256(_mm256_or_si256(_mm256_cmpeq_epi64(color, zero),
                                                                _mm256_cmpeq_epi64(other, zero)),
                                                _mm256_cmpeq_epi64(alpha, zero))
                              : _mm256_or_si256(_mm256_or_si256(_mm256_cmpeq_epi32(color, zero),
                                                                _mm256_cmpeq_epi32(other, zero)),
                                                _mm256_cmpeq_epi32(alpha, zero));
    return _mm256_xor_si256(v, _mm256_andnot_si256(kept, inverted));
}

void ntp__mirror_rgba_avx2(void *dst, const void *src, int32_t n, bool deep, bool invert_r,
                           bool invert_g)
{
    const int64_t m = deep ? 65535 : 255, twice = deep ? 1 : 0x100000001, g = m * (m + 1);
    const __m256i white = _mm256_set1_epi64x(twice * (m + g + g * (m + 1)));
    const __m256i inverted = _mm256_set1_epi64x(twice * ((invert_r ? m : 0) + (invert_g ? g : 0)));
    const uint8_t *s = src;
    uint8_t *d = dst, few[VECTOR] = { 0 };
    for (int32_t left = (deep ? 8 : 4) * n; left > 0; left -= VECTOR, s += VECTOR, d += VECTOR) {
        const bool whole = left >= VECTOR;
        if (!whole)
            copy(few, s, (size_t) left);
        const __m256i v = load_at(whole ? s : few, 0);
        _mm256_storeu_si256((void *) (whole ? d : few), deep ? mirrored(v, white, inverted, true)
                                                             : mirrored(v, white, inverted, false));
        if (!whole)
            copy(d, few, (size_t) left);
    }
    end_lanes();
}

void ntp__reverse_avx2(void *dst, const void *src, int32_t n, int32_t size)
{
    enum { LANE = 16 };
    static const int8_t ORDERS[4][LANE] = {
        { 13, 14, 15, 10, 11, 12, 7, 8, 9, 4, 5, 6, 1, 2, 3, -1 },
        { 12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3 },
        { 10, 11, 12, 13, 14, 15, 4, 5, 6, 7, 8, 9, -1, -1, -1, -1 },
        { 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7 }
    };
    const __m128i order = _mm_loadu_si128((const void *) ORDERS[size / 2 - 1]);
    const int32_t step = LANE / size * size;
    const uint8_t *s = (const uint8_t *) src + (size * n - LANE);
    uint8_t *d = dst, few[LANE] = { 0 };
    int32_t left = size * n;
    for (; left >= LANE; left -= step, s -= step, d += step)
        _mm_storeu_si128((void *) d, _mm_shuffle_epi8(_mm_loadu_si128((const void *) s), order));
    copy(few + LANE - left, src, (size_t) left);
    _mm_storeu_si128((void *) d, _mm_shuffle_epi8(_mm_loadu_si128((const void *) few), order));
}
