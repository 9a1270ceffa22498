/* SPDX-License-Identifier: MIT */
/*
 * compare_avx2.h - differences of packed RGB in levels, and its angles, with AVX2 or AVX-512
 */
#ifndef NTP_COMPARE_AVX2_H
#define NTP_COMPARE_AVX2_H

#include "texel/angle.h"
#include "texel/kernels.h"
#include "base/view.h"

enum {
    ANGLES = 3,
    ROUND_BIN = 500, /* with it a bin is a 1000th */
    SPAN = 2048,     /* texels: levels of 8 bit of so many add up in 8 lanes of 16 bits */
    /* Angles: so many and a block's, of 180 degrees, add up in 16 lanes of 32 bits */
    KEPT = 96,
    LEFT = KEPT + NTP__BLOCK
};

typedef struct ntp__compared {
    /* |Differences| of levels; and, at ANGLES, micro-degrees + ROUND_BIN of those found */
    uint64_t sum[4];
    uint32_t most[4];
    int32_t different;   /* texels */
    int32_t found, left; /* angles; all others are 0 */
    /* Given: a bin that is thought to be the fullest, for a kernel may be quicker to count it apart and may
     * think of another one; and where those found are counted, as ntp__angle_sums has it */
    int32_t fullest;
    uint32_t *bins;
    /* Of those left, as they are in doubt: |v x w|^2 and v . w */
    double s2[LEFT + 16], d[LEFT + 16];
} ntp__compared;

/* Compares the first of n packed pixels of 8 bit, or 16 (deep), in the standard encoding; returns how
 * many, at most SPAN.  Both kinds of angles may be followed by zeros. */
typedef int32_t ntp__compare_rgb(ntp__compared *out, const void *a, const void *b, int32_t n,
                                 bool deep);

ntp__compare_rgb ntp__compare_rgb_avx2, ntp__compare_rgb_avx512;

#endif
