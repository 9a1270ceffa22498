/* SPDX-License-Identifier: MIT */
/*
 * finite.h - is a number neither infinite nor NaN?
 *
 * isfinite and isnan of <math.h> are calls into libm with some compilers, and the library takes
 * nothing but roots from there.  Infinity less infinity is NaN, and NaN equals nothing.
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
