/* SPDX-License-Identifier: MIT */
/*
 * cells_avx2.c - counts packed texels of 8 bit in the cells of a tally, and adds them up, with AVX2
 *
 * The numbers of the cells come from arithmetic, sixteen at a time.  A table of 65,536 pairs would take
 * longer than that, and is waited for.  What is left for each texel is one count.
 */
#include "texel/cells_avx2.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "libntp.h"
#include "texel/find_four_tmpl.h"

#include <immintrin.h>
#include <stdbool.h>

enum { REST_8 = (255 * 255 - 5) / 4 /* e = REST_8 - k (k + 1) of red and green */ };

/* Four texels from each of two places: their colors, with the alpha or 0 above. */
static ALWAYS_INLINE __m256i load_colors(const uint8_t *first, const uint8_t *second,
                                         __m256i shuffle)
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
    __m256i shown; /* bits of alpha that are set in texels that no alpha hides */
    int32_t channels;
} layout8;

static ALWAYS_INLINE layout8 layout8_of(int32_t channels, bool hides)
{
    layout8 l;
    l.channels = channels;
    l.shown = _mm256_set1_epi16((short) (hides && channels == 4 ? 0 : 0xff00));
    if (channels == 3) {
#define PAIRS_BLUES(at)                                                                            \
    (at), (at) + 1, (at) + 3, (at) + 4, (at) + 6, (at) + 7, (at) + 9, (at) + 10, (at) + 2, -1,     \
        (at) + 5, -1, (at) + 8, -1, (at) + 11, -1
        l.first = _mm256_setr_epi8(PAIRS_BLUES(0), PAIRS_BLUES(0));
        l.second = _mm256_setr_epi8(PAIRS_BLUES(0), PAIRS_BLUES(4));
#undef PAIRS_BLUES
    } else {
        l.first = l.second = _mm256_broadcastsi128_si256(
            _mm_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15));
    }
    return l;
}

/* The reds and greens of 16 texels, and their blues with the alpha or 0 above.  The last load of packed RGB
 * begins four bytes early, to end with them. */
static ALWAYS_INLINE void load_16(__m256i *pairs, __m256i *blues, const uint8_t *src,
                                  const layout8 *l)
{
    const int32_t four = 4 * l->channels;
    const __m256i a = load_colors(src, src + 2 * four, l->first);
    const __m256i b = load_colors(src + four, src + 4 * four - 16, l->second);
    *pairs = _mm256_unpacklo_epi64(a, b);
    *blues = _mm256_unpackhi_epi64(a, b);
}

/* Which of them are unused for alpha 0; blue has none above it. */
static ALWAYS_INLINE __m256i are_hidden(__m256i blues, __m256i blue, const layout8 *l)
{
    return _mm256_cmpeq_epi16(_mm256_or_si256(blues, l->shown), blue);
}

ONE_COPY static uint64_t sum_of_lanes(const __m256i *v)
{
    const __m128i half = _mm_add_epi64(_mm256_castsi256_si128(*v), _mm256_extracti128_si256(*v, 1));
    return (uint64_t) _mm_cvtsi128_si64(_mm_add_epi64(half, _mm_unpackhi_epi64(half, half)));
}

/* Sums and extremes of texels so far. */
typedef struct surveyed8 {
    __m256i low[2], high[2],
        sum[3];    /* of pairs and blues; the first sum is that of both in a pair */
    __m256i every; /* the bits that all have in blue and alpha */
} surveyed8;

static ALWAYS_INLINE __m256i plus_bytes(__m256i sums, __m256i bytes)
{
    return _mm256_add_epi64(sums, _mm256_sad_epu8(bytes, _mm256_setzero_si256()));
}

/* Of whole groups. */
ONE_COPY static void survey_groups(surveyed8 *to, const uint8_t *src, int32_t n, int32_t channels)
{
    const __m256i none = _mm256_setzero_si256(), all = _mm256_set1_epi8(-1);
    const layout8 layout = layout8_of(channels, false);
    surveyed8 s = { { all, all }, { none, none }, { none, none, none }, all };
    for (int32_t i = 0; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i pairs, blues;
        load_16(&pairs, &blues, src, &layout);
        const __m256i blue = _mm256_and_si256(blues, _mm256_set1_epi16(255));
        s.every = _mm256_and_si256(s.every, blues);
        s.low[0] = _mm256_min_epu8(s.low[0], pairs);
        s.low[1] = _mm256_min_epu8(s.low[1], blue);
        s.high[0] = _mm256_max_epu8(s.high[0], pairs);
        s.high[1] = _mm256_max_epu8(s.high[1], blue);
        s.sum[0] = plus_bytes(s.sum[0], pairs);
        s.sum[1] = plus_bytes(s.sum[1], _mm256_srli_epi16(pairs, 8));
        s.sum[2] = plus_bytes(s.sum[2], blue);
    }
    *to = s;
}

