/* SPDX-License-Identifier: MIT */
/*
 * clean8_avx512_tmpl.h - derives the blue of packed 8-bit pixels, with AVX-512; a part of kernels_avx512.c
 *
 * As clean8_tmpl.h, which says why: 32 texels a step, those of three channels first asked whether their
 * blues are the derived ones where those of the last step were.  Pairs that are too long are looked up in
 * the table after all others, sixteen at a time.
 */

enum { STEP_8 = 32 /* texels */, LOW_8 = 64 /* bytes */, AT_ONCE = 512 /* texels */ };

/* The derived blues of words as bytes. */
static ALWAYS_INLINE __m512i blues_of(__m512i e)
{
    const __m512i low = root_of(_mm512_cvtepu16_epi32(_mm512_castsi512_si256(e)), false);
    const __m512i high = root_of(_mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(e, 1)), false);
    const __m512i t = _mm512_inserti32x4(_mm512_castsi128_si512(_mm512_cvtepi32_epi8(low)),
                                         _mm512_cvtepi32_epi8(high), 1);
    return _mm512_xor_si512(t, _mm512_set1_epi8(-128));
}

/* The pixel of each byte. */
static const _Alignas(64) uint8_t THIRDS[64] = {
    0,  0,  0,  1,  1,  1,  2,  2,  2,  3,  3,  3,  4,  4,  4,  5,  5,  5,  6,  6,  6,  7,
    7,  7,  8,  8,  8,  9,  9,  9,  10, 10, 10, 11, 11, 11, 12, 12, 12, 13, 13, 13, 14, 14,
    14, 15, 15, 15, 16, 16, 16, 17, 17, 17, 18, 18, 18, 19, 19, 19, 20, 20, 20, 21,
};

/* Pixels of which some bytes are blues. */
static ALWAYS_INLINE __m512i with_blues(__m512i v, __mmask64 these, int first, __m512i blues)
{
    const __m512i from = _mm512_add_epi8(_mm512_load_si512(THIRDS), _mm512_set1_epi8((char) first));
    return _mm512_mask_permutexvar_epi8(v, these, from, blues);
}

static ALWAYS_INLINE __m512i half_of(__m512i words, int k)
{
    return _mm512_cvtepu16_epi32(k == 0 ? _mm512_castsi512_si256(words)
                                        : _mm512_extracti64x4_epi64(words, 1));
}

/* Appends those of 16 to a list; returns how many they are. */
static ALWAYS_INLINE int32_t append(uint32_t *to, __m512i c, __mmask16 these)
{
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(these, c));
    return __builtin_popcount(these);
}

/* Appends those colors of 32, with all bits above them. */
static ALWAYS_INLINE int32_t append_colors(uint32_t *to, texels t, __mmask32 which)
{
    int32_t found = 0;
    for (int k = 0; k < 2; k++) {
        const __m512i above = _mm512_or_si512(half_of(t.b, k), _mm512_set1_epi32(0xff00));
        const __m512i c = _mm512_or_si512(half_of(t.rg, k), _mm512_slli_epi32(above, 16));
        found += append(to + found, c, (__mmask16) (which >> 16 * k));
    }
    return found;
}

/* Cleans n colors, whose pairs are too long, by the table, and keeps the byte above them.  Returns how many
 * changed: all that are used. */
