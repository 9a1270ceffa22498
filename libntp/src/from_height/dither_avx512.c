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

#include "texel/level.h"

#include <immintrin.h>

enum {
    WAVES = NTP__WAVES,
    PART = 8, /* doubles */
    PARTS = WAVES * NTP__WAVE / PART,
    M = 255
};

#define HALF_M   127.5
#define STEEPEST 1e6
#define SELDOM   __attribute__((noinline, cold))
#define ALL(v)   _mm512_set1_pd(v)
#define ALL_F(v) _mm512_set1_ps(v)

_Static_assert(NTP__WAVE == 16, "floats of a register");

/* A number of each row; and the levels of red and green as floats. */
typedef struct rows {
    __m512d of[PARTS];
} rows;

typedef struct levels {
    __m512 of[2];
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
        const __m512d least =
            _mm512_min_pd(_mm512_max_pd(at1, at4), ALL(0.1 * (1 - 0x1p-20)));
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

/* Eight levels in doubles. */
static inline __m256 level_of(__m512d n)
{
    const __m512d share = _mm512_mul_pd(_mm512_add_pd(n, ALL(1)), ALL(0.5));
    const __m512d level = _mm512_add_pd(_mm512_mul_pd(share, ALL(M)), ALL(0.5));
    return _mm256_cvtepi32_ps(
        _mm256_min_epi32(_mm512_cvttpd_epi32(level), _mm256_set1_epi32(M)));
}

SELDOM static levels round_precisely(const __m512d *x, const __m512d *y)
{
    __m256 level[2][2];
    for (int k = 0; k < 2; k++) {
        const __m512d factor = _mm512_div_pd(ALL(1), _mm512_sqrt_pd(square_sum(x[k], y[k])));
        level[0][k] = level_of(_mm512_mul_pd(x[k], factor));
        level[1][k] = level_of(_mm512_mul_pd(y[k], factor));
    }
    return (levels) { { join(level[0][0], level[0][1]), join(level[1][0], level[1][1]) } };
}

static inline __m512 level_of_floats(__m512 slope, __m512 factor, __mmask16 *any)
{
    const __m512 level = _mm512_fmadd_ps(slope, factor, ALL_F(128));
    const __m512 whole = _mm512_roundscale_ps(level, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
    const __m512 over = _mm512_sub_ps(_mm512_sub_ps(level, whole), ALL_F(0.5F));
    const __mmask16 some = _mm512_cmp_ps_mask(_mm512_abs_ps(slope), ALL_F(0x1p-56F), _CMP_GT_OQ);
    *any |= some & _mm512_cmp_ps_mask(_mm512_abs_ps(over), ALL_F(0.5F - 0x1p-13F), _CMP_GT_OQ);
    return whole;
}

/* Levels of a wave. */
static inline levels round_wave(const __m512d *x, const __m512d *y)
{
    const __m512 p = join(_mm512_cvtpd_ps(x[0]), _mm512_cvtpd_ps(x[1]));
    const __m512 q = join(_mm512_cvtpd_ps(y[0]), _mm512_cvtpd_ps(y[1]));
    const __m512 square = _mm512_fmadd_ps(p, p, _mm512_fmadd_ps(q, q, ALL_F(1)));
    const __m512 guess = _mm512_rsqrt14_ps(square);
    const __m512 rest = _mm512_fnmadd_ps(_mm512_mul_ps(square, guess), guess, ALL_F(3));
    const __m512 factor = _mm512_mul_ps(_mm512_mul_ps(guess, ALL_F(63.75F)), rest);
    __mmask16 any = 0;
    const levels v = { { level_of_floats(p, factor, &any), level_of_floats(q, factor, &any) } };
    return any != 0 ? round_precisely(x, y) : v;
}

static inline __m512 numerators(__m512 level)
{
    return _mm512_fmadd_ps(level, ALL_F(2), ALL_F(-M));
}

static inline __m512 rest_of(const levels *v)
{
    const __m512 p = numerators(v->of[0]), q = numerators(v->of[1]);
    return _mm512_fnmadd_ps(p, p, _mm512_fnmadd_ps(q, q, ALL_F(M * M)));
}

/* Pulls the pairs that are too long. */
SELDOM static levels pulled(levels v)
{
    uint32_t left = _mm512_cmp_ps_mask(rest_of(&v), _mm512_setzero_ps(), _CMP_LT_OQ);
    int32_t r[NTP__WAVE], g[NTP__WAVE];
    _mm512_storeu_si512(r, _mm512_cvttps_epi32(v.of[0]));
    _mm512_storeu_si512(g, _mm512_cvttps_epi32(v.of[1]));
    for (; left != 0; left &= left - 1)
        ntp__pull(&r[__builtin_ctz(left)], &g[__builtin_ctz(left)], M);
    return (levels) { { _mm512_cvtepi32_ps(_mm512_loadu_si512(r)),
                        _mm512_cvtepi32_ps(_mm512_loadu_si512(g)) } };
}

/* v - p / z */
static inline __m512d less_quotient(__m512d v, __m512d p, __m512d z, __m512d inverse)
{
    const __m512d q = _mm512_mul_pd(p, inverse), rest = _mm512_fnmadd_pd(q, z, p);
    return _mm512_sub_pd(v, _mm512_fmadd_pd(rest, inverse, q));
}

static inline void leave_errors(__m512d *x, __m512d *y, ntp__wave_step *step, levels v, bool zzero)
{
    const __m512 rest = rest_of(&v);
    const __m512 p = numerators(v.of[0]), q = numerators(v.of[1]);
    __m256i blue[2];
    for (int k = 0; k < 2; k++) {
        const __m512d z = _mm512_sqrt_pd(_mm512_cvtps_pd(half_of(rest, k)));
        const __m512d inverse = _mm512_div_pd(ALL(1), z);
        blue[k] = _mm512_cvttpd_epi32(_mm512_mul_pd(ALL(zzero ? 2 : 1), z));
        x[k] = less_quotient(x[k], _mm512_cvtps_pd(half_of(p, k)), z, inverse);
        y[k] = less_quotient(y[k], _mm512_cvtps_pd(half_of(q, k)), z, inverse);
    }
    const __m512i b = _mm512_inserti64x4(_mm512_castsi256_si512(blue[0]), blue[1], 1);
    _mm512_storeu_si512(step->level[0], _mm512_cvttps_epi32(v.of[0]));
    _mm512_storeu_si512(step->level[1], _mm512_cvttps_epi32(v.of[1]));
    _mm512_storeu_si512(
        step->level[2],
        _mm512_srli_epi32(_mm512_add_epi32(b, _mm512_set1_epi32(zzero ? 1 : M + 1)), 1));
}

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
    ntp__wave_step none[WAVES] = { { .slope = { { 0 } } } };
    double line[WAVES * NTP__WAVE] = { 0 };
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
            store_rows(line, &before);
            line[t] = along[t];
            for (int k = 0; k < PARTS; k++)
                before.of[k] = _mm512_loadu_pd(line + PART * k);
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
        for (int k = 0; k < WAVES; k++) {
            __m512d *const px = x.of + 2 * k, *const py = y.of + 2 * k;
            levels v = round_wave(px, py);
            if (_mm512_cmp_ps_mask(rest_of(&v), _mm512_setzero_ps(), _CMP_LT_OQ) != 0)
                v = pulled(v);
            leave_errors(px, py, step[k], v, zzero);
        }
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
