/* SPDX-License-Identifier: MIT */
/*
 * resize_avx2.c - sums of rows and columns in floats, and their directions as packed RGB, with AVX2
 *
 * Floats are twice as quick as the doubles of resize_kernels.c, and as good where all sums are
 * integers below 2^24.  Else resize_strip.c says how far a component may be off, in the same units.
 *
 * The bound of directions, where u = 2^-24, E that error, and L the length of the vector.  Quotients
 * x/L are off by (1 + sqrt(3)) E/L at most.  The components are floats.  So the sum of their squares is
 * off by 3u, the root by 2.5u, the factor by 3.5u, and the quotient by 4.5u of itself besides, less than
 * 5u.  Components of 8 bit may be exact sums that were rounded once: then each of these is off by u more,
 * squares by 2u, and x by u, so the quotient is by 6.5u, less than 7u.  Fused products round less often.
 */
#include "base/inlining.h"
#include "base/view.h"
#include "reshape/resize_kernels.h"
#include "texel/packed_avx2_tmpl.h"

#include <string.h>

enum {
    AT_ONCE = 32, /* numbers of a row */
    FOUR = 4,     /* texels */
    EIGHT = 8
};

/* 16 sums of two numbers */
static inline __m256i load_both(const float *row, const float *other, int32_t i)
{
    const int16_t *a = (const void *) row, *b = (const void *) other;
    return _mm256_add_epi16(_mm256_loadu_si256((const void *) (a + i)),
                            _mm256_loadu_si256((const void *) (b + i)));
}

static inline __m256i two_weights(const int16_t *weight)
{
    int32_t two;
    memcpy(&two, weight, sizeof two);
    return _mm256_set1_epi32(two);
}

/* Of both halves of 16 numbers: sums of upper parts of weights, and of lower ones. */
typedef struct both_parts {
    __m256i high[2], low[2];
} both_parts;

/* With n weights; few registers are enough for 16 numbers. */
static ALWAYS_INLINE both_parts sum_parts(const ntp__whole_weights *from, int32_t n, int32_t i)
{
    both_parts p;
    p.high[0] = p.high[1] = p.low[0] = p.low[1] = _mm256_setzero_si256();
    for (int32_t t = 0; t < n; t += 2) {
        const __m256i w = two_weights(from->upper + t), x = two_weights(from->lower + t);
        const __m256i a = load_both(from->row[t], from->other[t], i);
        const __m256i b = load_both(from->row[t + 1], from->other[t + 1], i);
        const __m256i c[2] = { _mm256_unpacklo_epi16(a, b), _mm256_unpackhi_epi16(a, b) };
        UNROLLED
        for (int32_t m = 0; m < 2; m++) {
            p.high[m] = _mm256_add_epi32(p.high[m], _mm256_madd_epi16(c[m], w));
            p.low[m] = _mm256_add_epi32(p.low[m], _mm256_madd_epi16(c[m], x));
        }
    }
    return p;
}

static ALWAYS_INLINE void sum_whole(float *sums, const ntp__whole_weights *from, int32_t n,
                                    int32_t count)
{
    for (int32_t i = 0; i < count; i += 2 * EIGHT) {
        const both_parts p = sum_parts(from, n, i);
        __m256 v[2];
        UNROLLED
        for (int32_t m = 0; m < 2; m++)
            v[m] = _mm256_fmadd_ps(_mm256_cvtepi32_ps(p.low[m]), _mm256_set1_ps(0x1p-15F),
                                   _mm256_cvtepi32_ps(p.high[m]));
        _mm256_storeu_ps(sums + i, _mm256_permute2f128_ps(v[0], v[1], 0x20));
        _mm256_storeu_ps(sums + i + EIGHT, _mm256_permute2f128_ps(v[0], v[1], 0x31));
    }
}

