/* SPDX-License-Identifier: MIT */
/*
 * cells.c - what is carried from the cells of a tally: seldom, so one copy serves all loops
 */
#include "texel/cells.h"

void ntp__carry(ntp__cell_counts *counts, uint32_t cell)
{
    ntp__carry_inline(counts, cell);
}
