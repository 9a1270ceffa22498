/* SPDX-License-Identifier: MIT */
/*
 * holes.h - the texels that get no height
 */
#ifndef NTP_HOLES_H
#define NTP_HOLES_H

#include "to_height/shared/slopes.h"

/* hole[i]: texel (x + i, y) holds no normal, or the mask, which may be NULL, is 0 there.  The block
 * holds the n texels from (x, y) on. */
void ntp__find_holes(bool hole[NTP__BLOCK], const ntp__slopes *slopes, const ntp_const_image *mask,
                     const ntp__block *block, int32_t x, int32_t y, int32_t n);

#endif
