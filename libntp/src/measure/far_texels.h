/* SPDX-License-Identifier: MIT */
/*
 * far_texels.h - adds 16-bit texels that are far from exact, with AVX2
 *
 * Nearly all texels of noise are so, and their counts fall into more memory than the caches near the
 * processor hold.  So what ntp__sums counts in 32 bits is counted in bytes first; a byte that runs
 * over is carried there.  Counts by steepness and flags have a table of their own.
 */
#ifndef NTP_FAR_TEXELS_H
#define NTP_FAR_TEXELS_H

#include "measure/judged_sums.h"

#include <stdbool.h>

/* A key of texels that are no neighbors: the bin of steepness, and flags. */
enum {
    NTP__KEY_ZZ_LONG = 1,  /* longer than 1 in Z-zero */
    NTP__KEY_SHORT = 2,    /* not longer than 1 */
    NTP__KEY_NEGATIVE = 4, /* below the horizon */
    NTP__KEY_TOO_LONG = 8, /* x and y */
    NTP__KEY_FAR = 16,     /* beyond the limit of the reference program */
    NTP__KEY_STEEP = 32,
    NTP__KEYS = NTP__ALL_BINS * NTP__KEY_STEEP
};

typedef struct ntp__far_counts {
    uint32_t skip;  /* blocks to come that are not looked at, as few of the last one were far */
    uint32_t first; /* no texel of the last block was close */
    uint32_t used;  /* 0: all of the following are 0 */
    uint32_t keys[2][NTP__KEYS];                       /* of every second texel apart */
    uint8_t few[sizeof(ntp__sums) / sizeof(uint32_t)]; /* by the words of ntp__sums */
} ntp__far_counts;

/* Adds n 16-bit texels as ntp__add_block does in the standard encoding, but for groups of eight in which
 * any is a neighbor in one of the encodings.  These go to the front of the block; returns how many they
 * are.  Some of the counts are in `far`. */
int32_t ntp__add_far_avx2(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n);

/* Adds to sums what `far` holds of the texels in `of`, or makes it empty. */
void ntp__merge_far(ntp__sums *into, const ntp__far_counts *far, const ntp__sums *of);
void ntp__clear_far(ntp__far_counts *far, const ntp__sums *of);

#endif
