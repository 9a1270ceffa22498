/* SPDX-License-Identifier: MIT */
/*
 * picture.h - checks and pixels for the operations that paint a picture of a texture
 *
 * This room makes pictures for people to look at, and compares two textures.
 *   heatmap.c             ntp_heatmap: what is wrong with each texel
 *   shade.c               ntp_shade: a lit preview
 *   compare.c             ntp_diff_...: differences of two textures, with a heatmap of them
 *   compare_avx2.h, .c    their sums for packed RGB, where there is AVX2
 *   picture_kernels.h     their loops
 *   picture.h, picture.c  what these share
 */
#ifndef NTP_PICTURE_H
#define NTP_PICTURE_H

#include "base/view.h"

/*
 * Checks that dst is a U8 picture of src's size with min_channels to 4 channels, but not 2.  Its
 * memory is its own, or that of src with the same layout: a block is read whole before it is
 * written.
 */
ntp_status ntp__check_painting(const ntp_image *dst, const ntp_const_image *src,
                               int32_t min_channels);

/* Writes one opaque pixel. */
static inline void ntp__paint(uint8_t *pixel, int32_t channels, const uint8_t rgb[3])
{
    pixel[0] = rgb[0];
    if (channels == 1)
        return;
    pixel[1] = rgb[1];
    pixel[2] = rgb[2];
    if (channels == 4)
        pixel[3] = 255;
}

enum { NTP__GROUP = 16 };

/* Loops over whole groups have no remainder, which would be code of its own for each. */
static inline int32_t ntp__whole(int32_t n)
{
    return (n + NTP__GROUP - 1) / NTP__GROUP * NTP__GROUP;
}

/* Makes the last group of n texels whole, with black ones. */
void ntp__fill_group(ntp__block *block, int32_t n);

/* Writes n opaque pixels, whose alpha need not be set. */
void ntp__pack_opaque(const ntp_image *dst, ntp__block *rgb, int32_t x, int32_t y, int32_t n);

#endif
