/* SPDX-License-Identifier: MIT */
/*
 * resize_exact_avx2.c - what floats do not decide where 8 bit is halved: exact sums, with AVX2
 *
 * Sums of rows are integers below 2^39, or 2^40 (settle_halves), and so are doubles.  A sum of two columns
 * is split into a multiple of 2^20 and a rest of at most 2^19.  The magnitudes of the weights of these
 * add up to less than 2^30.  So both sums of products are exact too: the one is a multiple of 2^20 below
 * 2^71, the other is below 2^49.  Their total is rounded twice, to a double and to a float: by less than
 * (1 + 2^-27) times half a unit of the float's last place, for which resize_avx2.c has room.
 */
#include "reshape/resize_kernels.h"

#include "base/lanes_avx2.h"

#include <immintrin.h>
#include <stdbool.h>

enum { FOUR = 4, EIGHT = 8, STEP = 16 /* numbers of a row */ };

void ntp__sum_exactly_avx2(ntp__whole_sums *exact, ntp__planes *out, const double *sums,
                           const double *weight, int32_t taps, int32_t first, int32_t n,
                           int32_t planes)
{
    const __m256d upper = _mm256_set1_pd(0x1.8p72); /* numbers beside it are multiples of 2^20 */
    for (int32_t p = 0; p < planes; p++, sums += 2 * NTP__RUN) {
        for (int32_t i = first; i < n; i += FOUR) {
            /* From either end, even and odd columns take turns. */
            const double *a = sums + i, *b = a + NTP__RUN + taps / 2 - 1;
            ptrdiff_t step = NTP__RUN;
            __m256d high = _mm256_setzero_pd(), low = high;
            for (int32_t t = 0; t < taps / 2; t++, a += step, b -= step, step = 1 - step) {
                const __m256d w = _mm256_set1_pd(weight[t]);
                const __m256d v = _mm256_add_pd(_mm256_loadu_pd(a), _mm256_loadu_pd(b));
                const __m256d most = _mm256_sub_pd(_mm256_add_pd(v, upper), upper);
                high = _mm256_fmadd_pd(w, most, high);
                low = _mm256_fmadd_pd(w, _mm256_sub_pd(v, most), low);
            }
            _mm256_storeu_pd(exact->high[p] + i, high);
            _mm256_storeu_pd(exact->low[p] + i, low);
            _mm_storeu_ps(out->c[p] + i, _mm256_cvtpd_ps(_mm256_mul_pd(_mm256_add_pd(high, low),
                                                                       _mm256_set1_pd(0x1p-31))));
        }
    }
    end_lanes();
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
    end_lanes();
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
            const __m256 sure =
                _mm256_or_ps(_mm256_or_ps(all, _mm256_castsi256_ps(none)),
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
    end_lanes();
}