static uint64_t look_up(uint32_t *color, int32_t n, const uint32_t *table, uint32_t touch_unused)
{
    const __m512i rgb = _mm512_set1_epi32(0xffffff);
    const __mmask16 black = touch_unused & NTP_UNUSED_BLACK ? 0 : 0xffff;
    const __mmask16 white = touch_unused & NTP_UNUSED_WHITE ? 0 : 0xffff;
    int32_t changed = 0;
    _mm512_storeu_si512(color + n, _mm512_setzero_si512());
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __mmask16 some = n - i < LANES_512 ? (__mmask16) ((1U << (n - i)) - 1) : 0xffff;
        const __m512i v = _mm512_loadu_si512(color + i), c = _mm512_and_si512(v, rgb);
        const __m512i pair = _mm512_and_si512(c, _mm512_set1_epi32(0xffff));
        const __mmask16 stay =
            (_mm512_testn_epi32_mask(c, c) & black) | (_mm512_cmpeq_epi32_mask(c, rgb) & white);
        if (stay == 0xffff) /* a background */
            continue;
        __m512i to = _mm512_and_si512(_mm512_i32gather_epi32(pair, table, 4), rgb);
        to = _mm512_or_si512(to, _mm512_andnot_si512(rgb, v));
        to = _mm512_mask_mov_epi32(to, stay, v);
        changed += __builtin_popcount(some & ~stay);
        _mm512_storeu_si512(color + i, to);
    }
    return (uint64_t) changed;
}

/* Puts these colors into those pixels of 16, whose color has a byte above it. */
static ALWAYS_INLINE void put_colors(uint8_t *d, __m512i c)
{
    const __m512i third = _mm512_load_si512(THIRDS);
    const __m512i from = _mm512_add_epi8(third, steps_of(0x04040404, 0x03020100));
    const __m512i above = _mm512_or_si512(_mm512_slli_epi32(third, 2), _mm512_set1_epi8(3));
    const __mmask64 these = _mm512_movepi8_mask(_mm512_permutexvar_epi8(above, c));
    const __m512i v = _mm512_mask_permutexvar_epi8(load_48(d), these, from, c);
    _mm256_storeu_si256((void *) d, _mm512_castsi512_si256(v));
    _mm_storeu_si128((void *) (d + 32), _mm512_extracti32x4_epi32(v, 2));
}

/* Puts colors of a list into those of n pixels. */
static void put_long(uint8_t *d, int32_t n, const uint32_t *color, const __mmask32 *which)
{
    for (; n > 0; n -= STEP_8, d += 3 * STEP_8) {
        const __mmask32 longs = *which++;
        for (int k = 0; longs != 0 && k < STEP_8; k += LANES_512) {
            const __mmask16 these = (__mmask16) (longs >> k);
            put_colors(d + 3 * k, _mm512_maskz_expand_epi32(these, _mm512_loadu_si512(color)));
            color += __builtin_popcount(these);
        }
    }
}

/* At most AT_ONCE texels in whole steps.  Returns how many pairs are too long; these colors are in `left`. */
static ALWAYS_INLINE int32_t derive_8(uint8_t *d, const uint8_t *s, int32_t n, uint32_t *left,
                                      __mmask32 *which, uint64_t *changed)
{
    const __mmask64 low = 0x4924924924924924, high = 0x92492492;
    int32_t found = 0;
    bool same = true;
    _mm512_storeu_si512(which, _mm512_setzero_si512());
    for (int32_t i = 0; i < n; i += STEP_8, s += 3 * STEP_8, d += 3 * STEP_8) {
        const texels t = take_words(s);
        __m512i v = _mm512_loadu_si512(s);
        __m512i w = _mm512_zextsi256_si512(_mm256_loadu_si256((const void *) (s + LOW_8)));
        const __m512i e = rest_words(t.rg);
        const __mmask32 longs = _mm512_movepi16_mask(e);
        if (same) {
            const __m512i z = _mm512_xor_si512(t.b, _mm512_set1_epi16(128));
            const __m512i off = _mm512_sub_epi16(e, _mm512_mullo_epi16(z, z));
            same = (longs | _mm512_cmpgt_epu16_mask(off, _mm512_add_epi16(z, z))) == 0;
        }
        if (!same) {
            if (longs != 0) {
                /* the next block: while many colors are looked up, none of it is fetched by itself */
                for (int k = 0; found > LANES_512 && k < 3 * STEP_8; k += LOW_8) {
                    _mm_prefetch((const char *) (s + 3 * AT_ONCE + k), _MM_HINT_T0);
                    _mm_prefetch((const char *) (d + 3 * AT_ONCE + k), _MM_HINT_T0);
                }
                which[i / STEP_8] = longs;
                found += append_colors(left + found, t, longs);
            }
            if (longs != ~0U) {
                __m512i blues = blues_of(e);
                if (longs != 0)
                    blues = _mm512_mask_mov_epi8(blues, longs,
                                                 _mm512_castsi256_si512(_mm512_cvtepi16_epi8(t.b)));
                const __m512i v_now = with_blues(v, low, 0, blues);
                const __m512i w_now = with_blues(w, high, LOW_8 / 3, blues);
                const uint64_t others = _mm512_cmpneq_epi8_mask(v_now, v);
                const uint64_t more = _mm512_cmpneq_epi8_mask(w_now, w);
                *changed +=
                    (uint64_t) __builtin_popcountll(others) + (uint64_t) __builtin_popcountll(more);
                same = (others | more | longs) == 0;
                v = v_now;
                w = w_now;
            }
        }
        _mm512_storeu_si512(d, v);
        _mm256_storeu_si256((void *) (d + LOW_8), _mm512_castsi512_si256(w));
    }
    return found;
}

