/* SPDX-License-Identifier: MIT */
/*
 * mix_avx2.h - packed RGB made stronger, or blended, with AVX2
 *
 * All texels are of the standard encoding, of 8 bit or of 16 (deep).
 */
#ifndef NTP_MIX_AVX2_H
#define NTP_MIX_AVX2_H

#include "base/view.h"
#include "reshape/blend_kernels.h"

/* Up to NTP__BLOCK texels side by side.  What is read beyond the last one does not matter. */
typedef struct ntp__mix_run {
    uint16_t c[3 * NTP__BLOCK];
} ntp__mix_run;

/* Multiplies x and y by the strength; they are swapped first, and mirrored after that. */
typedef struct ntp__boost {
    double strength; /* 2^-10 to 2^10 */
    bool swap, mirror_x, mirror_y;
} ntp__boost;

/*
 * Both make n texels at d.  at: the places of those that are in doubt, too long, or perhaps unused;
 * they return how many there are.  The strength of the detail is at most NTP__MOST_MIXED.
 */
enum { NTP__MOST_MIXED = 64 };
int32_t ntp__strengthen_rgb_avx2(void *d, int32_t *at, const ntp__mix_run *s, int32_t n,
                                 const ntp__boost *how, bool deep);
int32_t ntp__blend_rgb_avx2(void *d, int32_t *at, const ntp__mix_run *base,
                            const ntp__mix_run *detail, int32_t n, const ntp__mixture *how,
                            bool reoriented, bool exact, bool deep);

/* Texels of a run from their places to a block, and of a block to their places at d. */
void ntp__take_places(ntp__block *block, const ntp__mix_run *s, const int32_t *at, int32_t n,
                      bool deep);
void ntp__put_places(void *d, const ntp__block *block, const int32_t *at, int32_t n, bool deep);

#endif
