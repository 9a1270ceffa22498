/* SPDX-License-Identifier: MIT */
/*
 * kernels_avx512.c - loops over packed RGB with AVX-512
 *
 * They do what those of kernels.c do (kernels.h says what), and replace them where there is AVX-512.
 */
#include "texel/kernels_avx512.h"

#include "base/lanes_avx2.h"
#include "libntp.h"

#include <string.h>

#include "texel/packed_avx512_tmpl.h"

enum { STEP_BYTES = 48 };

/* ------------------------------------------------------------------ over the length */

/*
 * A step is 48 bytes: 16 texels of 8 bit as floats, or 8 of 16 bit as doubles.  With x = r - M/2, half
 * the numerator, all squares and their sum S are exact.  The level is floor(x f + (M + 1)/2), where
 * f = M/2 over the root of S.  It is summed up on top of a power of two, so that the lowest bits are
 * the level and a part of it, in units of 2^-15 of a level, or 2^-16.
 *
 * y is 1/sqrt(S) but for 2^-14 of it, so e = 1 - S y^2 is below 2^-12.9, and 1/sqrt(S) = y (1 + e/2 +
 * 3 e^2/8 + ...).  Of floats the second term is left out, which is less than 2^-27; and roundings add
 * 2.5 times 2^-24.  Of less than 2^22 units that is 0.75 at most, and the sum is rounded by half of one.  Of
 * doubles the third term is left out, which is less than 2^-40, and all is less than 2^31 units.  So a
 * level is sure if it is more than one unit from the next.
 *
 * The limits of rounded texels are those of texel/normalize_tmpl.h: |4 S + 2 - M^2| is less than twice the
 * sum of all |2x| and 1.
 */

static ALWAYS_INLINE __m512i of(double v, bool deep)
{
    return deep ? _mm512_castpd_si512(_mm512_set1_pd(v))
                : _mm512_castps_si512(_mm512_set1_ps((float) v));
}

/* a b + c */
static ALWAYS_INLINE __m512i fused(__m512i a, __m512i b, __m512i c, bool deep)
{
    if (deep)
        return _mm512_castpd_si512(_mm512_fmadd_pd(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b),
                                                   _mm512_castsi512_pd(c)));
    return _mm512_castps_si512(
        _mm512_fmadd_ps(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b), _mm512_castsi512_ps(c)));
}

static ALWAYS_INLINE __m512i times(__m512i a, __m512i b, bool deep)
{
    return deep
               ? _mm512_castpd_si512(_mm512_mul_pd(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b)))
               : _mm512_castps_si512(_mm512_mul_ps(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b)));
}

static ALWAYS_INLINE __m512i sum_of(__m512i a, __m512i b, bool deep)
{
    return deep
               ? _mm512_castpd_si512(_mm512_add_pd(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b)))
               : _mm512_castps_si512(_mm512_add_ps(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b)));
}

static ALWAYS_INLINE __m512i size_of(__m512i v, bool deep)
{
    return _mm512_and_si512(v, deep ? _mm512_set1_epi64(INT64_MAX) : _mm512_set1_epi32(INT32_MAX));
}

/* v, but w in these. */
static ALWAYS_INLINE __m512i with_those(__m512i v, uint32_t mask, __m512i w, bool deep)
{
    return deep ? _mm512_mask_mov_epi64(v, (__mmask8) mask, w)
                : _mm512_mask_mov_epi32(v, (__mmask16) mask, w);
}

static ALWAYS_INLINE uint32_t is_below(__m512i a, __m512i b, bool deep)
{
    if (deep)
        return _mm512_cmp_pd_mask(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b), _CMP_LT_OQ);
    return _mm512_cmp_ps_mask(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b), _CMP_LT_OQ);
}

static ALWAYS_INLINE __m512i inverse_root(__m512i v, bool deep)
{
    return deep ? _mm512_castpd_si512(_mm512_rsqrt14_pd(_mm512_castsi512_pd(v)))
                : _mm512_castps_si512(_mm512_rsqrt14_ps(_mm512_castsi512_ps(v)));
}

/* Of samples k of a step the bytes, where halves_of has them. */
static ALWAYS_INLINE __m512i places_of(int k, bool deep)
{
    return deep ? _mm512_cvtepi32_epi64(
                      _mm512_castsi512_si256(steps_of(0x06060000, 0x01000000 + 0x02020000 * k)))
                : steps_of(0x0300, 0x0100 * k);
}

