/* SPDX-License-Identifier: MIT */
/*
 * stretch_avx512.c - columns of packed texels of 8 bit, filtered down with AVX-512
 *
 * Two roots and quotients take as long as one of half the width.  Sums are of whole numbers below 2^24, so
 * multiply-add is exact, too.
 */
#include "detect/stretch.h"

#include "texel/packed_avx512_tmpl.h"

void ntp__filter_down8_avx512(columns *to, const uint8_t *const rows[TAPS], int32_t channels,
                              int32_t n, bool alpha)
{
    enum { MAX = 255 };
    const __m512i max = _mm512_set1_epi16(MAX), square = _mm512_set1_epi32(MAX * MAX);
    const __m512i least = _mm512_set1_epi32((int32_t) ntp__least_rest(MAX));
    const __m512i far = _mm512_set1_epi32(ntp__far_sum(MAX));
    const __m512i places = steps_of(0x010001 * channels, 0x010000);
    const __m512i alphas = _mm512_set1_epi32((int32_t) 0xff000000);
    const __mmask16 hides = alpha ? 0xffff : 0;
    for (int32_t first = 0; first < n; first += LANES_512) {
        const int32_t i = first > n - LANES_512 ? n - LANES_512 : first; /* the last again */
        __m512 u = _mm512_setzero_ps(), v = u, p_smooth = u, q_steep = u;
        __mmask16 steep = 0, no_normal = 0;
        for (int32_t k = 0; k < TAPS; k++) {
            const uint8_t *const s = rows[k] + (ptrdiff_t) i * channels;
            const __m512i t = channels == 3 ? load_48(s) : _mm512_loadu_si512(s);
            const __m512i rg = _mm512_maskz_permutexvar_epi8(0x5555555555555555, places, t);
            const __m512i xy = _mm512_sub_epi16(_mm512_add_epi16(rg, rg), max);
            const __m512i rest = _mm512_sub_epi32(square, _mm512_madd_epi16(xy, xy));
            const __mmask16 low = _mm512_cmplt_epi32_mask(rest, least);
            const __mmask16 end = _mm512_cmpgt_epi32_mask(
                _mm512_abs_epi32(_mm512_madd_epi16(xy, _mm512_set1_epi16(1))), far);
            steep |= low;
            no_normal |= (low & end) | _mm512_mask_testn_epi32_mask(hides, t, alphas);
            const __m512 z = _mm512_sqrt_ps(_mm512_cvtepi32_ps(_mm512_max_epi32(rest, least)));
            const __m512i x = _mm512_srai_epi32(_mm512_slli_epi32(xy, 16), 16 - SLOPE_ONE_BITS);
            const __m512i y = _mm512_slli_epi32(_mm512_srai_epi32(xy, 16), SLOPE_ONE_BITS);
            const __m512 p = _mm512_roundscale_ps(_mm512_div_ps(_mm512_cvtepi32_ps(x), z),
                                                  _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
            const __m512 q = _mm512_roundscale_ps(_mm512_div_ps(_mm512_cvtepi32_ps(y), z),
                                                  _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
            const __m512 steeply = _mm512_set1_ps(STEEP[TAPS - 1 - k]); /* its other sign */
            const __m512 smoothly = _mm512_set1_ps(SMOOTH[k]);
            u = _mm512_fmadd_ps(p, steeply, u);
            q_steep = _mm512_fmadd_ps(q, steeply, q_steep);
            v = _mm512_fmadd_ps(q, smoothly, v);
            p_smooth = _mm512_fmadd_ps(p, smoothly, p_smooth);
            if (k == BEFORE || k == BEFORE + 1) {
                _mm512_storeu_ps(to->p[k - BEFORE] + i, p);
                _mm512_storeu_ps(to->q[k - BEFORE] + i, q);
            }
        }
        _mm512_storeu_ps(to->u + i, u);
        _mm512_storeu_ps(to->v + i, v);
        _mm512_storeu_ps(to->p_smooth + i, p_smooth);
        _mm512_storeu_ps(to->q_steep + i, q_steep);
        const __m512i bad = _mm512_maskz_set1_epi32(steep, TOO_STEEP);
        _mm512_storeu_si512(
            to->bad + i, _mm512_mask_or_epi32(bad, no_normal, bad, _mm512_set1_epi32(NO_NORMAL)));
    }
    _mm256_zeroupper();
}
