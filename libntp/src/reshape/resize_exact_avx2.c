/* SPDX-License-Identifier: MIT */
/*
 * resize_exact_avx2.c - what floats do not decide where 8 bit is resized: exact sums, with AVX2
 *
 * An exact sum of rows is 2^15 times one of upper parts of weights plus one of lower parts; both are
 * below 2^31.  Sums of columns of both are below 2^61, so neither is rounded.  The total is rounded
 * twice, to a double and to a float: by less than (1 + 2^-27) times half a unit of the float's last
 * place, which is less than the room that resize_avx2.c has.
 */
#include "reshape/whole_avx2_tmpl.h"

#include "base/lanes_avx2.h"

#include <stdbool.h>

enum { EIGHT = 8, STEP = 16 /* numbers of a row */ };

void ntp__add_whole_avx2(double *sums, const ntp__whole_weights *from, double scale, int32_t first,
                         int32_t count)
{
    const __m256d one = _mm256_set1_pd(scale), upper = _mm256_set1_pd(scale * 0x1p15);
    for (int32_t i = first; i < first + count; i += 2 * EIGHT) {
        const both_parts p = sum_parts(from, from->n, i);
        __m128i high[4], low[4];
        for (int32_t m = 0; m < 2; m++) {
            high[m] = _mm256_castsi256_si128(p.high[m]);
            low[m] = _mm256_castsi256_si128(p.low[m]);
            high[m + 2] = _mm256_extracti128_si256(p.high[m], 1);
            low[m + 2] = _mm256_extracti128_si256(p.low[m], 1);
        }
        for (int32_t m = 0; m < 4; m++)
            _mm256_storeu_pd(sums + i + 4 * m,
                             _mm256_add_pd(_mm256_mul_pd(_mm256_cvtepi32_pd(high[m]), upper),
                                           _mm256_mul_pd(_mm256_cvtepi32_pd(low[m]), one)));
    }
}

/* The nearest doubles of integers of 64 bits: of their upper and lower halves, as the last bits of
 * 2^84 + 2^63 and of 2^52. */
static inline __m256d doubles_of(__m256i v)
{
    const __m256i low = _mm256_blend_epi32(_mm256_set1_epi64x(0x4330000000000000), v, 0x55);
    const __m256i high =
        _mm256_xor_si256(_mm256_srli_epi64(v, 32), _mm256_set1_epi64x(0x4530000080000000));
    const __m256d less = _mm256_set1_pd(0x1p84 + 0x1p63 + 0x1p52);
    return _mm256_add_pd(_mm256_sub_pd(_mm256_castsi256_pd(high), less), _mm256_castsi256_pd(low));
}

/* (2^15 high + low) 2^-31.  The lower part becomes one of 15 bits first, so that it is small beside the other, or
 * both are exact. */
static inline __m128 floats_of(__m256i high, __m256i low)
{
    const __m256i lift = _mm256_set1_epi64x((int64_t) 1 << 62);
    const __m256i over = _mm256_sub_epi64(_mm256_srli_epi64(_mm256_add_epi64(low, lift), 15),
                                          _mm256_set1_epi64x((int64_t) 1 << 47));
    const __m256i rest = _mm256_and_si256(low, _mm256_set1_epi64x(32767));
    return _mm256_cvtpd_ps(_mm256_add_pd(
        _mm256_mul_pd(doubles_of(_mm256_add_epi64(high, over)), _mm256_set1_pd(0x1p-16)),
        _mm256_mul_pd(doubles_of(rest), _mm256_set1_pd(0x1p-31))));
}

/* Upper and lower sums of even columns of a plane, and of odd ones. */
typedef struct column_sums {
    int32_t of[2][2][NTP__RUN + STEP];
} column_sums;

static void sum_both_columns(column_sums *c, const ntp__whole_weights *from, int32_t first,
                             int32_t end, int32_t plane)
{
    for (int32_t odd = 0; odd < 2; odd++) {
        for (int32_t i = first; i < end; i += STEP) {
            const both_parts p = sum_parts(from, from->n, (2 * plane + odd) * NTP__RUN + i);
            for (int32_t k = 0; k < 2; k++) {
                const __m256i low = k == 0 ? p.high[0] : p.low[0];
                const __m256i high = k == 0 ? p.high[1] : p.low[1];
                int32_t *to = c->of[odd][k] + i - first;
                _mm256_storeu_si256((void *) to, _mm256_permute2x128_si256(low, high, 0x20));
                _mm256_storeu_si256((void *) (to + EIGHT),
                                    _mm256_permute2x128_si256(low, high, 0x31));
            }
        }
    }
}

/* Adds w times eight sums, whose even ones are in sum[0]. */
static inline void add_products(__m256i sum[2], const int32_t *a, const int32_t *b, __m256i w)
{
    const __m256i v = _mm256_add_epi32(_mm256_loadu_si256((const void *) a),
                                       _mm256_loadu_si256((const void *) b));
    sum[0] = _mm256_add_epi64(sum[0], _mm256_mul_epi32(v, w));
    sum[1] = _mm256_add_epi64(sum[1], _mm256_mul_epi32(_mm256_srli_epi64(v, 32), w));
}

