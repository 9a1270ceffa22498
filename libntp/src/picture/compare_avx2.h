/* SPDX-License-Identifier: MIT */
/*
 * compare_avx2.h - differences of packed RGB in levels, and its angles, with AVX2 or AVX-512
 */
#ifndef NTP_COMPARE_AVX2_H
#define NTP_COMPARE_AVX2_H

#include "texel/kernels.h"
#include "base/view.h"

enum { ANGLES = 3, ROUND_BIN = 500 /* with it a bin is a 1000th */ };

typedef struct ntp__compared {
    /* |Differences| of levels; and, at ANGLES, micro-degrees + ROUND_BIN of those found */
    uint64_t sum[4];
    uint32_t most[4];
    int32_t different;   /* texels */
    int32_t found, left; /* angles; all others are 0 */
    /* Of those found: bins as ntp__angle_sums has them, in no order */
    _Alignas(64) int32_t bin[NTP__BLOCK + 16];
    /* Of those left: |v x w|^2 and v . w */
    double s2[NTP__BLOCK + 8], d[NTP__BLOCK + 8];
} ntp__compared;

/* Compares n packed pixels of 8 bit, or 16 (deep), in the standard encoding.  Both kinds of angles may
 * be followed by zeros. */
typedef void ntp__compare_rgb(ntp__compared *out, const void *a, const void *b, int32_t n,
                              bool deep);

ntp__compare_rgb ntp__compare_rgb_avx2, ntp__compare_rgb_avx512;

#endif
