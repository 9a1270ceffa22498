/* SPDX-License-Identifier: MIT */
/*
 * clean8_tmpl.h - the loops that derive the blue of packed 8-bit pixels; a part of kernels.c
 *
 * Where only blue changes, a group of pixels is read as a few words, and its blues are put into
 * them.  The blues come from a table of 64 KiB; the part that a texture uses mostly fits into the
 * first cache.  With AVX2 they come from arithmetic, and so as fast for every texture; but most blues of
 * many textures are right already, which takes no root to see.
 */
#ifdef __AVX2__
#  include "texel/blue_avx2_tmpl.h"
#endif

static inline void prefetch(const uint8_t *dst, const uint8_t *src)
{
#ifdef __GNUC__
    __builtin_prefetch(src, 0);
    __builtin_prefetch(dst, 1);
#else
    (void) dst;
    (void) src;
#endif
}

#ifdef __AVX2__

/* The derived blues of 16 pairs, as words, from what rest_words makes of them; of pairs that are too
 * long it is any number. */
static inline __m256i blue_words(__m256i e)
{
    return _mm256_add_epi16(root_words(e), _mm256_set1_epi16(128));
}

/* One bit for each of 16 numbers: is it negative? */
static inline uint32_t negatives(__m256i e0, __m256i e1)
{
    return (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(e0)) |
           (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(e1)) << 8;
}

/* The places of 16 pixels from i on that have a bit; returns how many. */
ONE_COPY static int32_t find_some(int32_t *at, int32_t i, uint32_t bits)
{
    int32_t found = 0;
    UNROLLED
    for (int k = 0; k < 16; k += 4)
        found += find_four(at + found, i + k, bits >> k & 15);
    return found;
}

/* The same; mostly none has. */
static inline int32_t find_sixteen(int32_t *at, int32_t i, uint32_t bits)
{
    return bits == 0 ? 0 : find_some(at, i, bits);
}

/* e of pairs whose red and green are 0 or 255, as those of black and of white. */
enum { CORNER = REST_8 - 2 * 127 * 128 };

static inline bool any_corner(__m256i e)
{
    const __m256i corners = _mm256_cmpeq_epi16(e, _mm256_set1_epi16(CORNER));
    return !_mm256_testz_si256(corners, corners);
}

/* Which of eight pixels with alpha are black or white, and unused for that? */
static inline __m256i unused_colors(__m256i v, uint32_t touch_unused)
{
    const __m256i color = _mm256_set1_epi32(0xffffff), c = _mm256_and_si256(v, color);
    const __m256i black = _mm256_set1_epi32(touch_unused & NTP_UNUSED_BLACK ? 0 : -1);
    const __m256i white = _mm256_set1_epi32(touch_unused & NTP_UNUSED_WHITE ? 0 : -1);
    return _mm256_or_si256(_mm256_and_si256(_mm256_cmpeq_epi32(c, _mm256_setzero_si256()), black),
                           _mm256_and_si256(_mm256_cmpeq_epi32(c, color), white));
}

/* Puts the blues into 16 pixels with alpha.  Those whose pair is too long stay as they are, and those whose alpha
 * is 0 if `opaque` has all bits set.  Returns a bit for each of the former that is used. */
static inline uint32_t put_blues_rgba(uint8_t *dst, const uint8_t *src, uint32_t opaque,
                                      uint32_t touch_unused, uint64_t *changed)
{
    const __m256i zero = _mm256_setzero_si256(), all = _mm256_set1_epi32((int32_t) opaque);
    const __m256i shuffle = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, -1, -1, -1, -1, -1, -1, -1, -1));
    __m256i v[2], pairs[2], unused[2], left[2], same[2];
    UNROLLED
    for (int i = 0; i < 2; i++) {
        v[i] = _mm256_loadu_si256((const __m256i *) (const void *) (src + 32 * i));
        pairs[i] = _mm256_shuffle_epi8(v[i], shuffle);
        unused[i] = _mm256_and_si256(_mm256_cmpeq_epi32(_mm256_srli_epi32(v[i], 24), zero), all);
    }
    const __m256i e = rest_words(_mm256_unpacklo_epi64(pairs[0], pairs[1])), t = blue_words(e);
    left[0] = _mm256_or_si256(unused[0], _mm256_unpacklo_epi16(e, e)); /* their high bits */
    left[1] = _mm256_or_si256(unused[1], _mm256_unpackhi_epi16(e, e));
    uint32_t bits = negatives(left[0], left[1]);
    UNROLLED
    for (int i = 0; i < 2; i++) {
        const __m256i blues =
            i == 0 ? _mm256_unpacklo_epi16(zero, t) : _mm256_unpackhi_epi16(zero, t);
        const __m256i rest = _mm256_andnot_si256(_mm256_set1_epi32(0xff0000), v[i]);
        const __m256i blue = _mm256_and_si256(blues, _mm256_set1_epi32(0xff0000));
        __m256i now = _mm256_or_si256(rest, blue);
        if (bits != 0) {
            now = _mm256_castps_si256(_mm256_blendv_ps(
                _mm256_castsi256_ps(now), _mm256_castsi256_ps(v[i]), _mm256_castsi256_ps(left[i])));
            unused[i] = _mm256_or_si256(unused[i], unused_colors(v[i], touch_unused));
        }
        same[i] = _mm256_cmpeq_epi32(now, v[i]);
        _mm256_storeu_si256((__m256i *) (void *) (dst + 32 * i), now);
    }
    *changed += (uint64_t) __builtin_popcount(negatives(same[0], same[1]) ^ 0xffff);
    return bits == 0 ? 0 : bits & ~negatives(unused[0], unused[1]);
}

