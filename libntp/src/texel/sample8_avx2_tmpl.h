/* SPDX-License-Identifier: MIT */
/*
 * sample8_avx2_tmpl.h - moments and steps of packed texels of 8 bit; a part of cells_avx2.c
 *
 * Sums are integers: of 16 texels at a time, and of up to 2^16 in lanes of 32 bits.
 */

/* Squares and products of words add up to less than 2^29 in a lane. */
static ALWAYS_INLINE __m256i plus_products(__m256i sums, __m256i a, __m256i b)
{
    return _mm256_add_epi32(sums, _mm256_madd_epi16(a, b));
}

/* Sums of groups, in lanes, and counts. */
typedef struct moments8 {
    __m256i square[3], product[3], sum[3];
    uint32_t n, high_r, high_g, flat, unit;
} moments8;

/* Adds three times eight lanes. */
ONE_COPY static void add_lanes(uint64_t to[3], const __m256i v[3])
{
    for (int32_t k = 0; k < 3; k++) {
        const __m256i low = _mm256_and_si256(v[k], _mm256_set1_epi64x(UINT32_MAX));
        const __m256i both = _mm256_add_epi64(low, _mm256_srli_epi64(v[k], 32));
        to[k] += sum_of_lanes(&both);
    }
}

ONE_COPY static void add_moments(ntp__samples *to, const moments8 *from)
{
    add_lanes(to->sum, from->sum);
    add_lanes(to->square, from->square);
    add_lanes(to->product, from->product);
    to->n += from->n;
    to->red_low += from->n - from->high_r;
    to->green_low += from->n - from->high_g;
    to->gamma_flat += from->flat;
    to->gamma_unit += from->unit;
}

/* Adds 16 texels, whose bytes are at p, too. */
ONE_COPY static void add_texels(moments8 *to, const uint32_t *linear, __m256i pairs, __m256i b,
                                const uint8_t *p, int32_t stride)
{
    enum { FLAT = NTP__GAMMA_FLAT_LEAST, RANGE = NTP__GAMMA_FLAT_RANGE };
    const __m256i r = _mm256_and_si256(pairs, _mm256_set1_epi16(255)),
                  g = _mm256_srli_epi16(pairs, 8);
    const __m256i from = _mm256_sub_epi8(pairs, _mm256_set1_epi8((char) FLAT));
    const uint32_t high = (uint32_t) _mm256_movemask_epi8(pairs);
    to->square[0] = plus_products(to->square[0], r, r);
    to->square[1] = plus_products(to->square[1], g, g);
    to->square[2] = plus_products(to->square[2], b, b);
    to->product[0] = plus_products(to->product[0], r, g);
    to->product[1] = plus_products(to->product[1], r, b);
    to->product[2] = plus_products(to->product[2], g, b);
    to->sum[0] = plus_bytes(to->sum[0], r);
    to->sum[1] = plus_bytes(to->sum[1], g);
    to->sum[2] = plus_bytes(to->sum[2], b);
    to->n += GROUP;
    to->high_r += (uint32_t) __builtin_popcount(high & 0x55555555);
    to->high_g += (uint32_t) __builtin_popcount(high & 0xaaaaaaaa);
    to->flat += words_set(_mm256_cmpeq_epi16(_mm256_subs_epu8(from, _mm256_set1_epi8(RANGE)),
                                             _mm256_setzero_si256()));
    uint32_t unit = 0; /* in a register: else each would wait for the one before to be stored */
    for (int32_t k = 0; k < GROUP; k += 2) {
        UNROLLED
        for (int32_t i = 0; i < 2; i++, p += stride)
            unit += ntp__linear_near_unit(linear[p[0]] + linear[p[1]] + linear[p[2]]);
    }
    to->unit += unit;
}

/* Adds all but some of them.  Black adds nothing to sums. */
ONE_COPY static void add_others(moments8 *to, const uint32_t *linear, __m256i pairs, __m256i b,
                                __m256i left_out)
{
    const uint32_t black = words_set(left_out);
    __m256i colors[2];
    pairs = _mm256_andnot_si256(left_out, pairs);
    b = _mm256_andnot_si256(left_out, b);
    colors[0] = _mm256_unpacklo_epi16(pairs, b);
    colors[1] = _mm256_unpackhi_epi16(pairs, b);
    add_texels(to, linear, pairs, b, (const uint8_t *) colors, 4);
    to->n -= black;
    to->unit -= ntp__linear_near_unit(3 * linear[0]) ? black : 0;
}

