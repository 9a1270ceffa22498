/* SPDX-License-Identifier: MIT */
/*
 * resize.h - a normals texture in another size, without GIMP
 */
#ifndef NTP_PLUGIN_RESIZE_H
#define NTP_PLUGIN_RESIZE_H

#include "fields.h"
#include "raster.h"

typedef struct resize_job {
    ntp_resize_options how;
    ntp_encoding encoding;
    int32_t width, height; /* of the result */
} resize_job;

/* The options of PROCEDURE_RESIZE. */
resize_job resize_job_from(const settings *s);

/* A side of that length by the settings: given is the width or height that they say, 0 for by
 * percent.  0: longer than NTP_MAX_SIDE. */
int32_t resize_side(const settings *s, double given, int32_t side);

/* Makes packed texels of the layer's channels and type; free them. */
job_status resize_job_run(const resize_job *job, const raster *layer, void **made,
                          const surroundings *around);

#endif
