/* SPDX-License-Identifier: MIT */
/*
 * cells_tmpl.h - counts packed texels of 8 bit in the cells of a tally; a part of kernels.c
 *
 * The numbers of the cells come from arithmetic, eight at a time.  A table of 65,536 pairs would take
 * longer than that, and is waited for.  What is left for each texel is one count.
 */

#ifdef __AVX2__

/* Four texels from each of two places: their colors, with the alpha or 0 above. */
static inline __m256i load_colors(const uint8_t *first, const uint8_t *second, __m256i shuffle)
{
    const __m128i a = _mm_loadu_si128((const __m128i *) (const void *) first);
    const __m128i b = _mm_loadu_si128((const __m128i *) (const void *) second);
    const __m256i both = _mm256_inserti128_si256(_mm256_castsi128_si256(a), b, 1);
    return _mm256_shuffle_epi8(both, shuffle);
}

enum { GROUP = 16 /* texels that are looked at together */ };

/* Where 16 texels are, and which of their bytes go where: see load_16. */
typedef struct layout8 {
    __m256i first, second;
    __m256i before; /* of blue, with alpha above: 127, opaque */
    int32_t channels;
} layout8;

static inline layout8 layout8_of(int32_t channels)
{
    layout8 l;
    l.channels = channels;
    if (channels == 3) {
#  define PAIRS_BLUES(at)                                                                          \
      (at), (at) + 1, (at) + 3, (at) + 4, (at) + 6, (at) + 7, (at) + 9, (at) + 10, (at) + 2, -1,   \
          (at) + 5, -1, (at) + 8, -1, (at) + 11, -1
        l.first = _mm256_setr_epi8(PAIRS_BLUES(0), PAIRS_BLUES(0));
        l.second = _mm256_setr_epi8(PAIRS_BLUES(0), PAIRS_BLUES(4));
#  undef PAIRS_BLUES
        l.before = _mm256_set1_epi16(127);
    } else {
        l.first = l.second = _mm256_broadcastsi128_si256(
            _mm_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15));
        l.before = _mm256_set1_epi16((short) 0xff7f);
    }
    return l;
}

/* The reds and greens of 16 texels, and their blues with the alpha or 0 above.  The last load of packed RGB
 * begins four bytes early, to end with them. */
static inline void load_16(__m256i *pairs, __m256i *blues, const uint8_t *src, const layout8 *l)
{
    const int32_t four = 4 * l->channels;
    const __m256i a = load_colors(src, src + 2 * four, l->first);
    const __m256i b = load_colors(src + four, src + 4 * four - 16, l->second);
    *pairs = _mm256_unpacklo_epi64(a, b);
    *blues = _mm256_unpackhi_epi64(a, b);
}

/* Their k: as bytes, the lesser of v ^ 127 and v ^ 128. */
static inline __m256i k_of(__m256i bytes)
{
    return _mm256_min_epu8(_mm256_xor_si256(bytes, _mm256_set1_epi8(127)),
                           _mm256_xor_si256(bytes, _mm256_set1_epi8(-128)));
}

/* The rows of 16 pairs of bytes; k are the k of red and green. */
static inline __m256i row_words(__m256i pairs, __m256i k)
{
    enum { FLAT = NTP__ROWS - NTP__FLAT_ROWS - (127 + 2 * 127) };
    const __m256i p = _mm256_and_si256(k, _mm256_set1_epi16(255)), q = _mm256_srli_epi16(k, 8);
    const __m256i k1 = _mm256_max_epi16(p, q), k2 = _mm256_min_epi16(p, q);
    const __m256i square = _mm256_mullo_epi16(k1, _mm256_sub_epi16(k1, _mm256_set1_epi16(-1)));
    /* flat: red + 2 green, each 127 or 128 */
    const __m256i flat = _mm256_add_epi16(_mm256_maddubs_epi16(pairs, _mm256_set1_epi16(0x201)),
                                          _mm256_set1_epi16(FLAT));
    return _mm256_blendv_epi8(_mm256_add_epi16(_mm256_srli_epi16(square, 1), k2), flat,
                              _mm256_cmpeq_epi16(k, _mm256_setzero_si256()));
}

