/* SPDX-License-Identifier: MIT */
/*
 * resize_avx512.c - sums of whole rows, exact sums of columns, and directions as packed RGB of 8 bit, with AVX-512
 *
 * As resize_avx2.c does it.  Fused products only make errors smaller, so its bounds hold.
 */
#include "reshape/resize_kernels.h"

#include "base/lanes_avx2.h"
#include "texel/packed_avx512_tmpl.h"

#include <string.h>

/* 32 sums of two numbers */
static inline __m512i load_both(const float *row, const float *other, int32_t i)
{
    const int16_t *a = (const void *) row, *b = (const void *) other;
    return _mm512_add_epi16(_mm512_loadu_si512(a + i), _mm512_loadu_si512(b + i));
}

static inline __m512i two_weights(const int16_t *weight)
{
    int32_t two;
    memcpy(&two, weight, sizeof two);
    return _mm512_set1_epi32(two);
}

void ntp__sum_whole_avx512(float *sums, const ntp__whole_weights *from, int32_t count)
{
    /* Numbers 0 to 3 and 8 to 11 of each 16 are in the one half, the others in the other. */
    const __m512i first = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    const __m512i second = _mm512_add_epi32(first, _mm512_set1_epi32(8));
    for (int32_t i = 0; i < count; i += 2 * LANES_512) {
        const __m512i zero = _mm512_setzero_si512();
        __m512i high[2] = { zero, zero }, low[2] = { zero, zero };
        for (int32_t t = 0; t < from->n; t += 2) {
            const __m512i w = two_weights(from->upper + t), x = two_weights(from->lower + t);
            const __m512i a = load_both(from->row[t], from->other[t], i);
            const __m512i b = load_both(from->row[t + 1], from->other[t + 1], i);
            const __m512i c[2] = { _mm512_unpacklo_epi16(a, b), _mm512_unpackhi_epi16(a, b) };
            UNROLLED
            for (int32_t k = 0; k < 2; k++) {
                high[k] = _mm512_add_epi32(high[k], _mm512_madd_epi16(c[k], w));
                low[k] = _mm512_add_epi32(low[k], _mm512_madd_epi16(c[k], x));
            }
        }
        __m512 v[2];
        UNROLLED
        for (int32_t k = 0; k < 2; k++)
            v[k] = _mm512_fmadd_ps(_mm512_cvtepi32_ps(low[k]), _mm512_set1_ps(0x1p-15F),
                                   _mm512_cvtepi32_ps(high[k]));
        _mm512_storeu_ps(sums + i, _mm512_permutex2var_ps(v[0], first, v[1]));
        _mm512_storeu_ps(sums + i + LANES_512, _mm512_permutex2var_ps(v[0], second, v[1]));
    }
    end_lanes();
}

void ntp__sum_exactly_avx512(ntp__whole_sums *exact, ntp__planes *out, const double *sums,
                             const double *weight, int32_t taps, int32_t first, int32_t n,
                             int32_t planes)
{
    enum { EIGHT = 8 };
    const __m512d upper = _mm512_set1_pd(0x1.8p72); /* as in resize_exact_avx2.c */
    for (int32_t p = 0; p < planes; p++, sums += 2 * NTP__RUN) {
        for (int32_t i = first; i < n; i += EIGHT) {
            const double *a = sums + i, *b = a + NTP__RUN + taps / 2 - 1;
            ptrdiff_t step = NTP__RUN;
            __m512d high = _mm512_setzero_pd(), low = high;
            for (int32_t t = 0; t < taps / 2; t++, a += step, b -= step, step = 1 - step) {
                const __m512d w = _mm512_set1_pd(weight[t]);
                const __m512d v = _mm512_add_pd(_mm512_loadu_pd(a), _mm512_loadu_pd(b));
                const __m512d most = _mm512_sub_pd(_mm512_add_pd(v, upper), upper);
                high = _mm512_fmadd_pd(w, most, high);
                low = _mm512_fmadd_pd(w, _mm512_sub_pd(v, most), low);
            }
            const __m512d all = _mm512_mul_pd(_mm512_add_pd(high, low), _mm512_set1_pd(0x1p-31));
            _mm512_storeu_pd(exact->high[p] + i, high);
            _mm512_storeu_pd(exact->low[p] + i, low);
            _mm256_storeu_ps(out->c[p] + i, _mm512_cvtpd_ps(all));
        }
    }
    end_lanes();
}

