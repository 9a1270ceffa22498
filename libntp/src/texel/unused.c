/* SPDX-License-Identifier: MIT */
/*
 * unused.c - the texels that hold no normal
 */
#include "texel/unused.h"

#include "texel/level.h"

bool ntp__texel_unused(const ntp__block *block, int32_t i, int32_t m, uint32_t touch_unused)
{
    return (block->any_broken && block->broken[i]) ||
           ntp__unused(block->c[0][i], block->c[1][i], block->c[2][i], block->c[3][i], m,
                       touch_unused);
}
