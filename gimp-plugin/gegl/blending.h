/* SPDX-License-Identifier: MIT */
/*
 * blending.h - what GIMP does with a result, and 16-bit results that survive its blending
 *
 * If there is a selection, GIMP 3 blends the result of a filter into the layer, in linear light.
 * babl converts 16-bit samples of a gamma curve to linear light and back by approximations: at
 * gamma 2.2 four of five levels change.  So if a mask follows, the operation outputs linear light,
 * as numbers that babl converts to the right levels.
 */
#ifndef NTP_GEGL_BLENDING_H
#define NTP_GEGL_BLENDING_H

#include "pixels.h"

typedef enum ahead {
    AHEAD_OTHER, /* another program, or not known */
    AHEAD_LAYER, /* the result replaces the layer, in the layer's format */
    AHEAD_MASK   /* it is blended into the layer by a mask */
} ahead;

/* To be called by prepare(): GIMP prepares again when it builds the graph. */
ahead blending_ahead(GeglOperation *operation);

typedef struct blending blending;

/*
 * For a result that is blended into a layer stored in this format: the output format to use
 * instead, for texels made by blending_put.  NULL: output samples as they are.  *b is NULL at first
 * and stays valid.
 */
const Babl *blending_prepare(const blending **b, const pixels *stored);

/* From finished 16-bit texels without gaps, with an alpha channel or without. */
void blending_put(const blending *b, gint channels, const guint16 *texels, gfloat *light,
                  gsize count);

#endif
