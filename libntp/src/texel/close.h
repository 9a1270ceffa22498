/* SPDX-License-Identifier: MIT */
/*
 * close.h - counts of 16-bit texels that are exact, or as close as rounding leaves them
 *
 * A texel is close here if it is standard, not below the horizon, on the disc, a neighbor, at most
 * one level off its derived blue, and at most 1/65536 from length 1, rounded.  All that the standard
 * encoding asks of it then fits into a few bits, and so does what Z-zero asks, but for how far blue
 * is off.  Kernels count these (close_tmpl.h), and measure/ reads the counts when it needs them.
 */
#ifndef NTP_CLOSE_H
#define NTP_CLOSE_H

#include <stdint.h>

/* Of t = a - A_M + 1 in the notation of judge_tmpl.h, which says how long a standard vector is. */
enum {
    NTP__CLOSE_T_ONE = -16382,   /* the least of length 65536 */
    NTP__CLOSE_T_LONGER = 16385, /* and of 65537 */
    NTP__CLOSE_T_MOST = 49149    /* of |t|, before other lengths */
};

/* The bits of a place in the standard counts, and in those of Z-zero. */
enum {
    NTP__CLOSE_LENGTH = 3, /* the length in 1/65536, less 65535 */
    NTP__CLOSE_LONG = 4,
    NTP__CLOSE_ROUNDED = 8,
    NTP__CLOSE_INEXACT = 16,
    NTP__CLOSE_STEEP_BIT = 5, /* above: floor(64 xy / A_M), which steepness follows from */
    NTP__CLOSE_PLACES = 64 << NTP__CLOSE_STEEP_BIT,

    NTP__CLOSE_ZZ_NEIGHBOR = 1,
    NTP__CLOSE_ZZ_ROUNDED = 2,
    NTP__CLOSE_ZZ_EXACT = 4,
    NTP__CLOSE_ZZ_LONG = 8,
    NTP__CLOSE_ZZ_LENGTH = 16,    /* times the length in 1/128, less the least */
    NTP__CLOSE_ZZ_SHORTEST = 127, /* read as Z-zero, standard vectors are 1 to 2/sqrt(3) long */
    NTP__CLOSE_ZZ_PLACES = 24 * NTP__CLOSE_ZZ_LENGTH,

    NTP__CLOSE_COPIES =
        4 /* texels side by side are counted apart: a count waits for the one before */
};

/*
 * Exact texels have places of their own, by their standard length: how many of the limits of 65536
 * levels, of 1, and of 65537 levels it reaches.  Those that are nearly flat come first, with the
 * distance of blue from that of Z-zero.  Behind them are others by steepness and length in Z-zero,
 * with this distance in a table of its own.  Distances have LESS added here, or 1 in places: below that,
 * what is no such texel is counted and forgotten.
 */
enum {
    NTP__EXACT_NEAR = 14, /* levels of blue below 65536 */
    NTP__EXACT_PASSED = 3,
    NTP__EXACT_NEIGHBOR = 4, /* in Z-zero */
    NTP__EXACT_ROUNDED = 8,
    NTP__EXACT_OFF_BIT = 4,
    NTP__EXACT_NEAR_PLACES = 16 << NTP__EXACT_OFF_BIT,
    NTP__EXACT_NEAR_COPIES = 8,

    NTP__EXACT_STEEP_BIT = 2,
    NTP__EXACT_ROW = 64 << NTP__EXACT_STEEP_BIT, /* places for 1/128 of length */
    NTP__EXACT_ROWS = 20,                        /* from 1 on, up to 2/sqrt(3) */

    NTP__EXACT_FAR = NTP__EXACT_NEAR_PLACES * NTP__EXACT_NEAR_COPIES,
    NTP__EXACT_COUNTS = NTP__EXACT_FAR + NTP__EXACT_ROWS * NTP__EXACT_ROW * NTP__CLOSE_COPIES,
    NTP__EXACT_LESS = 8,
    NTP__EXACT_DISTANCES = 32768 + 1 + NTP__EXACT_LESS
};

typedef struct ntp__close_counts {
    uint32_t standard[NTP__CLOSE_PLACES][NTP__CLOSE_COPIES];
    uint32_t zzero[NTP__CLOSE_ZZ_PLACES][NTP__CLOSE_COPIES];
    uint32_t exact[NTP__EXACT_COUNTS], exact_off[NTP__EXACT_DISTANCES];
} ntp__close_counts;

/* What is known of the close texels of a block besides. */
typedef struct ntp__close_block {
    int32_t texels; /* how many are close */
    int32_t left;   /* how many are not, and wait at the front of the planes */
    /* of angles in micro-degrees: none is more than 2/M, give or take a part in 10000 of that */
    int32_t angle_bins[3];
    uint32_t angle_sum, angle_max;
    /* as Z-zero: of lengths less 65536, in 1/65536; extremes of lengths */
    int32_t length_sum;
    uint64_t length_error2;
    uint32_t least, greatest, levels_off_max;
} ntp__close_block;

#endif
