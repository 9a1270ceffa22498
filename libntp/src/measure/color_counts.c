/* SPDX-License-Identifier: MIT */
/*
 * color_counts.c - the cells of a tally: which row is whose, and which rows hold counts
 *
 * There are 8260 rows, whose cells take 2.8 MB.  A small texture has texels in a
 * few of them.  So everything that looks through the cells goes by the notes in row_seen.
 */
#include "texel/kernels.h"
#include "texel/level.h"
#include "base/inlining.h"
#include "measure/color_counts.h"
#include "measure/merge.h"
#ifdef NTP_HAVE_AVX512
#  include "measure/colors_avx512.h"
#endif

#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#ifdef __SSE2__
#  include <emmintrin.h>
#endif

/* The blue of the first near cell: 8 below the derived one.  If a near cell would be gray, the
 * first is above that level instead.  So the loops need not look for black and white among them. */
static uint32_t first_near(int32_t k1, int32_t k2, int32_t blue)
{
    int32_t most = 256 - NTP__NEAR, gray = 128 + k1;
    int32_t first = blue - NTP__NEAR / 2 < most ? blue - NTP__NEAR / 2 : most;
    if (k1 == k2 && gray >= first && gray < first + NTP__NEAR)
        first = gray + 1;
    return (uint32_t) first;
}

enum { K = 128 }; /* magnitudes: |X| = 2k + 1 for k = r - 128 or 127 - r */

/* Row number `row` becomes that of k1 >= k2, with this derived blue (-1: too long). */
static uint32_t define_row(ntp__color_counts *t, uint32_t row, int32_t k1, int32_t k2, int32_t want)
{
    uint32_t first = first_near(k1, k2, want < 0 ? K : want);
    t->row[row] = (ntp__color_row) { (uint16_t) ((K + k1) | (K + k2) << 8), (uint8_t) first,
                                     (uint8_t) (want < 0 ? 0 : want) };
    return ntp__entry(row, first);
}

void ntp__rows_prepare(ntp__color_counts *t)
{
    int32_t r[K], g[K], want[K];
    uint32_t rows = 0;
    if (t->rows_ready)
        return;
    for (int32_t k1 = 0; k1 < K; k1++) {
        for (int32_t k2 = 0; k2 <= k1; k2++) {
            r[k2] = K + k1;
            g[k2] = K + k2;
        }
        ntp__kernels(NTP__CPU_ALL)->derive(want, r, g, k1 + 1, 255, 0);
        for (int32_t k2 = 0; k2 <= k1; k2++, rows++) {
            uint32_t entry = define_row(t, rows, k1, k2, want[k2]);
            for (int32_t i = 0; i < 8; i++) {
                int32_t a = i & 1 ? k2 : k1, b = i & 1 ? k1 : k2;
                int32_t x = i & 2 ? 127 - a : K + a, y = i & 4 ? 127 - b : K + b;
                t->row_of[x | y << 8] = entry;
            }
        }
    }
    for (int32_t i = 0; i < NTP__FLAT_ROWS; i++, rows++) {
        int32_t x = 127 + (i & 1), y = 127 + (i >> 1);
        t->row_of[x | y << 8] = define_row(t, rows, 0, 0, 255);
    }
    t->rows_ready = 1;
}

uint32_t ntp__find_row(ntp__color_counts *t, int32_t r, int32_t g)
{
    int32_t a = r < K ? K - 1 - r : r - K, b = g < K ? K - 1 - g : g - K;
    int32_t k1 = a > b ? a : b, k2 = a > b ? b : a, row = k1 * (k1 + 1) / 2 + k2;
    if (k1 == 0)
        row = NTP__ROWS - NTP__FLAT_ROWS + (r - (K - 1)) + 2 * (g - (K - 1));
    if (t->row[row].pair != 0)
        return ntp__entry((uint32_t) row, t->row[row].first);
    int64_t rest = ntp__rest(r, g, 255);
    return define_row(t, (uint32_t) row, k1, k2,
                      rest < 0 ? -1 : ntp__blue_of_rest(rest, 255, false));
}

