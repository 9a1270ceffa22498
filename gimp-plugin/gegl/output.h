/* SPDX-License-Identifier: MIT */
/*
 * output.h - finished texels go to GEGL
 */
#ifndef NTP_GEGL_OUTPUT_H
#define NTP_GEGL_OUTPUT_H

#include "blending.h"

/* Outputs a block of texels, the first of its rows and the bytes from one to the next; in the form
 * for GIMP's blending if that is the format. */
void output_write(GeglBuffer *output, const Babl *format, const GeglRectangle *block,
                  const pixels *made, const guchar *first, gint stride, const blending *b);

#endif
