/* SPDX-License-Identifier: MIT */
/*
 * relief_scale.h - the scale that --scale auto stands for
 */
#ifndef NTP_CLI_RELIEF_SCALE_H
#define NTP_CLI_RELIEF_SCALE_H

#include "libntp.h"

/* Multiplies *scale by the one that shows the relief of these heights, see ntp_relief_scale.  The
 * heights are the whole image; of the options those count that ntp_relief_add names. */
ntp_status heights_suit_scale(const ntp_const_image *heights, const ntp_normals_options *how,
                              double *scale);

#endif
