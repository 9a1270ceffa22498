/* SPDX-License-Identifier: MIT */
/*
 * ends_meet.h - is wrap the better guess for a damaged texture?
 */
#ifndef NTP_ENDS_MEET_H
#define NTP_ENDS_MEET_H

#include "base/view.h"

/* Is wrap likely to cost the heights less than a free border, along x or (down) along y?  Only where
 * lengths show that texels are damaged, and z is not derived.  Of `how` it takes decode, z and unused
 * texels.  Both sides are 16 or more, and texels are square. */
bool ntp__ends_meet(const ntp_const_image *src, const ntp_height_options *how, bool down);

#endif
