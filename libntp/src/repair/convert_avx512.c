/* SPDX-License-Identifier: MIT */
/*
 * convert_avx512.c - the most common conversions of packed RGB, with AVX-512
 *
 * As convert_words_tmpl.h, which says why the numbers are right, but 32 texels a step, in the order in
 * which they lie: levels of 8 bit, blues and their roots are words, and what takes 32 bits is in two
 * halves.
 */
#include "repair/convert_avx2.h"

#include "texel/packed_avx512_tmpl.h"

enum { STEP = 2 * LANES_512 };

enum { AHEAD = 4096 /* bytes, as processors themselves fetch no more than the page */ };

/* ~(a ^ b) & c, and a ^ b ^ c. */
enum { ALIKE_AND = 0x82, XOR = 0x96 };

enum { LAST_BLUE = 21 /* the first one in the last of three vectors of words */ };
#define FIRST_BLUES 0x4924924924924924

/* Of 32 pixels the places of reds and greens, and of blues. */
static const uint8_t apart[] = {
    0,  1,  3,  4,  6,  7,  9,  10, 12, 13, 15, 16, 18, 19, 21, 22, 24, 25, 27, 28, 30, 31, 33, 34,
    36, 37, 39, 40, 42, 43, 45, 46, 48, 49, 51, 52, 54, 55, 57, 58, 60, 61, 63, 64, 66, 67, 69, 70,
    72, 73, 75, 76, 78, 79, 81, 82, 84, 85, 87, 88, 90, 91, 93, 94, 2,  5,  8,  11, 14, 17, 20, 23,
    26, 29, 32, 35, 38, 41, 44, 47, 50, 53, 56, 59, 62, 65, 68, 71, 74, 77, 80, 83, 86, 89, 92, 95,
};
/* Where the samples of 32 pixels are in these: blues each twice as far. */
static const uint8_t back[] = {
    0,   1,  64,  2,   3,  66,  4,   5,  68,  6,   7,  70,  8,   9,  72,  10,  11,  74,  12, 13,
    76,  14, 15,  78,  16, 17,  80,  18, 19,  82,  20, 21,  84,  22, 23,  86,  24,  25,  88, 26,
    27,  90, 28,  29,  92, 30,  31,  94, 32,  33,  96, 34,  35,  98, 36,  37,  100, 38,  39, 102,
    40,  41, 104, 42,  43, 106, 44,  45, 108, 46,  47, 110, 48,  49, 112, 50,  51,  114, 52, 53,
    116, 54, 55,  118, 56, 57,  120, 58, 59,  122, 60, 61,  124, 62, 63,  126,
};
static const uint32_t blues[] = { 0x24924924, 0x49249249, 0x92492492 }; /* bits of them there */
static const uint8_t counted[] = {
    0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
    16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31,
};

/* Small tables, and what is made of them before the loop, are less code than whole vectors. */
static inline __m512i words_at(const uint8_t *table)
{
    return _mm512_cvtepu8_epi16(_mm256_loadu_si256((const void *) table));
}

static inline __m512i load_32(const uint8_t *s)
{
    return _mm512_zextsi256_si512(_mm256_loadu_si256((const void *) s));
}

/* These 32 bytes, each of them twice. */
static inline __m512i doubled(const uint8_t *s)
{
    const __m512i words = words_at(s);
    return _mm512_or_si512(words, _mm512_slli_epi16(words, 8));
}

typedef struct halves {
    __m512i low, high;
} halves;

static inline halves widened(__m512i words)
{
    return (halves) { _mm512_cvtepu16_epi32(_mm512_castsi512_si256(words)),
                      _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(words, 1)) };
}

/* t where z is 2t + 1 or -(2t + 1), of blues with their first bit set or not, as `up` says. */
static inline __m512i size_of_z(__m512i b, __m512i up, int16_t most)
{
    return _mm512_ternarylogic_epi32(b, up, _mm512_set1_epi16(most), ALIKE_AND);
}

/* As blue_of: 2t, 2t + 1 or 2t + 2, given d = e - t^2; where it is not exact, |Z| = 2t + 1.
 * 2d < t - 1 is d < floor(t / 2), and 2d < 3t is d < 2t - floor(t / 2). */
static inline __m512i to_size(__m512i t, __m512i d, __mmask32 exact)
{
    const __m512i one = _mm512_set1_epi16(1), twice = _mm512_add_epi16(t, t);
    const __m512i half = _mm512_srli_epi16(t, 1), z = _mm512_add_epi16(twice, one);
    const __mmask32 less = _mm512_mask_cmplt_epu16_mask(exact, d, half);
    const __mmask32 more = _mm512_mask_cmpge_epu16_mask(exact, d, _mm512_sub_epi16(twice, half));
    return _mm512_mask_add_epi16(_mm512_mask_sub_epi16(z, less, z, one), more, z, one);
}

/* ------------------------------------------------------------------------------ from 8 bit */

typedef struct step8 {
    __m512i first, last;  /* the bytes as they lie: 64 and 32 */
    __m512i rg, b, t, up; /* pairs; 257 b; up: -1 where z > 0 */
    __m512i e, d;         /* d = e - t^2 */
    __mmask32 exact;
} step8;