/* Half the numerators of samples from these places. */
static ALWAYS_INLINE __m512i halves_of(__m512i v, __m512i from, bool deep)
{
    const double base = deep ? 0x1p36 : 0x1p15;
    const __m512i level = _mm512_mask_permutexvar_epi8(
        of(base, deep), deep ? 0x0c0c0c0c0c0c0c0c : 0x2222222222222222, from, v);
    return sum_of(level, of(-base - (deep ? 32767.5 : 127.5), deep), deep);
}

/* The levels of sums, packed. */
static ALWAYS_INLINE __m512i packed_levels(__m512i r, __m512i g, __m512i b, bool deep)
{
    /* Bytes of red and of blue, and 64 + those of green. */
    static const _Alignas(64) uint8_t of_deep[64] = {
        2,  3,  66, 67, 2,  3,  10, 11, 74,  75,  10, 11, 18, 19, 82,  83,
        18, 19, 26, 27, 90, 91, 26, 27, 34,  35,  98, 99, 34, 35, 42,  43,
        106, 107, 42, 43, 50, 51, 114, 115, 50, 51, 58, 59, 122, 123, 58, 59,
    }, of_8[64] = {
        2,  66, 2,  6,  70, 6,  10, 74, 10, 14, 78, 14, 18,  82,  18, 22,
        86, 22, 26, 90, 26, 30, 94, 30, 34, 98, 34, 38, 102, 38,  42, 106,
        42, 46, 110, 46, 50, 114, 50, 54, 118, 54, 58, 122, 58, 62, 126, 62,
    };
    const __m512i from = _mm512_load_si512(deep ? of_deep : of_8);
    return _mm512_mask_permutexvar_epi8(_mm512_permutex2var_epi8(r, from, g),
                                        deep ? 0xc30c30c30c30 : 0x924924924924, from, b);
}

/* The sums of the halves of numerators of black and of white, between which those of other colors are; where all
 * are used, more than that. */
typedef struct ends {
    double black, white;
} ends;

static ALWAYS_INLINE ends ends_of(uint32_t touch_unused, bool deep)
{
    const double sum = deep ? 1.5 * 65535 : 1.5 * 255;
    return (ends) { touch_unused & NTP_UNUSED_BLACK ? -2 * sum : -sum,
                    touch_unused & NTP_UNUSED_WHITE ? 2 * sum : sum };
}

/* Which texels are unused for being black or white? */
static ALWAYS_INLINE uint32_t unused_of(__m512i x, __m512i y, __m512i z, ends end, bool deep)
{
    const __m512i sum = sum_of(sum_of(x, y, deep), z, deep);
    return (is_below(of(end.black, deep), sum, deep) & is_below(sum, of(end.white, deep), deep)) ^
           (deep ? 0xff : 0xffff);
}

/* Factors that make halves of numerators those of unit vectors.  1 for texels that are rounded already. */
static ALWAYS_INLINE __m512i factors_of(const __m512i x[3], __m512i squares, bool deep)
{
    const double m = deep ? 65535 : 255;
    const __m512i sizes =
        sum_of(sum_of(size_of(x[0], deep), size_of(x[1], deep), deep), x[2], deep);
    const __m512i off = size_of(sum_of(squares, of((2 - m * m) / 4, deep), deep), deep);
    const __m512i y = inverse_root(squares, deep), half = of(0.5, deep);
    const __m512i minus_e = fused(times(squares, y, deep), y, of(-1, deep), deep);
    const __m512i by =
        deep ? fused(minus_e, of(0.375, deep), of(-0.5, deep), deep) : of(-0.5, deep);
    const __m512i scaled = times(y, of(m / 2, deep), deep);
    const uint32_t rounded = is_below(off, sum_of(sizes, half, deep), deep);
    const __m512i factor = fused(times(scaled, minus_e, deep), by, scaled, deep);
    return with_those(factor, rounded, of(1, deep), deep);
}