/* A bit for each of 64 bytes that is not 0. */
static inline uint64_t bytes_in_use(const uint8_t *bytes)
{
    uint64_t none = 0;
#ifdef __SSE2__
    const __m128i zero = _mm_setzero_si128();
#  pragma GCC unroll 4
    for (int32_t i = 0; i < 64; i += 16) {
        const __m128i v = _mm_loadu_si128((const __m128i *) (const void *) (bytes + i));
        none |= (uint64_t) (uint32_t) _mm_movemask_epi8(_mm_cmpeq_epi8(v, zero)) << i;
    }
#else
    for (int32_t i = 0; i < 64; i++)
        none |= (uint64_t) (bytes[i] == 0) << i;
#endif
    return ~none;
}

int32_t ntp__row_cells(ntp__cells *cells, const ntp__color_counts *t, int32_t row)
{
    const uint32_t *const near = &t->at.near[row * NTP__NEAR];
    const uint8_t *const far = &t->at.far[row * NTP__ROW_CELLS];
    const uint8_t *const carried = &t->at.carried[row * NTP__ROW_CELLS];
    const uint16_t *const often = &t->at.often[row * NTP__ROW_CELLS];
    const int32_t first = t->row[row].first, seen = t->at.row_seen[row];
    const uint64_t any_near = ntp__in_use16(near);
    int32_t n = 0;
    if (seen == NTP__SEEN_NEAR) {
        for (uint32_t bits = ntp__in_use16(near); bits != 0; bits &= bits - 1) {
            const int32_t place = __builtin_ctz(bits);
            cells->blue[n] = first + place;
            cells->count[n++] = near[place];
        }
        return n;
    }
    for (int32_t i = 0; i < 256; i += NTP__QUARTER) {
        /* Near cells may lie in two of these. */
        uint64_t bits = (uint32_t) (first - i) < 64   ? any_near << (first - i)
                        : (uint32_t) (i - first) < 64 ? any_near >> (i - first)
                                                      : 0;
        if (seen & NTP__SEEN_QUARTER << i / NTP__QUARTER) {
            bits |= bytes_in_use(far + i);
            if (seen & NTP__SEEN_CARRIED)
                bits |= bytes_in_use(carried + i);
            if (seen & NTP__SEEN_OFTEN) /* all of these */
                bits = UINT64_MAX;
        }
        for (; bits != 0; bits &= bits - 1) {
            const int32_t blue = i + __builtin_ctzll(bits);
            const uint32_t place = (uint32_t) (blue - first);
            uint32_t count = far[blue] + (place < NTP__NEAR ? near[place] : 0);
            if (seen & NTP__SEEN_CARRIED)
                count += (uint32_t) carried[blue] << 8;
            if (seen & NTP__SEEN_OFTEN)
                count += (uint32_t) often[blue] << 16;
            cells->blue[n] = blue;
            cells->count[n] = count;
            n += count != 0;
        }
    }
    return n;
}

/* The first row whose greater magnitude is k1, but for flat ones. */
static inline int32_t first_of(int32_t k1)
{
    return k1 * (k1 + 1) / 2;
}

ntp__row_cells_fn *ntp__row_reader(void)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        return ntp__row_cells_avx512;
#endif
    return ntp__row_cells;
}

/* The row after this one, of those whose magnitudes are at most `most`: flat ones are the last. */
static inline int32_t next_of(int32_t row, int32_t most)
{
    return row + 1 == first_of(most + 1) ? NTP__ROWS - NTP__FLAT_ROWS : row + 1;
}

/* Are there close texels of a row?  Most rows have none. */
static inline bool any_close(const ntp__color_counts *t, int32_t row)
{
#ifdef __SSE2__
    __m128i any = _mm_setzero_si128();
    for (uint32_t i = 0; i < NTP__CLOSE8_BLUES; i++) {
        const uint32_t *const close = t->close[ntp__close8_of((uint32_t) row, i)];
        any = _mm_or_si128(any, _mm_loadu_si128((const __m128i *) (const void *) close));
    }
    return _mm_movemask_epi8(_mm_cmpeq_epi8(any, _mm_setzero_si128())) != 0xffff;
#else
    uint64_t any = 0, two[2];
    for (uint32_t i = 0; i < NTP__CLOSE8_BLUES; i++) {
        memcpy(two, t->close[ntp__close8_of((uint32_t) row, i)], sizeof two);
        any |= two[0] | two[1];
    }
    return any != 0;
#endif
}

