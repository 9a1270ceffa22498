/* SPDX-License-Identifier: MIT */
/*
 * dither_avx2_tmpl.h - a part of gradient_kernels.c: what dither_tmpl.h does, with AVX2
 *
 * The bytes are the same.  A wave stays in registers, and the errors that go down move to the next
 * row by a shuffle.  Roots and quotients in doubles, which are most of the time, are left out where
 * something simpler decides: whether errors are limited, and which levels are near.  Fused products only make
 * errors of what decides smaller; what is carried on has none.
 */
#include "base/lanes_avx2.h"

#include <immintrin.h>

enum { GROUP = 4, GROUPS = NTP__WAVE / GROUP };

/* A number of each row of a wave. */
typedef struct wave {
    __m256d of[GROUPS];
} wave;

#define ALL(v) _mm256_set1_pd(v)

static ALWAYS_INLINE __m256d between(__m256d v, __m256d most)
{
    return _mm256_max_pd(_mm256_min_pd(v, most), _mm256_sub_pd(_mm256_setzero_pd(), most));
}

static ALWAYS_INLINE __m256d square_sum(__m256d from, __m256d x, __m256d y)
{
    return _mm256_add_pd(_mm256_add_pd(from, _mm256_mul_pd(x, x)), _mm256_mul_pd(y, y));
}

static ALWAYS_INLINE void load_wave(wave *w, const double *from)
{
    for (int32_t g = 0; g < GROUPS; g++)
        w->of[g] = _mm256_loadu_pd(from + GROUP * g);
}

static ALWAYS_INLINE void store_wave(double *to, const wave *w)
{
    for (int32_t g = 0; g < GROUPS; g++)
        _mm256_storeu_pd(to + GROUP * g, w->of[g]);
}

/* Adds errors to slopes, limited as in dither_tmpl.h. */
SELDOM static void add_limited(wave *x, wave *y, const wave *along, const wave *down, double half)
{
    for (int32_t g = 0; g < GROUPS; g++) {
        const __m256d length2 = square_sum(ALL(1), x->of[g], y->of[g]);
        const __m256d length = _mm256_sqrt_pd(length2);
        const __m256d one = _mm256_div_pd(_mm256_mul_pd(length2, length), ALL(half));
        const __m256d most = _mm256_min_pd(one, _mm256_div_pd(length, ALL(10)));
        x->of[g] = _mm256_add_pd(x->of[g], between(along->of[g], most));
        y->of[g] = _mm256_add_pd(y->of[g], between(down->of[g], most));
    }
}

/*
 * May one of the errors be beyond its limit?  t^(3/2), t = 1 + w^2, is convex, so its tangents at t = 1
 * and 4 are nowhere above it, and sqrt(t) is at least 1.  The margins are far above what roundings
 * do to either side.
 */
static ALWAYS_INLINE bool any_limited(const wave *x, const wave *y, const wave *along,
                                      const wave *down, double half)
{
    const double level = (1 - 0x1p-20) / half;
    const __m256d none = ALL(-0.0), tenth = ALL(0.1 * (1 - 0x1p-20));
    __m256d any = _mm256_setzero_pd();
    for (int32_t g = 0; g < GROUPS; g++) {
        const __m256d t =
            _mm256_fmadd_pd(x->of[g], x->of[g], _mm256_fmadd_pd(y->of[g], y->of[g], ALL(1)));
        const __m256d at1 = _mm256_fmsub_pd(t, ALL(1.5 * level), ALL(0.5 * level));
        const __m256d at4 = _mm256_fmsub_pd(t, ALL(3 * level), ALL(4 * level));
        const __m256d least = _mm256_min_pd(_mm256_max_pd(at1, at4), tenth);
        const __m256d error = _mm256_max_pd(_mm256_andnot_pd(none, along->of[g]),
                                            _mm256_andnot_pd(none, down->of[g]));
        any = _mm256_or_pd(any, _mm256_cmp_pd(error, least, _CMP_GT_OQ));
    }
    return _mm256_movemask_pd(any) != 0;
}

/* Levels of four texels in doubles. */
static ALWAYS_INLINE __m128i level_of(__m256d n, int32_t m)
{
    const __m256d share = _mm256_mul_pd(_mm256_add_pd(n, ALL(1)), ALL(0.5));
    const __m256d level = _mm256_add_pd(_mm256_mul_pd(share, ALL(m)), ALL(0.5));
    return _mm_min_epi32(_mm256_cvttpd_epi32(level), _mm_set1_epi32(m));
}