void ntp__add_whole_avx2(double *sums, const ntp__whole_weights *from, double scale, int32_t first,
                         int32_t count)
{
    const __m256d one = _mm256_set1_pd(scale), upper = _mm256_set1_pd(scale * 0x1p15);
    for (int32_t i = first; i < first + count; i += 2 * EIGHT) {
        const both_parts p = sum_parts(from, from->n, i);
        __m128i high[4], low[4];
        UNROLLED
        for (int32_t m = 0; m < 2; m++) {
            high[m] = _mm256_castsi256_si128(p.high[m]);
            low[m] = _mm256_castsi256_si128(p.low[m]);
            high[m + 2] = _mm256_extracti128_si256(p.high[m], 1);
            low[m + 2] = _mm256_extracti128_si256(p.low[m], 1);
        }
        UNROLLED
        for (int32_t m = 0; m < 4; m++)
            _mm256_storeu_pd(sums + i + 4 * m,
                             _mm256_add_pd(_mm256_mul_pd(_mm256_cvtepi32_pd(high[m]), upper),
                                           _mm256_mul_pd(_mm256_cvtepi32_pd(low[m]), one)));
    }
}

/* Lanczos has six pairs of rows where the height is halved. */
void ntp__sum_whole_avx2(float *sums, const ntp__whole_weights *from, int32_t count)
{
    if (from->n == 6)
        sum_whole(sums, from, 6, count);
    else
        sum_whole(sums, from, from->n, count);
}

void ntp__sum_rows_avx2(float *sums, const float *const *rows, const int32_t *weight, float scale,
                        int32_t taps, bool symmetric, int32_t count)
{
    const int32_t end = symmetric ? taps / 2 : taps;
    for (int32_t i = 0; i < count; i += AT_ONCE) {
        __m256 sum[AT_ONCE / EIGHT];
        UNROLLED
        for (int32_t k = 0; k < AT_ONCE / EIGHT; k++)
            sum[k] = _mm256_setzero_ps();
        for (int32_t t = 0; t < end; t++) {
            const __m256 w = _mm256_set1_ps((float) weight[t] * scale);
            const float *a = rows[t] + i, *b = rows[taps - 1 - t] + i;
            UNROLLED
            for (int32_t k = 0; k < AT_ONCE / EIGHT; k++) {
                __m256 v = _mm256_loadu_ps(a + k * EIGHT);
                if (symmetric)
                    v = _mm256_add_ps(v, _mm256_loadu_ps(b + k * EIGHT));
                sum[k] = _mm256_fmadd_ps(w, v, sum[k]);
            }
        }
        UNROLLED
        for (int32_t k = 0; k < AT_ONCE / EIGHT; k++)
            _mm256_storeu_ps(sums + i + k * EIGHT, sum[k]);
    }
}

