/* SPDX-License-Identifier: MIT */
/*
 * height.h - the job of plug-in-ntp-height-from-normals, without GIMP
 */
#ifndef NTP_PLUGIN_HEIGHT_H
#define NTP_PLUGIN_HEIGHT_H

#include "fields.h"
#include "raster.h"

typedef struct height_job {
    ntp_height_options how;
    ntp_y y;
    ntp_encoding encoding;
    bool invert;
    double contrast; /* 0..1: stretches about the middle by 1 + contrast */
} height_job;

/* True if a report on the layer has to decide the encoding. */
bool height_finds_out(const settings *s);

/* The job for the settings of PROCEDURE_HEIGHT; an encoding to be found out is the standard. */
height_job height_job_from(const settings *s);

/*
 * The heights of a layer as a plane of its size, 0..1: the lowest texel 0, the highest 1; a flat
 * surface is 0.5. *range: how many texels the highest is above the lowest; with this scale the
 * plane, without contrast, makes the normals again.  The caller frees *plane.
 */
job_status height_job_run(const height_job *job, const raster *normals, float **plane,
                          double *range, const surroundings *around);

/* Writes the plane into all colors of an area of a layer; alpha is kept, or set to the height. */
job_status height_write(const float *plane, const raster *layer, const raster *result,
                        const ntp_rect *area, bool alpha_too);

#endif