/* The low byte of each word, in both of its bytes. */
static inline __m256i twice_of(__m256i words)
{
    const __m128i low = _mm_setr_epi8(0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14, 14);
    return _mm256_shuffle_epi8(words, _mm256_broadcastsi128_si256(low));
}

/*
 * The rows of 16 texels, and their places among counts of close ones: NTP__CLOSE8_NONE where they are not
 * close, not opaque, or gray.  Returns which of them are that: the caller counts them.  With u = b - 127,
 * close ones have 128 <= b, (u - 4)^2 <= e < (u + 4)^2, or 0 <= u (u + 8) - e + 15 < 16 u.  From u = 4 on
 * that is root - 3 <= u <= root + 4, where 128 + root is the derived blue; below, it is part of that.  u is 0
 * where blue is less than 128 or alpha is not 255, so that it does not hold.  The sum is from -2^14 to
 * 34,000: as unsigned numbers, negative ones are above 2^15 too.
 */
static inline __m256i are_other(__m256i *rows, __m256i *places, const uint8_t *src,
                                const layout8 *l)
{
    enum { MOVED = NTP__ROWS - NTP__FLAT_ROWS - NTP__CLOSE8_ROWS };
    __m256i pairs, blues;
    load_16(&pairs, &blues, src, l);
    const __m256i k = k_of(pairs);
    const __m256i xy = _mm256_maddubs_epi16(_mm256_sub_epi8(k, _mm256_set1_epi8(-1)), k);
    const __m256i u = _mm256_subs_epu16(blues, l->before);
    const __m256i square = _mm256_mullo_epi16(u, _mm256_add_epi16(u, _mm256_set1_epi16(8)));
    const __m256i sum =
        _mm256_add_epi16(square, _mm256_sub_epi16(xy, _mm256_set1_epi16(REST_8 - 15)));
    const __m256i below = _mm256_subs_epu16(_mm256_slli_epi16(u, 4), sum);
    const __m256i other = _mm256_or_si256(_mm256_cmpeq_epi16(below, _mm256_setzero_si256()),
                                          _mm256_cmpeq_epi16(pairs, twice_of(blues)));
    *rows = row_words(pairs, k);
    /* of close ones only flat rows have numbers of at least 2^13 */
    const __m256i flat = _mm256_and_si256(_mm256_srli_epi16(*rows, 6), _mm256_set1_epi16(MOVED));
    const __m256i place =
        _mm256_or_si256(_mm256_sub_epi16(*rows, flat), _mm256_slli_epi16(blues, NTP__CLOSE8_SHIFT));
    *places = _mm256_or_si256(place, other);
    return other;
}

/* A bit for each of sixteen words with all bits set. */
static inline uint32_t lanes_of_words(__m256i words)
{
    const __m128i low = _mm256_castsi256_si128(words), high = _mm256_extracti128_si256(words, 1);
    return (uint32_t) _mm_movemask_epi8(_mm_packs_epi16(low, high));
}

/* Whether any texel of a group is left is as good as random: so it is asked once for all of them. */
static void count_close8(ntp__close8_block *out, ntp__close8_counts close, const uint8_t *src,
                         int32_t n, int32_t channels, size_t ahead)
{
    enum { COPIES = NTP__CLOSE8_COPIES };
    uint16_t at[256], left[256 / GROUP];
    const layout8 layout = layout8_of(channels);
    __m256i first = _mm256_setzero_si256(), unlike = first;
    uint32_t any = 0;
    int32_t others = 0;
    for (int32_t i = 0; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i rows, places;
        _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
        const __m256i other = are_other(&rows, &places, src, &layout);
        _mm256_storeu_si256((__m256i *) (void *) (out->row + i), rows);
        _mm256_storeu_si256((__m256i *) (void *) (at + i), places);
        if (i == 0)
            first = _mm256_broadcastw_epi16(_mm256_castsi256_si128(places));
        unlike = _mm256_or_si256(unlike, _mm256_xor_si256(places, first));
        left[i / GROUP] = (uint16_t) lanes_of_words(other);
        any |= left[i / GROUP];
    }
    for (int32_t i = 0; any != 0 && i + GROUP <= n; i += GROUP) {
        UNROLLED
        for (int32_t k = 0; k < GROUP; k += 4)
            others += find_four_bytes(out->left + others, i + k, left[i / GROUP] >> k & 15);
    }
    out->others = others;
    out->colors = 0;
    if (_mm256_testz_si256(unlike,
                           unlike)) { /* each of these counts would wait for the one before */
        for (int k = 0; k < COPIES; k++)
            close[at[0]][k] += (uint32_t) n / COPIES;
        return;
    }
    for (int32_t i = 0; i < n; i += COPIES) {
        UNROLLED
        for (int k = 0; k < COPIES; k++)
            close[at[i + k]][k]++;
    }
}