/* Two weights, each four times. */
static inline __m256 spread(const float *weight)
{
    double two;
    memcpy(&two, weight, sizeof two);
    return _mm256_permutevar8x32_ps(_mm256_castpd_ps(_mm256_castpd128_pd256(_mm_set_sd(two))),
                                    _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
}

void ntp__sum_columns_avx2(ntp__planes *out, float least[4], const float *sums,
                           const int32_t *first, const float *weight, int32_t taps, int32_t n)
{
    __m128 low = _mm_set1_ps(0x1p100F);
    int32_t i = 0;
    for (; i < n; i += FOUR) {
        const float *c[FOUR], *w[FOUR];
        __m256 sum[FOUR];
        __m128 v[FOUR];
        UNROLLED
        for (int32_t k = 0; k < FOUR; k++) {
            const int32_t at = i + k < n ? i + k : n - 1;
            c[k] = sums + 4 * (ptrdiff_t) first[at];
            w[k] = weight + (ptrdiff_t) taps * at;
            sum[k] = _mm256_setzero_ps();
        }
        for (int32_t t = 0; t < taps; t += 2) {
            UNROLLED
            for (int32_t k = 0; k < FOUR; k++)
                sum[k] = _mm256_fmadd_ps(spread(w[k] + t), _mm256_loadu_ps(c[k] + 4 * t), sum[k]);
        }
        UNROLLED
        for (int32_t k = 0; k < FOUR; k++) {
            v[k] = _mm_add_ps(_mm256_castps256_ps128(sum[k]), _mm256_extractf128_ps(sum[k], 1));
            low = _mm_min_ps(low, v[k]);
        }
        _MM_TRANSPOSE4_PS(v[0], v[1], v[2], v[3]);
        UNROLLED
        for (int32_t k = 0; k < FOUR; k++)
            _mm_storeu_ps(out->c[k] + i, v[k]);
    }
    for (; i % (2 * EIGHT) != 0; i++)
        out->c[0][i] = out->c[1][i] = out->c[2][i] = 0;
    _mm_storeu_ps(least, low);
}

void ntp__sum_halves_avx2(ntp__planes *out, float least[4], const float *sums, const float *weight,
                          int32_t taps, int32_t n, int32_t planes)
{
    for (int32_t p = 0; p < planes; p++, sums += 2 * NTP__RUN) {
        __m256 low = _mm256_set1_ps(0x1p100F);
        for (int32_t i = 0; i < n; i += AT_ONCE) {
            const int32_t at = i + AT_ONCE < n ? i : n - AT_ONCE;
            /* From either end, even and odd columns take turns. */
            const float *a = sums + at, *b = a + NTP__RUN + taps / 2 - 1;
            ptrdiff_t step = NTP__RUN;
            __m256 sum[FOUR];
            UNROLLED
            for (int32_t k = 0; k < FOUR; k++)
                sum[k] = _mm256_setzero_ps();
            for (int32_t t = 0; t < taps / 2; t++, a += step, b -= step, step = 1 - step) {
                const __m256 w = _mm256_set1_ps(weight[t]);
                UNROLLED
                for (int32_t k = 0; k < FOUR; k++)
                    sum[k] = _mm256_fmadd_ps(w,
                                             _mm256_add_ps(_mm256_loadu_ps(a + EIGHT * k),
                                                           _mm256_loadu_ps(b + EIGHT * k)),
                                             sum[k]);
            }
            UNROLLED
            for (int32_t k = 0; k < FOUR; k++) {
                low = _mm256_min_ps(low, sum[k]);
                _mm256_storeu_ps(out->c[p] + at + EIGHT * k, sum[k]);
            }
        }
        const __m128 half = _mm_min_ps(_mm256_castps256_ps128(low), _mm256_extractf128_ps(low, 1));
        const __m128 two = _mm_min_ps(half, _mm_movehl_ps(half, half));
        least[p] = _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
    }
    for (int32_t i = n; i % (2 * EIGHT) != 0; i++)
        out->c[0][i] = out->c[1][i] = out->c[2][i] = 0;
}

/* The samples of one color of 32 pixels, or 16 (deep), in their order. */
static ALWAYS_INLINE __m256i color_of(const __m256i v[3], int32_t c, bool deep)
{
    if (deep) {
        const __m256i w =
            c == 0   ? _mm256_blend_epi16(_mm256_blend_epi16(v[0], v[1], 0x92), v[2], 0x24)
            : c == 1 ? _mm256_blend_epi16(_mm256_blend_epi16(v[0], v[1], 0x24), v[2], 0x49)
                     : _mm256_blend_epi16(_mm256_blend_epi16(v[0], v[1], 0x49), v[2], 0x92);
        return c == 0   ? SHUFFLE(w, 0, 1, 6, 7, 12, 13, 2, 3, 8, 9, 14, 15, 4, 5, 10, 11)
               : c == 1 ? SHUFFLE(w, 2, 3, 8, 9, 14, 15, 4, 5, 10, 11, 0, 1, 6, 7, 12, 13)
                        : SHUFFLE(w, 4, 5, 10, 11, 0, 1, 6, 7, 12, 13, 2, 3, 8, 9, 14, 15);
    }
    const __m256i first = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(-1, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, -1));
    const __m256i second = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(0, -1, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0));
    const __m256i w =
        c == 0   ? _mm256_blendv_epi8(_mm256_blendv_epi8(v[1], v[0], first), v[2], second)
        : c == 1 ? _mm256_blendv_epi8(_mm256_blendv_epi8(v[2], v[1], first), v[0], second)
                 : _mm256_blendv_epi8(_mm256_blendv_epi8(v[0], v[2], first), v[1], second);
    return c == 0   ? SHUFFLE(w, 0, 3, 6, 9, 12, 15, 2, 5, 8, 11, 14, 1, 4, 7, 10, 13)
           : c == 1 ? SHUFFLE(w, 1, 4, 7, 10, 13, 0, 3, 6, 9, 12, 15, 2, 5, 8, 11, 14)
                    : SHUFFLE(w, 2, 5, 8, 11, 14, 1, 4, 7, 10, 13, 0, 3, 6, 9, 12, 15);
}

