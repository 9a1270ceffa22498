/* SPDX-License-Identifier: MIT */
/*
 * angle.h - angles between vectors of integers, and sums of angles that merge exactly
 */
#ifndef NTP_ANGLE_H
#define NTP_ANGLE_H

#include "libntp.h"

#include <string.h>

#define NTP__PI 3.14159265358979323846

extern const double ntp__atan_eighths[9]; /* atan(i/8) */

/*
 * The angle between two vectors of integers, in micro-degrees.  The arc tangent is our own, because
 * that of libm differs between systems.  |components| <= 2^17; neither vector is zero.
 */
uint32_t ntp__angle(int64_t x1, int64_t y1, int64_t z1, int64_t x2, int64_t y2, int64_t z2);

/* atan2(s, d) in radians, s >= 0, not both 0; off by less than 1e-14. */
double ntp__radians(double s, double d);

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

/* Counts n bins, each one more; changes the one after the last. */
static inline void ntp__count_angles(uint32_t *bins, int32_t *bin, int32_t n)
{
    bin[n] = 0; /* the partner of the last */
    for (int32_t i = 0; i < n; i += 2) {
        /* Two in one load, in either order: loads are what these loops wait for. */
        uint64_t two;
        memcpy(&two, bin + i, sizeof two);
        bins[(uint32_t) two]++;
        bins[two >> 32]++;
    }
    bins[0] -= (uint32_t) (n & 1);
}

/* Makes the sums empty again. */
void ntp__angles_clear(ntp__angle_sums *angles);

void ntp__angles_merge(ntp__angle_sums *into, const ntp__angle_sums *from);

/* p99 is the middle of the bin in which the texel of that rank lies. */
void ntp__angles_describe(ntp_angles *out, const ntp__angle_sums *sums);

#endif
