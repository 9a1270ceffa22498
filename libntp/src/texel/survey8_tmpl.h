/* SPDX-License-Identifier: MIT */
/*
 * survey8_tmpl.h - sums and extremes of packed texels of 8 bit; a part of kernels.c
 *
 * Of three channels, three registers of 32 bytes are a period: of these, each third byte of each one makes
 * a register of one channel.  Of four, the bytes of one channel are masked.
 */

#ifdef __AVX2__

/* The least of 32 bytes. */
static inline uint32_t least_byte(__m256i v)
{
    const __m128i half = _mm_min_epu8(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i odd = _mm_srli_epi16(half, 8);
    return (uint32_t) _mm_cvtsi128_si32(_mm_minpos_epu16(_mm_min_epu8(odd, half))) & 255;
}

static inline uint64_t sum_of_lanes(__m256i v)
{
    const __m128i half = _mm_add_epi64(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return (uint64_t) _mm_cvtsi128_si64(_mm_add_epi64(half, _mm_unpackhi_epi64(half, half)));
}

static ALWAYS_INLINE int32_t survey8_of(ntp__survey8 *s, const uint8_t *p, int32_t n,
                                        const int channels)
{
    enum { BYTES = 32 };
    /* Every third byte, and every fourth; from the first place where they begin. */
#  define THIRD  255, 0, 0
#  define FOURTH 255, 0, 0, 0
    static const uint8_t EVERY[2][BYTES + 4] = {
        { THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD, THIRD },
        { FOURTH, FOURTH, FOURTH, FOURTH, FOURTH, FOURTH, FOURTH, FOURTH, FOURTH },
    };
#  undef THIRD
#  undef FOURTH
    const int vectors = channels == 3 ? 3 : 1;
    const int32_t step = BYTES * vectors / channels;
    const __m256i none = _mm256_setzero_si256(), all = _mm256_set1_epi8(-1);
    __m256i of[3], sum[3] = { none, none, none };
    __m256i least[3] = { all, all, all }, greatest[3] = { none, none, none };
    int32_t done = 0;
    UNROLLED
    for (int c = 0; c < 3; c++)
        of[c] = _mm256_loadu_si256(
            (const __m256i *) (const void *) (EVERY[channels - 3] + (channels - c) % channels));
    for (; done + step <= n; done += step, p += BYTES * vectors) {
        const __m256i *const v = (const __m256i *) (const void *) p;
        UNROLLED
        for (int c = 0; c < 3; c++) {
            __m256i own = _mm256_loadu_si256(v);
            if (channels == 3) { /* each third byte of three registers */
                own = _mm256_blendv_epi8(own, _mm256_loadu_si256(v + 1), of[(c + 1) % 3]);
                own = _mm256_blendv_epi8(own, _mm256_loadu_si256(v + 2), of[(c + 2) % 3]);
            }
            least[c] = _mm256_min_epu8(least[c], own);
            greatest[c] = _mm256_max_epu8(greatest[c], own);
            if (channels == 4)
                own = _mm256_and_si256(own, of[c]);
            sum[c] = _mm256_add_epi64(sum[c], _mm256_sad_epu8(own, none));
        }
    }
    UNROLLED
    for (int c = 0; c < 3; c++) {
        __m256i low = least[c], high = greatest[c];
        if (channels == 4) {
            low = _mm256_or_si256(low, _mm256_xor_si256(of[c], all));
            high = _mm256_and_si256(high, of[c]);
        }
        s->sum[c] = sum_of_lanes(sum[c]);
        s->least[c] = least_byte(low);
        s->greatest[c] = 255 - least_byte(_mm256_xor_si256(high, all));
    }
    return done;
}

static int32_t survey8(ntp__survey8 *s, const uint8_t *src, int32_t n, int32_t channels)
{
    return channels == 3 ? survey8_of(s, src, n, 3) : survey8_of(s, src, n, 4);
}

#else

/* A group of texels at a time, in columns.  At the end these become channels. */
static int32_t survey8(ntp__survey8 *s, const uint8_t *p, int32_t n, int32_t channels)
{
    enum { GROUP = 16, MOST = 4 * GROUP, STEPS = 256 }; /* 256 bytes add up to less than 2^16 */
    uint8_t least[MOST], greatest[MOST];
    uint16_t sums[MOST];
    const int32_t step = channels * GROUP;
    int32_t done = 0;
    memset(s, 0, sizeof *s);
    memset(s->least, 255, sizeof s->least);
    memset(least, 255, sizeof least);
    memset(greatest, 0, sizeof greatest);
    while (done + GROUP <= n) {
        memset(sums, 0, sizeof sums);
        for (int32_t k = 0; k < STEPS && done + GROUP <= n; k++, done += GROUP, p += step) {
            for (int32_t i = 0; i < step; i++) {
                least[i] = p[i] < least[i] ? p[i] : least[i];
                greatest[i] = p[i] > greatest[i] ? p[i] : greatest[i];
                sums[i] = (uint16_t) (sums[i] + p[i]);
            }
        }
        for (int32_t i = 0; i < step; i++) {
            if (i % channels < 3)
                s->sum[i % channels] += sums[i];
        }
    }
    for (int32_t i = 0; i < step; i++) {
        const int32_t c = i % channels;
        if (c == 3)
            continue;
        s->least[c] = least[i] < s->least[c] ? least[i] : s->least[c];
        s->greatest[c] = greatest[i] > s->greatest[c] ? greatest[i] : s->greatest[c];
    }
    return done;
}
#endif
