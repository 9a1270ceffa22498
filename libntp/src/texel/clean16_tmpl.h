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

#elif defined __AVX2__

/* Eight pixels: each half is of four, of which `low` has the bytes 0 to 15, and `high` 8 to 23. */
static inline __m256i pairs_of16(__m256i low, __m256i high)
{
    return _mm256_or_si256(SHUFFLE(low, 0, 1, 2, 3, 6, 7, 8, 9, N, N, N, N, N, N, N, N),
                           SHUFFLE(high, N, N, N, N, N, N, N, N, 4, 5, 6, 7, 10, 11, 12, 13));
}

/* Puts eight blues into these bytes, and stores them. */
static inline void put_blues16(uint16_t *dst, __m256i low, __m256i high, __m256i b,
                               uint64_t *changed)
{
    enum { IN_LOW = 0x04, IN_HIGH = 0x92 }; /* the words of blues, each once */
    const __m256i low_now = _mm256_blend_epi16(low, _mm256_slli_si256(b, 4), IN_LOW);
    const __m256i high_now = _mm256_blend_epi16(
        high, SHUFFLE(b, N, N, 4, 5, N, N, N, N, 8, 9, N, N, N, N, 12, 13), IN_HIGH);
    const __m256i same =
        _mm256_and_si256(_mm256_cmpeq_epi16(low_now, low), _mm256_cmpeq_epi16(high_now, high));
    *changed += (uint64_t) __builtin_popcount(~(uint32_t) _mm256_movemask_epi8(same)) / 2;
    store_two(dst, dst + 12, low_now);
    store_two(dst + 4, dst + 16, high_now);
}

/* Eight pixels; false, with nothing written, when a pair is too long. */
static inline bool clean16_step(uint16_t *dst, const uint16_t *src, bool zzero, uint64_t *changed)
{
    const __m256i low = load_two(src, src + 12), high = load_two(src + 4, src + 16);
    const __m256i e = rest_of(pairs_of16(low, high), true);
    if (_mm256_movemask_ps(_mm256_castsi256_ps(e)) != 0)
        return false;
    put_blues16(dst, low, high, blue_of(e, root_of(e, true), true, zzero), changed);
    return true;
}

/* The blue of unused colors whose red and green are those of black or of white; -1: none are unused. */
typedef struct unused_blues {
    int32_t black, white;
} unused_blues;

static inline unused_blues blues_of_unused(int32_t m, uint32_t touch_unused)
{
    return (unused_blues) { touch_unused & NTP_UNUSED_BLACK ? -1 : 0,
                            touch_unused & NTP_UNUSED_WHITE ? -1 : m };
}

static inline __m256i unused_of(texels t, const unused_blues *ends)
{
    const __m256i black = _mm256_and_si256(_mm256_cmpeq_epi32(t.rg, _mm256_setzero_si256()),
                                           _mm256_cmpeq_epi32(t.b, _mm256_set1_epi32(ends->black)));
    const __m256i white = _mm256_and_si256(_mm256_cmpeq_epi32(t.rg, _mm256_set1_epi32(-1)),
                                           _mm256_cmpeq_epi32(t.b, _mm256_set1_epi32(ends->white)));
    return _mm256_or_si256(black, white);
}

enum { MOST_16 = 256, ROOM_16 = MOST_16 + CLEAN16_STEP };

/* Pairs of a block that are too long, in whole steps; what |X| and |Y| become, halved, in units of 2^-16; and
 * blues, negative where the pair is in doubt.  One loop for all that is done to them would wait, as it has long chains. */
typedef struct many_long {
    int32_t rg[ROOM_16], unit[2][ROOM_16], blue[ROOM_16];
} many_long;

static inline __m256i load_8(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) from);
}

static inline void store_8(int32_t *to, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) to, v);
}

static inline __m128i half_of(__m256i v, int k)
{
    return k == 0 ? _mm256_castsi256_si128(v) : _mm256_extracti128_si256(v, 1);
}

/*
 * Shortens eight pairs.  The squares of X and Y have the sum 4w + 2.  A float r of 1/sqrt(w + 1/2) is off by
 * at most 3u of it, as in normalize16_tmpl.h, and so are units by less than 1/2 after a step of Newton.
 */
static inline void shorten(many_long *to, int32_t first)
{
    const double by = 65535 * 65536.0 / 8;
    const __m256i p = _mm256_xor_si256(load_8(to->rg + first), _mm256_set1_epi16(-32768));
    const __m256i q = _mm256_xor_si256(p, _mm256_srai_epi16(p, 15)), x = _mm256_add_epi16(q, q);
    const __m256i one = _mm256_set1_epi32(1), w = sum_of_pair(q);
    const __m256i size[2] = { _mm256_or_si256(_mm256_and_si256(x, _mm256_set1_epi32(65535)), one),
                              _mm256_or_si256(_mm256_srli_epi32(x, 16), one) };
    const __m256 square = _mm256_add_ps(_mm256_cvtepi32_ps(w), _mm256_set1_ps(0.5F));
    const __m256 over = _mm256_div_ps(_mm256_set1_ps(1), _mm256_sqrt_ps(square));
    UNROLLED
    for (int k = 0; k < 2; k++) {
        const __m256d r = _mm256_cvtps_pd(_mm_castsi128_ps(half_of(_mm256_castps_si256(over), k)));
        const __m256d s = _mm256_add_pd(_mm256_cvtepi32_pd(half_of(w, k)), _mm256_set1_pd(0.5));
        const __m256d rest =
            _mm256_sub_pd(_mm256_set1_pd(3), _mm256_mul_pd(s, _mm256_mul_pd(r, r)));
        const __m256d factor = _mm256_mul_pd(_mm256_mul_pd(r, _mm256_set1_pd(by)), rest);
        for (int i = 0; i < 2; i++)
            _mm_storeu_si128(
                (__m128i *) (void *) (to->unit[i] + first + 4 * k),
                _mm256_cvtpd_epi32(_mm256_mul_pd(_mm256_cvtepi32_pd(half_of(size[i], k)), factor)));
    }
}

