/* SPDX-License-Identifier: MIT */
/*
 * decode.h - what the levels of a texture mean, and whether its blue is to be trusted
 */
#ifndef NTP_DECODE_H
#define NTP_DECODE_H

#include "base/view.h"
#include "to_height/shared/height_plan.h"

/*
 * Settles plan->decode where it is NTP_DECODE_AUTO and the texture shows another rule than that of
 * (2c - M)/M (else it stays: the pile of neutral levels is looked for later), and plan->z where it
 * is NTP_Z_AUTO.
 */
void ntp__decode_by_evidence(ntp__height_plan *plan, const ntp_const_image *src);

#endif
