/* SPDX-License-Identifier: MIT */
/*
 * paint_avx512.c - lit previews and heatmaps of packed RGB, with AVX-512
 *
 * As paint_avx2.c, but 16 texels at a time, and in one loop.  With u = 2^-24, the guess of 1 over a length is off
 * by less than 2^-14, its step leaves 1.5 times the square of that, u/10, and adds 2.5u; the square of the length
 * adds 1.5u.  So 1 over a length is off by less than 4.2u, not 3.5u, and cosines by less than 9.2u of the 10u in
 * shade.c.  Faults take few instructions, so no branch asks whether there are any: it would
 * often be mispredicted.
 */
#include "picture/paint_avx2.h"

#include "base/lanes_avx2.h"
#include "texel/packed_avx512_tmpl.h"

enum { STEP = LANES_512 };

static inline __m512 all(float v)
{
    return _mm512_set1_ps(v);
}

static inline __m512i ints(int32_t v)
{
    return _mm512_set1_epi32(v);
}

static inline __m512 dot(const __m512 v[3], const float w[3])
{
    return _mm512_fmadd_ps(v[2], all(w[2]),
                           _mm512_fmadd_ps(v[1], all(w[1]), _mm512_mul_ps(v[0], all(w[0]))));
}

/* Levels less M/2: half of the numerators, exactly. */
static inline __m512 centered(__m512i level, float middle)
{
    return _mm512_sub_ps(_mm512_cvtepi32_ps(level), all(middle));
}

/* Of each 32 bits three bytes. */
static inline void put_colors(uint8_t *d, __m512i color)
{
    static const _Alignas(64) uint8_t from[64] = {
        0,  1,  2,  4,  5,  6,  8,  9,  10, 12, 13, 14, 16, 17, 18, 20,
        21, 22, 24, 25, 26, 28, 29, 30, 32, 33, 34, 36, 37, 38, 40, 41,
        42, 44, 45, 46, 48, 49, 50, 52, 53, 54, 56, 57, 58, 60, 61, 62,
    };
    const __m512i v = _mm512_permutexvar_epi8(_mm512_load_si512(from), color);
    _mm256_storeu_si256((void *) d, _mm512_castsi512_si256(v));
    _mm_storeu_si128((void *) (d + 32), _mm512_extracti32x4_epi32(v, 2));
}

/* Each of 16 levels three times. */
static inline void put_gray(uint8_t *d, __m512i level)
{
    static const _Alignas(64) uint8_t from[64] = {
        0,  0,  0,  4,  4,  4,  8,  8,  8,  12, 12, 12, 16, 16, 16, 20,
        20, 20, 24, 24, 24, 28, 28, 28, 32, 32, 32, 36, 36, 36, 40, 40,
        40, 44, 44, 44, 48, 48, 48, 52, 52, 52, 56, 56, 56, 60, 60, 60,
    };
    const __m512i v = _mm512_permutexvar_epi8(_mm512_load_si512(from), level);
    _mm256_storeu_si256((void *) d, _mm512_castsi512_si256(v));
    _mm_storeu_si128((void *) (d + 32), _mm512_extracti32x4_epi32(v, 2));
}

/* What of a lamp is not made anew for each texel. */
typedef struct lamp {
    ntp__lamp of;         /* of one color, and y as it is stored */
    float middle, corner; /* M/2; the square of the length of corners, or a little less */
} lamp;

