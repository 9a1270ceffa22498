/* SPDX-License-Identifier: MIT */
/*
 * level_edges.h - are edges level, as a mirror leaves them?
 */
#ifndef NTP_LEVEL_EDGES_H
#define NTP_LEVEL_EDGES_H

#include "base/view.h"

/* Does no texel of the left and the right edge (down: of the upper and the lower one) slope across its edge,
 * by more than damage makes it, though those beside them do?  Sides below 16 texels do not tell. */
bool ntp__edges_are_level(const ntp_const_image *src, bool down);

#endif
