/* SPDX-License-Identifier: MIT */
/*
 * alpha8_avx2_tmpl.h - counts of the alpha of packed RGBA of 8 bit; a part of cells_avx2.c
 */

/* Alpha and green of eight texels in the disc; of two zeros the sum is greater. */
static ALWAYS_INLINE uint32_t are_in_disc(__m256i texels)
{
    const __m256i from = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(1, 3, -1, -1, 5, 7, -1, -1, 9, 11, -1, -1, 13, 15, -1, -1));
    const __m256i k = k_of(_mm256_shuffle_epi8(texels, from));
    const __m256i sum = _mm256_maddubs_epi16(_mm256_sub_epi8(k, _mm256_set1_epi8(-1)), k);
    return words_set(_mm256_cmpgt_epi16(_mm256_set1_epi16(REST_8 + 1), sum));
}

/* A bit for each of 16 texels. */
static ALWAYS_INLINE uint32_t lanes_of_texels(__m256i a, __m256i b)
{
    return (uint32_t) (_mm256_movemask_ps(_mm256_castsi256_ps(a)) |
                       _mm256_movemask_ps(_mm256_castsi256_ps(b)) << 8);
}

int32_t ntp__count_alpha8_avx2(ntp__alphas8 *alphas, const uint8_t *src, int32_t n, int32_t visible)
{
    const __m256i alpha = _mm256_set1_epi32((int) 0xff000000);
    const __m256i hidden = _mm256_set1_epi32(visible ? 0 : 1); /* 1 is no alpha here */
    int32_t i = 0;
    for (; i + GROUP <= n; i += GROUP, src += 4 * GROUP) {
        const __m256i a = _mm256_loadu_si256((const __m256i *) (const void *) src);
        const __m256i b = _mm256_loadu_si256((const __m256i *) (const void *) (src + 2 * GROUP));
        const __m256i alpha_a = _mm256_and_si256(a, alpha), alpha_b = _mm256_and_si256(b, alpha);
        const __m256i clear_a = _mm256_cmpeq_epi32(alpha_a, hidden),
                      clear_b = _mm256_cmpeq_epi32(alpha_b, hidden);
        const uint32_t clear = lanes_of_texels(clear_a, clear_b);
        const uint32_t full =
            lanes_of_texels(_mm256_cmpeq_epi32(alpha_a, alpha), _mm256_cmpeq_epi32(alpha_b, alpha));
        if (clear != 0) {
            uint32_t color;
            memcpy(&color, src + 4 * __builtin_ctz(clear), sizeof color);
            const __m256i same = _mm256_set1_epi32((int) color);
            const __m256i other =
                _mm256_or_si256(_mm256_andnot_si256(_mm256_cmpeq_epi32(a, same), clear_a),
                                _mm256_andnot_si256(_mm256_cmpeq_epi32(b, same), clear_b));
            if ((alphas->clear > 0 && alphas->color != color) || !_mm256_testz_si256(other, other))
                break;
            alphas->color = color;
            alphas->clear += (uint32_t) __builtin_popcount(clear);
        }
        if ((full | clear) == 0xffff) {
            alphas->count[0][0] += (uint32_t) __builtin_popcount(clear);
            alphas->count[0][255] += (uint32_t) __builtin_popcount(full);
            continue;
        }
        alphas->in_disc += are_in_disc(a) + are_in_disc(b);
        /* Neighbors are often alike, and a count waits for the one before it in the same place. */
        for (int32_t k = 0; k < GROUP; k += 4) {
            UNROLLED
            for (int32_t c = 0; c < 4; c++)
                alphas->count[c][src[4 * (k + c) + 3]]++;
        }
    }
    end_lanes();
    return i;
}
