/* SPDX-License-Identifier: MIT */
/*
 * gray_map.h - what the operations share that make a gray map of a layer
 */
#ifndef NTP_GEGL_GRAY_MAP_H
#define NTP_GEGL_GRAY_MAP_H

#include "pixels.h"

/* The picture; without edges, or without texels, the area itself. */
GeglRectangle gray_map_edges(GeglOperation *operation, const GeglRectangle *area);

/* Some samples of a map become gray pixels of the type of p, with the alpha of those that were
 * read. */
void gray_map_paint(guchar *made, const guchar *map, const guchar *read, const pixels *p,
                    gint count);

#endif