enum {
    DERIVED = 2 * NTP__KERNEL_STEP /* pixels a step */,
    MOST = 512,
    MANY = MOST / 16,
    LINE = 64 /* bytes */
};

/* v with the bytes of blues that the shuffle takes; N: one that stays. */
#  define WITH_BLUES(v, blues, ...)                                                                \
      _mm256_blendv_epi8(SHUFFLE(blues, __VA_ARGS__), (v),                                         \
                         _mm256_setr_epi8(__VA_ARGS__, __VA_ARGS__))

/* The blues of 32 pixels, each half of 16. */
static inline __m256i blues_in(const __m256i v[3])
{
    return _mm256_or_si256(
        _mm256_or_si256(SHUFFLE(v[0], 2, 5, 8, 11, 14, N, N, N, N, N, N, N, N, N, N, N),
                        SHUFFLE(v[1], N, N, N, N, N, 1, 4, 7, 10, 13, N, N, N, N, N, N)),
        SHUFFLE(v[2], N, N, N, N, N, N, N, N, N, N, 0, 3, 6, 9, 12, 15));
}

/* All of 32 pixels have the derived blue if 0 <= e - t^2 <= 2t of the t that is in it.  -2^14 < e < 2^14 - 2^7,
 * so modulo 2^16 this is more than 2t where e is negative, and where t is 128, as it is of all blues below
 * 128. */
static inline bool are_derived(const __m256i v[3], __m256i e, __m256i f)
{
    const __m256i high = _mm256_set1_epi8(-128);
    const __m256i both = _mm256_min_epu8(_mm256_xor_si256(blues_in(v), high), high);
    const __m256i t = _mm256_unpacklo_epi8(both, _mm256_setzero_si256());
    const __m256i u = _mm256_unpackhi_epi8(both, _mm256_setzero_si256());
    const __m256i d = _mm256_sub_epi16(e, _mm256_mullo_epi16(t, t));
    const __m256i g = _mm256_sub_epi16(f, _mm256_mullo_epi16(u, u));
    const __m256i off = _mm256_or_si256(_mm256_subs_epu16(d, _mm256_add_epi16(t, t)),
                                        _mm256_subs_epu16(g, _mm256_add_epi16(u, u)));
    return _mm256_testz_si256(off, off);
}

static inline void store_three(uint8_t *dst, const __m256i v[3])
{
    UNROLLED
    for (int i = 0; i < 3; i++)
        store_two(dst + 16 * i, dst + 48 + 16 * i, v[i]);
}

/* 32 pixels, and pairs of the first and of the last eight of each half, as words.  Each half of a vector is of 16
 * pixels. */
static inline void load_pairs(__m256i v[3], __m256i *pairs, __m256i *others, const uint8_t *src)
{
    UNROLLED
    for (int i = 0; i < 3; i++)
        v[i] = load_apart(src + 16 * i, 48);
    *pairs = _mm256_or_si256(SHUFFLE(v[0], 0, 1, 3, 4, 6, 7, 9, 10, 12, 13, 15, N, N, N, N, N),
                             SHUFFLE(v[1], N, N, N, N, N, N, N, N, N, N, N, 0, 2, 3, 5, 6));
    *others = _mm256_or_si256(SHUFFLE(v[1], 8, 9, 11, 12, 14, 15, N, N, N, N, N, N, N, N, N, N),
                              SHUFFLE(v[2], N, N, N, N, N, N, 1, 2, 4, 5, 7, 8, 10, 11, 13, 14));
}