enum { WAITING = 512, STREAMS = 8 /* counts that are waiting, and parts of them */ };

/* Cells that are to be counted, and their rows. */
typedef struct waiting8 {
    uint32_t at[WAITING];
    uint16_t rows[WAITING];
    int32_t n;
} waiting8;

static inline void note_rows(ntp__cell_counts *counts, const uint16_t *rows, int32_t n)
{
    for (int32_t k = 0; k < n; k++)
        counts->row_seen[rows[k]] |= NTP__SEEN_QUARTERS;
}

/* Apart from the arithmetic, so that many counts are on their way at once.  Neighbors are often alike, and a
 * count waits for the one before it in the same place; so one of each part follows the other. */
ONE_COPY static void count_each(ntp__cell_counts *counts, waiting8 *w)
{
    const uint8_t *const seen = counts->row_seen;
    const int32_t n = w->n, part = n / STREAMS;
    for (int32_t i = 0; i + 4 <= n; i += 4) {
        const uint16_t *const rows = w->rows + i;
        UNROLLED
        for (int32_t k = 0; k < 4; k++)
            _mm_prefetch((const char *) counts->far + w->at[i + k], _MM_HINT_T0);
        /* storing it again would be waited for */
        const int all = seen[rows[0]] & seen[rows[1]] & seen[rows[2]] & seen[rows[3]];
        if ((all & NTP__SEEN_QUARTERS) != NTP__SEEN_QUARTERS)
            note_rows(counts, rows, 4);
    }
    note_rows(counts, w->rows + n / 4 * 4, n % 4);
    for (int32_t i = 0; i < part; i++) {
        UNROLLED
        for (int32_t k = 0; k < STREAMS; k++)
            ntp__count_far(counts, w->at[i + k * part], 1);
    }
    for (int32_t i = STREAMS * part; i < n; i++)
        ntp__count_far(counts, w->at[i], 1);
    w->n = 0;
}

/* How many of sixteen words have all bits set. */
static inline uint32_t words_set(__m256i words)
{
    return (uint32_t) __builtin_popcount((uint32_t) _mm256_movemask_epi8(words)) / 2;
}

static inline bool all_set(__m256i bits)
{
    return _mm256_movemask_epi8(bits) == -1;
}

/* The numbers of the cells of texels 0 to 3 and 8 to 11, and of the others. */
static inline void cells_of(__m256i at[2], __m256i rows, __m256i blues)
{
    const __m256i by = _mm256_set1_epi32(1 << 16 | NTP__ROW_CELLS);
    at[0] = _mm256_madd_epi16(_mm256_unpacklo_epi16(rows, blues), by);
    at[1] = _mm256_madd_epi16(_mm256_unpackhi_epi16(rows, blues), by);
}

/* Gray ones of a group: they are counted, and those among them that are unused for being black or white.
 * Returns which these are. */
static inline __m256i unused_grays(ntp__found8 *found, __m256i gray, __m256i pairs)
{
    const __m256i none = _mm256_setzero_si256(), all = _mm256_set1_epi8(-1);
    __m256i black = none, white = none;
    if (!(found->used & NTP__BLACK8))
        black = _mm256_and_si256(gray, _mm256_cmpeq_epi16(pairs, none));
    if (!(found->used & NTP__WHITE8))
        white = _mm256_and_si256(gray, _mm256_cmpeq_epi16(pairs, all));
    found->gray += words_set(gray);
    found->black += words_set(black);
    found->white += words_set(white);
    return _mm256_or_si256(black, white);
}