/* The greater ones of pairs and blues as texels of four channels. */
static ALWAYS_INLINE void merge_greatest(uint8_t *to, __m256i pairs, __m256i blue)
{
    __m256i *const v = (__m256i *) (void *) to;
    const __m256i low = _mm256_unpacklo_epi16(pairs, blue),
                  high = _mm256_unpackhi_epi16(pairs, blue);
    _mm256_storeu_si256(v, _mm256_max_epu8(_mm256_loadu_si256(v), low));
    _mm256_storeu_si256(v + 1, _mm256_max_epu8(_mm256_loadu_si256(v + 1), high));
}

/* Adds whole groups to what is known of texels. */
ONE_COPY static void add_groups(ntp__packed_survey *to, const uint8_t *src, int32_t n,
                                int32_t channels)
{
    const __m256i all = _mm256_set1_epi8(-1);
    surveyed8 s;
    survey_groups(&s, src, n, channels);
    const uint64_t greens = sum_of_lanes(&s.sum[1]);
    merge_greatest(to->extremes[0], _mm256_xor_si256(s.low[0], all),
                   _mm256_xor_si256(s.low[1], all));
    merge_greatest(to->extremes[1], s.high[0], s.high[1]);
    to->texels += (uint64_t) n;
    to->translucent |= !_mm256_testc_si256(s.every, _mm256_set1_epi16((short) 0xff00));
    to->sum[0] += sum_of_lanes(&s.sum[0]) - greens;
    to->sum[1] += greens;
    to->sum[2] += sum_of_lanes(&s.sum[2]);
}

/* Their k: as bytes, the lesser of v ^ 127 and v ^ 128. */
static ALWAYS_INLINE __m256i k_of(__m256i bytes)
{
    return _mm256_min_epu8(_mm256_xor_si256(bytes, _mm256_set1_epi8(127)),
                           _mm256_xor_si256(bytes, _mm256_set1_epi8(-128)));
}

/* The rows of 16 pairs of bytes; k are the k of red and green. */
static ALWAYS_INLINE __m256i row_words(__m256i pairs, __m256i k)
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
static ALWAYS_INLINE __m256i twice_of(__m256i words)
{
    const __m128i low = _mm_setr_epi8(0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14, 14);
    return _mm256_shuffle_epi8(words, _mm256_broadcastsi128_si256(low));
}

/* How many of sixteen words have all bits set. */
static ALWAYS_INLINE uint32_t words_set(__m256i words)
{
    return (uint32_t) __builtin_popcount((uint32_t) _mm256_movemask_epi8(words)) / 2;
}

/* Gray ones of a group: they are counted, and those among them that are unused for being black or white.
 * Returns which these are. */
ONE_COPY static __m256i unused_grays(ntp__found8 *found, __m256i gray, __m256i pairs)
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

/*
 * The rows of 16 texels, and their places among counts of close ones: NTP__CLOSE8_NONE where they are hidden,
 * not close, or gray.  Returns which of them are one of the latter and not in found: the caller counts them.  With u = b - 127,
 * close ones have 128 <= b, (u - 4)^2 <= e < (u + 4)^2, or 0 <= u (u + 8) - e + 15 < 16 u.  From u = 4 on
 * that is root - 3 <= u <= root + 4, where 128 + root is the derived blue; below, it is part of that.  u is 0
 * where blue is less than 128, so that it does not hold.  The sum is from -2^14 to 34,000: as unsigned
 * numbers, negative ones are above 2^15 too.
 */
