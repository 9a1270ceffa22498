/* SPDX-License-Identifier: MIT */
/*
 * blend_kernels.h - the loops of ntp_blend, compiled once for each instruction set
 */
#ifndef NTP_BLEND_KERNELS_H
#define NTP_BLEND_KERNELS_H

#include "texel/kernels.h"

/* What the vectors of a mode are made with; blend.c has the formulas. */
typedef struct ntp__mixture {
    double strength, turn; /* of x and of y; turn = -strength where the y of the two differ */
    double mb, md;         /* M of base and detail */
    double by_alpha, opaque, most;    /* the detail counts (by_alpha alpha + opaque) / most */
    double filled;                    /* z of what fills up a faded detail */
    double base_z, detail_z, product; /* the terms of z, of all modes but RNM */
} ntp__mixture;

/*
 * The vectors of the mode in doubles, divided by 2^shift.  size is at least their length, and what
 * was added up for a component; an error is below 2^-49 of it.  n is a whole number of lanes.
 */
typedef void ntp__mix_fn(ntp__vectors *out, double *size, const ntp__vectors *base,
                         const ntp__vectors *detail, const int32_t *alpha, int32_t n,
                         const ntp__mixture *how);

typedef struct ntp__blend_kernels {
    ntp__mix_fn *reoriented, *others;
} ntp__blend_kernels;

#endif
