/* SPDX-License-Identifier: MIT */
/*
 * cells_tmpl.h - counts packed texels of 8 bit in the cells of a tally; a part of kernels.c
 *
 * The numbers of the cells come from arithmetic, eight at a time.  A table of 65,536 pairs would take
 * longer than that, and is waited for.  What is left for each texel is one count.
 */

#ifdef __AVX2__

/* The numbers of the cells of eight colors, as rows_prepare defines them in color_counts.c.
 * `far_rows`: the rows of those that are far, else NTP__ROWS. */
static inline __m256i cells_of(__m256i *far_rows, __m256i colors)
{
    const __m256i low = _mm256_set1_epi32(255), one = _mm256_set1_epi32(1);
    const __m256i middle = _mm256_set1_epi32(128), last_near = _mm256_set1_epi32(NTP__NEAR - 1);
    /* k of r, g: as bytes, the lesser of r ^ 127 and r ^ 128 */
    const __m256i k = _mm256_min_epu8(_mm256_xor_si256(colors, _mm256_set1_epi32(0x7f7f)),
                                      _mm256_xor_si256(colors, _mm256_set1_epi32(0x8080)));
    const __m256i p = _mm256_and_si256(k, low), b = _mm256_srli_epi32(colors, 16);
    const __m256i q = _mm256_and_si256(_mm256_srli_epi32(k, 8), low);
    const __m256i k1 = _mm256_max_epi16(p, q), k2 = _mm256_min_epi16(p, q);
    const __m256i sq1 = _mm256_mullo_epi16(k1, _mm256_add_epi32(k1, one));
    const __m256i sq2 = _mm256_mullo_epi16(k2, _mm256_add_epi32(k2, one));
    /* flat: the high bits of r, g, as bits 0 and 1 */
    const __m256i high = _mm256_and_si256(colors, _mm256_set1_epi32(0x8080));
    const __m256i bits = _mm256_or_si256(_mm256_srli_epi32(high, 7), _mm256_srli_epi32(high, 14));
    const __m256i flat = _mm256_add_epi32(_mm256_and_si256(bits, _mm256_set1_epi32(3)),
                                          _mm256_set1_epi32(NTP__ROWS - NTP__FLAT_ROWS));
    const __m256i row = _mm256_blendv_epi8(_mm256_add_epi32(_mm256_srli_epi32(sq1, 1), k2), flat,
                                           _mm256_cmpeq_epi32(k1, _mm256_setzero_si256()));
    const __m256i e = _mm256_sub_epi32(_mm256_set1_epi32(16255), _mm256_add_epi32(sq1, sq2));
    __m256i t = root8(e);
    t = _mm256_add_epi32(t, _mm256_cmpgt_epi32(_mm256_mullo_epi16(t, t), e));
    t = _mm256_andnot_si256(_mm256_srai_epi32(e, 31), t); /* too long: as if blue were 128 */
    __m256i first = _mm256_min_epi32(_mm256_add_epi32(t, _mm256_set1_epi32(128 - NTP__NEAR / 2)),
                                     _mm256_set1_epi32(256 - NTP__NEAR));
    /* above the gray, where that would be among them */
    const __m256i gray = _mm256_add_epi32(k1, middle), up = _mm256_sub_epi32(gray, first);
    const __m256i among = _mm256_and_si256(_mm256_cmpeq_epi32(k1, k2),
                                           _mm256_cmpeq_epi32(_mm256_min_epu32(up, last_near), up));
    first = _mm256_blendv_epi8(first, _mm256_add_epi32(gray, one), among);
    const __m256i place = _mm256_sub_epi32(b, first);
    const __m256i near = _mm256_cmpeq_epi32(_mm256_min_epu32(place, last_near), place);
    const __m256i far = _mm256_add_epi32(_mm256_add_epi32(b, _mm256_slli_epi32(row, 8)),
                                         _mm256_set1_epi32(NTP__FIRST_FAR));
    *far_rows = _mm256_blendv_epi8(row, _mm256_set1_epi32(NTP__ROWS), near);
    return _mm256_add_epi32(_mm256_slli_epi32(row, 4), _mm256_blendv_epi8(far, place, near));
}

