/* SPDX-License-Identifier: MIT */
/*
 * cells.h - where colors of 8 bit are counted: the layout of the cells of a tally
 *
 * A row stands for {|X|, |Y|}.  measure/color_counts.h says what cells are for; here kernels find
 * their numbers.
 */
#ifndef NTP_CELLS_H
#define NTP_CELLS_H

enum {
    /* Unordered pairs of 128 magnitudes, and one row for each of the four flat pairs (127 or 128 in
     * red and in green).  These are kept apart to count flat colors. */
    NTP__FLAT_ROWS = 4,
    NTP__ROWS = 128 * 129 / 2 + NTP__FLAT_ROWS,

    NTP__NEAR = 16,            /* cells around the derived blue of a row: a cache line */
    NTP__FAR_CELLS = 256 + 16, /* rows a power of two apart would share few cache sets */

    /* All near cells come first, then the far ones. */
    NTP__FIRST_FAR = NTP__ROWS * NTP__NEAR,
    NTP__CELLS = NTP__FIRST_FAR + NTP__ROWS * NTP__FAR_CELLS
};

/* Where the cells of a row hold counts. */
enum { NTP__SEEN_NEAR = 1, NTP__SEEN_FAR = 2 };

#endif
