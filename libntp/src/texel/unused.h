/* SPDX-License-Identifier: MIT */
/*
 * unused.h - the texels that hold no normal
 */
#ifndef NTP_UNUSED_H
#define NTP_UNUSED_H

#include "base/view.h"

/* Does texel i hold no normal?  Floats that are no vector do not.  m is M of the levels. */
bool ntp__texel_unused(const ntp__block *block, int32_t i, int32_t m, uint32_t touch_unused);

/* May one of the first n texels hold no normal?  m has all its bits set. */
bool ntp__any_suspect(const ntp__block *block, int32_t n, int32_t m);

#endif
