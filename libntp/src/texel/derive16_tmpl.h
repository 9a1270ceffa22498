/* SPDX-License-Identifier: MIT */
/*
 * derive16_tmpl.h - derives the blue of packed 16-bit pixels, with AVX2; a part of kernels.c
 *
 * Pixels are read and written as in clean8_tmpl.h, which comes first, eight in a step.  Pairs that are too long are
 * pulled after all others of a block, many at once.
 */

/* Puts eight blues into these bytes, and stores them.  Each half is of four pixels, of which `low` has the bytes 0
 * to 15, and `high` 8 to 23. */
static inline void put_blues16(uint16_t *dst, __m256i low, __m256i high, __m256i b,
                               uint64_t *changed)
{
    enum { IN_LOW = 0x04, IN_HIGH = 0x92 }; /* the words of blues, each once */
    const __m256i low_now = _mm256_blend_epi16(low, _mm256_slli_si256(b, 4), IN_LOW);
    const __m256i high_now = _mm256_blend_epi16(
        high, SHUFFLE(b, -1, -1, 4, 5, -1, -1, -1, -1, 8, 9, -1, -1, -1, -1, 12, 13), IN_HIGH);
    const __m256i same =
        _mm256_and_si256(_mm256_cmpeq_epi16(low_now, low), _mm256_cmpeq_epi16(high_now, high));
    *changed += (uint64_t) __builtin_popcount(~(uint32_t) _mm256_movemask_epi8(same)) / 2;
    store_two(dst, dst + 12, low_now);
    store_two(dst + 4, dst + 16, high_now);
}

enum { STEP_16 = 8 };

/* Pulls n of a block's pixels, in place; returns how many are in doubt and stay as they are: at[0] and so on. */
ONE_COPY static int32_t pull_pixels(uint16_t *d, int32_t *at, int32_t n, int32_t zzero)
{
    int32_t c[3][256 + LANES], doubt[256 + LANES], left = 0;
    memset(c[0] + n, 0, LANES * sizeof c[0][0]);
    memset(c[1] + n, 0, LANES * sizeof c[1][0]);
    for (int32_t i = 0; i < n; i++) {
        c[0][i] = d[3 * at[i]];
        c[1][i] = d[3 * at[i] + 1];
    }
    pull(c[0], c[1], doubt, n, 65535);
    derive(c[2], c[0], c[1], n, 65535, zzero);
    for (int32_t i = 0; i < n; i++) {
        uint16_t *const to = d + 3 * at[i];
        if (doubt[i]) {
            at[left++] = at[i];
            continue;
        }
        to[0] = (uint16_t) c[0][i];
        to[1] = (uint16_t) c[1][i];
        to[2] = (uint16_t) c[2][i];
    }
    return left;
}

/* Eight pixels; false, with nothing written, when a pair is too long. */
static inline bool clean16_step(uint16_t *dst, const uint16_t *src, bool zzero, uint64_t *changed)
{
    const __m256i low = load_two(src, src + 12), high = load_two(src + 4, src + 16);
    const __m256i e = rest_of(take16((const uint8_t *) src).rg, true);
    if (_mm256_movemask_ps(_mm256_castsi256_ps(e)) != 0)
        return false;
    put_blues16(dst, low, high, blue_of(e, root_of(e, true), true, zzero), changed);
    return true;
}

/* Eight pixels, of which unused ones and those that are too long stay as they are; returns bits of the latter. */
static inline int derive16_step(uint16_t *dst, const uint16_t *src, bool zzero,
                                const unused_blues *ends, uint64_t *changed)
{
    const __m256i low = load_two(src, src + 12), high = load_two(src + 4, src + 16);
    const texels t = take16((const uint8_t *) src);
    const __m256i e = rest_of(t.rg, true);
    const __m256i b = blue_of(e, root_of(e, true), true, zzero);
    const __m256i at_end = _mm256_or_si256(_mm256_cmpeq_epi32(t.rg, _mm256_setzero_si256()),
                                           _mm256_cmpeq_epi32(t.rg, _mm256_set1_epi32(-1)));
    int longs = _mm256_movemask_ps(_mm256_castsi256_ps(e));
    put_blues16(dst, low, high, _mm256_blendv_epi8(b, t.b, _mm256_srai_epi32(e, 31)), changed);
    if (!_mm256_testz_si256(at_end, at_end))
        longs &= ~_mm256_movemask_ps(_mm256_castsi256_ps(unused_of(t, ends)));
    return longs;
}

static int32_t derive_rgb16(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                            uint32_t touch_unused, int32_t *at, uint64_t *changed)
{
    const unused_blues ends = blues_of_unused(65535, touch_unused);
    uint64_t others = 0;
    int32_t found = 0, left = 0, i = 0;
    /* Where pairs that are too long come closely, a branch for them would be taken at random. */
    while (i < n && clean16_step(dst + 3 * i, src + 3 * i, zzero != 0, &others))
        i += STEP_16;
    for (; i < n; i += STEP_16) {
        const int longs = derive16_step(dst + 3 * i, src + 3 * i, zzero != 0, &ends, &others);
        found += find_four(at + found, i, longs & 15);
        found += find_four(at + found, i + 4, longs >> 4);
    }
    if (found > 0)
        left = pull_pixels(dst, at, found, zzero);
    *changed += others + (uint64_t) (found - left);
    return left;
}
