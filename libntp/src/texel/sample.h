/* SPDX-License-Identifier: MIT */
/*
 * sample.h - single samples of heights and normals, where speed does not matter
 */
#ifndef NTP_SAMPLE_H
#define NTP_SAMPLE_H

#include "base/view.h"

/* A stored sample: levels as they are, floats too. */
static inline double ntp__sample(const ntp_const_image *v, int32_t x, int32_t y, int32_t channel)
{
    const void *at = ntp__at(v, x, y);
    if (v->type == NTP_TYPE_U8)
        return ((const uint8_t *) at)[channel];
    if (v->type == NTP_TYPE_U16)
        return ((const uint16_t *) at)[channel];
    return (double) ((const float *) at)[channel];
}

#endif