void ntp__sum_exactly_avx2(ntp__whole_sums *exact, ntp__planes *out, const ntp__whole_weights *from,
                           const int32_t *weight, int32_t taps, int32_t first, int32_t n,
                           int32_t planes)
{
    const int32_t half = taps / 2;
    column_sums c;
    for (int32_t p = 0; p < planes; p++) {
        sum_both_columns(&c, from, first, n + half, p);
        for (int32_t i = first; i < n; i += EIGHT) {
            __m256i sum[2][2] = { { _mm256_setzero_si256(), _mm256_setzero_si256() },
                                  { _mm256_setzero_si256(), _mm256_setzero_si256() } };
            /* From either end, even and odd columns take turns. */
            for (int32_t t = 0; t < half; t++) {
                const __m256i w = _mm256_set1_epi32(weight[t]);
                const int32_t a = i - first + t / 2, b = i - first + half - 1 - t / 2;
                for (int32_t k = 0; k < 2; k++)
                    add_products(sum[k], c.of[t % 2][k] + a, c.of[1 - t % 2][k] + b, w);
            }
            __m128 v[2];
            for (int32_t k = 0; k < 2; k++) {
                v[k] = floats_of(sum[0][k], sum[1][k]);
                _mm256_storeu_si256((void *) (exact->high[p] + i + 4 * k), sum[0][k]);
                _mm256_storeu_si256((void *) (exact->low[p] + i + 4 * k), sum[1][k]);
            }
            _mm_storeu_ps(out->c[p] + i, _mm_unpacklo_ps(v[0], v[1]));
            _mm_storeu_ps(out->c[p] + i + 4, _mm_unpackhi_ps(v[0], v[1]));
        }
    }
}

void ntp__any_of_halves_avx2(int16_t *to, const float *const *rows, const int32_t *weight,
                             int32_t taps, int32_t half, int32_t run, int32_t n)
{
    int16_t any[NTP__RUN + 2 * STEP];
    for (int32_t i = 0; i < n + half; i += STEP) {
        __m256i v = _mm256_setzero_si256();
        for (int32_t t = 0; t < taps; t++) {
            const int16_t *row = (const int16_t *) (const void *) rows[t] + run * NTP__RUN + i;
            if (weight[t] != 0)
                v = _mm256_or_si256(
                    v, _mm256_or_si256(_mm256_loadu_si256((const void *) row),
                                       _mm256_loadu_si256((const void *) (row + NTP__RUN))));
        }
        _mm256_storeu_si256((void *) (any + i), v);
    }
    for (int32_t i = 0; i < n; i += STEP) {
        __m256i v = _mm256_setzero_si256();
        for (int32_t k = 0; k < half; k++)
            v = _mm256_or_si256(v, _mm256_loadu_si256((const void *) (any + i + k)));
        _mm256_storeu_si256((void *) (to + i), v);
    }
}

static inline __m256 eight_of(const int16_t *from)
{
    return _mm256_castsi256_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128((const void *) from)));
}

void ntp__judge_planes_avx2(ntp__planes *p, const ntp__plane_marks *marks, float m, float error,
                            bool holes, int32_t first, int32_t n)
{
    const __m256 zero = _mm256_setzero_ps(), most = _mm256_set1_ps(error);
    const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(error > 0 ? 0 : -1));
    for (int32_t i = first; i < n; i += EIGHT) {
        const __m256 x = _mm256_loadu_ps(p->c[0] + i), y = _mm256_loadu_ps(p->c[1] + i);
        const __m256 z = _mm256_loadu_ps(p->c[2] + i);
        __m256 empty = zero, unsure = zero;
        if (holes) {
            const __m256 w = _mm256_loadu_ps(p->c[3] + i), few = _mm256_cmp_ps(w, most, _CMP_LE_OQ);
            const __m256i none = _mm256_cmpeq_epi32(_mm256_castps_si256(eight_of(marks->used + i)),
                                                    _mm256_setzero_si256());
            const __m256 sure = _mm256_or_ps(
                _mm256_or_ps(all, _mm256_castsi256_ps(none)),
                _mm256_cmp_ps(w, _mm256_sub_ps(zero, most), _CMP_LT_OQ));
            empty = _mm256_and_ps(few, sure);
            unsure = few;
        }
        const __m256 size = _mm256_andnot_ps(_mm256_set1_ps(-0.0F), z);
        unsure = _mm256_or_ps(unsure, _mm256_cmp_ps(size, most, _CMP_LE_OQ));
        unsure = _mm256_andnot_ps(_mm256_or_ps(empty, all), unsure);
        /* A sign bit is all that counts of what is below. */
        const __m256 above = _mm256_andnot_ps(eight_of(marks->below + i), z);
        const __m256 kept = _mm256_blendv_ps(z, zero, above);
        _mm256_storeu_ps(p->c[2] + i, _mm256_blendv_ps(kept, _mm256_set1_ps(m), empty));
        const __m256 one = _mm256_set1_ps(1);
        _mm256_storeu_ps(p->c[1] + i, _mm256_blendv_ps(y, one, empty));
        _mm256_storeu_ps(p->c[0] + i, _mm256_or_ps(_mm256_blendv_ps(x, one, empty), unsure));
    }
}
