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

/* Pairs of a block that are too long, in whole steps; what |X| and |Y| become, halved, in units of 2^-16; and
 * blues, negative where the pair is in doubt. */
typedef struct many_long {
    int32_t rg[256 + STEP_16], unit[2][256 + STEP_16], blue[256 + STEP_16];
} many_long;

static inline __m128i four_of(__m256i v, int k)
{
    return k == 0 ? _mm256_castsi256_si128(v) : _mm256_extracti128_si256(v, 1);
}

/* Sizes (|X| - 1)/2, and words of ones where X is negative. */
static inline __m256i load_sizes(const int32_t *rg, __m256i *sign)
{
    const __m256i p = _mm256_xor_si256(load_plane(rg), _mm256_set1_epi16(-32768));
    *sign = _mm256_srai_epi16(p, 15);
    return _mm256_xor_si256(p, *sign);
}

/* What eight |X| and |Y| become.  The squares of X and Y have the sum 4w + 2.  As in normalize16_tmpl.h a float of
 * 1/sqrt(w + 1/2) is off by at most 3u, and a unit by less than 2^-9 after the step of Newton. */
static inline void shorten_eight(many_long *to, int32_t i)
{
    const double half = 65535 * 65536.0 / 8; /* M/4 in units, and half of the step */
    const __m256i one = _mm256_set1_epi32(1);
    __m256i sign;
    const __m256i q = load_sizes(to->rg + i, &sign), w = sum_of_pair(q);
    const __m256i twice = _mm256_add_epi16(q, q);
    const __m256i size[2] = { _mm256_or_si256(_mm256_and_si256(twice, _mm256_set1_epi32(0xffff)),
                                              one),
                              _mm256_or_si256(_mm256_srli_epi32(twice, 16), one) };
    const __m256 root = _mm256_sqrt_ps(_mm256_add_ps(_mm256_cvtepi32_ps(w), _mm256_set1_ps(0.5F)));
    const __m256 over = _mm256_div_ps(_mm256_set1_ps(1), root);
    UNROLLED
    for (int k = 0; k < 2; k++) {
        const __m256d r =
            _mm256_cvtps_pd(k == 0 ? _mm256_castps256_ps128(over) : _mm256_extractf128_ps(over, 1));
        const __m256d square =
            _mm256_add_pd(_mm256_cvtepi32_pd(four_of(w, k)), _mm256_set1_pd(0.5));
        const __m256d rest =
            _mm256_sub_pd(_mm256_set1_pd(3), _mm256_mul_pd(square, _mm256_mul_pd(r, r)));
        const __m256d factor = _mm256_mul_pd(_mm256_mul_pd(r, _mm256_set1_pd(half)), rest);
        UNROLLED
        for (int c = 0; c < 2; c++) {
            const __m256d v = _mm256_mul_pd(_mm256_cvtepi32_pd(four_of(size[c], k)), factor);
            _mm_storeu_si128((__m128i *) (void *) (to->unit[c] + i + 4 * k), _mm256_cvtpd_epi32(v));
        }
    }
}

/* Pulls them as pull() in judge_tmpl.h, and derives their blues.  Whole units are the nearest, so a pair is in doubt
 * where they are a whole size; but all become less than they were. */
static inline void pull_eight(many_long *to, int32_t i, bool zzero)
{
    const __m256i half = _mm256_set1_epi32(32768), last = _mm256_set1_epi32(65535);
    __m256i sign;
    const __m256i q = load_sizes(to->rg + i, &sign), zero = _mm256_setzero_si256();
    const __m256i u = _mm256_min_epu32(_mm256_add_epi32(load_plane(to->unit[0] + i), half),
                                       _mm256_or_si256(_mm256_slli_epi32(q, 16), last));
    const __m256i v = _mm256_min_epu32(_mm256_add_epi32(load_plane(to->unit[1] + i), half),
                                       _mm256_or_si256(q, last));
    const __m256i size = onto_disc(_mm256_blend_epi16(_mm256_srli_epi32(u, 16), v, 0xaa), q, true);
    const __m256i rg = _mm256_xor_si256(size, _mm256_xor_si256(sign, _mm256_set1_epi16(-32768)));
    const __m256i doubt = _mm256_or_si256(_mm256_cmpeq_epi32(_mm256_and_si256(u, last), zero),
                                          _mm256_cmpeq_epi32(_mm256_and_si256(v, last), zero));
    const __m256i e = rest_of(rg, true), b = blue_of(e, root_of(e, true), true, zzero);
    store_plane(to->rg + i, rg);
    store_plane(to->blue + i, _mm256_or_si256(b, doubt));
}

/* Pulls n of a block's pixels, in place; returns how many are in doubt and stay as they are: at[0] and so on. */
ONE_COPY static int32_t pull_pixels(uint16_t *d, const uint16_t *src, int32_t *at, int32_t n,
                                    int32_t zzero)
{
    enum { NEXT = 3 * 256 /* samples */ };
    many_long v;
    int32_t left = 0;
    for (int32_t i = 0; i < n; i++)
        memcpy(&v.rg[i], d + 3 * at[i], sizeof v.rg[i]);
    store_plane(v.rg + n, _mm256_setzero_si256());
    for (int32_t i = 0; i < n; i += STEP_16) {
        /* the next block: while this one is pulled, none of it is fetched by itself */
        prefetch((const uint8_t *) (d + NEXT + 3 * i), (const uint8_t *) (src + NEXT + 3 * i));
        shorten_eight(&v, i);
    }
    for (int32_t i = 0; i < n; i += STEP_16)
        pull_eight(&v, i, zzero != 0);
    for (int32_t i = 0; i < n; i++) {
        uint16_t *const to = d + 3 * at[i];
        if (v.blue[i] < 0) {
            at[left++] = at[i];
            continue;
        }
        memcpy(to, &v.rg[i], sizeof v.rg[i]);
        to[2] = (uint16_t) v.blue[i];
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
        left = pull_pixels(dst, src, at, found, zzero);
    *changed += others + (uint64_t) (found - left);
    return left;
}
