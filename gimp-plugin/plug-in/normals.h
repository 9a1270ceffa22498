/* SPDX-License-Identifier: MIT */
/*
 * normals.h - the job of plug-in-ntp-normals-from-height, without GIMP
 *
 * Bands of rows are read, libntp makes normals from them, and they are written: any height with
 * little memory.
 */
#ifndef NTP_PLUGIN_NORMALS_H
#define NTP_PLUGIN_NORMALS_H

#include "../channels.h"
#include "fields.h"
#include "heights.h"
#include "raster.h"

typedef enum alpha_rule {
    ALPHA_KEEP,
    ALPHA_ONE,
    ALPHA_ZERO,
    ALPHA_INVERSE,
    ALPHA_HEIGHT,
    ALPHA_INVERSE_HEIGHT,
    ALPHA_LAYER
} alpha_rule;

/* x and y alone, as the DU/DV of gimp-normalmap.  Signed ones are SNORM of Direct3D, two's
 * complement. */
typedef enum dudv_format {
    DUDV_NONE,
    DUDV_8_SIGNED,
    DUDV_8_UNSIGNED,
    DUDV_16_SIGNED, /* in 8-bit layers over red and green, blue and alpha, low byte first */
    DUDV_16_UNSIGNED
} dudv_format;

typedef struct normals_job {
    ntp_normals_options how;
    smoothing forms; /* of the heights, before everything but the scale that suits them */
    ntp_y y;
    ntp_encoding encoding;
    alpha_rule alpha;
    dudv_format dudv;
    bool
        luminance; /* heights are a layer's luminance, which is not made here: the luma without it */
    bool biased;   /* the height is the luma of the color minus the mean color */
    bool swap;     /* exchange red and blue */
    bool dithers;  /* in 8 and 16 bit */
    bool occludes; /* blue, if it is free, is ambient occlusion */
    bool flipped;  /* red points left: the scale has the other sign */
    channel_order channels;
    bool measures; /* the scale is still to be multiplied by the one that suits the heights */
} normals_job;

/* The job for the settings of PROCEDURE_NORMALS. */
normals_job normals_job_from(const settings *s);

/* Measures the heights, if the settings name no scale; normals_job_run does so by itself. */
job_status normals_job_find_scale(normals_job *job, const raster *heights);

/* Makes the smoothed heights that the job asks for, and changes the job to one of these; without
 * data: as they are.  normals_job_run does so by itself. */
job_status normals_job_smooth(normals_job *job, smoothed *made, const raster *heights,
                              const surroundings *around);

/* Does the result need an alpha channel in a layer of this type? */
bool normals_job_needs_alpha(const normals_job *job, ntp_type type);

/*
 * heights: the layer from which the height is read.  layer: where its alpha is, or NULL; alpha: the
 * plane's layer for ALPHA_LAYER, or NULL.  result is written; it has 3 or 4 channels.  All but
 * `alpha` have one size.  area NULL: everything.
 */
job_status normals_job_run(const normals_job *job, const raster *heights, const raster *layer,
                           const raster *alpha, const raster *result, const ntp_rect *area,
                           const surroundings *around);

#endif