SELDOM static void round_wave(__m128i r[GROUPS], __m128i g[GROUPS], const wave *x, const wave *y,
                              const ntp__dithering *how)
{
    for (int32_t k = 0; k < GROUPS; k++) {
        const __m256d p = x->of[k], q = y->of[k];
        __m256d factor = _mm256_div_pd(ALL(1), _mm256_sqrt_pd(square_sum(ALL(1), p, q)));
        if (how->min_z > 0) {
            const __m256d flat = _mm256_add_pd(_mm256_mul_pd(p, p), _mm256_mul_pd(q, q));
            const __m256d other = _mm256_div_pd(ALL(how->shortened), _mm256_sqrt_pd(flat));
            factor =
                _mm256_blendv_pd(factor, other, _mm256_cmp_pd(factor, ALL(how->min_z), _CMP_LT_OQ));
        }
        r[k] = level_of(_mm256_mul_pd(p, factor), how->m);
        g[k] = level_of(_mm256_mul_pd(q, factor), how->m);
    }
}

static ALWAYS_INLINE __m256 as_floats(__m256d low, __m256d high)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(low)), _mm256_cvtpd_ps(high),
                                1);
}

/* 127.5 n + 128, truncated; widens `any` by the texels where another float could be so to another
 * level. */
static ALWAYS_INLINE __m256i level_of_floats(__m256 slope, __m256 factor, __m256 *any)
{
    const __m256 none = _mm256_set1_ps(-0.0F), half = _mm256_set1_ps(0.5F);
    const __m256 level = _mm256_fmadd_ps(slope, factor, _mm256_set1_ps(128));
    const __m256i whole = _mm256_cvttps_epi32(level);
    const __m256 over = _mm256_sub_ps(_mm256_sub_ps(level, _mm256_cvtepi32_ps(whole)), half);
    const __m256 near =
        _mm256_cmp_ps(_mm256_andnot_ps(none, over), _mm256_set1_ps(0.5F - 0x1p-13F), _CMP_GT_OQ);
    const __m256 some =
        _mm256_cmp_ps(_mm256_andnot_ps(none, slope), _mm256_set1_ps(0x1p-56F), _CMP_GT_OQ);
    *any = _mm256_or_ps(*any, _mm256_and_ps(near, some));
    return whole;
}

/* 127.5 over a root: a step of Newton's from a guess.  Neither of the two waits for a divider.  With
 * u = 2^-24, the guess of any processor errs by 1.5 times 2^-12, and the step leaves 1.5 times the square of
 * that, 3.4u; roundings add 4u. */
static ALWAYS_INLINE __m256 scale_of(__m256 square)
{
    const __m256 guess = _mm256_rsqrt_ps(square);
    const __m256 by = _mm256_fnmadd_ps(_mm256_mul_ps(square, guess), guess, _mm256_set1_ps(3));
    return _mm256_mul_ps(_mm256_mul_ps(guess, _mm256_set1_ps(63.75F)), by);
}

/*
 * The levels of 8 bit, in floats; false: one of them may be wrong.  With u = 2^-24, a slope errs by u,
 * the sum of squares by 5u, 127.5 over its root by 2.5u + 7.4u, and 127.5 n by 11.9u of at most 127.5;
 * the sum with 128 by 2^-17 more.  All that is less than 2^-13.  An n below 2^-55 vanishes beside
 * the 1 in level_of, so there the level is 128.
 */
static ALWAYS_INLINE bool round_wave_8(__m128i r[GROUPS], __m128i g[GROUPS], const wave *x,
                                       const wave *y)
{
    __m256 any = _mm256_setzero_ps();
    for (int32_t k = 0; k < GROUPS; k += 2) {
        const __m256 p = as_floats(x->of[k], x->of[k + 1]), q = as_floats(y->of[k], y->of[k + 1]);
        const __m256 square = _mm256_fmadd_ps(q, q, _mm256_set1_ps(1));
        const __m256 factor = scale_of(_mm256_fmadd_ps(p, p, square));
        const __m256i red = level_of_floats(p, factor, &any),
                      green = level_of_floats(q, factor, &any);
        r[k] = _mm256_castsi256_si128(red);
        r[k + 1] = _mm256_extracti128_si256(red, 1);
        g[k] = _mm256_castsi256_si128(green);
        g[k + 1] = _mm256_extracti128_si256(green, 1);
    }
    return _mm256_movemask_ps(any) == 0;
}