/* Alpha and green in the disc, where alpha is not full.  k is that of red and green. */
static inline __m256i are_in_disc(__m256i k, __m256i blues)
{
    const __m256i high = _mm256_set1_epi16((short) 0xff00);
    const __m256i both =
        _mm256_or_si256(_mm256_and_si256(k_of(blues), high), _mm256_srli_epi16(k, 8));
    const __m256i sum = _mm256_maddubs_epi16(_mm256_sub_epi8(both, _mm256_set1_epi8(-1)), both);
    const __m256i full = _mm256_cmpeq_epi16(_mm256_and_si256(blues, high), high);
    return _mm256_andnot_si256(full, _mm256_cmpgt_epi16(_mm256_set1_epi16(REST_8 + 1), sum));
}

/* Leaves out those that are not to be counted of the last GROUP, whose cells are in the order of cells_of. */
static void leave_out(waiting8 *w, uint32_t which)
{
    uint32_t *const at = w->at + w->n, cells[GROUP];
    uint16_t *const rows = w->rows + w->n;
    int32_t n = 0;
    memcpy(cells, at, sizeof cells);
    for (int32_t i = 0; i < GROUP; i++) {
        at[n] = cells[(i & 3) | (i & 8) >> 1 | (i & 4) << 1];
        rows[n] = rows[i];
        n += !(which >> i & 1);
    }
    w->n += n;
}

/* Neighbors are often alike, and a count waits for the one before it in the same place. */
static inline void count_alpha(uint32_t (*alpha)[256], const uint8_t *src)
{
    for (int32_t i = 0; i < GROUP; i += 4) {
        UNROLLED
        for (int32_t k = 0; k < 4; k++)
            alpha[k][src[4 * (i + k) + 3]]++;
    }
}

static int32_t count_cells(ntp__cell_counts *counts, ntp__found8 *found, const uint8_t *src,
                           int32_t n, int32_t channels)
{
    const layout8 layout = layout8_of(channels);
    const __m256i none = _mm256_setzero_si256(), all = _mm256_set1_epi8(-1);
    const __m256i low = _mm256_set1_epi16(255);
    waiting8 w;
    int32_t i = 0;
    w.n = 0;
    for (; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i pairs, blues, at[2], unused = none;
        load_16(&pairs, &blues, src, &layout);
        const __m256i k = k_of(pairs), rows = row_words(pairs, k);
        const __m256i blue = _mm256_and_si256(blues, low);
        const __m256i gray = _mm256_cmpeq_epi16(pairs, twice_of(blues));
        const bool opaque =
            channels == 3 || all_set(_mm256_cmpeq_epi16(_mm256_or_si256(blues, low), all));
        if (!opaque && !(found->used & NTP__CLEAR8) &&
            _mm256_movemask_epi8(_mm256_cmpeq_epi16(blue, blues)) != 0)
            break;
        if (_mm256_movemask_epi8(gray) != 0)
            unused = unused_grays(found, gray, pairs);
        if (!opaque)
            count_alpha(found->alpha, src);
        else if (channels == 4)
            found->alpha[0][255] += GROUP;
        if (!opaque)
            found->in_disc += words_set(_mm256_andnot_si256(unused, are_in_disc(k, blues)));
        cells_of(at, rows, blue);
        _mm256_storeu_si256((__m256i *) (void *) (w.rows + w.n), rows);
        _mm256_storeu_si256((__m256i *) (void *) (w.at + w.n), at[0]);
        _mm256_storeu_si256((__m256i *) (void *) (w.at + w.n + 8), at[1]);
        const __m256i first = _mm256_broadcastd_epi32(_mm256_castsi256_si128(at[0]));
        const uint32_t left_out = lanes_of_words(unused);
        if (left_out != 0) {
            leave_out(&w, left_out);
        } else if (all_set(_mm256_and_si256(_mm256_cmpeq_epi32(at[0], first),
                                            _mm256_cmpeq_epi32(at[1], first)))) {
            note_rows(counts, w.rows + w.n, 1);
            ntp__count_far(counts, w.at[w.n], GROUP);
        } else {
            w.n += GROUP;
        }
        if (w.n > WAITING - GROUP)
            count_each(counts, &w);
    }
    count_each(counts, &w);
    return i;
}
#else
#  define count_cells  NULL
#  define count_close8 NULL
#endif
