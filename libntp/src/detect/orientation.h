/* SPDX-License-Identifier: MIT */
/*
 * orientation.h - what orientation.c measures and decide_orientation.c judges
 */
#ifndef NTP_ORIENTATION_H
#define NTP_ORIENTATION_H

#include "libntp.h"

enum {
    BITS = 12,  /* kept of a derivative in a product */
    SIZES = 25, /* bit lengths 0..24: 384 (the filter's sum of magnitudes) times 10 slopes of 1 */

    ALONG_UNIT = 256, /* divides what `along` adds up, so that even 2^31 of the largest fit */

    SIDE = 16 /* blocks along each side of the picture */
};

/* What the loops of one filter add up to. */
typedef struct loop_sums {
    uint64_t loops[SIZES];
    uint64_t energy[SIZES]; /* sums of u*u + v*v, shifted as in add_loop */
    /* Sums of u*v, shifted likewise.  Most sizes are not in use, and their pages stay untouched. */
    int64_t cross[SIZES][SIDE * SIDE];
} loop_sums;

enum { WIDE, NARROW, FILTERS };

struct ntp_orientation {
    uint32_t width, height, every_row; /* 0: empty */
    uint64_t steep;                    /* loops left out only because a texel is too steep */
    uint64_t along; /* sum of squares of p derived along x and q along y, by the wide filter */
    uint64_t both, either; /* sums of 2 |p q| and of p*p + q*q of a loop's texel */
    loop_sums sums[FILTERS];
};

#endif
