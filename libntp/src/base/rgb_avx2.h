/* SPDX-License-Identifier: MIT */
/*
 * rgb_avx2.h - packed RGB to planes and back with AVX2
 */
#ifndef NTP_RGB_AVX2_H
#define NTP_RGB_AVX2_H

#include "base/view.h"

/* Three planes of n <= NTP__BLOCK packed pixels of 8 bit, or 16 (deep); values of planes after the
 * first n change. */
void ntp__unpack_rgb_avx2(ntp__block *block, const void *src, int32_t n, bool deep);

/* The other way round. */
void ntp__pack_rgb_avx2(void *dst, const ntp__block *block, int32_t n, bool deep);

#endif
