/* SPDX-License-Identifier: MIT */
/*
 * preview.h - what a dialog shows: texels of the result, and the lit surface, without GIMP
 */
#ifndef NTP_PLUGIN_PREVIEW_H
#define NTP_PLUGIN_PREVIEW_H

#include "report.h"

typedef struct preview {
    const procedure *procedure; /* normals, height or clean */
    const settings *settings;
    const raster *layer;
    const raster *heights;  /* another layer's height, or NULL */
    const report *found;    /* clean, if a report decides; or NULL */
    int32_t width, height;  /* pixels to fill */
    double x, y;            /* the texel position at their upper left corner */
    double step;            /* texels from one pixel to the next */
    const ntp_light *light; /* or NULL */
} preview;

/*
 * Fills packed RGB.  map gets the texels that the procedure will write, converted to 8 bits, one
 * under the middle of each pixel and never a mixture.  lit gets the plane with these normals.
 * Heights are an exception: they are made only from the texels under the pixels, as from a small
 * texture, and lit shows the normals as they are.  scale: the scale that suits the layer, if the
 * settings name none; otherwise it stays.
 */
job_status preview_render(const preview *p, uint8_t *map, uint8_t *lit, double *scale);

#endif
