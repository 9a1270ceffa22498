/* SPDX-License-Identifier: MIT */
/*
 * dither_avx512.c - what dither_tmpl.h does, of 8 bit without min_z, with AVX-512
 *
 * As dither_avx2_tmpl.h, which says why roundings in floats are right, but of two waves of rows: while a
 * step of one waits for roots and quotients, the other goes on.  Between roots and levels there are floats
 * alone: levels, numerators and what they leave for blue are integers below 2^24.  Fused products only
 * make errors of what is checked smaller; what is carried on has none, but for quotients.
 *
 * p / z is p times 1 / z, and a correction by the remainder.  For all numerators of 8 bit that gives the
 * quotient as it is rounded (the test tries them).
 */
#include "from_height/gradient.h"

#include "base/inlining.h"
#include "texel/level.h"

#include <immintrin.h>
#include <math.h>

enum {
    PART = 8, /* doubles */
    WAVES = NTP__WAVES,
    PARTS = WAVES * NTP__WAVE / PART,
    M = 255
};

#define HALF_M   127.5
#define STEEPEST 1e6
#define ALL(v)   _mm512_set1_pd(v)
#define ALL_F(v) _mm512_set1_ps(v)

_Static_assert(NTP__WAVE == 16, "floats of a register");

/* A number of each row */
typedef struct rows {
    __m512d of[PARTS];
} rows;

/* The numerators of a wave, as floats: of red and green, and the square of that of blue. */
typedef struct levels {
    __m512 p, q, rest;
} levels;

static inline __m512d between(__m512d v, __m512d most)
{
    return _mm512_max_pd(_mm512_min_pd(v, most), _mm512_sub_pd(_mm512_setzero_pd(), most));
}

static inline __m512d square_sum(__m512d x, __m512d y)
{
    return _mm512_add_pd(_mm512_add_pd(ALL(1), _mm512_mul_pd(x, x)), _mm512_mul_pd(y, y));
}

static inline void store_rows(double *to, const rows *v)
{
    for (int k = 0; k < PARTS; k++)
        _mm512_storeu_pd(to + PART * k, v->of[k]);
}

SELDOM static void add_limited(rows *x, rows *y, const rows *along, const rows *down)
{
    for (int k = 0; k < PARTS; k++) {
        const __m512d length2 = square_sum(x->of[k], y->of[k]), length = _mm512_sqrt_pd(length2);
        const __m512d one = _mm512_div_pd(_mm512_mul_pd(length2, length), ALL(HALF_M));
        const __m512d most = _mm512_min_pd(one, _mm512_div_pd(length, ALL(10)));
        x->of[k] = _mm512_add_pd(x->of[k], between(along->of[k], most));
        y->of[k] = _mm512_add_pd(y->of[k], between(down->of[k], most));
    }
}

static inline bool any_limited(const rows *x, const rows *y, const rows *along, const rows *down)
{
    static const double level = (1 - 0x1p-20) / HALF_M;
    uint32_t any = 0;
    for (int k = 0; k < PARTS; k++) {
        const __m512d t =
            _mm512_fmadd_pd(x->of[k], x->of[k], _mm512_fmadd_pd(y->of[k], y->of[k], ALL(1)));
        const __m512d at1 = _mm512_fmadd_pd(t, ALL(1.5 * level), ALL(-0.5 * level));
        const __m512d at4 = _mm512_fmadd_pd(t, ALL(3 * level), ALL(-4 * level));
        const __m512d least = _mm512_min_pd(_mm512_max_pd(at1, at4), ALL(0.1 * (1 - 0x1p-20)));
        const __m512d error =
            _mm512_max_pd(_mm512_abs_pd(along->of[k]), _mm512_abs_pd(down->of[k]));
        any |= _mm512_cmp_pd_mask(error, least, _CMP_GT_OQ);
    }
    return any != 0;
}

static inline __m512 join(__m256 low, __m256 high)
{
    return _mm512_castpd_ps(_mm512_insertf64x4(_mm512_castps_pd(_mm512_castps256_ps512(low)),
                                               _mm256_castps_pd(high), 1));
}

static inline __m256 half_of(__m512 v, int k)
{
    return _mm256_castpd_ps(k == 0 ? _mm512_castpd512_pd256(_mm512_castps_pd(v))
                                   : _mm512_extractf64x4_pd(_mm512_castps_pd(v), 1));
}

static inline __m512 rest_of(__m512 p, __m512 q)
{
    return _mm512_fnmadd_ps(p, p, _mm512_fnmadd_ps(q, q, ALL_F(M * M)));
}