/* The derived blues; of pairs that are too long, any number. */
static inline __m256i blues_of(__m256i e, __m256i f)
{
    return _mm256_xor_si256(_mm256_packus_epi16(root_words(e), root_words(f)),
                            _mm256_set1_epi8(-128));
}

/* Stores 32 pixels with these blues; returns for each how many were others, as bytes of a sum. */
static inline __m256i store_blues(uint8_t *dst, const __m256i v[3], __m256i blues)
{
    const __m256i now[3] = {
        WITH_BLUES(v[0], blues, N, N, 0, N, N, 1, N, N, 2, N, N, 3, N, N, 4, N),
        WITH_BLUES(v[1], blues, N, 5, N, N, 6, N, N, 7, N, N, 8, N, N, 9, N, N),
        WITH_BLUES(v[2], blues, 10, N, N, 11, N, N, 12, N, N, 13, N, N, 14, N, N, 15)
    };
    store_three(dst, now);
    __m256i other = _mm256_set1_epi8(3);
    UNROLLED
    for (int i = 0; i < 3; i++)
        other = _mm256_add_epi8(other, _mm256_cmpeq_epi8(now[i], v[i]));
    return other;
}

/* Puts the derived blues into 32 pixels; false, with nothing written, if a pair is too long.  `others`
 * adds up how many were others.  `same`: none was, so this is asked of the next ones before a root is
 * taken. */
static inline bool put_derived_blues(uint8_t *dst, const uint8_t *src, __m256i *others, bool *same)
{
    __m256i v[3], p, q;
    load_pairs(v, &p, &q, src);
    const __m256i e = rest_words(p), f = rest_words(q);
    if (*same && are_derived(v, e, f)) { /* whole vectors are half as many stores */
        UNROLLED
        for (int i = 0; i < 3; i++)
            _mm256_storeu_si256(
                (__m256i *) (void *) (dst + 32 * i),
                _mm256_loadu_si256((const __m256i *) (const void *) (src + 32 * i)));
        return true;
    }
    if (!_mm256_testz_si256(_mm256_or_si256(e, f), _mm256_set1_epi16(-32768)))
        return false;
    const __m256i other = store_blues(dst, v, blues_of(e, f));
    *same = _mm256_testz_si256(other, other);
    *others = _mm256_add_epi64(*others, _mm256_sad_epu8(other, _mm256_setzero_si256()));
    return true;
}

static inline uint64_t sum_of_four(__m256i v)
{
    uint64_t each[4];
    _mm256_storeu_si256((__m256i *) (void *) each, v);
    return each[0] + each[1] + each[2] + each[3];
}

static int32_t derive_rgb8(uint8_t *dst, const uint8_t *src, int32_t n, uint64_t *changed)
{
    __m256i others = _mm256_setzero_si256();
    bool same = true;
    int32_t i = 0;
    while (i + DERIVED <= n && put_derived_blues(dst + 3 * i, src + 3 * i, &others, &same))
        i += DERIVED;
    if (changed != NULL)
        *changed += sum_of_four(others);
    return i;
}

/* Which of 32 pixels have this in all bytes? */
static inline __m256i are_all(__m256i pairs, __m256i others, __m256i blues, int byte)
{
    const __m256i all = _mm256_set1_epi8((char) byte);
    return _mm256_and_si256(
        _mm256_packs_epi16(_mm256_cmpeq_epi16(pairs, all), _mm256_cmpeq_epi16(others, all)),
        _mm256_cmpeq_epi8(blues, all));
}

/* Puts derived blues into whole steps, in which pairs that are too long are not seldom: these pixels are done
 * by the table after all others. */
