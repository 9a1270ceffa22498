/* SPDX-License-Identifier: MIT */
/*
 * finite.h - is a number neither infinite nor NaN?
 *
 * With some compilers isfinite and isnan of <math.h> call libm, from which the library takes only
 * square roots.  Infinity minus infinity is NaN, and NaN equals nothing.
 */
#ifndef NTP_FINITE_H
#define NTP_FINITE_H

#include <stdbool.h>

static inline bool ntp__is_finite(double v)
{
    return v - v == 0;
}

static inline bool ntp__is_nan(double v)
{
    return v != v;
}

#endif
