/* SPDX-License-Identifier: MIT */
/*
 * luminance.h - the luminance of colors, as GIMP's own Normal Map filter takes it for the height
 *
 * It is the sum of red, green and blue in linear light, by the weights of the color space, in its
 * transfer curve.  babl does the same in single precision, on a way that it chooses by timing when
 * a program starts, so two programs may get different numbers.  Here the formula of the curve is
 * evaluated in double precision and rounded once.
 */
#ifndef NTP_LUMINANCE_H
#define NTP_LUMINANCE_H

#include <babl/babl.h>
#include <glib.h>

typedef struct luminance luminance;

/*
 * How to make it of colors that are stored in that format: R'G'B' or another curve, with alpha or
 * without, as u8, u16 or float.  NULL: the curve of the space is neither linear nor that of sRGB nor
 * a power, but a table of a profile, say.  Kept until the program ends.
 */
const luminance *luminance_of(const Babl *stored);

/* Makes it of `count` colors; each alpha follows it if that is wanted.  Gray is what it is. */
void luminance_make(const luminance *l, gconstpointer colors, gfloat *made, gsize count,
                    gboolean alpha);

#endif