/* Of all pixels: the least of the bits that any color has, the most of those that all have, and the
 * least blue. */
typedef struct color_range {
    __m256i any, all, blue;
} color_range;

/* Numbers of the even texels (odd = 0) or odd ones of a color, w or 2w - M. */
static ALWAYS_INLINE void place_half(void *to, __m256i w, int32_t odd, __m256i twice, __m256i less,
                                     bool deep)
{
    if (deep) {
        const __m256i e =
            odd == 0 ? _mm256_and_si256(w, _mm256_set1_epi32(65535)) : _mm256_srli_epi32(w, 16);
        const __m256i x = _mm256_sub_epi32(_mm256_add_epi32(e, _mm256_and_si256(e, twice)), less);
        _mm256_storeu_ps((float *) to + odd * NTP__RUN, _mm256_cvtepi32_ps(x));
    } else {
        const __m256i factor = odd == 0 ? _mm256_srli_epi16(twice, 8) : twice;
        const __m256i x = _mm256_sub_epi16(_mm256_maddubs_epi16(w, factor), less);
        _mm256_storeu_si256((void *) ((int16_t *) to + odd * NTP__RUN), x);
    }
}

/* 32 pixels, or 16 (deep) */
static ALWAYS_INLINE void place_halves(char *to, const uint8_t *s, color_range *r, bool deep,
                                       bool zzero)
{
    const ptrdiff_t size = 2 * NTP__RUN * (deep ? sizeof(float) : sizeof(int16_t));
    const __m256i v[3] = { load_two(s, s + 48), load_two(s + 16, s + 64),
                           load_two(s + 32, s + 80) };
    const __m256i w[3] = { color_of(v, 0, deep), color_of(v, 1, deep), color_of(v, 2, deep) };
    const __m256i any = _mm256_or_si256(_mm256_or_si256(w[0], w[1]), w[2]);
    const __m256i all = _mm256_and_si256(_mm256_and_si256(w[0], w[1]), w[2]);
    r->any = deep ? _mm256_min_epu16(r->any, any) : _mm256_min_epu8(r->any, any);
    r->all = deep ? _mm256_max_epu16(r->all, all) : _mm256_max_epu8(r->all, all);
    r->blue = deep ? _mm256_min_epu16(r->blue, w[2]) : _mm256_min_epu8(r->blue, w[2]);
    UNROLLED
    for (int32_t c = 0; c < 3; c++, to += size) {
        const bool as_it_is = zzero && c == 2;
        const __m256i twice = deep ? _mm256_set1_epi32(as_it_is ? 0 : -1)
                                   : _mm256_set1_epi16(as_it_is ? 0x100 : 0x200);
        const __m256i less =
            deep ? _mm256_set1_epi32(as_it_is ? 0 : 65535) : _mm256_set1_epi16(as_it_is ? 0 : 255);
        place_half(to, w[c], 0, twice, less, deep);
        place_half(to, w[c], 1, twice, less, deep);
    }
}

static ALWAYS_INLINE bool place_all_halves(char *to, bool *negative, const uint8_t *s, int32_t n,
                                           bool deep, bool zzero)
{
    const int32_t step = deep ? 16 : 32, size = deep ? 6 : 3, number = deep ? 4 : 2;
    const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi8(-1);
    color_range r = { ones, zero, ones };
    for (int32_t i = 0; i < n; i += step) {
        const int32_t at = i + step < n ? i : n - step;
        place_halves(to + number * at / 2, s + size * at, &r, deep, zzero);
    }
    /* The number beside the last of a run goes into a sum that nothing uses: memory checkers see it set. */
    for (int32_t k = 0; !deep && k < 6; k++)
        ((int16_t *) (void *) to)[k * NTP__RUN + n / 2] = 0;
    const __m256i black = deep ? _mm256_cmpeq_epi16(r.any, zero) : _mm256_cmpeq_epi8(r.any, zero);
    const __m256i white = deep ? _mm256_cmpeq_epi16(r.all, ones) : _mm256_cmpeq_epi8(r.all, ones);
    const uint32_t upper = deep ? 0xaaaaaaaa : 0xffffffff; /* bytes of blue */
    *negative = !zzero && (~(uint32_t) _mm256_movemask_epi8(r.blue) & upper) != 0;
    return _mm256_testz_si256(_mm256_or_si256(black, white), ones);
}