static ALWAYS_INLINE int32_t normalize_rgb(uint8_t *d, const uint8_t *s, int32_t n,
                                           uint32_t touch_unused, int32_t *at, uint64_t *changed,
                                           bool deep)
{
    const ends end = ends_of(touch_unused, deep);
    const int32_t at_once = STEP_BYTES / (deep ? 6 : 3);
    const double unit = deep ? 0x1p-16 : 0x1p-15, m = deep ? 65535 : 255;
    const __m512i base = of((deep ? 0x1p36 + 32768 : 0x1p8 + 128) + unit, deep);
    const __m512i red = places_of(0, deep), green = places_of(1, deep), blue = places_of(2, deep);
    int32_t found = 0;
    uint64_t sum = 0;
    /* Only corners of the cube can be unused.  Where there is one there mostly are more, and a branch for each
     * step would be taken at random. */
    bool corners = false;
    for (int32_t i = 0; i < n; i += at_once, s += STEP_BYTES, d += STEP_BYTES) {
        const __m512i v = load_48(s);
        __m512i x[3] = { halves_of(v, red, deep), halves_of(v, green, deep),
                         halves_of(v, blue, deep) };
        const __m512i squares =
            fused(x[2], x[2], fused(x[1], x[1], times(x[0], x[0], deep), deep), deep);
        corners =
            corners || is_below(squares, of(3 * m * m / 4, deep), deep) != (deep ? 0xff : 0xffff);
        const __m512i was = x[2];
        x[2] = size_of(was, deep);
        __m512i factor = factors_of(x, squares, deep);
        if (corners) {
            const uint32_t stay = unused_of(x[0], x[1], was, end, deep);
            x[2] = with_those(x[2], stay, was, deep);
            factor = with_those(factor, stay, of(1, deep), deep);
        }
        for (int k = 0; k < 3; k++) {
            x[k] = fused(x[k], factor, base, deep);
            x[k] = deep ? x[k] : _mm512_slli_epi32(x[k], 1);
        }
        __m512i now = packed_levels(x[0], x[1], x[2], deep);
        const __m512i part = _mm512_min_epu16(_mm512_min_epu16(x[0], x[1]), x[2]);
        const uint32_t left = _mm512_mask_cmplt_epu16_mask(deep ? 0x11111111 : 0x55555555, part,
                                                           _mm512_set1_epi16(deep ? 3 : 6));
        if (left != 0) {
            /* all bits where a level is taken from */
            const __m512i marks = _mm512_maskz_set1_epi16(left << 1, -1);
            const __m512i those = packed_levels(marks, marks, marks, deep);
            const uint32_t doubt =
                deep ? _mm512_test_epi64_mask(marks, marks) : _mm512_test_epi32_mask(marks, marks);
            const __m512i places = _mm512_maskz_compress_epi32((__mmask16) doubt, steps_of(1, i));
            now = _mm512_mask_mov_epi8(now, _mm512_movepi8_mask(those), v);
            /* No more than i places are known yet, as below. */
            _mm256_storeu_si256((void *) (at + found), _mm512_castsi512_si256(places));
            if (!deep)
                _mm256_storeu_si256((void *) (at + found + 8),
                                    _mm512_extracti64x4_epi64(places, 1));
            found += __builtin_popcount(doubt);
        }
        const uint64_t other =
            deep ? _mm512_cmpneq_epi16_mask(now, v) : _mm512_cmpneq_epi8_mask(now, v);
        sum += (uint64_t) __builtin_popcountll((other | other >> 1 | other >> 2) &
                                               (deep ? 0x249249 : 0x249249249249));
        _mm256_storeu_si256((void *) d, _mm512_castsi512_si256(now));
        _mm_storeu_si128((void *) (d + 32), _mm512_extracti32x4_epi32(now, 2));
    }
    *changed += sum;
    return found;
}

int32_t ntp__normalize_rgb8_avx512(void *dst, const void *src, int32_t n, uint32_t touch_unused,
                                   int32_t *at, uint64_t *changed)
{
    const int32_t left = normalize_rgb(dst, src, n, touch_unused, at, changed, false);
    end_lanes();
    return left;
}

int32_t ntp__normalize_rgb16_avx512(void *dst, const void *src, int32_t n, uint32_t touch_unused,
                                    int32_t *at, uint64_t *changed)
{
    const int32_t left = normalize_rgb(dst, src, n, touch_unused, at, changed, true);
    end_lanes();
    return left;
}

/* ------------------------------------------------------------------ derived blue */

