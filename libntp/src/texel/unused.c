/* SPDX-License-Identifier: MIT */
/*
 * unused.c - the texels that hold no normal
 */
#include "texel/unused.h"

#include "texel/kernels.h"
#include "texel/level.h"

bool ntp__texel_unused(const ntp__block *block, int32_t i, int32_t m, uint32_t touch_unused)
{
    return (block->any_broken && block->broken[i]) ||
           ntp__unused(block->c[0][i], block->c[1][i], block->c[2][i], block->c[3][i], m,
                       touch_unused);
}

bool ntp__any_suspect(const ntp__block *b, int32_t n, int32_t m)
{
    return b->any_broken ||
           ntp__kernels(NTP__CPU_ALL)->suspect(b->c[0], b->c[1], b->c[2], b->c[3], n, m) != 0;
}
