/* SPDX-License-Identifier: MIT */
/*
 * smooth.h - heights blurred, and their small, middle and large forms weighed
 *
 * What `ntp from-height --blur B --octaves S,0,M-S,0,L-M` does.  The large forms are the heights
 * blurred by 8 texels, the middle ones those by 2 without the large ones, the small ones the rest;
 * so weights of 1 give the heights back.
 */
#ifndef NTP_GIMP_SMOOTH_H
#define NTP_GIMP_SMOOTH_H

#include "libntp.h"

#include <stdbool.h>

typedef struct smoothing {
    double blur;                 /* sigma, in texels */
    double small, middle, large; /* weights */
} smoothing;

/* Does it change heights? */
bool smoothing_acts(const smoothing *s);

/* How many texels on each side of a texel matter. */
int32_t smoothing_reach(const smoothing *s);

/* Channels of the result: with the alpha of heights of so many channels, if they have it. */
int32_t smoothing_channels(int32_t channels);

/*
 * Smooths the heights that `how` reads, with its borders.  out: NTP_TYPE_F32 NTP_ENCODING_HEIGHT of
 * smoothing_channels; then NTP_HEIGHT_SOURCE_RED is the height.  Returns NTP_ERR_SCRATCH without
 * memory.
 */
ntp_status smoothing_run(const smoothing *s, const ntp_image *out, const ntp_const_image *heights,
                         const ntp_normals_options *how);

#endif
