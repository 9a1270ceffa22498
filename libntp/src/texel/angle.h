/* SPDX-License-Identifier: MIT */
/*
 * angle.h - sums of angles that merge exactly: of a measurement and of a comparison
 */
#ifndef NTP_ANGLE_H
#define NTP_ANGLE_H

#include "libntp.h"

enum {
    NTP__ANGLE_BINS = 180001 /* of 0.001 degrees */
};

/* Angles in micro-degrees. */
typedef struct ntp__angle_sums {
    uint64_t texels, sum, max;
    uint32_t bins[NTP__ANGLE_BINS];
} ntp__angle_sums;

/* Adds `count` texels with this angle, of at most 180 degrees. */
static inline void ntp__angles_add(ntp__angle_sums *angles, uint32_t angle, uint32_t count)
{
    angles->texels += count;
    angles->sum += (uint64_t) angle * count;
    angles->bins[(angle + 500) / 1000] += count;
    if (angle > angles->max)
        angles->max = angle;
}

/* Makes the sums empty again. */
void ntp__angles_clear(ntp__angle_sums *angles);

void ntp__angles_merge(ntp__angle_sums *into, const ntp__angle_sums *from);

/* p99 is the middle of the bin in which the texel of that rank lies. */
void ntp__angles_describe(ntp_angles *out, const ntp__angle_sums *sums);

#endif
