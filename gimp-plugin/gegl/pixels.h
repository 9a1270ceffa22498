/* SPDX-License-Identifier: MIT */
/*
 * pixels.h - the pixel formats in which the operations read and write
 *
 * Results are exact only if no color conversion happens.  So an operation takes the numbers of its
 * input as they are stored: same sample type, same color space, same transfer curve, and alpha if
 * the input has alpha.  Sample types that libntp does not know are converted to float.
 */
#ifndef NTP_GEGL_PIXELS_H
#define NTP_GEGL_PIXELS_H

#include <gegl.h>

#include "../luminance.h"
#include "libntp.h"

typedef struct pixels {
    const Babl *format;
    const Babl *stored;         /* what is read for these pixels: the same, but for a luminance */
    const luminance *luminance; /* how they are made of it; NULL: by babl */
    ntp_type type;
    gint channels; /* 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha */
    gint bytes;    /* of a pixel */
} pixels;

/* How to read an input of that format (NULL: not known yet) with its numbers unchanged. */
pixels pixels_of(const Babl *source);

/* The luminance of a colored input of that format, with alpha if it has alpha. */
pixels pixels_luminance(const Babl *source);

/* Reads a part of an input, whose rows begin `stride` bytes apart. */
void pixels_read(GeglBuffer *input, const pixels *p, const GeglRectangle *part, void *data,
                 gint stride);

/* RGB of the same sample type, space and transfer curve, with alpha or without. */
pixels pixels_as_rgb(const Babl *source, gboolean alpha);

/* A view of width x height pixels, rows without gaps, of heights or plain samples. */
ntp_image pixels_view(const pixels *p, void *data, gint width, gint height);

/*
 * The number that was typed.  XCF files store single precision: 7.3 is read back as 7.30000019.  A
 * number that may come from there means the decimal of up to 7 digits nearest to it, so that a
 * layer effect is the same after its file was opened again.
 */
gdouble pixels_as_typed(gdouble value);

#endif
