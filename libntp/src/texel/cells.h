/* SPDX-License-Identifier: MIT */
/*
 * cells.h - where colors of 8 bit are counted: the layout of the cells of a tally
 *
 * A row stands for {|X|, |Y|}.  measure/color_counts.h says what cells are for; here kernels find
 * their numbers.
 *
 * A row has near cells, of the 16 blues around its derived one, and a cell for each blue.  A color
 * with a near cell may be counted in both of its cells.  Well-formed textures need the near ones
 * only.  The others are bytes, so that they stay in the cache and are quick to look through; what is
 * more than a byte holds is carried to tables that few textures need.
 */
#ifndef NTP_CELLS_H
#define NTP_CELLS_H

#include <stdint.h>

enum {
    /* Unordered pairs of 128 magnitudes, and one row for each of the four flat pairs (127 or 128 in
     * red and in green).  These are kept apart to count flat colors. */
    NTP__FLAT_ROWS = 4,
    NTP__ROWS = 128 * 129 / 2 + NTP__FLAT_ROWS,

    NTP__NEAR = 16,            /* near cells of a row: a cache line */
    NTP__ROW_CELLS = 256 + 16, /* rows a power of two apart would share few cache sets */
    NTP__CELLS = NTP__ROWS * NTP__ROW_CELLS
};

/* Where the cells of a row hold counts; and that many of them do, noted where the row was added as a
 * whole.  Of those that are not near ones each quarter has a bit, from NTP__SEEN_QUARTER on: where few colors are
 * far from exact, most of a row is neither read nor cleared. */
enum {
    NTP__SEEN_NEAR = 1,
    NTP__SEEN_OFTEN = 2, /* 65536 texels or more in a cell */
    NTP__SEEN_CARRIED = 4,
    NTP__SEEN_DENSE = 8,
    NTP__SEEN_QUARTER = 16,
    NTP__SEEN_QUARTERS = 15 * NTP__SEEN_QUARTER,
    NTP__QUARTER = 64 /* blues */
};

/* Close texels of a row, whose blue is one of eight around its derived one: from 4 levels below that to 3
 * above it, told apart by their low bits.  These are the high bits of a number of 16 bits, so that rows which
 * are much alike lie together.  Neighbors are often alike, and a count waits for the one before it in the
 * same place; so there are four counts, one for each fourth texel.  Rows from NTP__CLOSE8_ROWS on are too
 * long, but for the flat ones, which take their places. */
enum {
    NTP__CLOSE8_ROWS = 127 * 128 / 2,
    NTP__CLOSE8_BLUES = 8,
    NTP__CLOSE8_BELOW = 4,
    NTP__CLOSE8_SHIFT = 13,
    NTP__CLOSE8_NONE = 65535, /* of no color */
    NTP__CLOSE8_COPIES = 4
};
typedef uint32_t ntp__close8_counts[65536][NTP__CLOSE8_COPIES];

/* The counts of a blue of a row, which is flat or below NTP__CLOSE8_ROWS. */
static inline uint32_t ntp__close8_of(uint32_t row, uint32_t blue)
{
    enum { FLAT = NTP__ROWS - NTP__FLAT_ROWS };
    return (row < FLAT ? row : row - FLAT + NTP__CLOSE8_ROWS) | blue % NTP__CLOSE8_BLUES
                                                                    << NTP__CLOSE8_SHIFT;
}

/* Rows may be noted as far in blocks of eight, also those that hold nothing, until these are looked at:
 * a bit of each block says that it is noted.  The rows that are left are in the first blocks, too. */
enum { NTP__BLOCK_SHIFT = 3, NTP__ROW_BLOCKS = 1024 };

typedef struct ntp__cell_counts {
    uint8_t row_seen[NTP__ROWS]; /* NTP__SEEN_* */
    uint8_t noted[NTP__ROW_BLOCKS / 8];
    uint32_t near[NTP__ROWS * NTP__NEAR];
    uint8_t far[NTP__CELLS];     /* by row and blue */
    uint8_t carried[NTP__CELLS]; /* in 256 */
    uint16_t often[NTP__CELLS];  /* in 65536 */
} ntp__cell_counts;

static inline int32_t ntp__row_block(int32_t row)
{
    return row >> NTP__BLOCK_SHIFT & (NTP__ROW_BLOCKS - 1);
}

/* Adds 256 to a cell: for loops that a call would slow down. */
static inline void ntp__carry_inline(ntp__cell_counts *counts, uint32_t cell)
{
    uint8_t *const seen = &counts->row_seen[cell / NTP__ROW_CELLS];
    *seen |= NTP__SEEN_CARRIED;
    if (++counts->carried[cell] != 0)
        return;
    counts->often[cell]++;
    *seen |= NTP__SEEN_OFTEN;
}

/* The same, as a call. */
void ntp__carry(ntp__cell_counts *counts, uint32_t cell);

/* Adds up to 256 to a cell that is not a near one, of a row that is noted as far. */
static inline void ntp__count_far(ntp__cell_counts *counts, uint32_t cell, uint32_t count)
{
    const uint32_t sum = counts->far[cell] + count;
    counts->far[cell] = (uint8_t) sum;
    if (sum > 255)
        ntp__carry(counts, cell);
}

#endif
