/* SPDX-License-Identifier: MIT */
/*
 * colors_avx512.h - adds colors of 8 bit with their counts to the sums, with AVX-512
 */
#ifndef NTP_COLORS_AVX512_H
#define NTP_COLORS_AVX512_H

#include "measure/color_counts.h"
#include "measure/judged_sums.h"

/* Adds the colors of all rows that are not too long, but for those noted as NTP__SEEN_OFTEN, with angles of the
 * standard encoding; and to blues[b] the texels of each blue b.  Notes which of these rows hold no counts, or
 * none in a quarter; and which are dense: ntp__add_dense_rows_avx2 has to add these. */
void ntp__add_colors_avx512(ntp__sums *sums, uint64_t blues[256], ntp__color_counts *counts);

/* As ntp__row_cells. */
int32_t ntp__row_cells_avx512(ntp__cells *cells, const ntp__color_counts *counts, int32_t row);

#endif