/* As derive_8, of pixels with alpha; those below `least` stay as they are.  Words are the pairs of 16 pixels,
 * and above each that of one of the next 16. */
static int32_t derive_rgba(uint8_t *d, const uint8_t *s, int32_t n, uint32_t *left,
                           __mmask16 *which, uint32_t least, uint64_t *changed)
{
    const __m512i unused = _mm512_set1_epi32((int32_t) least);
    int32_t found = 0, others = 0;
    for (int32_t i = 0; i < n; i += STEP_8, s += 4 * STEP_8, d += 4 * STEP_8) {
        const __m512i v[2] = { _mm512_loadu_si512(s), _mm512_loadu_si512(s + 4 * LANES_512) };
        const __m512i e =
            rest_words(_mm512_mask_mov_epi16(v[0], 0xaaaaaaaa, _mm512_slli_epi32(v[1], 16)));
        for (int k = 0; found > LANES_512 && k < 4 * STEP_8; k += LOW_8) { /* as there */
            _mm_prefetch((const char *) (s + 4 * AT_ONCE + k), _MM_HINT_T0);
            _mm_prefetch((const char *) (d + 4 * AT_ONCE + k), _MM_HINT_T0);
        }
        for (int k = 0; k < 2; k++) {
            const __m512i rest = _mm512_srai_epi32(k == 0 ? _mm512_slli_epi32(e, 16) : e, 16);
            const __m512i t = _mm512_add_epi32(root_of(rest, false), _mm512_set1_epi32(128));
            const __mmask16 used = _mm512_cmpge_epu32_mask(v[k], unused);
            const __mmask16 longs =
                _mm512_mask_cmplt_epi32_mask(used, rest, _mm512_setzero_si512());
            /* t instead of v in the bits of blue */
            const __m512i now = _mm512_mask_ternarylogic_epi32(
                v[k], used ^ longs, _mm512_slli_epi32(t, 16), _mm512_set1_epi32(0xff0000), 0xd8);
            others += __builtin_popcount(_mm512_cmpneq_epi32_mask(now, v[k]));
            _mm512_storeu_si512(d + 4 * LANES_512 * k, now);
            *which++ = longs;
            found += append(left + found, v[k], longs);
        }
    }
    *changed += (uint64_t) others;
    return found;
}

/* Puts colors of a list into those of n pixels with alpha. */
static void put_rgba(uint8_t *d, int32_t n, const uint32_t *color, const __mmask16 *which)
{
    for (int32_t i = 0; i < n; i += LANES_512, d += 4 * LANES_512) {
        const __m512i v = _mm512_loadu_si512(d), c = _mm512_loadu_si512(color);
        _mm512_storeu_si512(d, _mm512_mask_expand_epi32(v, which[i / LANES_512], c));
        color += __builtin_popcount(which[i / LANES_512]);
    }
}
