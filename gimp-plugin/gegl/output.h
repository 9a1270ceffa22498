/* SPDX-License-Identifier: MIT */
/*
 * output.h - finished texels go to GEGL
 */
#ifndef NTP_GEGL_OUTPUT_H
#define NTP_GEGL_OUTPUT_H

#include "blending.h"

/* For prepare(): sets the formats of the input and of a result that has its colors, and returns the
 * form of the input.  *b is NULL at first. */
pixels output_formats(GeglOperation *operation, const blending **b);

/* Outputs a block of texels, the first of its rows and the bytes from one to the next; in the form
 * for GIMP's blending if that is the format. */
void output_write(GeglBuffer *output, const Babl *format, const GeglRectangle *block,
                  const pixels *made, const guchar *first, gint stride, const blending *b);

#endif
