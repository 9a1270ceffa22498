/* SPDX-License-Identifier: MIT */
/*
 * between.h - do slopes lie between texels?
 */
#ifndef NTP_BETWEEN_H
#define NTP_BETWEEN_H

#include "base/view.h"

/* Are slopes to the right those half a texel to the right of a texel, and slopes down those half a
 * texel below it, as forward differences are?  Sides below 44 texels do not tell. */
bool ntp__lie_between(const ntp_const_image *src);

#endif
