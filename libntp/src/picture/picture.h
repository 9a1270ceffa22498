/* SPDX-License-Identifier: MIT */
/*
 * picture.h - checks and pixels for the operations that paint a picture of a texture
 *
 * This room makes pictures for people to look at, and compares two textures.
 *   heatmap.c             ntp_heatmap: what is wrong with each texel
 *   shade.c               ntp_shade: a lit preview
 *   compare.c             ntp_diff_...: differences of two textures, with a heatmap of them
 *   compare_avx2.h, .c    their sums for packed RGB, where there is AVX2
 *   compare_avx512.c      and where there is AVX-512
 *   small_angles.h        numbers of both
 *   paint_avx2.h, .c      heatmaps and previews of packed RGB, where there is AVX2
 *   picture_kernels.h     the loops of all
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

enum { NTP__GROUP = 16, NTP__CHECKER = 8 /* the side of a field, in texels */ };

/* 0 or 1: the kind of field of a checker. */
static inline int32_t ntp__checker(int32_t x, int32_t y)
{
    return (x / NTP__CHECKER + y / NTP__CHECKER) % 2;
}

/* Loops over whole groups have no remainder, which would be code of its own for each. */
static inline int32_t ntp__whole(int32_t n)
{
    return (n + NTP__GROUP - 1) / NTP__GROUP * NTP__GROUP;
}

/* Makes the last group of n texels whole, with black ones. */
void ntp__fill_group(ntp__block *block, int32_t n);

/* Texels of packed RGB that loops leave over, from anywhere. */
typedef struct ntp__odd_texels {
    ntp__block block; /* of whole groups */
    int32_t n, x[NTP__BLOCK], y[NTP__BLOCK];
} ntp__odd_texels;

/* How packed RGB is painted.  `paint` sets bits of odd texels, and returns how many there are (as in
 * paint_avx2.h).  Those that are black or white, and unused for it, become a gray of
 * unused[white][checker]; `again` makes the colors of the others. */
typedef struct ntp__painter {
    const ntp_image *dst;
    const ntp_const_image *src;
    const void *job;
    uint32_t touch_unused;
    uint8_t unused[2][2];
    int32_t (*paint)(const void *job, uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src,
                     int32_t n, bool deep);
    void (*again)(const void *job, ntp__block *out, const ntp__odd_texels *odd);
} ntp__painter;

/* Paints packed RGB with memory of its own, where there is AVX2; false: there is another way only. */
bool ntp__paint_packed(const ntp__painter *painter, const ntp_rect *rect);

/* Writes n opaque pixels, whose alpha need not be set. */
void ntp__pack_opaque(const ntp_image *dst, ntp__block *rgb, int32_t x, int32_t y, int32_t n);

#endif
