/* SPDX-License-Identifier: MIT */
/*
 * cells_avx2.h - kernels for packed texels that count and add up, or pack their colors, with AVX2
 */
#ifndef NTP_CELLS_AVX2_H
#define NTP_CELLS_AVX2_H

#include "texel/kernels.h"

ntp__count8_fn ntp__count_cells_avx2;
ntp__count_alpha8_fn ntp__count_alpha8_avx2;
ntp__count_close8_fn ntp__count_close8_avx2;
ntp__survey8_fn ntp__survey8_avx2;
ntp__sample8_fn ntp__sample8_avx2;
ntp__move_colors_fn ntp__move_colors_avx2;

enum { NTP__WAITING8 = 512 /* cells that are to be counted at once, at most */ };

/* Counts n cells, of rows that are noted as far. */
void ntp__count_each8(ntp__cell_counts *counts, const uint32_t *at, int32_t n);

#endif