/* As `light` and `show` of picture_kernels.c; returns bits of those in doubt. */
static inline uint32_t shade(uint8_t *d, texels t, const lamp *how)
{
    const ntp__lamp *const l = &how->of;
    const __m512 v[3] = { centered(_mm512_and_si512(t.rg, _mm512_set1_epi32(65535)), how->middle),
                          centered(_mm512_srli_epi32(t.rg, 16), how->middle),
                          centered(t.b, how->middle) };
    const __m512 zero = _mm512_setzero_ps(), one = all(1);
    const __m512 square =
        _mm512_fmadd_ps(v[2], v[2], _mm512_fmadd_ps(v[1], v[1], _mm512_mul_ps(v[0], v[0])));
    /* A step of Newton's from a guess waits for no divider. */
    const __m512 guess = _mm512_rsqrt14_ps(square);
    const __m512 by = _mm512_fnmadd_ps(_mm512_mul_ps(square, guess), guess, all(3));
    const __m512 over = _mm512_mul_ps(_mm512_mul_ps(guess, all(0.5F)), by);
    const __m512 lambert = _mm512_mul_ps(dot(v, l->towards), over);
    /* Less than 1/8 is as good as 0, and the power of less may be a slow number. */
    __m512 glint = _mm512_max_ps(_mm512_mul_ps(dot(v, l->half), over), all(0.125F));
    for (int32_t k = 0; k < NTP__SQUARINGS; k++)
        glint = _mm512_mul_ps(glint, glint);
    glint = _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(lambert, zero, _CMP_GT_OQ), glint);
    const __m512 light = _mm512_fmadd_ps(
        glint, all(l->specular),
        _mm512_fmadd_ps(_mm512_max_ps(lambert, zero), all(l->diffuse), all(l->ambient)));
    const __m512 root = _mm512_sqrt_ps(_mm512_min_ps(light, one));
    const __m512 shown = _mm512_mul_ps(root, all(255));
    const __m512i level = _mm512_cvtps_epi32(shown);
    const __m512 part = _mm512_abs_ps(_mm512_sub_ps(shown, _mm512_cvtepi32_ps(level)));
    const __m512 gap = _mm512_sub_ps(all(0.5F - 0x1p-14F), part);
    const __m512 off = _mm512_fmadd_ps(glint, all(l->off_by_glint), all(l->off));
    put_gray(d, level);
    /* Light may be on the other side; and only corners of the cube are as long as black and white. */
    const __mmask16 edge =
        _mm512_cmp_ps_mask(_mm512_abs_ps(lambert), all(NTP__EDGE_OF_LIGHT), _CMP_LT_OQ);
    const __mmask16 corner = _mm512_cmp_ps_mask(square, all(how->corner), _CMP_GE_OQ);
    return edge | corner | _mm512_cmp_ps_mask(_mm512_mul_ps(gap, root), off, _CMP_NGT_UQ);
}

int32_t ntp__shade_rgb_avx512(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src, int32_t n,
                              bool deep, const ntp__lamp *how, float own)
{
    const uint8_t *s = src;
    int32_t found = 0, i = 0;
    lamp l = { *how, how->m / 2, 0.75F * (1 - 0x1p-18F) * how->m * how->m };
    l.of.towards[1] *= how->up;
    l.of.half[1] *= how->up;
    l.of.ambient *= own;
    l.of.diffuse *= own;
    for (; i + STEP <= n; i += STEP, dst += 3 * STEP, s += (deep ? 6 : 3) * STEP) {
        const uint32_t bits = shade(dst, deep ? take16(s) : take8(s), &l);
        odd[i / 8] = (uint8_t) bits;
        odd[i / 8 + 1] = (uint8_t) (bits >> 8);
        found += __builtin_popcount(bits);
    }
    end_lanes();
    return i < n ? found + ntp__shade_rgb_avx2(dst, odd + i / 8, s, n - i, deep, how, own) : found;
}

/* 100 + half of luma, as gray_of of paint_avx2.c, which says why; also of 8 bit, whose sums are below 2^23. */
static inline __m512i gray_of(__m512i rg, __m512i b, int32_t m)
{
    const int32_t whole = NTP__LUMA_WHOLE * (m / 255), twice = 2 * whole;
    const int32_t more = NTP__LUMA_WHOLE * ((m + 1) / 2) + whole / 2;
    const int32_t least = (int32_t) (twice - 1 - (int64_t) NTP__GRAY_BASE * twice);
    const __m512i sum =
        _mm512_add_epi32(_mm512_madd_epi16(rg, ints(NTP__LUMA_GREEN << 16 | NTP__LUMA_RED)),
                         _mm512_madd_epi16(b, ints(NTP__LUMA_BLUE)));
    const __m512i s = _mm512_add_epi32(sum, ints(more));
    const __m512i low = _mm512_cvttps_epi32(_mm512_fmadd_ps(
        _mm512_cvtepi32_ps(s), all(1.0F / (float) twice), all(NTP__GRAY_BASE - 0x1p-13F)));
    const __m512i rest = _mm512_sub_epi32(s, _mm512_mullo_epi32(low, ints(twice)));
    return _mm512_mask_add_epi32(low, _mm512_cmpgt_epi32_mask(rest, ints(least)), low, ints(1));
}

