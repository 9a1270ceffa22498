/* SPDX-License-Identifier: MIT */
/*
 * blue_row.h - what blue_evidence.c adds up of the cells of a row
 */
#ifndef NTP_BLUE_ROW_H
#define NTP_BLUE_ROW_H

#include "measure/color_counts.h"

/* In 8-bit levels. */
enum { NTP__BLUE_OFF_MOST = 32, NTP__BLUE_NEAR = 3, NTP__BLUE_ABOVE = 4 };

typedef struct ntp__blue_sums {
    double n, want, blue, want2, blue2, product;
    double tilted, gap, off[2], near[2], above; /* of tilted texels */
} ntp__blue_sums;

/* What all texels share whose red and green leave the same z; and their number, and sums of blue. */
typedef struct ntp__blue_row {
    double want[2], gap, n, blue, blue2;
    bool is_tilted;
} ntp__blue_row;

/* Fills in the number and the sums of n cells, the colors of a row; of a tilted one adds how far they are off to
 * `sums`, in their order: the same bytes as of the loop in plain C. */
void ntp__add_blues_avx2(ntp__blue_sums *sums, ntp__blue_row *row, const ntp__cells *cells,
                         int32_t n);

#endif
