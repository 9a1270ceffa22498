/* SPDX-License-Identifier: MIT */
/*
 * layer_scale.h - the scale that suits a layer of heights, measured once
 */
#ifndef NTP_GEGL_LAYER_SCALE_H
#define NTP_GEGL_LAYER_SCALE_H

#include "pixels.h"

/* The scale, and what it depends on. */
typedef struct layer_scale {
    gboolean measured;
    gdouble value;
    ntp_normals_options of;
    const Babl *format; /* the luminance is read as red of another format */
    GeglRectangle edges;
} layer_scale;

/* Is it that of heights that are read in this format, with these options? */
gboolean layer_scale_is_known(const layer_scale *s, const ntp_normals_options *how,
                              const Babl *format, const GeglRectangle *edges);

/* Measures it on some rows of the input. */
void layer_scale_measure(layer_scale *s, const ntp_normals_options *how, const pixels *in,
                         GeglBuffer *input, const GeglRectangle *edges);

#endif
