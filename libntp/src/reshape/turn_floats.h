/* SPDX-License-Identifier: MIT */
/*
 * turn_floats.h - float texels that are only moved and mirrored
 */
#ifndef NTP_TURN_FLOATS_H
#define NTP_TURN_FLOATS_H

#include "base/view.h"

/* Red of the result is green of the source, and the other way round; then either is mirrored. */
typedef struct ntp__turning {
    bool swap, mirror_r, mirror_g;
} ntp__turning;

/* Turns n float texels from (x, y) on: 1 - v, rounded, or -v of vectors.  Unused ones, and all other samples, keep
 * their bits. */
void ntp__turn_floats(const ntp_image *dst, const ntp_const_image *src, const ntp__turning *how,
                      int32_t x, int32_t y, int32_t n);

#endif
