/* SPDX-License-Identifier: MIT */
/*
 * ends_meet.h - is wrap the better guess for a damaged texture?
 */
#ifndef NTP_ENDS_MEET_H
#define NTP_ENDS_MEET_H

#include "base/view.h"
#include "to_height/shared/height_plan.h"

/* What both axes have in common; it begins with `known` false. */
typedef struct ntp__reading {
    bool known;
    ntp__height_plan plan; /* how a solver with free borders reads the texture */
} ntp__reading;

/* Is wrap likely to cost the heights less than a free border, along x or (down) along y?  Only where
 * lengths show that texels are damaged, and z is not derived.  Of `how` it takes decode, z and unused
 * texels.  Both sides are 16 or more, and texels are square. */
bool ntp__ends_meet(ntp__reading *reading, const ntp_const_image *src,
                    const ntp_height_options *how, bool down);

#endif
