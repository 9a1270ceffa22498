/* SPDX-License-Identifier: MIT */
/*
 * cells_avx512.c - counts packed texels of 8 bit that are close to exact, with AVX-512
 *
 * As count_close8 of cells_avx2.c, which says why the numbers are right, but 32 texels at a time, and their
 * sums and extremes on the way.  A count takes about as long as all the arithmetic for a texel.  So flat
 * texels with their derived blue, half of many textures, are counted by bits of masks instead.
 *
 * No list is longer than the texels looked at so far, so there is room for 16 lanes at its end.
 */
#include "texel/kernels_avx512.h"

#include "base/lanes_avx2.h"
#include "texel/packed_avx512_tmpl.h"

#include <string.h>

/* A loop of two steps, also where the compiler saves code. */
#define UNROLLED _Pragma("GCC unroll 2")

enum { STEP = 32, FLAT = NTP__ROWS - NTP__FLAT_ROWS };

/* The lanes of a mask's low half, one after the other: behind them come any numbers.  Returns how many. */
static inline int32_t keep(uint32_t *at, __m512i places, __mmask32 mask)
{
    const __mmask16 these = (__mmask16) mask;
    _mm512_storeu_si512(at, _mm512_maskz_compress_epi32(these, places));
    return __builtin_popcount(these);
}

/* Sixteen of 32 words. */
static inline __m512i half_of(__m512i words, int k)
{
    return _mm512_cvtepu16_epi32(k ? _mm512_extracti64x4_epi64(words, 1)
                                   : _mm512_castsi512_si256(words));
}

/* The same as bytes. */
static inline int32_t keep_bytes(uint8_t *at, __m512i places, __mmask32 mask)
{
    const __mmask16 these = (__mmask16) mask;
    const __m512i kept = _mm512_maskz_compress_epi32(these, places);
    _mm_storeu_si128((void *) at, _mm512_cvtepi32_epi8(kept));
    return __builtin_popcount(these);
}

/* Bytes `first` and first + 1 of 32 texels, in two registers of which the second begins at byte `second`. */
static inline __m512i bytes_of(int32_t channels, int32_t first, int32_t second)
{
    const __m512i from =
        _mm512_add_epi8(steps_of(0x02020202 * channels, 0x01000100 + 0x01010000 * channels),
                        _mm512_set1_epi8((char) first));
    const __mmask64 others = _mm512_cmpge_epu8_mask(from, _mm512_set1_epi8(64));
    return _mm512_mask_add_epi8(from, others, from, _mm512_set1_epi8((char) (64 - second)));
}

/* The greater ones of registers as texels of four channels. */
ONE_COPY static void merge_greatest(uint8_t *to, __m512i rg, __m512i b)
{
    const __m512i low = _mm512_unpacklo_epi16(rg, b), high = _mm512_unpackhi_epi16(rg, b);
    _mm512_storeu_si512(to, _mm512_max_epu8(_mm512_loadu_si512(to), low));
    _mm512_storeu_si512(to + 64, _mm512_max_epu8(_mm512_loadu_si512(to + 64), high));
}

ONE_COPY static uint64_t sum_of(__m512i v)
{
    return (uint64_t) _mm512_reduce_add_epi64(v);
}

static inline __m512i plus_bytes(__m512i sums, __m512i bytes)
{
    return _mm512_add_epi64(sums, _mm512_sad_epu8(bytes, _mm512_setzero_si512()));
}

/* The sums of all lanes of four bits, each of 16 bits. */
ONE_COPY static uint64_t flat_counts(__m512i flat)
{
    __m512i sums = _mm512_setzero_si512();
    for (int i = 0; i < NTP__FLAT_ROWS; i++) {
        const __m512i one = _mm512_and_si512(_mm512_srl_epi16(flat, _mm_cvtsi32_si128(4 * i)),
                                             _mm512_set1_epi16(15));
        sums = plus_bytes(_mm512_ror_epi64(sums, 16), one);
    }
    return sum_of(_mm512_ror_epi64(sums, 16));
}

