/* SPDX-License-Identifier: MIT */
/*
 * layer_occlusion.h - ambient occlusion of a whole layer of heights, made once
 */
#ifndef NTP_GEGL_LAYER_OCCLUSION_H
#define NTP_GEGL_LAYER_OCCLUSION_H

#include <gegl-plugin.h>

#include "../smooth.h"
#include "pixels.h"

typedef struct layer_occlusion {
    ntp_image map; /* without data: not known */
    gchar *with;   /* what it depends on, but for the input */
} layer_occlusion;

/* The heights on which it depends. */
typedef struct occluded {
    GeglOperation *operation; /* shows progress */
    GeglBuffer *input;
    pixels in;
    const GeglRectangle *edges;
    smoothing forms;
    ntp_normals_options how; /* with the scale */
} occluded;

/* Finds it, in samples of this type, unless it is known. */
gboolean layer_occlusion_make(layer_occlusion *l, const occluded *of, ntp_type type);

/* For new heights. */
void layer_occlusion_forget(layer_occlusion *l);

#endif