/* Sums of bytes, in the low half of each lane, and of those in `across`, in the other half. */
static ALWAYS_INLINE __m256i plus_steps(__m256i sums, __m256i bytes, __m256i across)
{
    const __m256i some = plus_bytes(_mm256_setzero_si256(), _mm256_and_si256(bytes, across));
    return plus_bytes(_mm256_add_epi64(sums, _mm256_slli_epi64(some, 32)), bytes);
}

static ALWAYS_INLINE __m256i between(__m256i a, __m256i b)
{
    return _mm256_sub_epi8(_mm256_max_epu8(a, b), _mm256_min_epu8(a, b));
}

/* Which of 16 texels are unused. */
static ALWAYS_INLINE __m256i are_unused(__m256i pairs, __m256i b, __m256i hidden, uint32_t touch)
{
    const __m256i all = _mm256_set1_epi8(-1), none = _mm256_setzero_si256();
    const __m256i black = _mm256_cmpeq_epi16(_mm256_or_si256(pairs, b), none);
    const __m256i white = _mm256_cmpeq_epi16(
        _mm256_and_si256(pairs, _mm256_or_si256(b, _mm256_slli_epi16(all, 8))), all);
    return _mm256_or_si256(touch & NTP_UNUSED_TRANSPARENT ? none : hidden,
                           _mm256_or_si256(touch & NTP_UNUSED_BLACK ? none : black,
                                           touch & NTP_UNUSED_WHITE ? none : white));
}

int32_t ntp__sample8_avx2(ntp__samples *to, ntp__samples *to_padding, uint64_t to_steps[3][2],
                          const uint32_t *linear, const uint8_t *src, int32_t n, int32_t channels,
                          int32_t x, uint32_t touch)
{
    enum { NEAR = 16 };
    const layout8 layout = layout8_of(channels, true);
    const __m256i low = _mm256_set1_epi16(255), none = _mm256_setzero_si256();
    const __m256i columns = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i across = _mm256_cmpeq_epi16(columns, _mm256_set1_epi16((short) (-x & 7)));
    __m256i steps[3] = { none, none, none };
    moments8 used, padded;
    int32_t i = 0;
    memset(&used, 0, sizeof used);
    memset(&padded, 0, sizeof padded);
    for (; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i pairs, blues, last, last_blues;
        load_16(&pairs, &blues, src, &layout);
        load_16(&last, &last_blues, src - channels, &layout);
        const __m256i b = _mm256_and_si256(blues, low), step = between(pairs, last);
        steps[0] = plus_steps(steps[0], _mm256_and_si256(step, low), across);
        steps[1] = plus_steps(steps[1], _mm256_srli_epi16(step, 8), across);
        steps[2] = plus_steps(steps[2], between(b, _mm256_and_si256(last_blues, low)), across);
        const __m256i ends = _mm256_add_epi8(pairs, _mm256_set1_epi8(NEAR));
        const __m256i at_end =
            _mm256_cmpeq_epi8(_mm256_min_epu8(ends, _mm256_set1_epi8(2 * NEAR - 1)), ends);
        const __m256i inside = _mm256_xor_si256(_mm256_cmpeq_epi16(at_end, _mm256_set1_epi8(-1)),
                                                _mm256_set1_epi8(-1));
        const __m256i hidden = are_hidden(blues, b, &layout);
        if (_mm256_testc_si256(_mm256_andnot_si256(hidden, inside), _mm256_set1_epi8(-1))) {
            add_texels(&used, linear, pairs, b, src, channels);
            continue;
        }
        const __m256i unused = are_unused(pairs, b, hidden, touch);
        const __m256i others = _mm256_or_si256(unused, inside);
        add_others(&used, linear, pairs, b, unused);
        if (!_mm256_testc_si256(others, _mm256_set1_epi8(-1)))
            add_others(&padded, linear, pairs, b, others);
    }
    add_moments(to, &used);
    add_moments(to_padding, &padded);
    for (int32_t k = 0; k < 3; k++) {
        const uint64_t both = sum_of_lanes(&steps[k]);
        to_steps[k][0] += (both & UINT32_MAX) - (both >> 32);
        to_steps[k][1] += both >> 32;
    }
    end_lanes();
    return i;
}