/* Pulls the pairs of four that are too long. */
SELDOM static void pull_four(__m128i *red, __m128i *green, int32_t m)
{
    int32_t r[GROUP], g[GROUP];
    _mm_storeu_si128((__m128i *) (void *) r, *red);
    _mm_storeu_si128((__m128i *) (void *) g, *green);
    for (int32_t k = 0; k < GROUP; k++) {
        if (ntp__rest(r[k], g[k], m) < 0)
            ntp__pull(&r[k], &g[k], m);
    }
    *red = _mm_loadu_si128((const __m128i *) (const void *) r);
    *green = _mm_loadu_si128((const __m128i *) (const void *) g);
}

static ALWAYS_INLINE __m256d numerator(__m128i level, int32_t m)
{
    return _mm256_cvtepi32_pd(_mm_sub_epi32(_mm_add_epi32(level, level), _mm_set1_epi32(m)));
}

/* What a pair leaves for the square of blue, exactly. */
static ALWAYS_INLINE __m256d rest_of_pair(__m256d p, __m256d q, int32_t m)
{
    return _mm256_fnmadd_pd(q, q, _mm256_fnmadd_pd(p, p, ALL((double) m * m)));
}

/* Stores the levels of a step and takes their slopes off: what is left are the errors. */
static ALWAYS_INLINE void leave_errors(wave *along, wave *down, const wave *x, const wave *y,
                                       ntp__wave_step *step, const __m128i r[GROUPS],
                                       const __m128i g[GROUPS], int32_t m, bool zzero)
{
    const __m256d twice = ALL(zzero ? 2 : 1);
    const __m128i more = _mm_set1_epi32(zzero ? 1 : m + 1);
    for (int32_t k = 0; k < GROUPS; k++) {
        __m128i c[3] = { r[k], g[k] };
        __m256d p = numerator(c[0], m), q = numerator(c[1], m);
        __m256d rest = rest_of_pair(p, q, m);
        if (_mm256_movemask_pd(rest) != 0) {
            pull_four(&c[0], &c[1], m);
            p = numerator(c[0], m);
            q = numerator(c[1], m);
            rest = rest_of_pair(p, q, m);
        }
        const __m256d z = _mm256_sqrt_pd(rest);
        c[2] = _mm_srli_epi32(_mm_add_epi32(_mm256_cvttpd_epi32(_mm256_mul_pd(twice, z)), more), 1);
        for (int32_t i = 0; i < 3; i++)
            _mm_storeu_si128((__m128i *) (void *) &step->level[i][GROUP * k], c[i]);
        along->of[k] = _mm256_sub_pd(x->of[k], _mm256_div_pd(p, z));
        down->of[k] = _mm256_sub_pd(y->of[k], _mm256_div_pd(q, z));
    }
}

/* Moves the numbers of all rows to the next one; the first gets `first`. */
static ALWAYS_INLINE void move_down(wave *w, double first)
{
    __m256d before = ALL(first);
    for (int32_t g = 0; g < GROUPS; g++) {
        const __m256d turned = _mm256_permute4x64_pd(w->of[g], _MM_SHUFFLE(2, 1, 0, 3));
        w->of[g] = _mm256_blend_pd(turned, before, 1);
        before = turned;
    }
}

