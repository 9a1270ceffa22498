/* SPDX-License-Identifier: MIT */
/*
 * refine.h - changes heights until their normals round to the texture
 */
#ifndef NTP_REFINE_H
#define NTP_REFINE_H

#include "to_height/round_trip.h"

/* Working memory; the round trip comes from the caller. */
size_t ntp__refine_scratch(const ntp__height_plan *plan, int32_t parts);

/*
 * Improves the heights in dst in up to plan->refine rounds.  dst always holds the heights that
 * differ in the fewest texels, also after NTP_ERR_CANCELLED.  Of the result it sets `rounds` and
 * `refine_left`.  holes: texels that the solver gave no height.
 */
ntp_status ntp__refine(const ntp_image *dst, ntp__round_trip *trip, const ntp__height_plan *plan,
                       bool holes, void *scratch, const ntp_hooks *hooks,
                       ntp_height_result *result);

#endif