static ALWAYS_INLINE __m256i are_other(__m256i *rows, __m256i *places, __m256i *hidden,
                                       ntp__found8 *found, const uint8_t *src, const layout8 *l)
{
    enum { MOVED = NTP__ROWS - NTP__FLAT_ROWS - NTP__CLOSE8_ROWS };
    __m256i pairs, blues;
    load_16(&pairs, &blues, src, l);
    const __m256i blue = _mm256_and_si256(blues, _mm256_set1_epi16(255));
    const __m256i k = k_of(pairs);
    const __m256i xy = _mm256_maddubs_epi16(_mm256_sub_epi8(k, _mm256_set1_epi8(-1)), k);
    const __m256i u = _mm256_subs_epu16(blue, _mm256_set1_epi16(127));
    const __m256i square = _mm256_mullo_epi16(u, _mm256_add_epi16(u, _mm256_set1_epi16(8)));
    const __m256i sum =
        _mm256_add_epi16(square, _mm256_sub_epi16(xy, _mm256_set1_epi16(REST_8 - 15)));
    const __m256i below = _mm256_subs_epu16(_mm256_slli_epi16(u, 4), sum);
    __m256i gray = _mm256_cmpeq_epi16(pairs, twice_of(blue));
    const __m256i other = _mm256_or_si256(_mm256_cmpeq_epi16(below, _mm256_setzero_si256()), gray);
    *hidden = are_hidden(blues, blue, l);
    __m256i known = *hidden;
    gray = _mm256_andnot_si256(known, gray);
    if (_mm256_movemask_epi8(gray) != 0)
        known = _mm256_or_si256(known, unused_grays(found, gray, pairs));
    *rows = row_words(pairs, k);
    /* of close ones only flat rows have numbers of at least 2^13 */
    const __m256i flat = _mm256_and_si256(_mm256_srli_epi16(*rows, 6), _mm256_set1_epi16(MOVED));
    const __m256i place =
        _mm256_or_si256(_mm256_sub_epi16(*rows, flat), _mm256_slli_epi16(blue, NTP__CLOSE8_SHIFT));
    *places = _mm256_or_si256(place, _mm256_or_si256(other, *hidden));
    return _mm256_andnot_si256(known, other);
}

/* A bit for each of sixteen words with all bits set. */
static ALWAYS_INLINE uint32_t lanes_of_words(__m256i words)
{
    const __m128i low = _mm256_castsi256_si128(words), high = _mm256_extracti128_si256(words, 1);
    return (uint32_t) _mm_movemask_epi8(_mm_packs_epi16(low, high));
}