static inline step8 take_8(const uint8_t *s)
{
    step8 in;
    in.first = _mm512_loadu_si512(s);
    in.last = load_32(s + 64);
    in.rg = _mm512_permutex2var_epi8(in.first, _mm512_loadu_si512(apart), in.last);
    in.b = _mm512_permutex2var_epi8(in.first, doubled(apart + 64), in.last);
    in.up = _mm512_srai_epi16(in.b, 15);
    in.t = size_of_z(in.b, in.up, 127);
    in.e = rest_words(in.rg);
    in.d = _mm512_sub_epi16(in.e, _mm512_mullo_epi16(in.t, in.t));
    in.exact = _mm512_cmple_epu16_mask(in.d, _mm512_add_epi16(in.t, in.t));
    return in;
}

/* The root of 16 bits for e of 8 bit. */
static inline __m512i deep_root(__m512i with_2, __m512i above)
{
    const __m512i by = _mm512_set1_epi32(513 | 3 * (257 * 257 - 1) / 8 << 16);
    return root_of(_mm512_add_epi32(_mm512_madd_epi16(with_2, by), above), true);
}

static int32_t widen(uint8_t *d, const uint8_t *s, int32_t n)
{
    const __m512i two = _mm512_set1_epi16(2), zero = _mm512_setzero_si512();
    __m512i from[3];
    int32_t i = 0;
    for (int k = 0; k < 3; k++) /* each byte twice, and both bytes of blues of another vector */
        from[k] = _mm512_mask_add_epi16(doubled(counted), blues[k], doubled(back + STEP * k),
                                        _mm512_set1_epi16(256));
    for (; i + STEP <= n; i += STEP, s += (ptrdiff_t) STEP * 3, d += (ptrdiff_t) STEP * 6) {
        const step8 in = take_8(s);
        const __m512i t = _mm512_packs_epi32(
            deep_root(_mm512_unpacklo_epi16(in.e, two), _mm512_unpacklo_epi16(zero, in.e)),
            deep_root(_mm512_unpackhi_epi16(in.e, two), _mm512_unpackhi_epi16(zero, in.e)));
        /* 32768 + t, or 32767 - t */
        const __m512i want = _mm512_ternarylogic_epi32(t, in.up, _mm512_set1_epi16(32767), XOR);
        const __m512i z = _mm512_mask_mov_epi16(in.b, in.exact, want);
        for (int k = 0; k < 3; k++)
            _mm512_storeu_si512(d + 64 * k,
                                _mm512_permutex2var_epi8(load_32(s + STEP * k), from[k], z));
    }
    return i;
}

static int32_t to_zzero_8(uint8_t *d, const uint8_t *s, int32_t n, uint32_t unused,
                          uint64_t *negative)
{
    int32_t i = 0, up = 0; /* not in memory, where each step would wait for the one before */
    for (; i + STEP <= n; i += STEP, s += (ptrdiff_t) STEP * 3, d += (ptrdiff_t) STEP * 3) {
        step8 in = take_8(s);
        const __m512i any = _mm512_or_si512(in.rg, in.b);
        const uint32_t black = _mm512_testn_epi16_mask(any, any) & unused;
        const __m512i z = _mm512_maskz_mov_epi16(~black, to_size(in.t, in.d, in.exact));
        up += __builtin_popcount(_mm512_movepi16_mask(in.b) | black);
        in.first = _mm512_mask_permutexvar_epi8(in.first, FIRST_BLUES, _mm512_loadu_si512(back), z);
        in.last = _mm512_mask_permutexvar_epi8(in.last, blues[2], load_32(back + 64), z);
        _mm512_storeu_si512(d, in.first);
        _mm256_storeu_si256((void *) (d + 64), _mm512_castsi512_si256(in.last));
    }
    *negative += (uint64_t) (i - up);
    return i;
}

/* ------------------------------------------------------------------------------ from 16 bit */

typedef struct step16 {
    __m512i v[3];          /* the words as they lie */
    __m512i low, high;     /* red and green of 16 texels */
    __m512i b, t, up;      /* up: -1 where z > 0 */
    __m512i d_low, d_high; /* e - t^2 */
    __mmask32 exact;
} step16;

static inline __mmask16 exact_16(__m512i rg, __m512i t, __m512i *d)
{
    *d = _mm512_sub_epi32(rest_of(rg, true), _mm512_madd_epi16(t, t));
    return _mm512_cmple_epu32_mask(*d, _mm512_add_epi32(t, t));
}