/* Four texels from each of two places: their colors, with the alpha or 0 above. */
static inline __m256i load_colors(const uint8_t *first, const uint8_t *second, __m256i shuffle)
{
    const __m128i a = _mm_loadu_si128((const __m128i *) (const void *) first);
    const __m128i b = _mm_loadu_si128((const __m128i *) (const void *) second);
    const __m256i both = _mm256_inserti128_si256(_mm256_castsi128_si256(a), b, 1);
    return _mm256_shuffle_epi8(both, shuffle);
}

/* Sixteen texels of packed RGB; the last load begins four bytes early, to end with them. */
static inline void load_rgb(__m256i colors[2], const uint8_t *src)
{
#  define FOUR(at)                                                                                 \
      (at), (at) + 1, (at) + 2, -1, (at) + 3, (at) + 4, (at) + 5, -1, (at) + 6, (at) + 7,          \
          (at) + 8, -1, (at) + 9, (at) + 10, (at) + 11, -1
    colors[0] = load_colors(src, src + 12, _mm256_setr_epi8(FOUR(0), FOUR(0)));
    colors[1] = load_colors(src + 24, src + 32, _mm256_setr_epi8(FOUR(0), FOUR(4)));
#  undef FOUR
}

/* A bit for each of sixteen lanes with all bits set. */
static inline uint32_t lanes_set(const __m256i lanes[2])
{
    return negatives(lanes[0], lanes[1]);
}

/* Sixteen colors; false: one is gray, or not opaque. */
static inline bool load_group(__m256i colors[2], const uint8_t *src, int32_t channels)
{
    __m256i gray[2], least = _mm256_set1_epi32(-1);
    if (channels == 3) {
        load_rgb(colors, src);
    } else {
        for (int k = 0; k < 2; k++) {
            colors[k] = _mm256_loadu_si256((const __m256i *) (const void *) (src + 32 * k));
            least = _mm256_and_si256(least, colors[k]);
            colors[k] = _mm256_and_si256(colors[k], _mm256_set1_epi32(RGB));
        }
        /* all bits of alpha, in all texels? */
        const __m256i most = _mm256_or_si256(least, _mm256_set1_epi32(RGB));
        least = _mm256_cmpeq_epi32(most, _mm256_set1_epi32(-1));
    }
    for (int k = 0; k < 2; k++)
        gray[k] = _mm256_cmpeq_epi32(_mm256_and_si256(colors[k], _mm256_set1_epi32(0xffff)),
                                     _mm256_srli_epi32(colors[k], 8));
    return lanes_set(gray) == 0 && _mm256_movemask_epi8(least) == -1;
}

/* Apart from the arithmetic, so that many counts are on their way at once. */
ONE_COPY static void count_each(uint32_t *cells, const uint32_t *at, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        cells[at[i]]++;
}

static int32_t count_cells(uint32_t *cells, uint8_t *row_seen, const uint8_t *src, int32_t n,
                           int32_t channels)
{
    enum { GROUP = 16, ALL = 0xffff, WAITING = 512 };
    uint32_t at[WAITING], far[GROUP];
    int32_t i = 0, waiting = 0;
    for (; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i colors[2], same[2], rows[2], near[2];
        if (!load_group(colors, src, channels))
            break;
        const __m256i first = _mm256_broadcastd_epi32(_mm256_castsi256_si128(colors[0]));
        for (int k = 0; k < 2; k++) {
            same[k] = _mm256_cmpeq_epi32(colors[k], first);
            const __m256i cell = cells_of(&rows[k], colors[k]);
            near[k] = _mm256_cmpeq_epi32(rows[k], _mm256_set1_epi32(NTP__ROWS));
            _mm256_storeu_si256((__m256i *) (void *) (at + waiting + 8 * k), cell);
            _mm256_storeu_si256((__m256i *) (void *) (far + 8 * k), rows[k]);
        }
        if (lanes_set(near) != ALL) {
            for (int k = 0; k < GROUP; k++)
                row_seen[far[k]] = NTP__SEEN_NEAR | NTP__SEEN_FAR;
        }
        if (lanes_set(same) == ALL) {
            cells[at[waiting]] += GROUP;
            continue;
        }
        waiting += GROUP;
        if (waiting == WAITING) {
            count_each(cells, at, waiting);
            waiting = 0;
        }
    }
    count_each(cells, at, waiting);
    return i;
}
#else
#  define count_cells NULL
#endif
