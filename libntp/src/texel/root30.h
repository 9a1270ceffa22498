/* SPDX-License-Identifier: MIT */
/*
 * root30.h - the square root of the texel kernels
 */
#ifndef NTP_ROOT30_H
#define NTP_ROOT30_H

#include <math.h>
#include <stdint.h>

/* floor(sqrt(e)) for 0 <= e < 2^30: the float root is right or one too great (shown for every e
 * by tests/unit/test_kernels.c). */
static inline int32_t ntp__root30(int32_t e)
{
    int32_t t = (int32_t) sqrtf((float) e);
    return t - (t * t > e);
}

#endif
