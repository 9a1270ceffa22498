/* SPDX-License-Identifier: MIT */
/*
 * paint_avx512.c - lit previews of packed RGB, with AVX-512
 *
 * As paint_avx2.c, but 16 texels at a time, and in one loop.  Fused products only make errors smaller, so
 * shade.c's bounds hold.
 */
#include "picture/paint_avx2.h"

#include "texel/packed_avx512_tmpl.h"

enum { STEP = LANES_512 };

static inline __m512 all(float v)
{
    return _mm512_set1_ps(v);
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
    const __m512 over = _mm512_div_ps(one, _mm512_sqrt_ps(square));
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
    return i < n ? found + ntp__shade_rgb_avx2(dst, odd + i / 8, s, n - i, deep, how, own) : found;
}
