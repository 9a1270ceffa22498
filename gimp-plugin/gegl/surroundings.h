/* SPDX-License-Identifier: MIT */
/*
 * surroundings.h - the texels from which an area is made, read beyond edges that wrap
 */
#ifndef NTP_GEGL_SURROUNDINGS_H
#define NTP_GEGL_SURROUNDINGS_H

#include "pixels.h"

/*
 * An area and `reach` texels on each side of it.  Where the border wraps it may begin before the
 * edge and end beyond it; otherwise it ends there.
 */
GeglRectangle surroundings_of(const GeglRectangle *area, const GeglRectangle *edges, gint reach,
                              gboolean wrap_x, gboolean wrap_y);

/* The smallest area inside the edges that contains all of it after wrapping. */
GeglRectangle surroundings_wrapped(const GeglRectangle *area, const GeglRectangle *edges);

/* Reads an area that may lie partly beyond the edges, where the picture is repeated. */
void surroundings_read(GeglBuffer *input, const pixels *in, const GeglRectangle *edges,
                       const GeglRectangle *area, guchar *data);

#endif