static void add_to_cell(ntp__color_counts *t, uint32_t row, uint32_t blue, uint32_t count)
{
    enum { MOST = 256 };
    const uint32_t place = blue - t->row[row].first;
    t->at.row_seen[row] |= place < NTP__NEAR ? NTP__SEEN_NEAR : NTP__SEEN_QUARTERS;
    if (place < NTP__NEAR) {
        t->at.near[row * NTP__NEAR + place] += count;
        return;
    }
    for (; count > MOST; count -= MOST)
        ntp__count_far(&t->at, row * NTP__ROW_CELLS + blue, MOST);
    ntp__count_far(&t->at, row * NTP__ROW_CELLS + blue, count);
}

void ntp__take_close8_of(ntp__color_counts *t, const uint8_t *texels, int32_t n, int32_t channels)
{
    for (const uint8_t *p = texels; p < texels + (size_t) n * (size_t) channels; p += channels) {
        const uint32_t row = ntp__entry_cells(t->row_of[p[0] | p[1] << 8]) / NTP__NEAR;
        const uint32_t blue = t->row[row].blue;
        const uint32_t above = p[2] + (uint32_t) NTP__CLOSE8_BELOW - blue;
        if (blue == 0 || above >= NTP__CLOSE8_BLUES)
            continue;
        uint32_t *const close = t->close[ntp__close8_of(row, p[2])];
        const uint32_t count = close[0] + close[1] + close[2] + close[3];
        if (count > 0)
            add_to_cell(t, row, p[2], count);
        memset(close, 0, sizeof t->close[0]);
    }
}

/* Defines a row, unless that was done: then its pair is not 0.  k1 is its greater magnitude. */
static void define(ntp__color_counts *t, int32_t row, int32_t k1)
{
    const int32_t flat = row - (NTP__ROWS - NTP__FLAT_ROWS);
    if (t->row[row].pair != 0)
        return;
    if (flat >= 0)
        ntp__find_row(t, K - 1 + (flat & 1), K - 1 + (flat >> 1));
    else
        ntp__find_row(t, K + k1, K + row - first_of(k1));
}

static void add_close_row(ntp__color_counts *into, const ntp__color_counts *from, int32_t row,
                          int32_t k1)
{
    if (!any_close(from, row))
        return;
    define(into, row, k1);
    const uint32_t least = (uint32_t) into->row[row].blue - NTP__CLOSE8_BELOW;
    for (uint32_t blue = least; blue < least + NTP__CLOSE8_BLUES; blue++) {
        const uint32_t *const close = from->close[ntp__close8_of((uint32_t) row, blue)];
        const uint32_t count = close[0] + close[1] + close[2] + close[3]; /* less than 2^32 */
        if (count > 0)
            add_to_cell(into, (uint32_t) row, blue, count);
    }
}

/* Adds the close texels of `from`, whose magnitudes are at most `most`, to the cells of `into`, and notes their
 * rows. */
static void add_close(ntp__color_counts *into, const ntp__color_counts *from, int32_t most)
{
    if (!from->has_close)
        return;
    for (int32_t k1 = 0, row = 0; k1 <= most && k1 < K - 1; k1++) {
        for (; row < first_of(k1 + 1); row++)
            add_close_row(into, from, row, k1);
    }
    for (int32_t row = NTP__ROWS - NTP__FLAT_ROWS; row < NTP__ROWS; row++)
        add_close_row(into, from, row, 0);
}

static void clear_close(ntp__color_counts *t, int32_t most)
{
    const int32_t rows = most < K - 1 ? first_of(most + 1) : NTP__CLOSE8_ROWS;
    if (!t->has_close)
        return;
    for (uint32_t i = 0; i < NTP__CLOSE8_BLUES; i++) {
        memset(t->close[ntp__close8_of(0, i)], 0, (size_t) rows * sizeof t->close[0]);
        memset(t->close[ntp__close8_of(NTP__ROWS - NTP__FLAT_ROWS, i)], 0,
               NTP__FLAT_ROWS * sizeof t->close[0]);
    }
    memset(t->close[NTP__CLOSE8_NONE], 0, sizeof t->close[0]);
    t->has_close = 0;
}

