/* SPDX-License-Identifier: MIT */
/*
 * convert.h - what the two parts of ntp_convert share
 */
#ifndef NTP_CONVERT_H
#define NTP_CONVERT_H

#include "base/view.h"
#include "texel/kernels.h"
#include "texel/level.h"

typedef struct ntp__conversion {
    const ntp_image *dst;
    const ntp_const_image *src;
    ntp_convert_options how;
    int32_t ms, md; /* M of source and target; floats count as 16 bit */
    bool flip;
    const ntp__kernels_table *kernels;
} ntp__conversion;

/* Level c at the new depth; ntp__narrow without its division. */
static inline int32_t ntp__deepen(int32_t c, int32_t ms, int32_t md)
{
    return ms == md ? c : ms < md ? c * 257 : (255 * c + 32895) >> 16;
}

/* floor(v M + 1/2), clamped; exact, see ntp__level_of_unit. */
static inline int32_t ntp__level_of(double v, int32_t m)
{
    double c = v * m + 0.5;
    c = c > 0 ? c : 0; /* of NaN, too; one instruction each, as noise would mislead branches */
    c = c < m ? c : m;
    return (int32_t) c;
}

/* Converts n texels of row y from column x on; how many at most, goes with the function. */
typedef void ntp__convert_fn(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                             ntp_convert_counts *counts);

/* The fast way for these views and options; NULL: there is none.  *most: texels at a time. */
ntp__convert_fn *ntp__fast_conversion(const ntp__conversion *j, int32_t *most);

/* Heights, and from float vectors: texel by texel; up to NTP__BLOCK of them. */
ntp__convert_fn ntp__convert_each;

/* To float vectors, up to NTP__BLOCK texels. */
ntp__convert_fn ntp__convert_to_vectors;

/* Integers of at least three channels, not XY, to packed float vectors, or any to biased floats without a flip:
 * n texels up to the whole row. */
ntp__convert_fn ntp__decode;

/* Packed samples of 8 or 16 bit to the same format, flipped if that is asked for; also of whole rows. */
ntp__convert_fn ntp__move_8, ntp__move_16;

/* The exact levels of one float vector, y as in the source; alpha is not set. */
void ntp__convert_vector(const ntp__conversion *j, const float raw[3], int32_t out[3],
                         ntp_convert_counts *counts);

#endif
