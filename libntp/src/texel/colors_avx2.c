/* SPDX-License-Identifier: MIT */
/*
 * colors_avx2.c - colors of packed RGBA as packed RGB, and back, with AVX2
 *
 * Sixteen bytes of pixels, of both depths, have twelve of colors.
 */
#include "texel/cells_avx2.h"

#include "libntp.h"

#include <immintrin.h>

/* Of 8 and of 16 bit: the colors of these bytes; where they go; the lower and the upper byte of each alpha. */
#define N 128
static const uint8_t COLORS[2][4][16] = {
    { { 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, N, N, N, N },
      { 0, 1, 2, N, 3, 4, 5, N, 6, 7, 8, N, 9, 10, 11, N },
      { 3, 3, 3, 3, 7, 7, 7, 7, 11, 11, 11, 11, 15, 15, 15, 15 },
      { 3, 3, 3, 3, 7, 7, 7, 7, 11, 11, 11, 11, 15, 15, 15, 15 } },
    { { 0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, N, N, N, N },
      { 0, 1, 2, 3, 4, 5, N, N, 6, 7, 8, 9, 10, 11, N, N },
      { 6, 6, 6, 6, 6, 6, 6, 6, 14, 14, 14, 14, 14, 14, 14, 14 },
      { 7, 7, 7, 7, 7, 7, 7, 7, 15, 15, 15, 15, 15, 15, 15, 15 } }
};
#undef N

void ntp__move_colors_avx2(uint8_t *rgb, uint8_t *dst, const uint8_t *src, int32_t n, int32_t m,
                           uint32_t touch_unused)
{
    const int32_t deep = m > 255;
    __m128i at[4];
    for (int k = 0; k < 4; k++)
        at[k] = _mm_loadu_si128((const __m128i *) (const void *) COLORS[deep][k]);
    const __m128i flat = deep ? _mm_set1_epi64x(0xffff80008000) : _mm_set1_epi32(0xff8080);
    const __m128i touched = _mm_set1_epi8(touch_unused & NTP_UNUSED_TRANSPARENT ? -1 : 0);
    for (int32_t i = 0; i < n << (2 + deep); i += 16, rgb += 12) {
        const __m128i v = _mm_loadu_si128((const __m128i *) (const void *) (src + i));
        const __m128i zero = _mm_cmpeq_epi8(v, _mm_setzero_si128());
        const __m128i clear = _mm_andnot_si128(
            touched, _mm_and_si128(_mm_shuffle_epi8(zero, at[2]), _mm_shuffle_epi8(zero, at[3])));
        if (dst == NULL) {
            const __m128i c = _mm_shuffle_epi8(_mm_blendv_epi8(v, flat, clear), at[0]);
            _mm_storeu_si128((__m128i *) (void *) rgb, c);
        } else {
            const __m128i c = _mm_loadu_si128((const __m128i *) (const void *) rgb);
            const __m128i stays = _mm_or_si128(clear, at[1]);
            _mm_storeu_si128((__m128i *) (void *) (dst + i),
                             _mm_blendv_epi8(_mm_shuffle_epi8(c, at[1]), v, stays));
        }
    }
}
