/* SPDX-License-Identifier: MIT */
/*
 * heights.h - the heights of a layer: read, made relative to the mean color, smoothed
 */
#ifndef NTP_PLUGIN_HEIGHTS_H
#define NTP_PLUGIN_HEIGHTS_H

#include "../smooth.h"
#include "raster.h"

/* What "biased" subtracts from each color sample, in the numbers of the samples. */
typedef struct bias {
    double mean[3];
} bias;

job_status bias_find(bias *b, const raster *r);
void bias_take_off(const bias *b, const raster *r, void *rows, int32_t count);

/* Reads rows from `first` on; those beyond an edge from the other end. */
bool heights_read(const raster *r, int32_t first, int32_t count, unsigned char *to);

/* Smoothed heights in memory: floats, with the alpha of the layer if it has one. */
typedef struct smoothed {
    raster raster;
    float *data;
} smoothed;

/* Smooths what `how` reads of a layer, with its borders. */
job_status smoothed_make(smoothed *made, const smoothing *forms, const ntp_normals_options *how,
                         bool biased, const raster *heights, const surroundings *around);
void smoothed_free(smoothed *made);

#endif
