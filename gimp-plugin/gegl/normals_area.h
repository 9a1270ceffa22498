/* SPDX-License-Identifier: MIT */
/*
 * normals_area.h - normals of an area of a layer of heights, block by block
 */
#ifndef NTP_GEGL_NORMALS_AREA_H
#define NTP_GEGL_NORMALS_AREA_H

#include "../presets.h"
#include "../smooth.h"
#include "blending.h"

typedef struct normals_area {
    recipe recipe;           /* the settings */
    ntp_normals_options how; /* theirs with the scale, and with borders for what was read */
    smoothing forms;
    pixels in, out;
    const GeglRectangle *edges; /* of the layer */
    const Babl *format;         /* of the output */
    const blending *blending;
    const ntp_light *light; /* NULL: output the normals */
    const ntp_image *open;  /* ambient occlusion of the layer for blue, or NULL */
    void *errors;           /* of dithering, which begins with the first row; NULL: none */
    /* memory of normals_area_make */
    guchar *heights, *normals;
    GeglRectangle smoothed; /* what of the layer `smooth` has */
    ntp_image smooth;       /* without data: heights are read for each block */
} normals_area;

/* How far the heights lie on which a normal depends. */
gint normals_area_reach(const ntp_normals_options *how, const smoothing *forms);

/* What is read for an area, chosen so that borders act on this part as they do on the whole. */
GeglRectangle normals_area_reads(const ntp_normals_options *how, const smoothing *forms,
                                 const GeglRectangle *area, const GeglRectangle *edges);

/* Makes an area, and outputs what is wanted of it. */
gboolean normals_area_make(normals_area *j, GeglBuffer *input, GeglBuffer *output,
                           const GeglRectangle *area, const GeglRectangle *wanted);

#endif
