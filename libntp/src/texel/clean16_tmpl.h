/* SPDX-License-Identifier: MIT */
/*
 * clean16_tmpl.h - the loop that derives the blue of packed 16-bit pixels; a part of kernels.c
 *
 * Eight pixels a step.  On x86 the loop is written by hand: compilers do not see that pmaddwd of
 * (a, c) with itself and with (1, 1) gives a(a + 1) + c(c + 1), and besides the square root that is
 * all the arithmetic.  With AVX2 pixels are read and written as in clean8_tmpl.h, which comes first.
 * Elsewhere it is plain C.
 */
#ifdef __SSE2__
#  include <immintrin.h>
#endif

enum {
    CLEAN16_STEP = 8,
    CLEAN16_REST = 1073709055 /* (65535^2 - 5) / 4 */
};

#ifndef __SSE2__

/* Eight pixels; false, with nothing written, when a pair is too long. */
static inline bool clean16_step(uint16_t *dst, const uint16_t *src, bool zzero, uint64_t *changed)
{
    int32_t b[CLEAN16_STEP], odd = 0;
    for (int32_t i = 0; i < CLEAN16_STEP; i++) {
        int32_t r = src[3 * i] - 32768, g = src[3 * i + 1] - 32768;
        int32_t e = CLEAN16_REST - r * (r + 1) - g * (g + 1);
        odd |= e;
        b[i] = blue(e < 0 ? 0 : e, 32768, zzero);
    }
    if (odd < 0)
        return false;
    for (int32_t i = 0; i < CLEAN16_STEP; i++) {
        *changed += src[3 * i + 2] != b[i];
        dst[3 * i] = src[3 * i];
        dst[3 * i + 1] = src[3 * i + 1];
        dst[3 * i + 2] = (uint16_t) b[i];
    }
    return true;
}

#else

/* e of four pairs, red in the lower half and green in the upper; both less 32768. */
static inline __m128i rest4(__m128i rg)
{
    __m128i squares = _mm_madd_epi16(rg, rg), sum = _mm_madd_epi16(rg, _mm_set1_epi16(1));
    return _mm_sub_epi32(_mm_set1_epi32(CLEAN16_REST), _mm_add_epi32(squares, sum));
}

/* blue() of four e, less 32768.  Roots are below 2^15, or are 2^15 by rounding.  pmaddwd squares
 * 2^15 correctly too, although a signed word reads it as -2^15. */
static inline __m128i blue4(__m128i e, bool zzero)
{
    __m128i t = _mm_cvttps_epi32(_mm_sqrt_ps(_mm_cvtepi32_ps(e)));
    t = _mm_add_epi32(t, _mm_cmpgt_epi32(_mm_madd_epi16(t, t), e));
    if (!zzero)
        return t;
    __m128i d2 = _mm_slli_epi32(_mm_sub_epi32(e, _mm_madd_epi16(t, t)), 1);
    __m128i t2 = _mm_add_epi32(t, t), one = _mm_set1_epi32(1);
    __m128i below1 = _mm_cmpgt_epi32(t, _mm_add_epi32(d2, one));
    __m128i below2 = _mm_cmpgt_epi32(_mm_add_epi32(t2, t), d2);
    __m128i z = _mm_add_epi32(t2, _mm_set1_epi32(2 - 32768));
    return _mm_add_epi32(z, _mm_add_epi32(below1, below2));
}

/* Eight pixels; false, with nothing written, when a pair is too long. */
static inline bool clean16_step(uint16_t *dst, const uint16_t *src, bool zzero, uint64_t *changed)
{
    __m128i p[3], rg[2], flip = _mm_set1_epi16(-32768);
    for (int i = 0; i < 3; i++)
        p[i] = _mm_loadu_si128((const __m128i *) (const void *) (src + 8 * i));
    int32_t pair[8];
    for (int i = 0; i < 8; i++)
        memcpy(&pair[i], src + 3 * i, 4);
    rg[0] = _mm_setr_epi32(pair[0], pair[1], pair[2], pair[3]);
    rg[1] = _mm_setr_epi32(pair[4], pair[5], pair[6], pair[7]);
    __m128i e0 = rest4(_mm_xor_si128(rg[0], flip)), e1 = rest4(_mm_xor_si128(rg[1], flip));
    if (_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(e0, e1))) != 0)
        return false;
    __m128i b = _mm_packs_epi32(blue4(e0, zzero), blue4(e1, zzero));
    b = _mm_xor_si128(b, flip);
    uint16_t level[8];
    uint32_t others = 0;
    _mm_storeu_si128((__m128i *) (void *) level, b);
    for (int i = 0; i < 3; i++)
        _mm_storeu_si128((__m128i *) (void *) (dst + 8 * i), p[i]);
    for (int i = 0; i < 8; i++) {
        others += dst[3 * i + 2] != level[i];
        dst[3 * i + 2] = level[i];
    }
    *changed += others;
    return true;
}

#endif

/* Whole steps, up to one that has a pair that is too long. */
static inline int32_t clean16_steps(uint16_t *dst, const uint16_t *src, int32_t n, bool zzero,
                                    uint64_t *changed)
{
    uint64_t others = 0; /* not in memory, where each step would wait for the one before */
    int32_t i = 0;
    while (i + CLEAN16_STEP <= n && clean16_step(dst + 3 * i, src + 3 * i, zzero, &others))
        i += CLEAN16_STEP;
    *changed += others;
    return i;
}

ONE_COPY static int32_t clean16_run(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                                    uint64_t *changed)
{
    return zzero ? clean16_steps(dst, src, n, true, changed)
                 : clean16_steps(dst, src, n, false, changed);
}

/* The last pixels, less than a step, are filled up with flat ones, which do not change. */
static int32_t clean_rgb16(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                           uint64_t *changed)
{
    uint64_t others = 0;
    const int32_t done = clean16_run(dst, src, n, zzero, &others), left = n - done;
    bool all = left == 0;
    if (!all && left < CLEAN16_STEP) {
        uint16_t step[3 * CLEAN16_STEP];
        for (int32_t i = 0; i < 3 * CLEAN16_STEP; i++)
            step[i] = i % 3 == 2 ? 65535 : 32768;
        memcpy(step, src + 3 * done, (size_t) left * 6);
        all = clean16_run(step, step, CLEAN16_STEP, zzero, &others) > 0;
        if (all)
            memcpy(dst + 3 * done, step, (size_t) left * 6);
    }
    if (changed != NULL)
        *changed += others;
    return all ? n : done;
}
