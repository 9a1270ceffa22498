/* SPDX-License-Identifier: MIT */
/*
 * clean16_tmpl.h - the loop that derives the blue of packed 16-bit pixels; a part of kernels.c
 *
 * Eight pixels a step.  On x86 the loop is written by hand: compilers do not see that pmaddwd of
 * (a, c) with itself and with (1, 1) gives a(a + 1) + c(c + 1), and besides the square root that is
 * all the arithmetic.  Elsewhere it is plain C.
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
        if (changed != NULL)
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

#  ifdef __SSSE3__

/* Bytes of a shuffle: words of the source, or nothing. */
#    define W(i) 2 * (i), 2 * (i) + 1
#    define NO   -1, -1

static inline void load_pairs(__m128i rg[2], const __m128i p[3])
{
    rg[0] = _mm_or_si128(
        _mm_shuffle_epi8(p[0], _mm_setr_epi8(W(0), W(1), W(3), W(4), W(6), W(7), NO, NO)),
        _mm_shuffle_epi8(p[1], _mm_setr_epi8(NO, NO, NO, NO, NO, NO, W(1), W(2))));
    rg[1] = _mm_or_si128(
        _mm_shuffle_epi8(p[1], _mm_setr_epi8(W(4), W(5), W(7), NO, NO, NO, NO, NO)),
        _mm_shuffle_epi8(p[2], _mm_setr_epi8(NO, NO, NO, W(0), W(2), W(3), W(5), W(6))));
}

/* Returns how many blues were others.  Each of the eight has a place of its own in the vectors. */
static inline uint32_t replace_blues(__m128i p[3], __m128i b)
{
    __m128i at[3] = { _mm_setr_epi8(NO, NO, W(0), NO, NO, W(1), NO, NO),
                      _mm_setr_epi8(W(2), NO, NO, W(3), NO, NO, W(4), NO),
                      _mm_setr_epi8(NO, W(5), NO, NO, W(6), NO, NO, W(7)) };
    __m128i blues[3] = { _mm_setr_epi16(0, 0, -1, 0, 0, -1, 0, 0),
                         _mm_setr_epi16(-1, 0, 0, -1, 0, 0, -1, 0),
                         _mm_setr_epi16(0, -1, 0, 0, -1, 0, 0, -1) };
    __m128i differ = _mm_setzero_si128();
    for (int i = 0; i < 3; i++) {
        const __m128i now =
            _mm_or_si128(_mm_andnot_si128(blues[i], p[i]), _mm_shuffle_epi8(b, at[i]));
        differ = _mm_or_si128(differ, _mm_xor_si128(now, p[i]));
        p[i] = now;
    }
    const int same = _mm_movemask_epi8(_mm_cmpeq_epi16(differ, _mm_setzero_si128()));
    return (uint32_t) __builtin_popcount((unsigned) same ^ 0xffff) / 2;
}

#    undef W
#    undef NO

#  endif

/* Eight pixels; false, with nothing written, when a pair is too long. */
static inline bool clean16_step(uint16_t *dst, const uint16_t *src, bool zzero, uint64_t *changed)
{
    __m128i p[3], rg[2], flip = _mm_set1_epi16(-32768);
    for (int i = 0; i < 3; i++)
        p[i] = _mm_loadu_si128((const __m128i *) (const void *) (src + 8 * i));
#  ifdef __SSSE3__
    load_pairs(rg, p);
#  else
    int32_t pair[8];
    for (int i = 0; i < 8; i++)
        memcpy(&pair[i], src + 3 * i, 4);
    rg[0] = _mm_setr_epi32(pair[0], pair[1], pair[2], pair[3]);
    rg[1] = _mm_setr_epi32(pair[4], pair[5], pair[6], pair[7]);
#  endif
    __m128i e0 = rest4(_mm_xor_si128(rg[0], flip)), e1 = rest4(_mm_xor_si128(rg[1], flip));
    if (_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(e0, e1))) != 0)
        return false;
    __m128i b = _mm_packs_epi32(blue4(e0, zzero), blue4(e1, zzero));
    b = _mm_xor_si128(b, flip);
#  ifdef __SSSE3__
    const uint32_t others = replace_blues(p, b);
    for (int i = 0; i < 3; i++)
        _mm_storeu_si128((__m128i *) (void *) (dst + 8 * i), p[i]);
#  else
    uint16_t level[8];
    uint32_t others = 0;
    _mm_storeu_si128((__m128i *) (void *) level, b);
    for (int i = 0; i < 3; i++)
        _mm_storeu_si128((__m128i *) (void *) (dst + 8 * i), p[i]);
    for (int i = 0; i < 8; i++) {
        others += dst[3 * i + 2] != level[i];
        dst[3 * i + 2] = level[i];
    }
#  endif
    if (changed != NULL)
        *changed += others;
    return true;
}

#endif

/* Less than a step of pixels, filled up with flat ones, which do not change. */
static inline bool clean16_rest(uint16_t *dst, const uint16_t *src, int32_t n, bool zzero,
                                uint64_t *changed)
{
    uint16_t step[3 * CLEAN16_STEP];
    for (int32_t i = 0; i < 3 * CLEAN16_STEP; i++)
        step[i] = i % 3 == 2 ? 65535 : 32768;
    memcpy(step, src, (size_t) n * 6);
    if (!clean16_step(step, step, zzero, changed))
        return false;
    memcpy(dst, step, (size_t) n * 6);
    return true;
}

static inline int32_t clean16_run(uint16_t *dst, const uint16_t *src, int32_t n, bool zzero,
                                  uint64_t *changed)
{
    int32_t i = 0;
    for (; i + CLEAN16_STEP <= n; i += CLEAN16_STEP) {
        if (!clean16_step(dst + 3 * i, src + 3 * i, zzero, changed))
            return i;
    }
    return i == n || clean16_rest(dst + 3 * i, src + 3 * i, n - i, zzero, changed) ? n : i;
}
