/* SPDX-License-Identifier: MIT */
/*
 * lit.h - the result as a lit surface, in place of its numbers
 */
#ifndef NTP_GEGL_LIT_H
#define NTP_GEGL_LIT_H

#include "pixels.h"

/* A light from that direction: degrees from the right, counterclockwise, and above the surface. */
ntp_light lit_light(gdouble from, gdouble height);

/* Shows the normals of a view, lit, in a picture of this type that does not overlap it. */
gboolean lit_paint(const pixels *p, const ntp_image *dst, const ntp_const_image *normals,
                   const ntp_light *light, const ntp_rect *area);

#endif