static inline __mmask16 too_long(__m512 rest)
{
    return _mm512_cmp_ps_mask(rest, _mm512_setzero_ps(), _CMP_LT_OQ);
}

static inline __m512i level_of(__m512 numerator)
{
    return _mm512_cvttps_epi32(_mm512_fmadd_ps(numerator, ALL_F(0.5F), ALL_F((float) HALF_M)));
}

static inline __m512 numerators(__m512 level)
{
    return _mm512_fmadd_ps(level, ALL_F(2), ALL_F(-M));
}

/* As in dither_tmpl.h. */
static inline int32_t round_one(double n)
{
    const int32_t k = (int32_t) ((n + 1) / 2 * M + 0.5);
    return k < M ? k : M;
}

/* Rounds some texels of a wave in doubles, and pulls what is too long. */
SELDOM static void round_some(levels *v, const __m512d *x, const __m512d *y, uint32_t some)
{
    double slope[2][NTP__WAVE];
    float p[NTP__WAVE], q[NTP__WAVE];
    for (int k = 0; k < 2; k++) {
        _mm512_storeu_pd(slope[0] + PART * k, x[k]);
        _mm512_storeu_pd(slope[1] + PART * k, y[k]);
    }
    _mm512_storeu_ps(p, v->p);
    _mm512_storeu_ps(q, v->q);
    for (; some != 0; some &= some - 1) {
        const int i = __builtin_ctz(some);
        const double a = slope[0][i], b = slope[1][i], factor = 1 / sqrt(1 + a * a + b * b);
        int32_t r = round_one(a * factor), g = round_one(b * factor);
        if (ntp__rest(r, g, M) < 0)
            ntp__pull(&r, &g, M);
        p[i] = (float) ntp__num(r, M);
        q[i] = (float) ntp__num(g, M);
    }
    v->p = _mm512_loadu_ps(p);
    v->q = _mm512_loadu_ps(q);
    v->rest = rest_of(v->p, v->q);
}