/* As blue_of of texel/blue_avx2_tmpl.h, of 16 bit. */
static ALWAYS_INLINE __m512i blue_of(__m512i e, bool zzero)
{
    const __m512i t = root_of(e, true), one = _mm512_set1_epi32(1);
    if (!zzero)
        return _mm512_add_epi32(t, _mm512_set1_epi32(32768));
    const __m512i d = _mm512_sub_epi32(e, _mm512_madd_epi16(t, t)), d2 = _mm512_add_epi32(d, d);
    const __m512i t2 = _mm512_add_epi32(t, t), t3 = _mm512_add_epi32(t2, t);
    const __mmask16 above1 = _mm512_cmpge_epi32_mask(_mm512_add_epi32(d2, one), t);
    const __mmask16 above2 = _mm512_cmpge_epi32_mask(d2, t3);
    const __m512i z = _mm512_mask_add_epi32(t2, above1, t2, one);
    return _mm512_mask_add_epi32(z, above2, z, one);
}

#include "texel/pull_avx512_tmpl.h"

int32_t ntp__derive_rgb16_avx512(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                                 uint32_t touch_unused, int32_t *at, uint64_t *changed)
{
    const __m512i zero = _mm512_setzero_si512();
    const __m512i black = _mm512_set1_epi32(touch_unused & NTP_UNUSED_BLACK ? -1 : 0);
    const __m512i white = _mm512_set1_epi32(touch_unused & NTP_UNUSED_WHITE ? -1 : 65535);
    many_long v;
    __mmask16 which[256 / LANES_512];
    int32_t found = 0, sum = 0, left = 0;
    for (int32_t i = 0; i < n; i += LANES_512) {
        const texels t = take16((const uint8_t *) (src + 3 * i));
        const __m512i e = rest_of(t.rg, true);
        const __mmask16 fits = _mm512_cmpge_epi32_mask(e, zero);
        __mmask16 longs = (__mmask16) ~fits;
        __m512i b = t.b;
        if (longs != 0xffff) {
            const __m512i blue = blue_of(e, zzero != 0);
            sum += __builtin_popcount(_mm512_mask_cmpneq_epi32_mask(fits, blue, b));
            b = _mm512_mask_mov_epi32(b, fits, blue);
        }
        put16((uint8_t *) (dst + 3 * i), (texels) { t.rg, b });
        if (longs != 0) {
            const __mmask16 low = _mm512_mask_cmpeq_epi32_mask(longs, t.rg, zero),
                            high = _mm512_mask_cmpeq_epi32_mask(longs, t.rg, _mm512_set1_epi32(-1));
            longs &= (__mmask16) ~(_mm512_mask_cmpeq_epi32_mask(low, t.b, black) |
                                   _mm512_mask_cmpeq_epi32_mask(high, t.b, white));
            _mm512_storeu_si512(v.rg + found, _mm512_maskz_compress_epi32(longs, t.rg));
            found += __builtin_popcount(longs);
        }
        which[i / LANES_512] = longs;
    }
    if (found > 0) {
        left = pull_pixels(dst, src, &v, found, which, n, zzero != 0, at);
        sum += found - left;
    }
    *changed += (uint64_t) sum;
    end_lanes();
    return left;
}

/* ------------------------------------------------------------------ flags */

/* The tests of texel/flags_tmpl.h, which says why they are right: of 32 texels of 8 bit, in 16 bits each, or
 * 16 of 16 bit in 32. */

static ALWAYS_INLINE __m512i all_of(int64_t v, bool deep)
{
    return deep ? _mm512_set1_epi32((int32_t) (uint32_t) v) : _mm512_set1_epi16((short) v);
}

static ALWAYS_INLINE __m512i plus(__m512i v, __m512i w, bool deep)
{
    return deep ? _mm512_add_epi32(v, w) : _mm512_add_epi16(v, w);
}

static ALWAYS_INLINE __m512i minus(__m512i v, __m512i w, bool deep)
{
    return deep ? _mm512_sub_epi32(v, w) : _mm512_sub_epi16(v, w);
}

/* v <= w, of these texels */
static ALWAYS_INLINE __mmask32 up_to(__mmask32 these, __m512i v, __m512i w, bool deep)
{
    return deep ? _mm512_mask_cmple_epi32_mask((__mmask16) these, v, w)
                : _mm512_mask_cmple_epi16_mask(these, v, w);
}