/* Adds the rows that were not noted to `seen`, which is t's own or a copy.  Steeper rows than any in use are a third
 * of all, or more, and stay untouched. */
static void find_rows(uint8_t seen[NTP__ROWS], const ntp__color_counts *t, int32_t most)
{
    if (!t->unnoted)
        return;
    for (int32_t row = 0; row < NTP__ROWS; row = next_of(row, most)) {
        uint32_t any = 0;
        for (int32_t i = 0; i < NTP__NEAR; i++)
            any |= t->at.near[row * NTP__NEAR + i];
        seen[row] |= any != 0 ? NTP__SEEN_NEAR : 0;
    }
}

static void define_noted(ntp__color_counts *t)
{
    int32_t k1 = 0;
    for (int32_t row = 0; (row = ntp__next_row(t->at.row_seen, row)) < NTP__ROWS; row++) {
        while (k1 < K - 1 && first_of(k1 + 1) <= row)
            k1++;
        define(t, row, k1);
    }
}

void ntp__note_rows(ntp__color_counts *t, int32_t most)
{
    find_rows(t->at.row_seen, t, most);
    memset(t->at.noted, 0, sizeof t->at.noted);
    t->unnoted = 0;
    if (t->undefined)
        define_noted(t);
    t->undefined = 0;
    add_close(t, t, most);
    clear_close(t, most);
}

void ntp__merge_cells(ntp__color_counts *into, const ntp__color_counts *from, int32_t most)
{
    uint8_t seen[NTP__ROWS];
    memcpy(seen, from->at.row_seen, sizeof seen);
    find_rows(seen, from, most);
    into->grouped |= from->grouped;
    into->undefined = 1;
    for (int32_t row = 0; (row = ntp__next_row(seen, row)) < NTP__ROWS; row++) {
        const int32_t near = row * NTP__NEAR, first = row * NTP__ROW_CELLS;
        ntp__merge_counts(&into->at.near[near], &from->at.near[near], NTP__NEAR);
        into->at.row_seen[row] |= seen[row];
        for (int32_t i = first; seen[row] & NTP__SEEN_QUARTERS && i < first + 256; i++)
            ntp__count_far(&into->at, (uint32_t) i, from->at.far[i]);
        for (int32_t i = first; seen[row] & NTP__SEEN_CARRIED && i < first + 256; i++) {
            const uint32_t sum = (uint32_t) into->at.carried[i] + from->at.carried[i];
            const uint32_t often = (sum >> 8) + into->at.often[i] + from->at.often[i];
            into->at.carried[i] = (uint8_t) sum;
            if (often == 0)
                continue;
            into->at.often[i] = (uint16_t) often;
            into->at.row_seen[row] |= NTP__SEEN_OFTEN;
        }
    }
    add_close(into, from, most);
}

/* Clears 64 bytes, as a quarter of a row or its near cells are: compilers that save code loop over each byte. */
static ALWAYS_INLINE void clear_64(void *to)
{
    uint8_t *const bytes = to;
    UNROLLED
    for (int32_t i = 0; i < 64; i += 8)
        memset(bytes + i, 0, 8);
}

void ntp__clear_cells(ntp__color_counts *t, int32_t most)
{
    uint8_t *const seen = t->at.row_seen;
    find_rows(seen, t, most);
    t->unnoted = 0;
    clear_close(t, most);
    for (int32_t row = 0; (row = ntp__next_row(seen, row)) < NTP__ROWS; row++) {
        clear_64(&t->at.near[row * NTP__NEAR]);
        for (int32_t i = 0; i < 256; i += NTP__QUARTER) {
            if (seen[row] & NTP__SEEN_QUARTER << i / NTP__QUARTER)
                clear_64(&t->at.far[row * NTP__ROW_CELLS + i]);
        }
        if (seen[row] & NTP__SEEN_CARRIED)
            memset(&t->at.carried[row * NTP__ROW_CELLS], 0, NTP__ROW_CELLS);
        if (seen[row] & NTP__SEEN_OFTEN)
            memset(&t->at.often[row * NTP__ROW_CELLS], 0, NTP__ROW_CELLS * sizeof t->at.often[0]);
    }
    memset(&t->at, 0, offsetof(ntp__cell_counts, near));
    t->grouped = 0;
    t->mostly_far = 0;
}
