/* SPDX-License-Identifier: MIT */
/*
 * decode.h - what the levels of a texture mean, and whether its blue is to be trusted
 */
#ifndef NTP_DECODE_H
#define NTP_DECODE_H

#include "base/view.h"
#include "to_height/shared/height_plan.h"

/*
 * Replaces NTP_DECODE_AUTO and NTP_Z_AUTO in the plan by what up to 256 rows of the texture show.
 * For NTP_Z_AUTO it finds out below which z blue tells nothing, too.
 */
void ntp__decode_by_evidence(ntp__height_plan *plan, const ntp_const_image *src);

#endif
