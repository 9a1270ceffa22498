/* SPDX-License-Identifier: MIT */
/*
 * block.h - a block on its way from texels to bytes
 */
#ifndef NTP_BLOCK_H
#define NTP_BLOCK_H

#include "base/view.h"
#include "compress/search.h"

/* 16-bit levels; `seen`: the texel lies inside the picture. */
typedef struct ntp__block_levels {
    int32_t level[2][NTP__TEXELS];
    uint8_t seen[NTP__TEXELS];
} ntp__block_levels;

/* One channel: each texel has one value of the palette, counted from the low end. */
typedef struct ntp__coded {
    ntp__ends ends;
    uint8_t chosen[NTP__TEXELS];
} ntp__coded;

void ntp__want_levels(ntp__wanted *wanted, const ntp__block_levels *block, int32_t channel);

/* Makes the mean angle between the normals and those of the texels smaller, or leaves it. */
void ntp__code_by_angle(ntp__coded coded[2], const ntp__block_levels *block);

#endif