static inline void derive_others(uint8_t *dst, const uint8_t *src, int32_t n, const uint32_t *table,
                                 uint32_t touch_unused, uint64_t *changed)
{
    const __m256i black = _mm256_set1_epi8(touch_unused & NTP_UNUSED_BLACK ? 0 : -1);
    const __m256i white = _mm256_set1_epi8(touch_unused & NTP_UNUSED_WHITE ? 0 : -1);
    int32_t at[MOST + LANES], found = 0;
    __m256i others = _mm256_setzero_si256();
    for (int32_t i = 0; i < n; i += DERIVED) {
        __m256i v[3], p, q;
        load_pairs(v, &p, &q, src + 3 * i);
        const __m256i e = rest_words(p), f = rest_words(q), was = blues_in(v);
        const __m256i longs =
            _mm256_packs_epi16(_mm256_srai_epi16(e, 15), _mm256_srai_epi16(f, 15));
        const __m256i blues = _mm256_blendv_epi8(blues_of(e, f), was, longs);
        uint32_t bits = (uint32_t) _mm256_movemask_epi8(longs);
        if (any_corner(e) || any_corner(f))
            bits &= ~(uint32_t) _mm256_movemask_epi8(
                _mm256_or_si256(_mm256_and_si256(are_all(p, q, was, 0), black),
                                _mm256_and_si256(are_all(p, q, was, -1), white)));
        const __m256i other = store_blues(dst + 3 * i, v, blues);
        others = _mm256_add_epi64(others, _mm256_sad_epu8(other, _mm256_setzero_si256()));
        found += find_sixteen(at + found, i, bits & 0xffff);
        found += find_sixteen(at + found, i + 16, bits >> 16);
    }
    /* the next ones: while many are looked up, a processor does not fetch them by itself */
    for (int32_t k = 3 * n; found > MANY && k < 6 * n; k += LINE)
        prefetch(dst + k, src + k);
    for (int32_t k = 0; k < found; k++) { /* each changes, as its pair does */
        uint8_t *const p = dst + 3 * at[k];
        const uint32_t t = table[load16le(p)];
        memcpy(p, &t, 2);
        p[2] = (uint8_t) (t >> 16);
    }
    if (changed != NULL)
        *changed += sum_of_four(others) + (uint64_t) found;
}
#else
#  define derive_rgb8 NULL

/* Where the blues of eight packed pixels are in their three words. */
#  define BLUES_1     UINT64_C(0x0000ff0000ff0000)
#  define BLUES_2     UINT64_C(0x00ff0000ff0000ff)
#  define BLUES_3     UINT64_C(0xff0000ff0000ff00)
#  define HIGH_BITS   UINT64_C(0x8080808080808080)

/* Bytes that are not 0. */
static inline uint64_t count_bytes(uint64_t v)
{
    uint64_t high = ((v & ~HIGH_BITS) + ~HIGH_BITS) | v; /* the high bit of each such byte */
    return ((high & HIGH_BITS) >> 7) * UINT64_C(0x0101010101010101) >> 56;
}

enum { AHEAD = 768 }; /* bytes: twelve cache lines of 64 */

/* Puts in the blues of eight pixels from the table; false, with nothing written, if one is 0. */
static inline bool put_blues(uint8_t *dst, const uint8_t *src, const uint8_t *blue,
                             uint64_t *changed)
{
    uint64_t b[8];
    for (int i = 0; i < 8; i++)
        b[i] = blue[load16le(src + 3 * i)];
    uint64_t first = b[0] << 16 | b[1] << 40;
    uint64_t second = b[2] | b[3] << 24 | b[4] << 48;
    uint64_t third = b[5] << 8 | b[6] << 32 | b[7] << 56;
    uint64_t all = first | second | third;
    if ((all & HIGH_BITS) != HIGH_BITS) /* the blues of standard Z are 128 and more */
        return false;
    uint64_t s1 = load64le(src), s2 = load64le(src + 8), s3 = load64le(src + 16);
    if (changed != NULL)
        *changed += count_bytes(all ^ ((s1 & BLUES_1) | (s2 & BLUES_2) | (s3 & BLUES_3)));
    store64le(dst, (s1 & ~BLUES_1) | first);
    store64le(dst + 8, (s2 & ~BLUES_2) | second);
    store64le(dst + 16, (s3 & ~BLUES_3) | third);
    return true;
}

#endif

/* Cleans by the full table the groups that the faster loops give back. */
static inline void clean_by_pairs(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                  uint32_t touch_unused, uint64_t *changed);

/* All of a row but the last few pixels; returns how many were done. */
static inline size_t clean_blues(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                 const uint8_t *blue, uint32_t touch_unused, uint64_t *changed)
{
    size_t i = 0;
#ifdef __AVX2__
    (void) blue;
    /* Where pairs that are too long come closely, more is done at a time without a look for others. */
    for (size_t most = DERIVED; n - i >= DERIVED;) {
        const int32_t done = derive_rgb8(dst + 3 * i, src + 3 * i, (int32_t) (n - i), changed);
        i += (size_t) done;
        most = done > 0 ? DERIVED : most < MOST ? 2 * most : most;
        const size_t next = n - i < most ? (n - i) / DERIVED * DERIVED : most;
        derive_others(dst + 3 * i, src + 3 * i, (int32_t) next, table, touch_unused, changed);
        i += next;
    }
#else
    for (; i + 8 <= n; i += 8) {
        /* The table can fill the first cache, so rows are fetched ahead of time. */
        prefetch(dst + 3 * i + AHEAD, src + 3 * i + AHEAD);
        if (!put_blues(dst + 3 * i, src + 3 * i, blue, changed))
            clean_by_pairs(dst + 3 * i, src + 3 * i, 8, table, touch_unused, changed);
    }
#endif
    return i;
}