static ALWAYS_INLINE __mmask32 equal(__mmask32 these, __m512i v, __m512i w, bool deep)
{
    return deep ? _mm512_mask_cmpeq_epi32_mask((__mmask16) these, v, w)
                : _mm512_mask_cmpeq_epi16_mask(these, v, w);
}

/* f with the flag in these texels, which do not have it. */
static ALWAYS_INLINE __m512i with(__m512i f, __mmask32 these, int32_t flag, bool deep)
{
    return deep ? _mm512_mask_or_epi32(f, (__mmask16) these, f, _mm512_set1_epi32(flag))
                : _mm512_mask_add_epi16(f, these, f, _mm512_set1_epi16((short) flag));
}

/* u of all halves, with K and K - 1. */
static ALWAYS_INLINE __m512i folded(__m512i c, __m512i k, __m512i below, bool deep)
{
    const __m512i x = _mm512_xor_si512(c, k), y = _mm512_xor_si512(c, below);
    return deep ? _mm512_min_epu16(x, y) : _mm512_min_epu8(x, y);
}

/* 32 texels of 8 bit: r | g << 8, and b. */
static ALWAYS_INLINE texels take_words(const uint8_t *s)
{
    const __m512i v = _mm512_loadu_si512(s);
    const __m512i w = _mm512_zextsi256_si512(_mm256_loadu_si256((const void *) (s + 64)));
    const __m512i step = steps_of(0x06060606, 0x04030100);
    return (texels) { _mm512_permutex2var_epi8(v, step, w),
                      _mm512_maskz_permutex2var_epi8(
                          0x5555555555555555, v,
                          _mm512_add_epi8(step, _mm512_set1_epi32(0x00020002)), w) };
}

/* The flags of 96 bytes of texels, one to each. */
static ALWAYS_INLINE __m512i flags_of(texels c, bool deep, __mmask32 mirrored, __m512i kept,
                                      __m512i others)
{
    const int64_t k = deep ? 32768 : 128, pair = 1 + (deep ? 1 << 16 : 1 << 8);
    const __m512i u = folded(c.rg, all_of(k * pair, deep), all_of((k - 1) * pair, deep), deep);
    const __m512i z = folded(c.b, all_of(k, deep), all_of(k - 1, deep), deep);
    const __m512i sum = deep ? _mm512_madd_epi16(u, _mm512_set1_epi16(1))
                             : _mm512_maddubs_epi16(u, _mm512_set1_epi8(1));
    const __m512i square = deep ? _mm512_madd_epi16(u, u) : _mm512_maddubs_epi16(u, u);
    const __m512i square_z = deep ? _mm512_madd_epi16(z, z) : _mm512_mullo_epi16(z, z);
    const __m512i xy = plus(square, sum, deep), most = all_of(k * (k - 1) - 1, deep);
    const __m512i s = plus(minus(xy, most, deep), plus(square_z, z, deep), deep);
    const __m512i t = plus(sum, z, deep), rest = minus(all_of(-5, deep), s, deep);
    const __m512i size = deep ? _mm512_abs_epi32(s) : _mm512_abs_epi16(s);
    const __m512i reach = deep ? _mm512_max_epi32(s, rest) : _mm512_max_epi16(s, rest);
    const __m512i gray = deep ? _mm512_or_si512(c.b, _mm512_slli_epi32(c.b, 16))
                              : _mm512_or_si512(c.b, _mm512_slli_epi16(c.b, 8));
    const __mmask32 every = ~0U, positive = up_to(every, all_of(k, deep), c.b, deep);
    const __mmask32 neighbor = up_to(every, reach, plus(t, t, deep), deep);
    const __mmask32 rounded = up_to(every, size, plus(t, all_of(1, deep), deep), deep);
    const __mmask32 exact = up_to(positive | mirrored, size, z, deep);
    const __mmask32 fits = up_to(every, xy, most, deep);
    const __mmask32 corner = equal(every, t, all_of(3 * k - 3, deep), deep);
    __m512i f = _mm512_setzero_si512();
    f = with(f, neighbor, NTP_FLAG_NEIGHBOR, deep);
    f = with(f, rounded, NTP_FLAG_ROUNDED, deep);
    f = with(f, exact, NTP_FLAG_EXACT, deep);
    f = with(f, ~fits, NTP_FLAG_XY_TOO_LONG, deep);
    f = with(f, ~positive, NTP_FLAG_Z_NEGATIVE, deep);
    f = _mm512_and_si512(f, kept);
    const __mmask32 none = equal(every, f, _mm512_setzero_si512(), deep);
    f = deep ? _mm512_mask_mov_epi32(f, (__mmask16) none, others)
             : _mm512_mask_mov_epi16(f, none, others);
    return with(f, equal(corner, c.rg, gray, deep), NTP_FLAG_UNUSED, deep);
}

