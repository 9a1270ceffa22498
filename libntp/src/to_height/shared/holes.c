/* SPDX-License-Identifier: MIT */
/*
 * holes.c - the texels that get no height
 */
#include "to_height/shared/holes.h"

#include "texel/unused.h"

#include <string.h>

static bool masked_out(const ntp_const_image *mask, int32_t x, int32_t y)
{
    const void *at = ntp__at(mask, x, y);
    return mask->type == NTP_TYPE_U8 ? *(const uint8_t *) at == 0 : *(const uint16_t *) at == 0;
}

void ntp__find_holes(bool hole[NTP__BLOCK], const ntp__slopes *slopes, const ntp_const_image *mask,
                     const ntp__block *block, int32_t x, int32_t y, int32_t n)
{
    int32_t m = ntp__max(slopes->src->type);
    if (mask == NULL && !ntp__any_suspect(block, n, m)) {
        memset(hole, 0, (size_t) n * sizeof *hole);
        return;
    }
    for (int32_t i = 0; i < n; i++)
        hole[i] = (mask != NULL && masked_out(mask, x + i, y)) ||
                  ntp__texel_unused(block, i, m, slopes->touch_unused);
}