static inline step16 take_16(const uint8_t *s)
{
    const __m512i b = words_at(apart + 64);
    step16 in;
    for (int k = 0; k < 3; k++) {
        in.v[k] = _mm512_loadu_si512(s + (ptrdiff_t) 64 * k);
        _mm_prefetch((const char *) s + AHEAD + (ptrdiff_t) 64 * k, _MM_HINT_T0);
    }
    /* Places count on from vector to vector: 64 and more is the last one again. */
    in.low = _mm512_permutex2var_epi16(in.v[0], words_at(apart), in.v[1]);
    in.high = _mm512_permutex2var_epi16(in.v[2], words_at(apart + STEP), in.v[1]);
    in.b = _mm512_permutex2var_epi16(in.v[0], b, in.v[1]);
    in.b = _mm512_mask_permutexvar_epi16(in.b, UINT32_MAX << LAST_BLUE, b, in.v[2]);
    in.up = _mm512_srai_epi16(in.b, 15);
    in.t = size_of_z(in.b, in.up, 32767);
    const halves t = widened(in.t);
    const uint32_t low = exact_16(in.low, t.low, &in.d_low);
    const uint32_t high = exact_16(in.high, t.high, &in.d_high);
    in.exact = low | high << LANES_512;
    return in;
}

/* 256 floor((c + 128) / 257), and less than 256 more. */
static inline __m512i narrowed(__m512i c)
{
    return _mm512_mulhi_epu16(_mm512_adds_epu16(c, _mm512_set1_epi16(128)),
                              _mm512_set1_epi16((short) 0xff01));
}

static int32_t narrow(uint8_t *d, const uint8_t *s, int32_t n)
{
    const __m512i zero = _mm512_setzero_si512(), level = _mm512_set1_epi16(127);
    const __m512i odd =
        _mm512_add_epi16(_mm512_slli_epi16(doubled(counted), 2), _mm512_set1_epi16(0x0301));
    int32_t i = 0;
    for (; i + STEP <= n; i += STEP, s += (ptrdiff_t) STEP * 6, d += (ptrdiff_t) STEP * 3) {
        const step16 in = take_16(s);
        const __m512i rg = _mm512_permutex2var_epi8(narrowed(in.low), odd, narrowed(in.high));
        const __m512i e = rest_words(rg);
        if ((in.exact & _mm512_movepi16_mask(e)) != 0)
            break;
        const __m512i t = _mm512_packs_epi32(root_of(_mm512_unpacklo_epi16(e, zero), false),
                                             root_of(_mm512_unpackhi_epi16(e, zero), false));
        /* 128 + t, or 127 - t, below what is left out */
        const __m512i want = _mm512_ternarylogic_epi32(t, in.up, level, XOR);
        const __m512i z =
            _mm512_mask_mov_epi16(_mm512_srli_epi16(narrowed(in.b), 8), in.exact, want);
        _mm512_storeu_si512(d, _mm512_permutex2var_epi8(rg, _mm512_loadu_si512(back), z));
        _mm256_storeu_si256((void *) (d + 64), _mm512_castsi512_si256(_mm512_permutex2var_epi8(
                                                   rg, load_32(back + 64), z)));
    }
    return i;
}

static int32_t to_zzero_16(uint8_t *d, const uint8_t *s, int32_t n, uint32_t unused,
                           uint64_t *negative)
{
    const __m512i evens = _mm512_slli_epi16(words_at(counted), 1);
    int32_t i = 0, up = 0;
    for (; i + STEP <= n; i += STEP, s += (ptrdiff_t) STEP * 6, d += (ptrdiff_t) STEP * 6) {
        const step16 in = take_16(s);
        const uint32_t low = _mm512_testn_epi32_mask(in.low, in.low);
        const uint32_t high = _mm512_testn_epi32_mask(in.high, in.high);
        const uint32_t black =
            _mm512_testn_epi16_mask(in.b, in.b) & (low | high << LANES_512) & unused;
        const __m512i d_both = _mm512_permutex2var_epi16(in.d_low, evens, in.d_high);
        const __m512i z = _mm512_maskz_mov_epi16(~black, to_size(in.t, d_both, in.exact));
        up += __builtin_popcount(_mm512_movepi16_mask(in.b) | black);
        for (int k = 0; k < 3; k++)
            _mm512_storeu_si512(
                d + (ptrdiff_t) 64 * k,
                _mm512_mask_permutexvar_epi16(in.v[k], blues[k],
                                              _mm512_srli_epi16(words_at(back + STEP * k), 1), z));
    }
    *negative += (uint64_t) (i - up);
    return i;
}

int32_t ntp__convert_rgb_avx512(const ntp__conversion *j, uint8_t *d, const uint8_t *s, int32_t n,
                                uint64_t *negative)
{
    const bool standard = j->dst->encoding == NTP_ENCODING_STANDARD, deep = j->ms > 255;
    const uint32_t unused = ntp__black_is_unused(j);
    int32_t done = 0;
    if (j->src->encoding != NTP_ENCODING_STANDARD || (!standard && j->ms != j->md))
        return ntp__convert_rgb_avx2(j, d, s, n, negative);
    if (standard)
        done = (deep ? narrow : widen)(d, s, n);
    else
        done = (deep ? to_zzero_16 : to_zzero_8)(d, s, n, unused, negative);
    if (n - done < STEP)
        done += ntp__convert_rgb_avx2(j, d + (ptrdiff_t) (j->md > 255 ? 6 : 3) * done,
                                      s + (ptrdiff_t) (deep ? 6 : 3) * done, n - done, negative);
    return done;
}