/* Whether any texel of a group is left is as good as random: so it is asked once for all of them. */
int32_t ntp__count_close8_avx2(ntp__close8_block *out, ntp__close8_counts close, const uint8_t *src,
                               int32_t most, int32_t channels, size_t ahead)
{
    enum { COPIES = NTP__CLOSE8_COPIES };
    const int32_t n = most < 256 ? most : 256;
    uint16_t at[256], left[256 / GROUP];
    const layout8 layout = layout8_of(channels, out->visible != 0);
    __m256i first = _mm256_setzero_si256(), unlike = first;
    uint32_t any = 0;
    int32_t others = 0;
    out->hidden = 0;
    add_groups(out->found.survey, src, n, channels);
    for (int32_t i = 0; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i rows, places, hidden;
        _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
        const __m256i other = are_other(&rows, &places, &hidden, &out->found, src, &layout);
        out->hidden += (int32_t) words_set(hidden);
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
    const bool alike = _mm256_testz_si256(unlike, unlike);
    end_lanes();
    if (alike) { /* each of these counts would wait for the one before */
        for (int k = 0; k < COPIES; k++)
            close[at[0]][k] += (uint32_t) n / COPIES;
        return n;
    }
    for (int32_t i = 0; i < n; i += COPIES) {
        UNROLLED
        for (int k = 0; k < COPIES; k++)
            close[at[i + k]][k]++;
    }
    return n;
}

enum { STREAMS = 8 /* parts of counts that are waiting */ };

/* Cells that are to be counted, and their rows. */
typedef struct waiting8 {
    uint32_t at[NTP__WAITING8];
    uint16_t rows[NTP__WAITING8];
    int32_t n;
} waiting8;

static ALWAYS_INLINE void note_rows(ntp__cell_counts *counts, const uint16_t *rows, int32_t n)
{
    for (int32_t k = 0; k < n; k++)
        counts->row_seen[rows[k]] |= NTP__SEEN_QUARTERS;
}

/* Registers that it leaves alone are not saved by its callers. */
ONE_COPY static void carry(ntp__cell_counts *counts, uint32_t cell)
{
    ntp__carry_inline(counts, cell);
}

/* As ntp__count_far, of one. */
static ALWAYS_INLINE void count_one(ntp__cell_counts *counts, uint32_t cell)
{
    if (++counts->far[cell] == 0)
        carry(counts, cell);
}

/* Apart from the arithmetic, so that many counts are on their way at once.  Neighbors are often alike, and a
 * count waits for the one before it in the same place; so one of each part follows the other. */
void ntp__count_each8(ntp__cell_counts *counts, const uint32_t *at, int32_t n)
{
    const int32_t part = n / STREAMS;
    for (int32_t i = 0; i < part; i++) {
        UNROLLED
        for (int32_t k = 0; k < STREAMS; k++)
            count_one(counts, at[i + k * part]);
    }
    for (int32_t i = STREAMS * part; i < n; i++)
        count_one(counts, at[i]);
}

ONE_COPY static void count_each(ntp__cell_counts *counts, waiting8 *w)
{
    const uint8_t *const seen = counts->row_seen;
    const int32_t n = w->n;
    for (int32_t i = 0; i + 4 <= n; i += 4) {
        const uint16_t *const rows = w->rows + i;
        /* storing it again would be waited for */
        const int all = seen[rows[0]] & seen[rows[1]] & seen[rows[2]] & seen[rows[3]];
        if ((all & NTP__SEEN_QUARTERS) != NTP__SEEN_QUARTERS)
            note_rows(counts, rows, 4);
    }
    note_rows(counts, w->rows + n / 4 * 4, n % 4);
    ntp__count_each8(counts, w->at, n);
    w->n = 0;
}

static ALWAYS_INLINE bool all_set(__m256i bits)
{
    return _mm256_movemask_epi8(bits) == -1;
}

/* The numbers of the cells of texels 0 to 3 and 8 to 11, and of the others. */
static ALWAYS_INLINE void cells_of(__m256i at[2], __m256i rows, __m256i blues)
{
    const __m256i by = _mm256_set1_epi32(1 << 16 | NTP__ROW_CELLS);
    at[0] = _mm256_madd_epi16(_mm256_unpacklo_epi16(rows, blues), by);
    at[1] = _mm256_madd_epi16(_mm256_unpackhi_epi16(rows, blues), by);
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

int32_t ntp__count_cells_avx2(ntp__cell_counts *counts, ntp__found8 *found, const uint8_t *src,
                              int32_t n, int32_t channels, size_t ahead)
{
    const layout8 layout = layout8_of(channels, !(found->used & NTP__CLEAR8));
    waiting8 w;
    int32_t i = 0;
    w.n = 0;
    add_groups(found->survey, src, n / GROUP * GROUP, channels);
    for (; i + GROUP <= n; i += GROUP, src += channels * GROUP) {
        __m256i pairs, blues, at[2];
        _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
        load_16(&pairs, &blues, src, &layout);
        const __m256i blue = _mm256_and_si256(blues, _mm256_set1_epi16(255));
        const __m256i rows = row_words(pairs, k_of(pairs));
        const __m256i hidden = are_hidden(blues, blue, &layout);
        const __m256i gray = _mm256_andnot_si256(hidden, _mm256_cmpeq_epi16(pairs, twice_of(blue)));
        if (all_set(hidden))
            continue;
        __m256i unused = hidden;
        if (_mm256_movemask_epi8(gray) != 0)
            unused = _mm256_or_si256(hidden, unused_grays(found, gray, pairs));
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
        if (w.n > NTP__WAITING8 - GROUP)
            count_each(counts, &w);
    }
    count_each(counts, &w);
    end_lanes();
    return i;
}

/* The least of 16 words. */
ONE_COPY static uint32_t least_word(const __m256i *v)
{
    const __m128i half = _mm_min_epu16(_mm256_castsi256_si128(*v), _mm256_extracti128_si256(*v, 1));
    return (uint32_t) _mm_cvtsi128_si32(_mm_minpos_epu16(half)) & 65535;
}

int32_t ntp__survey8_avx2(ntp__survey8 *s, const uint8_t *src, int32_t n, int32_t channels)
{
    const __m256i low = _mm256_set1_epi16(255);
    surveyed8 v;
    survey_groups(&v, src, n, channels);
    const __m256i words[6] = {
        _mm256_and_si256(v.low[0], low),
        _mm256_srli_epi16(v.low[0], 8),
        v.low[1],
        _mm256_andnot_si256(v.high[0], low),
        _mm256_xor_si256(_mm256_srli_epi16(v.high[0], 8), low),
        _mm256_xor_si256(v.high[1], low),
    };
    for (int32_t k = 0; k < 3; k++) {
        s->sum[k] = sum_of_lanes(&v.sum[k]);
        s->least[k] = least_word(&words[k]);
        s->greatest[k] = 255 - least_word(&words[3 + k]);
    }
    s->sum[0] -= s->sum[1];
    end_lanes();
    return n / GROUP * GROUP;
}

#include "texel/alpha8_avx2_tmpl.h"
#include "texel/sample8_avx2_tmpl.h"