/* Pulls them as pull() in judge_tmpl.h, and derives their blues.  Whole units are the nearest, so a pair is in
 * doubt where they are a whole size; but all become less than they were. */
static inline void pull_eight(many_long *to, int32_t first, bool zzero)
{
    const __m256i p = _mm256_xor_si256(load_8(to->rg + first), _mm256_set1_epi16(-32768));
    const __m256i sign = _mm256_srai_epi16(p, 15), half = _mm256_set1_epi32(32768);
    const __m256i q = _mm256_xor_si256(p, sign), last = _mm256_set1_epi32(65535);
    const __m256i u = _mm256_min_epu32(_mm256_add_epi32(load_8(to->unit[0] + first), half),
                                       _mm256_or_si256(_mm256_slli_epi32(q, 16), last));
    const __m256i v = _mm256_min_epu32(_mm256_add_epi32(load_8(to->unit[1] + first), half),
                                       _mm256_or_si256(q, last));
    const __m256i part = _mm256_blend_epi16(u, _mm256_slli_epi32(v, 16), 0xaa);
    const __m256i whole = _mm256_cmpeq_epi16(part, _mm256_setzero_si256());
    const __m256i doubt = _mm256_or_si256(whole, _mm256_slli_epi32(whole, 16));
    const __m256i size = onto_disc(_mm256_blend_epi16(_mm256_srli_epi32(u, 16), v, 0xaa), q, true);
    const __m256i e = _mm256_sub_epi32(_mm256_set1_epi32(REST_16), sum_of_pair(size));
    const __m256i blue = blue_of(e, root_of(e, true), true, zzero);
    store_8(to->rg + first,
            _mm256_xor_si256(size, _mm256_xor_si256(sign, _mm256_set1_epi16(-32768))));
    store_8(to->blue + first,
            _mm256_or_si256(blue, _mm256_and_si256(doubt, _mm256_set1_epi32(INT32_MIN))));
}

/* Pulls n of a block's pixels, in place; returns how many are in doubt and stay as they are: at[0] and so on. */
ONE_COPY static int32_t pull_pixels(uint16_t *d, int32_t *at, int32_t n, bool zzero)
{
    many_long v;
    int32_t left = 0;
    for (int32_t i = 0; i < n; i++)
        memcpy(v.rg + i, d + 3 * at[i], sizeof v.rg[i]);
    store_8(v.rg + n, _mm256_setzero_si256());
    for (int32_t i = 0; i < n; i += CLEAN16_STEP)
        shorten(&v, i);
    for (int32_t i = 0; i < n; i += CLEAN16_STEP)
        pull_eight(&v, i, zzero);
    for (int32_t i = 0; i < n; i++) {
        uint16_t *const to = d + 3 * at[i];
        if (v.blue[i] < 0) {
            at[left++] = at[i];
            continue;
        }
        memcpy(to, v.rg + i, sizeof v.rg[i]);
        to[2] = (uint16_t) v.blue[i];
    }
    return left;
}

/* Eight pixels, of which unused ones and those that are too long stay as they are; returns bits of the latter. */
static inline int derive16_step(uint16_t *dst, const uint16_t *src, bool zzero,
                                const unused_blues *ends, uint64_t *changed)
{
    const texels t = take16((const uint8_t *) src);
    const __m256i e = rest_of(t.rg, true), longs = _mm256_srai_epi32(e, 31);
    const __m256i b = _mm256_blendv_epi8(blue_of(e, root_of(e, true), true, zzero), t.b, longs);
    const __m256i same = _mm256_cmpeq_epi32(b, t.b);
    int left = _mm256_movemask_ps(_mm256_castsi256_ps(longs));
    *changed += (uint64_t) __builtin_popcount(
        0xff ^ (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(same)));
    put16((uint8_t *) dst, (texels) { t.rg, b });
    if (left != 0)
        left &= ~_mm256_movemask_ps(_mm256_castsi256_ps(unused_of(t, ends)));
    return left;
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
    uint64_t others = 0; /* not in memory, where each step would wait for the one before */
    int32_t i = 0;
    while (i + CLEAN16_STEP <= n && clean16_step(dst + 3 * i, src + 3 * i, zzero, &others))
        i += CLEAN16_STEP;
    if (i < n && i + CLEAN16_STEP > n &&
        clean16_rest(dst + 3 * i, src + 3 * i, n - i, zzero, &others))
        i = n;
    if (changed != NULL)
        *changed += others;
    return i;
}