/* Is v beyond these limits? */
static inline __mmask16 is_outside(__m512i v, int32_t below, int32_t from)
{
    return _mm512_cmpge_epu32_mask(_mm512_sub_epi32(v, ints(below)), ints(from - below));
}

/* One number where one bit is set, another where both are; the bits of `strong` are among those of `weak`. */
static inline __m512i strength(__mmask16 weak, int32_t if_weak, __mmask16 strong, int32_t if_strong)
{
    return _mm512_mask_mov_epi32(_mm512_maskz_mov_epi32(weak, ints(if_weak)), strong,
                                 ints(if_strong));
}

/* As `heat` of paint_avx2.c; returns bits of those in doubt. */
static inline uint32_t heat(uint8_t *d, texels t, bool deep, const ntp__limits *l)
{
    const int32_t m = l->m, k = (m + 1) / 2, most = k * (k - 1);
    const __m512i rg = _mm512_sub_epi16(t.rg, _mm512_set1_epi16((short) k));
    const __m512i b = _mm512_sub_epi16(t.b, ints(k)), rest = rest_of(t.rg, deep);
    /* b(b + 1), of halves of 32 bits the other of which is 0 */
    const __m512i z =
        _mm512_sub_epi32(ints(0), _mm512_madd_epi16(b, _mm512_xor_si512(b, ints(-1))));
    const __m512i xy = _mm512_xor_si512(rest, ints(-1)), full = _mm512_add_epi32(xy, z);
    const __m512i pulled = _mm512_sub_epi32(z, ints(m + m / 2));
    const __mmask16 overlong = _mm512_cmplt_epi32_mask(rest, ints(0));
    const __mmask16 hard = _mm512_cmpge_epi32_mask(xy, ints(l->xy_strong));
    const __mmask16 below = _mm512_cmplt_epi32_mask(t.b, ints(k));
    const __m512i sum = _mm512_mask_mov_epi32(full, overlong, pulled);
    const __mmask16 weak = is_outside(sum, l->short_weak, l->long_weak);
    const __mmask16 strong = is_outside(sum, l->short_strong, l->long_strong);
    __m512i down = _mm512_maskz_xor_epi32(below, t.b, ints(m));
    if (deep) /* times 255/65535, rounded, as in picture_kernels.c */
        down = _mm512_srli_epi32(
            _mm512_add_epi32(_mm512_sub_epi32(_mm512_slli_epi32(down, 8), down), ints(32895)), 16);
    const __m512i faults = _mm512_or_si512(_mm512_or_si512(strength(overlong, 0x80, hard, 0xff),
                                                           strength(weak, 0x8000, strong, 0xff00)),
                                           _mm512_slli_epi32(down, 16));
    const __m512i gray = _mm512_mullo_epi32(gray_of(rg, b, m), ints(0x010101));
    put_colors(d, _mm512_mask_mov_epi32(faults, _mm512_testn_epi32_mask(faults, faults), gray));
    const __mmask16 doubt = overlong & _mm512_cmpgt_epi32_mask(z, ints(l->long_weak + 1)) &
                            _mm512_cmplt_epi32_mask(pulled, ints(l->long_strong));
    return doubt | _mm512_cmpge_epi32_mask(full, ints(2 * most));
}

int32_t ntp__heat_rgb_avx512(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src, int32_t n,
                             bool deep, const ntp__limits *limits)
{
    const uint8_t *s = src;
    const ntp__limits l = *limits;
    int32_t found = 0, i = 0;
    for (; i + STEP <= n; i += STEP, dst += 3 * STEP, s += (deep ? 6 : 3) * STEP) {
        const uint32_t bits = heat(dst, deep ? take16(s) : take8(s), deep, &l);
        odd[i / 8] = (uint8_t) bits;
        odd[i / 8 + 1] = (uint8_t) (bits >> 8);
        found += __builtin_popcount(bits);
    }
    end_lanes();
    return i < n ? found + ntp__heat_rgb_avx2(dst, odd + i / 8, s, n - i, deep, limits) : found;
}
