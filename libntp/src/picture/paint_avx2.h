/* SPDX-License-Identifier: MIT */
/*
 * paint_avx2.h - lit previews and heatmaps of packed RGB, with AVX2 and with AVX-512
 */
#ifndef NTP_PAINT_AVX2_H
#define NTP_PAINT_AVX2_H

#include "picture/picture.h"
#include "picture/picture_kernels.h"

/* These paint n <= NTP__BLOCK packed pixels of 8 bit, or 16 (deep), in the standard encoding; dst is not src.
 * Bit i % 8 of odd[i / 8] is set where pixel i may be wrong, also black and white ones; they return how
 * many are. */

/* All colors reflect `own` of the light. */
typedef int32_t ntp__shade_rgb(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src,
                               int32_t n, bool deep, const ntp__lamp *lamp, float own);
ntp__shade_rgb ntp__shade_rgb_avx2, ntp__shade_rgb_avx512;

/* Adds those of n from x, y on that have their bits, but for unused ones: these are painted.  Backgrounds are full
 * of them. */
void ntp__gather_odd_avx2(const ntp__painter *p, ntp__odd_texels *odd,
                          const uint8_t bits[NTP__BLOCK / 8], int32_t x, int32_t y, int32_t n);

/* By the reference palette. */
typedef int32_t ntp__heat_rgb(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src, int32_t n,
                              bool deep, const ntp__limits *limits);
ntp__heat_rgb ntp__heat_rgb_avx2, ntp__heat_rgb_avx512;

#endif
