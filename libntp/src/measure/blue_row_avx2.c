/* SPDX-License-Identifier: MIT */
/*
 * blue_row_avx2.c - adds up the blues of a row of cells, with AVX2
 *
 * Sums of whole numbers below 2^53 do not depend on their order.  Those of distances do, so that each of these
 * waits for the one before it; all else is done meanwhile.  Lanes behind the last cell add 0.
 */
#include "measure/blue_row.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"

enum { LANES = 4 };

typedef struct row_sums {
    __m256d texels, blue, blue2, above, near[2];
    __m128d off; /* standard, Z-zero */
} row_sums;

/* The sums of the lanes of four. */
static ALWAYS_INLINE __m256d sums_of(__m256d a, __m256d b, __m256d c, __m256d d)
{
    const __m256d ab = _mm256_hadd_pd(a, b), cd = _mm256_hadd_pd(c, d);
    return _mm256_add_pd(_mm256_permute2f128_pd(ab, cd, 0x20),
                         _mm256_permute2f128_pd(ab, cd, 0x31));
}

static ALWAYS_INLINE __m256d those(__m256d which, __m256d count)
{
    return _mm256_and_pd(which, count);
}

static ALWAYS_INLINE void add_tilted(row_sums *s, const ntp__blue_row *row, __m256d blue,
                                     __m256d count)
{
    __m256d times[2];
    for (int32_t k = 0; k < 2; k++) {
        const __m256d less = _mm256_sub_pd(blue, _mm256_set1_pd(row->want[k]));
        const __m256d off = _mm256_andnot_pd(_mm256_set1_pd(-0.0), less);
        const __m256d near = _mm256_cmp_pd(off, _mm256_set1_pd(NTP__BLUE_NEAR), _CMP_LE_OQ);
        s->near[k] = _mm256_add_pd(s->near[k], those(near, count));
        times[k] = _mm256_mul_pd(count, _mm256_min_pd(off, _mm256_set1_pd(NTP__BLUE_OFF_MOST)));
    }
    const __m256d most = _mm256_set1_pd(row->want[0] + NTP__BLUE_ABOVE);
    s->above = _mm256_add_pd(s->above, those(_mm256_cmp_pd(blue, most, _CMP_GT_OQ), count));
    const __m256d even = _mm256_unpacklo_pd(times[0], times[1]),
                  odd = _mm256_unpackhi_pd(times[0], times[1]);
    s->off = _mm_add_pd(s->off, _mm256_castpd256_pd128(even));
    s->off = _mm_add_pd(s->off, _mm256_castpd256_pd128(odd));
    s->off = _mm_add_pd(s->off, _mm256_extractf128_pd(even, 1));
    s->off = _mm_add_pd(s->off, _mm256_extractf128_pd(odd, 1));
}

void ntp__add_blues_avx2(ntp__blue_sums *sums, ntp__blue_row *row, const ntp__cells *cells,
                         int32_t n)
{
    const double half = 2147483648.0; /* conversions are of signed numbers */
    const __m256d zero = _mm256_setzero_pd();
    row_sums s = { zero, zero, zero, zero, { zero, zero }, _mm_loadu_pd(sums->off) };
    double four[4];
    for (int32_t i = 0; i < n; i += LANES) {
        const __m128i left = _mm_cmpgt_epi32(_mm_set1_epi32(n - i), _mm_setr_epi32(0, 1, 2, 3));
        const __m128i c = _mm_loadu_si128((const void *) (cells->count + i));
        const __m256d blue = _mm256_cvtepi32_pd(_mm_loadu_si128((const void *) (cells->blue + i)));
        const __m128i least = _mm_xor_si128(_mm_and_si128(c, left), _mm_set1_epi32(INT32_MIN));
        const __m256d count = _mm256_add_pd(_mm256_cvtepi32_pd(least), _mm256_set1_pd(half));
        const __m256d part = _mm256_mul_pd(count, blue);
        s.texels = _mm256_add_pd(s.texels, count);
        s.blue = _mm256_add_pd(s.blue, part);
        s.blue2 = _mm256_add_pd(s.blue2, _mm256_mul_pd(part, blue));
        if (row->is_tilted)
            add_tilted(&s, row, blue, count);
    }
    _mm256_storeu_pd(four, sums_of(s.texels, s.blue, s.blue2, s.above));
    row->n = four[0];
    row->blue = four[1];
    row->blue2 = four[2];
    sums->above += four[3];
    const __m256d near = _mm256_hadd_pd(s.near[0], s.near[1]);
    const __m128d both = _mm_add_pd(_mm256_castpd256_pd128(near), _mm256_extractf128_pd(near, 1));
    _mm_storeu_pd(sums->near, _mm_add_pd(_mm_loadu_pd(sums->near), both));
    _mm_storeu_pd(sums->off, s.off);
    end_lanes();
}
