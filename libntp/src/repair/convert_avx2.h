/* SPDX-License-Identifier: MIT */
/*
 * convert_avx2.h - packed RGB between the two encodings with a Z, and between depths, with AVX2
 */
#ifndef NTP_CONVERT_AVX2_H
#define NTP_CONVERT_AVX2_H

#include "repair/convert.h"

/*
 * Converts the texels of row y from column x on, of levels of packed RGB, without a flip.  Returns
 * how many of n are done, a multiple of 16: it stops before texels that have to be pulled or kept,
 * and before the last ones.  Adds to *negative how many negative z became |z|.
 */
int32_t ntp__convert_rgb_avx2(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                              uint64_t *negative);

#endif
