/* SPDX-License-Identifier: MIT */
/*
 * ends_meet.h - do the heights of a damaged texture end as they begin?
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

typedef enum ntp__ends {
    NTP__ENDS_UNTOLD,
    NTP__ENDS_MEET,  /* wrap is likely to cost the heights less than a free border */
    NTP__ENDS_DIFFER /* by steps that slopes along lines and slopes across them show alike */
} ntp__ends;

/* How heights end along x or (down) along y.  It is told only where lengths show that texels are
 * damaged, and z is not derived.  Of `how` it takes decode, z and unused texels.  Both sides are 16 or
 * more, and texels are square. */
ntp__ends ntp__find_ends(ntp__reading *reading, const ntp_const_image *src,
                         const ntp_height_options *how, bool down);

#endif
