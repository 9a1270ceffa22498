/* SPDX-License-Identifier: MIT */
/*
 * compare_avx2.h - differences of packed RGB in levels, and its small angles, with AVX2 or AVX-512
 */
#ifndef NTP_COMPARE_AVX2_H
#define NTP_COMPARE_AVX2_H

#include "texel/kernels.h"
#include "base/view.h"

typedef struct ntp__compared {
    uint32_t sum[3], most[3]; /* |differences| of levels */
    int32_t different;        /* texels */
    int32_t found, left;      /* how many of the following; all others are 0 */
    /* Micro-degrees, in no order; with room for the last of those left */
    _Alignas(32) int32_t angle[NTP__BLOCK + NTP__KERNEL_LANES];
    /* |v x w|^2 and v . w where the angle is still to be found */
    double s2[NTP__BLOCK], d[NTP__BLOCK];
} ntp__compared;

/* Compares n packed pixels of 8 bit, or 16 (deep), in the standard encoding.  Both kinds of angles may
 * be followed by zeros. */
typedef void ntp__compare_rgb(ntp__compared *out, const void *a, const void *b, int32_t n,
                              bool deep);

ntp__compare_rgb ntp__compare_rgb_avx2, ntp__compare_rgb_avx512;

#endif
