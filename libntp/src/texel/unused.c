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

bool ntp__any_suspect(const ntp__block *b, int32_t n, int32_t m)
{
    int32_t suspect = b->any_broken;
    for (int32_t i = 0; i < n; i++) {
        int32_t r = b->c[0][i], g = b->c[1][i], blue = b->c[2][i];
        suspect |= (b->c[3][i] == 0) | ((r | g | blue) == 0) | ((r & g & blue) == m);
    }
    return suspect != 0;
}