static inline __m512 round_floats(__m512 slope, __m512 factor, __mmask16 *any)
{
    const __m512 level = _mm512_fmadd_ps(slope, factor, ALL_F(128));
    const __m512 whole = _mm512_roundscale_ps(level, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
    const __m512 over = _mm512_sub_ps(_mm512_sub_ps(level, whole), ALL_F(0.5F));
    const __mmask16 some = _mm512_cmp_ps_mask(_mm512_abs_ps(slope), ALL_F(0x1p-56F), _CMP_GT_OQ);
    *any |= some & _mm512_cmp_ps_mask(_mm512_abs_ps(over), ALL_F(0.5F - 0x1p-13F), _CMP_GT_OQ);
    return numerators(whole);
}

/* Of a wave; widens `any` by the texels that may be wrong or are too long. */
static inline levels round_wave(const __m512d *x, const __m512d *y, __mmask16 *any)
{
    const __m512 p = join(_mm512_cvtpd_ps(x[0]), _mm512_cvtpd_ps(x[1]));
    const __m512 q = join(_mm512_cvtpd_ps(y[0]), _mm512_cvtpd_ps(y[1]));
    const __m512 square = _mm512_fmadd_ps(p, p, _mm512_fmadd_ps(q, q, ALL_F(1)));
    const __m512 guess = _mm512_rsqrt14_ps(square);
    const __m512 by = _mm512_fnmadd_ps(_mm512_mul_ps(square, guess), guess, ALL_F(3));
    const __m512 factor = _mm512_mul_ps(_mm512_mul_ps(guess, ALL_F(63.75F)), by);
    levels v = { round_floats(p, factor, any), round_floats(q, factor, any), ALL_F(0) };
    v.rest = rest_of(v.p, v.q);
    *any |= too_long(v.rest);
    return v;
}

/* v - p / z */
static inline __m512d less_quotient(__m512d v, __m512d p, __m512d z, __m512d inverse)
{
    const __m512d q = _mm512_mul_pd(p, inverse), rest = _mm512_fnmadd_pd(q, z, p);
    return _mm512_sub_pd(v, _mm512_fmadd_pd(rest, inverse, q));
}

static inline void leave_errors(__m512d *x, __m512d *y, ntp__wave_step *step, levels v,
                                double twice, int32_t more)
{
    __m256i blue[2];
    for (int k = 0; k < 2; k++) {
        const __m512d z = _mm512_sqrt_pd(_mm512_cvtps_pd(half_of(v.rest, k)));
        const __m512d inverse = _mm512_div_pd(ALL(1), z);
        blue[k] = _mm512_cvttpd_epi32(_mm512_mul_pd(ALL(twice), z));
        x[k] = less_quotient(x[k], _mm512_cvtps_pd(half_of(v.p, k)), z, inverse);
        y[k] = less_quotient(y[k], _mm512_cvtps_pd(half_of(v.q, k)), z, inverse);
    }
    const __m512i b = _mm512_inserti64x4(_mm512_castsi256_si512(blue[0]), blue[1], 1);
    _mm512_storeu_si512(step->level[0], level_of(v.p));
    _mm512_storeu_si512(step->level[1], level_of(v.q));
    _mm512_storeu_si512(step->level[2],
                        _mm512_srli_epi32(_mm512_add_epi32(b, _mm512_set1_epi32(more)), 1));
}

/* Moves the numbers of all rows to the next one; the first gets `first`. */
static inline void move_down(rows *v, double first)
{
    __m512i before = _mm512_castpd_si512(ALL(first));
    for (int k = 0; k < PARTS; k++) {
        const __m512i at = _mm512_castpd_si512(v->of[k]);
        v->of[k] = _mm512_castsi512_pd(_mm512_alignr_epi64(at, before, PART - 1));
        before = at;
    }
}

static inline void take_slopes(rows *v, ntp__wave_step *const step[WAVES], int c)
{
    for (int k = 0; k < PARTS; k++) {
        const double *from = &step[k * PART / NTP__WAVE]->slope[c][k * PART % NTP__WAVE];
        v->of[k] = between(_mm512_loadu_pd(from), ALL(STEEPEST));
    }
}

ntp__dither_waves_fn ntp__dither_avx512;

void ntp__dither_avx512(ntp__wave_step *steps[NTP__WAVES], double *along, double *down,
                        int32_t count, int32_t n, bool zzero)
{
    const double twice = zzero ? 2 : 1;
    const int32_t more = zzero ? 1 : M + 1;
    ntp__wave_step none[WAVES] = { { .slope = { { 0 } } } };
    _Alignas(64) double line[WAVES * NTP__WAVE] = { 0 };
    rows before, above;
    for (int k = 0; k < PARTS; k++)
        before.of[k] = above.of[k] = _mm512_setzero_pd();
    for (int32_t t = 0; t < n + count - 1; t++) {
        ntp__wave_step *step[WAVES];
        rows x, y;
        for (int32_t k = 0; k < WAVES; k++) {
            /* The rows of a wave have texels in these steps. */
            const int32_t at = t - NTP__WAVE * k, left = count - NTP__WAVE * k,
                          of = left < NTP__WAVE ? left : NTP__WAVE;
            step[k] = left > 0 && at >= 0 && at < n + of - 1 ? steps[k] + at : none + k;
        }
        if (t < count) {
            for (int k = 0; k < PARTS; k++)
                before.of[k] = _mm512_mask_mov_pd(before.of[k], (__mmask8) (1u << t >> PART * k),
                                                  ALL(along[t]));
        }
        move_down(&above, t < n ? down[t] : 0);
        take_slopes(&x, step, 0);
        take_slopes(&y, step, 1);
        if (any_limited(&x, &y, &before, &above)) {
            add_limited(&x, &y, &before, &above);
        } else {
            for (int k = 0; k < PARTS; k++) {
                x.of[k] = _mm512_add_pd(x.of[k], before.of[k]);
                y.of[k] = _mm512_add_pd(y.of[k], above.of[k]);
            }
        }
        __mmask16 some[WAVES] = { 0 };
        levels v[WAVES];
        for (int k = 0; k < WAVES; k++)
            v[k] = round_wave(x.of + 2 * k, y.of + 2 * k, &some[k]);
        if ((some[0] | some[1]) != 0) {
            for (int k = 0; k < WAVES; k++)
                round_some(&v[k], x.of + 2 * k, y.of + 2 * k, some[k]);
        }
        for (int k = 0; k < WAVES; k++)
            leave_errors(x.of + 2 * k, y.of + 2 * k, step[k], v[k], twice, more);
        before = x;
        above = y;
        if (t >= n - 1) {
            store_rows(line, &before);
            along[t - (n - 1)] = line[t - (n - 1)];
        }
        if (t >= count - 1) {
            store_rows(line, &above);
            down[t - (count - 1)] = line[count - 1];
        }
    }
}