/* Levels of v over the length, less that of 0; adds to *doubt, which says where they may be wrong. */
static inline __m512i rounded(__m512 v, __m512 factor, __m512 error, __mmask16 *doubt)
{
    const __m512 a = _mm512_mul_ps(v, factor);
    const __m512 from = _mm512_sub_ps(a, _mm512_roundscale_ps(a, _MM_FROUND_TO_NEAREST_INT));
    const __m512 near = _mm512_fmadd_ps(_mm512_abs_ps(a), _mm512_set1_ps(7 * 0x1p-24F), error);
    *doubt |= _mm512_cmp_ps_mask(_mm512_abs_ps(from), near, _CMP_NGE_UQ);
    return _mm512_cvt_roundps_epi32(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

/* Pulls pairs that are too long, as packed_avx2_tmpl.h says; *e is theirs. */
static inline __m512i pulled(__m512i pair, __m512i *e, __mmask16 over)
{
    const __m512i sign = _mm512_srai_epi16(pair, 15), q = _mm512_xor_si512(pair, sign);
    const __m512i to = _mm512_mask_mov_epi32(q, over, onto_disc(q, q, false));
    *e = _mm512_sub_epi32(
        _mm512_set1_epi32(REST_8),
        _mm512_add_epi32(_mm512_madd_epi16(to, to), _mm512_madd_epi16(to, _mm512_set1_epi16(1))));
    return _mm512_xor_si512(to, sign);
}

/* Sixteen texels; *left: those that are in doubt. */
static inline texels directions(const ntp__planes *p, int32_t i, __m512 error, __mmask16 *left)
{
    const __m512 x = _mm512_loadu_ps(p->c[0] + i), y = _mm512_loadu_ps(p->c[1] + i);
    const __m512 z = _mm512_loadu_ps(p->c[2] + i);
    const __m512 square = _mm512_fmadd_ps(z, z, _mm512_fmadd_ps(y, y, _mm512_mul_ps(x, x)));
    /* Changes no length but 0. */
    const __m512 length = _mm512_sqrt_ps(_mm512_max_ps(square, _mm512_set1_ps(0x1p-100F)));
    const __m512 factor = _mm512_div_ps(_mm512_set1_ps(127.5F), length);
    const __m512i zeros = _mm512_set1_epi16(128);
    error = _mm512_mul_ps(error, factor);
    *left = 0;
    const __m512i r = rounded(x, factor, error, left), g = rounded(y, factor, error, left);
    const __m512i pair = _mm512_mask_mov_epi16(r, 0xaaaaaaaa, _mm512_slli_epi32(g, 16));
    texels t;
    t.rg = _mm512_add_epi16(pair, zeros);
    __m512i e = rest_of(t.rg, false);
    const __mmask16 over = _mm512_cmplt_epi32_mask(e, _mm512_setzero_si512());
    if (over != 0)
        t.rg = _mm512_add_epi16(pulled(pair, &e, over), zeros);
    const __mmask16 down = _mm512_cmp_ps_mask(z, _mm512_setzero_ps(), _CMP_LT_OQ);
    t.b = _mm512_add_epi32(root_of(e, false), _mm512_set1_epi32(128));
    t.b = _mm512_mask_xor_epi32(t.b, down, t.b, _mm512_set1_epi32(255));
    return t;
}

int32_t ntp__pack_directions_avx512(uint8_t *d, int32_t *at, const ntp__planes *p, int32_t first,
                                    int32_t n, float error)
{
    const __m512 off = _mm512_set1_ps(3 * error); /* 1 + sqrt(3), with some room */
    int32_t found = 0;
    for (int32_t i = first; i < n; i += LANES_512) {
        const bool last = n - i < LANES_512;
        uint8_t few[3 * LANES_512], *to = d + 3 * i;
        __mmask16 doubt;
        const texels t = directions(p, i, off, &doubt);
        uint32_t left = doubt;
        put8(last ? few : to, t);
        if (last) {
            memcpy(to, few, 3 * (size_t) (n - i));
            left &= (1U << (n - i)) - 1;
        }
        for (; left != 0; left &= left - 1)
            at[found++] = i + __builtin_ctz(left);
    }
    end_lanes();
    return found;
}