static void dither(ntp__wave_step *steps, double *along, double *down, int32_t rows, int32_t n,
                   const ntp__dithering *how)
{
    const int32_t m = how->m;
    double line[NTP__WAVE] = { 0 };
    wave before, above;
    load_wave(&before, line);
    load_wave(&above, line);
    for (int32_t t = 0; t < n + rows - 1; t++) {
        const __m256d most = ALL(STEEPEST);
        __m128i r[GROUPS], g[GROUPS];
        wave x, y;
        if (t < rows) {
            store_wave(line, &before);
            line[t] = along[t];
            load_wave(&before, line);
        }
        move_down(&above, t < n ? down[t] : 0);
        load_wave(&x, steps[t].slope[0]);
        load_wave(&y, steps[t].slope[1]);
        for (int32_t k = 0; k < GROUPS; k++) {
            x.of[k] = between(x.of[k], most);
            y.of[k] = between(y.of[k], most);
        }
        if (any_limited(&x, &y, &before, &above, m / 2.0)) {
            add_limited(&x, &y, &before, &above, m / 2.0);
        } else {
            for (int32_t k = 0; k < GROUPS; k++) {
                x.of[k] = _mm256_add_pd(x.of[k], before.of[k]);
                y.of[k] = _mm256_add_pd(y.of[k], above.of[k]);
            }
        }
        if (m > 255 || how->min_z > 0 || !round_wave_8(r, g, &x, &y))
            round_wave(r, g, &x, &y, how);
        leave_errors(&before, &above, &x, &y, &steps[t], r, g, m, how->zzero);
        if (t >= n - 1) {
            store_wave(line, &before);
            along[t - (n - 1)] = line[t - (n - 1)];
        }
        if (t >= rows - 1) {
            store_wave(line, &above);
            down[t - (rows - 1)] = line[rows - 1];
        }
    }
}

/* Four numbers of each of four rows, as four numbers of each of four steps. */
static void put_slopes(ntp__wave_step *steps, const ntp__wave_rows *from, int32_t first, int32_t n)
{
    for (int32_t part = 0; part < 2 * NTP__WAVE_PART / GROUP; part++) {
        const int32_t c = part % 2, k = part / 2 * GROUP;
        const double *s = &from->slope[k][c][NTP__WAVE - first - k];
        double *d = &steps->slope[c][first + k];
        const ptrdiff_t row = 2 * NTP__WAVE_ROOM - 1, step = sizeof *steps / sizeof *d;
        for (int32_t t = 0; t < n; t += GROUP, s += GROUP, d += GROUP * step) {
            const __m256d a = _mm256_loadu_pd(s), b = _mm256_loadu_pd(s + row);
            const __m256d e = _mm256_loadu_pd(s + 2 * row), f = _mm256_loadu_pd(s + 3 * row);
            const __m256d ab = _mm256_unpacklo_pd(a, b), ba = _mm256_unpackhi_pd(a, b);
            const __m256d ef = _mm256_unpacklo_pd(e, f), fe = _mm256_unpackhi_pd(e, f);
            _mm256_storeu_pd(d, _mm256_permute2f128_pd(ab, ef, 0x20));
            _mm256_storeu_pd(d + step, _mm256_permute2f128_pd(ba, fe, 0x20));
            _mm256_storeu_pd(d + 2 * step, _mm256_permute2f128_pd(ab, ef, 0x31));
            _mm256_storeu_pd(d + 3 * step, _mm256_permute2f128_pd(ba, fe, 0x31));
        }
    }
}

/* Levels of eight rows of four steps, as four levels of each row. */
static void take_levels(ntp__wave_rows *to, const ntp__wave_step *steps, int32_t first, int32_t n)
{
    for (int32_t c = 0; c < 3; c++) {
        const int32_t *s = &steps->level[c][first];
        int32_t *d = &to->level[0][c][NTP__WAVE - first];
        const ptrdiff_t row = 3 * NTP__WAVE_ROOM - 1, step = sizeof *steps / sizeof *s;
        for (int32_t t = 0; t < n; t += GROUP, s += GROUP * step, d += GROUP) {
            const __m256i a = _mm256_loadu_si256((const void *) s);
            const __m256i b = _mm256_loadu_si256((const void *) (s + step));
            const __m256i e = _mm256_loadu_si256((const void *) (s + 2 * step));
            const __m256i f = _mm256_loadu_si256((const void *) (s + 3 * step));
            const __m256i ab = _mm256_unpacklo_epi32(a, b), ba = _mm256_unpackhi_epi32(a, b);
            const __m256i ef = _mm256_unpacklo_epi32(e, f), fe = _mm256_unpackhi_epi32(e, f);
            store_two(d, d + GROUP * row, _mm256_unpacklo_epi64(ab, ef));
            store_two(d + row, d + (GROUP + 1) * row, _mm256_unpackhi_epi64(ab, ef));
            store_two(d + 2 * row, d + (GROUP + 2) * row, _mm256_unpacklo_epi64(ba, fe));
            store_two(d + 3 * row, d + (GROUP + 3) * row, _mm256_unpackhi_epi64(ba, fe));
        }
    }
}

#undef ALL
