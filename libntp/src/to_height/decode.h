/* SPDX-License-Identifier: MIT */
/*
 * decode.h - what the levels of a texture mean, and whether its blue is to be trusted
 */
#ifndef NTP_DECODE_H
#define NTP_DECODE_H

#include "base/view.h"
#include "to_height/shared/height_plan.h"

/*
 * Replaces NTP_DECODE_AUTO in plan->decode if the texture shows another rule than (2c - M)/M.  Else
 * AUTO stays, and ntp__slopes_init looks for a pile of neutral levels later.  Replaces NTP_Z_AUTO
 * in plan->z always.
 */
void ntp__decode_by_evidence(ntp__height_plan *plan, const ntp_const_image *src);

#endif
