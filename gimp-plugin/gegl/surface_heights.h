/* SPDX-License-Identifier: MIT */
/*
 * surface_heights.h - the heights behind normals, as `ntp` finds them where nothing is told
 */
#ifndef NTP_GEGL_SURFACE_HEIGHTS_H
#define NTP_GEGL_SURFACE_HEIGHTS_H

#include "libntp.h"

#include <stdbool.h>

/* heights: floats, as large as the normals.  wrap: the borders that are told to wrap. */
ntp_status surface_heights(const ntp_image *heights, const ntp_const_image *normals,
                           const bool wrap[2], const ntp_hooks *hooks);

#endif
