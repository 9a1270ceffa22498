/* SPDX-License-Identifier: MIT */
/*
 * blending.h - what GIMP does with a result, and 16-bit results that its blending leaves as they are
 *
 * Where something is selected, GIMP 3 blends what a filter makes into the layer, in linear light.
 * babl takes 16-bit samples of a gamma curve there and back by approximations: at gamma 2.2 four
 * levels of five come back as another.  So where a mask follows, the result is handed over in linear
 * light already, as numbers of which babl makes the right levels.
 */
#ifndef NTP_GEGL_BLENDING_H
#define NTP_GEGL_BLENDING_H

#include "pixels.h"

typedef enum ahead {
    AHEAD_OTHER, /* another program, or not known */
    AHEAD_LAYER, /* the result replaces the layer, in the layer's format */
    AHEAD_MASK   /* it is blended into the layer by a mask */
} ahead;

/* To be asked by prepare(): when GIMP puts the graph together it prepares anew. */
ahead blending_ahead(GeglOperation *operation);

typedef struct blending blending;

/*
 * For a result that is blended into a layer that is stored so: the format to put out instead of
 * samples, of texels made by blending_put; NULL: samples are right.  *b begins as NULL and ends in
 * blending_free.
 */
const Babl *blending_prepare(blending **b, const pixels *stored);

/* From finished 16-bit texels without gaps, with an alpha channel or without. */
void blending_put(const blending *b, gint channels, const guint16 *texels, gfloat *light,
                  gsize count);

void blending_free(blending *b);

#endif