static ALWAYS_INLINE void flags_rgb(uint8_t *flags, const uint8_t *s, int32_t n, bool deep,
                                    const ntp__validity *how)
{
    enum { BYTES = 96, STEP = 32 };
    const int32_t step = deep ? STEP / 2 : STEP;
    const __mmask32 mirrored = how->keep_negative_z ? ~0U : 0;
    const __m512i kept = all_of(how->kept, deep), others = all_of(how->others, deep);
    for (; n > 0; n -= step, flags += step, s += BYTES) {
        uint8_t few[BYTES];
        const bool whole = n >= step;
        const uint8_t *from = whole ? s : few;
        uint8_t *to = whole ? flags : few;
        if (!whole)
            memcpy(few, s, (size_t) n * BYTES / (size_t) step);
        const __m512i f =
            flags_of(deep ? take16(from) : take_words(from), deep, mirrored, kept, others);
        if (deep)
            _mm_storeu_si128((void *) to, _mm512_cvtepi32_epi8(f));
        else
            _mm256_storeu_si256((void *) to, _mm512_cvtepi16_epi8(f));
        if (!whole)
            memcpy(flags, few, (size_t) n);
    }
}

void ntp__validate_rgb_avx512(uint8_t *flags, const void *src, int32_t n, const ntp__validity *how)
{
    if (how->m > 255)
        flags_rgb(flags, src, n, true, how);
    else
        flags_rgb(flags, src, n, false, how);
    end_lanes();
}

/* ------------------------------------------------------------------ derived blue of 8 bit */

#include "texel/clean8_avx512_tmpl.h"

uint64_t ntp__clean_rgb8_avx512(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                const uint8_t *blue, uint32_t kept, uint32_t touch_unused)
{
    ntp__clean8_fn *const clean = ntp__kernels(NTP__CPU_AVX2)->clean_rgb8;
    uint32_t others[AT_ONCE + LANES_512];
    __mmask32 longs[AT_ONCE / STEP_8];
    uint64_t changed = 0;
    size_t i = 0;
    while (blue != NULL && kept == 0 && n - i >= STEP_8) {
        const size_t left = (n - i) / STEP_8 * STEP_8, next = left < AT_ONCE ? left : AT_ONCE;
        const int32_t found =
            derive_8(dst + 3 * i, src + 3 * i, (int32_t) next, others, longs, &changed);
        if (found > 0) {
            changed += look_up(others, found, table, touch_unused);
            put_long(dst + 3 * i, (int32_t) next, others, longs);
        }
        i += next;
    }
    end_lanes();
    return changed + clean(dst + 3 * i, src + 3 * i, n - i, table, blue, kept, touch_unused);
}

uint64_t ntp__clean_rgba8_avx512(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                 const uint8_t *blue, uint32_t kept, uint32_t touch_unused)
{
    ntp__clean8_fn *const clean = ntp__kernels(NTP__CPU_AVX2)->clean_rgba8;
    const uint32_t least = touch_unused & NTP_UNUSED_TRANSPARENT ? 0 : 1U << 24;
    uint32_t others[AT_ONCE + LANES_512];
    __mmask16 longs[AT_ONCE / LANES_512];
    uint64_t changed = 0;
    size_t i = 0;
    while (blue != NULL && kept == 0 && n - i >= STEP_8) {
        const size_t left = (n - i) / STEP_8 * STEP_8, next = left < AT_ONCE ? left : AT_ONCE;
        const int32_t found =
            derive_rgba(dst + 4 * i, src + 4 * i, (int32_t) next, others, longs, least, &changed);
        if (found > 0) {
            changed += look_up(others, found, table, touch_unused);
            put_rgba(dst + 4 * i, (int32_t) next, others, longs);
        }
        i += next;
    }
    end_lanes();
    return changed + clean(dst + 4 * i, src + 4 * i, n - i, table, blue, kept, touch_unused);
}
