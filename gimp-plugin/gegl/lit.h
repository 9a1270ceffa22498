/* SPDX-License-Identifier: MIT */
/*
 * lit.h - the result as a lit surface, in place of its numbers
 */
#ifndef NTP_GEGL_LIT_H
#define NTP_GEGL_LIT_H

#include "pixels.h"

/* A light from that direction: degrees from the right, counterclockwise, and above the surface. */
ntp_light lit_light(gdouble from, gdouble height);

/* Shows the normals of an area of a view, lit, in a picture of this type that does not overlap it.  x, y: where
 * the area begins in the layer, whose unused texels show one checker however it is cut into parts. */
gboolean lit_paint(const pixels *p, const ntp_image *dst, const ntp_image *normals,
                   const ntp_light *light, const ntp_rect *area, gint x, gint y);

#endif
