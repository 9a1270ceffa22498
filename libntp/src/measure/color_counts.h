/* SPDX-License-Identifier: MIT */
/*
 * color_counts.h - the cells of a tally: how often each color of 8 bit occurs
 *
 * 8-bit texels are not judged one by one.  Each adds one to the cell of (row, blue).  The row
 * stands for {|X|, |Y|}: verdicts, lengths and angles depend on nothing else of red and green.  All
 * facts follow exactly, in integers, when the cells are read (tally.c).  A 16-bit texel of which
 * every level is a multiple of 257 goes to the same cells, for its X and Y are 257 times those of
 * the 8-bit texel.
 *
 * Tables of megabytes are slow to look through, so row_seen notes which rows hold counts.  In small
 * images it is set with each texel.  In large ones that would cost more, so it is set once, at the
 * end.
 */
#ifndef NTP_COLOR_COUNTS_H
#define NTP_COLOR_COUNTS_H

#include "texel/cells.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#  include <emmintrin.h>
#endif

enum { NTP__FEW = 4096 }; /* up to so many texels it pays to note the row of each */

typedef struct ntp__color_row {
    uint16_t pair; /* some r | g << 8 of the row, r, g >= 128; 0: it is not defined */
    uint8_t first; /* the blue of its first near cell */
    uint8_t blue;  /* the derived blue; 0: too long */
} ntp__color_row;

typedef struct ntp__color_counts {
    uint32_t rows_ready;
    uint32_t few;           /* few texels are being measured: their rows are noted */
    uint32_t unnoted;       /* some rows with near cells are not in row_seen */
    uint32_t undefined;     /* some rows in row_seen are not defined */
    uint32_t grouped;       /* many are far from exact, so rows may be dense */
    uint64_t far_texels;    /* that were counted by look-ups, ever */
    uint32_t mostly_far;    /* the next texels are to be counted by count_cells */
    uint32_t row_of[65536]; /* by r | g << 8: see ntp__entry; when rows_ready */
    ntp__color_row row[NTP__ROWS];
    ntp__close8_counts close; /* texels that are not in the cells yet */
    uint32_t has_close;       /* some are there */
    ntp__cell_counts at;      /* in well-formed textures, most of its pages stay untouched */
} ntp__color_counts;

/* Fills row_of, once. */
void ntp__rows_prepare(ntp__color_counts *counts);

/* The entry of row_of for one pair, without that table. */
uint32_t ntp__find_row(ntp__color_counts *counts, int32_t r, int32_t g);

/* An entry of row_of: where the near cells of its row begin, and the blue of the first. */
static inline uint32_t ntp__entry(uint32_t row, uint32_t first)
{
    return row * NTP__NEAR << 8 | first;
}

static inline uint32_t ntp__entry_cells(uint32_t entry)
{
    return entry >> 8;
}

static inline uint32_t ntp__entry_first(uint32_t entry)
{
    return entry & 255;
}

/* The colors of a row that occur, by rising blue, and how often.  What follows them is changed too. */
typedef struct ntp__cells {
    int32_t blue[256 + NTP__NEAR];
    uint32_t count[256 + NTP__NEAR];
} ntp__cells;

/* Those of a row that was seen; returns their number. */
int32_t ntp__row_cells(ntp__cells *cells, const ntp__color_counts *counts, int32_t row);

/* The quickest function that does this. */
typedef int32_t ntp__row_cells_fn(ntp__cells *cells, const ntp__color_counts *counts, int32_t row);
ntp__row_cells_fn *ntp__row_reader(void);

/* A bit for each of 16 counts, as of near cells, that is not 0. */
static inline uint32_t ntp__in_use16(const uint32_t *count)
{
#ifdef __SSE2__
    const __m128i *const v = (const __m128i *) (const void *) count;
    const __m128i zero = _mm_setzero_si128();
    const __m128i low = _mm_packs_epi32(_mm_cmpeq_epi32(_mm_loadu_si128(v), zero),
                                        _mm_cmpeq_epi32(_mm_loadu_si128(v + 1), zero));
    const __m128i high = _mm_packs_epi32(_mm_cmpeq_epi32(_mm_loadu_si128(v + 2), zero),
                                         _mm_cmpeq_epi32(_mm_loadu_si128(v + 3), zero));
    return 0xffff ^ (uint32_t) _mm_movemask_epi8(_mm_packs_epi16(low, high));
#else
    uint32_t bits = 0;
    for (int32_t i = 0; i < 16; i++)
        bits |= (uint32_t) (count[i] != 0) << i;
    return bits;
#endif
}

/* The first row from `row` on for which seen[row] is not 0; NTP__ROWS: none. */
static inline int32_t ntp__next_row(const uint8_t seen[NTP__ROWS], int32_t row)
{
    uint64_t eight;
    for (; row + 8 <= NTP__ROWS; row += 8) {
        memcpy(&eight, seen + row, sizeof eight);
        if (eight != 0)
            break;
    }
    while (row < NTP__ROWS && seen[row] == 0)
        row++;
    return row;
}

/* Are red and green of a row that was seen not too long? */
static inline bool ntp__row_is_on_disc(const ntp__color_counts *counts, int32_t row)
{
    enum { K = 128, REST = (255 * 255 - 5) / 4 };
    const int32_t k1 = (counts->row[row].pair & 255) - K, k2 = (counts->row[row].pair >> 8) - K;
    return k1 * (k1 + 1) + k2 * (k2 + 1) <= REST;
}

/* The greatest magnitude, k for |X| or |Y| = 2k + 1, of a level between these two. */
static inline int32_t ntp__steepest(int32_t least, int32_t greatest)
{
    const int32_t a = 127 - least, b = greatest - 128;
    return a > b ? a : b;
}

/* Completes row_seen and the cells, and defines their rows.  `most`: no magnitude of a color is greater. */
void ntp__note_rows(ntp__color_counts *counts, int32_t most);

/* Puts it into the cells if it holds no other ones than n packed texels, and row_of is filled.  More than
 * NTP__FEW_CLOSE are better looked for in all of it, which takes as long as to count tens of thousands. */
enum { NTP__FEW_CLOSE = 512 };
void ntp__take_close8_of(ntp__color_counts *counts, const uint8_t *texels, int32_t n,
                         int32_t channels);

/* The same holds for colors of `from`. */
void ntp__merge_cells(ntp__color_counts *into, const ntp__color_counts *from, int32_t most);
void ntp__clear_cells(ntp__color_counts *counts, int32_t most);

#endif