bool ntp__place_halves_avx2(void *to, bool *negative, const void *src, int32_t n, bool deep,
                            bool zzero)
{
    return deep ? place_all_halves(to, negative, src, n, true, zzero)
                : place_all_halves(to, negative, src, n, false, zzero);
}

static ALWAYS_INLINE __m256i same(__m256i a, __m256i b, bool deep)
{
    return deep ? _mm256_cmpeq_epi32(a, b) : _mm256_cmpeq_epi16(a, b);
}

static ALWAYS_INLINE __m256i numbers_of(int32_t v, bool deep)
{
    return deep ? _mm256_castps_si256(_mm256_set1_ps((float) v)) : _mm256_set1_epi16((short) v);
}

bool ntp__leave_out_halves_avx2(void *to, int32_t n, bool deep, bool zzero, uint32_t touch_unused)
{
    enum { BYTES = sizeof(__m256i), RUNS = 4 };
    const int32_t m = deep ? 65535 : 255, size = deep ? 4 : 2, bytes = n / 2 * size;
    const ptrdiff_t run = NTP__RUN * (ptrdiff_t) size;
    const __m256i high = numbers_of(m, deep), low = numbers_of(-m, deep);
    const __m256i flat = zzero ? _mm256_setzero_si256() : low;
    const __m256i black = _mm256_set1_epi8((touch_unused & NTP_UNUSED_BLACK) ? 0 : -1);
    const __m256i white = _mm256_set1_epi8((touch_unused & NTP_UNUSED_WHITE) ? 0 : -1);
    __m256i any = _mm256_setzero_si256();
    /* Those of even columns, then of odd ones; the last vector of both may overlap the one before. */
    for (int32_t i = 0, odd = 0; odd < 2; i = i + BYTES < bytes ? i + BYTES : 0, odd += i == 0) {
        char *at = (char *) to + odd * run + (i + BYTES < bytes ? i : bytes - BYTES);
        const __m256i x = _mm256_loadu_si256((const void *) at);
        const __m256i y = _mm256_loadu_si256((const void *) (at + 2 * run));
        const __m256i z = _mm256_loadu_si256((const void *) (at + 4 * run));
        const __m256i least = _mm256_and_si256(same(x, low, deep), same(z, flat, deep));
        const __m256i most = _mm256_and_si256(same(x, high, deep), same(z, high, deep));
        const __m256i unused =
            _mm256_and_si256(same(x, y, deep), _mm256_or_si256(_mm256_and_si256(least, black),
                                                               _mm256_and_si256(most, white)));
        any = _mm256_or_si256(any, unused);
        for (int32_t k = 0; k < RUNS; k++, at += 2 * run) {
            const __m256i v = _mm256_loadu_si256((const void *) at);
            _mm256_storeu_si256((void *) at, _mm256_andnot_si256(unused, v));
        }
    }
    return !_mm256_testz_si256(any, any);
}

void ntp__fill_halves_avx2(void *to, bool deep)
{
    const __m256i one = deep ? _mm256_castps_si256(_mm256_set1_ps(1)) : _mm256_set1_epi16(1);
    char *d = (char *) to + (deep ? 24 : 12) * NTP__RUN;
    for (int32_t i = 0; i < (deep ? 8 : 4) * NTP__RUN; i += (int32_t) sizeof one)
        _mm256_storeu_si256((void *) (d + i), one);
}

/* Levels of v over the length, less that of 0; adds to *doubt, which says where they may be wrong: by `part` of
 * themselves, and by `error`. */
