/* SPDX-License-Identifier: MIT */
/*
 * judged.h - what the kernels find out about a texel beyond the flags of ntp_validate
 */
#ifndef NTP_JUDGED_H
#define NTP_JUDGED_H

#include "libntp.h"

#include <math.h>

/* Flags of a judged texel: those of ntp_validate up to NTP_FLAG_Z_NEGATIVE, and: */
enum {
    NTP__LONG = 32,     /* the vector is longer than 1 */
    NTP__FAR = 64,      /* x, y are beyond the limit of the reference program */
    NTP__MIRRORED = 128 /* blue is M - derived blue */
};

/* The limit |(x, y)| <= 1.00774 of the reference program, squared. */
#define NTP__FAR_SQUARED (1.00774 * 1.00774)

enum {
    NTP__NO_BLUE = 65536,      /* a distance from the derived blue where there is none */
    NTP__LENGTH_ONE = 1 << 16, /* fixed-point unit of lengths */
    /* Texels by the length of x, y: bin i is i/8..(i+1)/8; too long: last. */
    NTP__STEEPNESS_BINS = 8,
    /* Padding has a bin of its own after them. */
    NTP__PADDING_BIN = NTP__STEEPNESS_BINS,
    NTP__ALL_BINS
};

/* A length in NTP__LENGTH_ONE, from its square in numerators. */
static inline int32_t ntp__fixed_length(double length2, int32_t m)
{
    return (int32_t) (sqrt(length2) * ((double) NTP__LENGTH_ONE / m) + 0.5);
}

#endif