void ntp__count_close8_avx512(ntp__close8_block *out, ntp__close8_counts close, const uint8_t *src,
                              int32_t n, int32_t channels, size_t ahead)
{
    enum { MOVED = FLAT - NTP__CLOSE8_ROWS, COPIES = NTP__CLOSE8_COPIES };
    _Alignas(64) uint32_t at[256 + LANES_512];
    const bool rgb = channels == 3;
    /* processors fetch what follows */
    const int32_t second = STEP * channels - 64; /* ends with the texels */
    const __m512i from_rg = bytes_of(channels, 0, second), from_b = bytes_of(channels, 2, second);
    const __mmask64 used = rgb ? 0x5555555555555555 : UINT64_MAX;
    const bool hides = !rgb && out->visible;
    const __m512i low = _mm512_set1_epi16(255), one = _mm512_set1_epi8(1);
    const __m512i one_flat =
        _mm512_set1_epi64(0x1000010000100001); /* by number of row: 16 to its last bits */
    const __m512i twice =
        _mm512_broadcast_i32x4(_mm_setr_epi8(0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14, 14));
    __m512i least_rg = _mm512_set1_epi8(-1), least_b = least_rg;
    __m512i most_rg = _mm512_setzero_si512(), most_b = most_rg;
    __m512i sum_r = most_rg, sum_g = most_rg, sum_b = most_rg;
    __m512i flat =
        most_rg; /* counts of four bits, up to 8: one for each flat pair, as flat_counts has it */
    __m512i unlike = most_rg; /* the first one */
    __m512i every = least_rg; /* the bits of all */
    __m512i first = most_rg;
    int32_t waiting = 0, others = 0, colors = 0, hidden = 0;
    for (int32_t i = 0; i < n; i += STEP, src += channels * STEP) {
        _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
        _mm_prefetch((const char *) src + ahead + 64, _MM_HINT_T0);
        const __m512i v = _mm512_loadu_si512(src), w = _mm512_loadu_si512(src + second);
        const __m512i rg = _mm512_permutex2var_epi8(v, from_rg, w);
        const __m512i blue_alpha = _mm512_maskz_permutex2var_epi8(used, v, from_b, w);
        const __m512i b = _mm512_and_si512(blue_alpha, low);
        every = _mm512_and_si512(every, blue_alpha);
        least_rg = _mm512_min_epu8(least_rg, rg);
        least_b = _mm512_min_epu8(least_b, b);
        most_rg = _mm512_max_epu8(most_rg, rg);
        most_b = _mm512_max_epu8(most_b, b);
        sum_r = plus_bytes(sum_r, _mm512_and_si512(rg, low));
        sum_g = plus_bytes(sum_g, _mm512_srli_epi16(rg, 8));
        sum_b = plus_bytes(sum_b, b);

        const __m512i k = _mm512_min_epu8(_mm512_xor_si512(rg, _mm512_set1_epi8(127)),
                                          _mm512_xor_si512(rg, _mm512_set1_epi8(-128)));
        const __m512i xy = _mm512_maddubs_epi16(_mm512_add_epi8(k, one), k);
        const __m512i u = _mm512_subs_epu16(b, _mm512_set1_epi16(127));
        const __m512i square = _mm512_mullo_epi16(u, _mm512_add_epi16(u, _mm512_set1_epi16(8)));
        const __m512i sum =
            _mm512_add_epi16(square, _mm512_sub_epi16(xy, _mm512_set1_epi16(REST_8 - 15)));
        __mmask32 gray = _mm512_cmpeq_epi16_mask(rg, _mm512_shuffle_epi8(b, twice));
        __mmask32 other = gray | _mm512_cmple_epu16_mask(_mm512_slli_epi16(u, 4), sum);

        const __m512i p = _mm512_and_si512(k, low), q = _mm512_srli_epi16(k, 8);
        const __m512i k1 = _mm512_max_epi16(p, q), k2 = _mm512_min_epi16(p, q);
        const __m512i rectangle =
            _mm512_mullo_epi16(k1, _mm512_sub_epi16(k1, _mm512_set1_epi16(-1)));
        const __mmask32 in_middle = _mm512_testn_epi16_mask(k, k);
        const __m512i row =
            _mm512_mask_add_epi16(_mm512_add_epi16(_mm512_srli_epi16(rectangle, 1), k2), in_middle,
                                  _mm512_maddubs_epi16(rg, _mm512_set1_epi16(0x201)),
                                  _mm512_set1_epi16(FLAT - (127 + 2 * 127)));
        const __m512i place =
            _mm512_or_si512(_mm512_mask_sub_epi16(row, in_middle, row, _mm512_set1_epi16(MOVED)),
                            _mm512_slli_epi16(b, NTP__CLOSE8_SHIFT));

        first = i == 0 ? _mm512_broadcastw_epi16(_mm512_castsi512_si128(place)) : first;
        unlike = _mm512_ternarylogic_epi64(unlike, place, first, 0xf6); /* | ^ */
        __mmask32 exact = _mm512_mask_cmpeq_epi16_mask(in_middle, b, low);
        __mmask32 counted = ~(other | exact);
        if (hides && _mm512_cmple_epu16_mask(blue_alpha, low) != 0) {
            const __mmask32 shown = _mm512_cmpgt_epu16_mask(blue_alpha, low);
            hidden += STEP - __builtin_popcount(shown);
            gray &= shown;
            other &= shown;
            exact &= shown;
            counted &= shown;
        }
        flat = _mm512_mask_add_epi16(flat, exact, flat, _mm512_permutexvar_epi16(row, one_flat));

        const __mmask32 colored = other & ~gray;
        UNROLLED
        for (int h = 0; h < 2; h++)
            waiting += keep(at + waiting, _mm512_slli_epi32(half_of(place, h), 2),
                            counted >> LANES_512 * h);
        UNROLLED
        for (int h = 0; h < 2 && colored != 0; h++) {
            const __m512i blue = _mm512_slli_epi32(half_of(b, h), 16);
            colors += keep(out->color + colors, _mm512_or_si512(half_of(row, h), blue),
                           colored >> LANES_512 * h);
        }
        if (gray != 0) {
            _mm512_storeu_si512(out->row + i, row);
            for (int h = 0; h < 2; h++)
                others += keep_bytes(out->left + others, steps_of(1, i + LANES_512 * h),
                                     gray >> LANES_512 * h);
        }
    }
    _mm512_storeu_si512(at + waiting, _mm512_set1_epi32(NTP__CLOSE8_NONE * COPIES));
    uint32_t *const counts = close[0];
    /* Else each of these counts would wait for the one before. */
    if (waiting == n && _mm512_test_epi64_mask(unlike, unlike) == 0) {
        for (int k = 0; k < COPIES; k++)
            counts[at[0] + (uint32_t) k] += (uint32_t) n / COPIES;
        waiting = 0;
    }
    for (int32_t i = 0; i < waiting; i += COPIES) {
        uint64_t two[2];
        memcpy(two, at + i, sizeof two);
        counts[(uint32_t) two[0]]++;
        counts[(two[0] >> 32) + 1]++;
        counts[(uint32_t) two[1] + 2]++;
        counts[(two[1] >> 32) + 3]++;
    }
    const uint64_t flats = flat_counts(flat);
    for (uint32_t i = 0; i < NTP__FLAT_ROWS; i++)
        close[ntp__close8_of(FLAT + i, 255)][0] += (uint32_t) (flats >> 16 * i) & 65535;
    out->others = others;
    out->colors = colors;
    out->hidden = hidden;
    const __m512i ones = _mm512_set1_epi8(-1);
    merge_greatest(out->survey.extremes[0], _mm512_xor_si512(least_rg, ones),
                   _mm512_xor_si512(least_b, ones));
    merge_greatest(out->survey.extremes[1], most_rg, most_b);
    out->survey.texels += (uint64_t) n;
    out->survey.translucent |=
        _mm512_cmplt_epu16_mask(every, _mm512_set1_epi16((short) 0xff00)) != 0;
    out->survey.sum[0] += sum_of(sum_r);
    out->survey.sum[1] += sum_of(sum_g);
    out->survey.sum[2] += sum_of(sum_b);
    end_lanes();
}
