/* SPDX-License-Identifier: MIT */
/*
 * dense_row_avx2.h - adds rows of cells of which many hold counts to the sums, with AVX2
 */
#ifndef NTP_DENSE_ROW_AVX2_H
#define NTP_DENSE_ROW_AVX2_H

#include "measure/color_counts.h"
#include "measure/judged_sums.h"

/* So many cells of a row that it pays to look at all of them; and where others would be judged with AVX-512. */
enum { NTP__DENSE = 96, NTP__DENSE_512 = 192 };

/* Notes rows of 8 bit as dense of which enough cells hold counts that are not near ones, and none holds 65536 texels,
 * and no other rows.  `least`, 1 to 256: so many are enough in rows that are not too long, in others NTP__DENSE; 0:
 * no row is dense that is not too long. */
void ntp__note_dense_rows_avx2(ntp__color_counts *counts, int32_t least);

/* Adds the colors of all rows that are noted as dense, with angles of the standard encoding; and to blues[b] the texels
 * of each blue b. */
void ntp__add_dense_rows_avx2(ntp__sums *sums, uint64_t blues[256],
                              const ntp__color_counts *counts);

/* All 256 blues of a row that is noted so, also those that do not occur. */
void ntp__dense_cells_avx2(ntp__cells *cells, const ntp__color_counts *counts, int32_t row);

#endif