static ALWAYS_INLINE __m256i rounded(__m256 v, __m256 factor, __m256 error, __m256 part,
                                     __m256 *doubt)
{
    const __m256 a = _mm256_mul_ps(v, factor), sign = _mm256_set1_ps(-0.0F);
    const __m256 from =
        _mm256_sub_ps(a, _mm256_round_ps(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
    const __m256 near = _mm256_fmadd_ps(_mm256_andnot_ps(sign, a), part, error);
    *doubt = _mm256_or_ps(*doubt, _mm256_cmp_ps(_mm256_andnot_ps(sign, from), near, _CMP_NGE_UQ));
    return _mm256_cvttps_epi32(_mm256_floor_ps(a));
}

/* Eight texels; *left: bits of those that are in doubt. */
static ALWAYS_INLINE texels directions(const ntp__planes *p, int32_t i, __m256 error, bool deep,
                                       bool zzero, uint32_t *left)
{
    const __m256 x = _mm256_loadu_ps(p->c[0] + i), y = _mm256_loadu_ps(p->c[1] + i);
    const __m256 z = _mm256_loadu_ps(p->c[2] + i);
    const __m256 square = _mm256_fmadd_ps(z, z, _mm256_fmadd_ps(y, y, _mm256_mul_ps(x, x)));
    /* Changes no length but 0. */
    const __m256 factor =
        _mm256_div_ps(_mm256_set1_ps(deep ? 32767.5F : 127.5F),
                      _mm256_sqrt_ps(_mm256_max_ps(square, _mm256_set1_ps(0x1p-100F))));
    const __m256 near = _mm256_set1_ps(deep ? 5 * 0x1p-24F : 7 * 0x1p-24F);
    __m256 doubt = _mm256_setzero_ps();
    error = _mm256_mul_ps(error, factor);
    const __m256i r = rounded(x, factor, error, near, &doubt);
    const __m256i g = rounded(y, factor, error, near, &doubt);
    const __m256i zeros = _mm256_set1_epi16((short) (deep ? 32768 : 128));
    const __m256i pair = _mm256_blend_epi16(r, _mm256_slli_epi32(g, 16), 0xaa);
    texels t;
    t.rg = _mm256_add_epi16(pair, zeros);
    __m256i e = rest_of(t.rg, deep);
    if (_mm256_movemask_ps(_mm256_castsi256_ps(e)) != 0)
        t.rg = _mm256_add_epi16(pulled(pair, &e, deep), zeros);
    const __m256i b = blue_of(e, root_of(e, deep), deep, zzero);
    const __m256i down = _mm256_castps_si256(_mm256_cmp_ps(z, _mm256_setzero_ps(), _CMP_LT_OQ));
    t.b = zzero
              ? b
              : _mm256_xor_si256(b, _mm256_and_si256(down, _mm256_set1_epi32(deep ? 65535 : 255)));
    *left = (uint32_t) _mm256_movemask_ps(doubt);
    return t;
}

/* Places in doubt may lie beyond the last texel; no pixel is written there. */
static ALWAYS_INLINE int32_t pack_directions(uint8_t *d, int32_t *at, const ntp__planes *p,
                                             int32_t first, int32_t n, float error, bool deep,
                                             bool zzero)
{
    const __m256 off = _mm256_set1_ps(3 * error); /* 1 + sqrt(3), with some room */
    const int32_t size = deep ? 6 : 3;
    uint8_t few[6 * EIGHT] = { 0 };
    int32_t found = 0;
    d += size * first;
    for (int32_t i = first; i < n; i += EIGHT, d += size * EIGHT) {
        const bool last = n - i < EIGHT + 2; /* four bytes more than eight texels are written */
        uint8_t *to = last ? few : d;
        uint32_t left;
        const texels t = directions(p, i, off, deep, zzero, &left);
        if (deep) {
            put16(to, t);
        } else {
            const __m256i v = SHUFFLE(_mm256_or_si256(t.rg, _mm256_slli_epi32(t.b, 8)), 0, 2, 1, 4,
                                      6, 5, 8, 10, 9, 12, 14, 13, N, N, N, N);
            store(to, _mm256_castsi256_si128(v));
            store(to + 12, _mm256_extracti128_si256(v, 1));
        }
        if (last)
            memcpy(d, few, (size_t) size * (size_t) (n - i < EIGHT ? n - i : EIGHT));
        for (; left != 0; left &= left - 1)
            at[found++] = i + __builtin_ctz(left);
    }
    return found;
}

int32_t ntp__pack_directions_avx2(void *d, int32_t *at, const ntp__planes *p, int32_t first,
                                  int32_t n, float error, bool deep, bool zzero)
{
    int32_t found = deep ? pack_directions(d, at, p, first, n, error, true, zzero)
                         : pack_directions(d, at, p, first, n, error, false, zzero);
    while (found > 0 && at[found - 1] >= n)
        found--;
    return found;
}
