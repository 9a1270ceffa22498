/* SPDX-License-Identifier: MIT */
/*
 * occlusion.h - ambient occlusion for the blue channel that x and y leave free
 */
#ifndef NTP_GIMP_OCCLUSION_H
#define NTP_GIMP_OCCLUSION_H

#include "libntp.h"

/*
 * Fills plane, one packed channel, with the occlusion of the whole heightfield that `how` reads, as
 * `ntp occlusion` does: without a radius, and beyond edges that do not wrap is nothing.  hooks as
 * for ntp_occlusion.  Returns NTP_ERR_SCRATCH without memory.
 */
ntp_status occlusion_make(const ntp_image *plane, const ntp_const_image *heights,
                          const ntp_normals_options *how, const ntp_hooks *hooks);

/* Stores an area of the plane in blue.  (x, y) is the place of the area's first texel in it. */
void occlusion_put(const ntp_image *view, const ntp_rect *area, const ntp_image *plane, int32_t x,
                   int32_t y);

#endif
