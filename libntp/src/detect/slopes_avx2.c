/* SPDX-License-Identifier: MIT */
/*
 * slopes_avx2.c - the slopes of a row with AVX2
 */
#include "detect/slopes_tmpl.h"

void ntp__add_slopes_avx2(columns *sums, float *p, float *q, ntp__block *block, int32_t n,
                          int32_t m, float steep, float smooth)
{
    enum { LANES = 8 };
    const int32_t filled = (n + LANES - 1) & -LANES; /* so that no loop has a remainder */
    for (int32_t i = n; i < filled; i++)
        block->c[0][i] = block->c[1][i] = 0;
    ntp__add_slopes(sums, p, q, block->c[0], block->c[1], filled, m, steep, smooth);
}
