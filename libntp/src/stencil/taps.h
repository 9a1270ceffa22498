/* SPDX-License-Identifier: MIT */
/*
 * taps.h - the gradient kernels, as integers
 *
 * This room says which texels a slope is made of, and with which weights.  from_height/ and
 * to_height/ both take slopes by it, so that the two agree.
 *   taps.h              the weights of every kernel
 *   border.h, border.c  what lies beyond the edges of an image
 *
 * Each kernel is a sum of one or two separable terms.  The slope to the right weights columns by
 * `along` and rows by `across`; the slope down is the transpose.  Index 4 is the texel itself.
 * Divided by the denominator, every kernel has gain 1 on a ramp.  The table is in a header, so that
 * the loops see its numbers as constants.
 *
 * Sources: forward, central: D. Eberly, Reconstructing a Height Field from a Normal Map, eq. 3
 * and 5.  sobel3: as in J. Zima's shader; I. Sobel, An Isotropic 3x3 Image Gradient Operator.
 * prewitt3: J. Prewitt, Object Enhancement and Extraction (1970).  scharr3: H. Scharr,
 * dissertation (2000).  prewitt5, sobel5, gimp5, gimp7, gimp9: the taps of the gimp-normalmap
 * plug-in, scaled to gain 1.
 */
#ifndef NTP_GRADIENT_TAPS_H
#define NTP_GRADIENT_TAPS_H

#include <stdint.h>

enum { NTP__MAX_RADIUS = 4, NTP__MAX_TAPS = 2 * NTP__MAX_RADIUS + 1 };

typedef struct ntp__taps {
    int32_t along[NTP__MAX_TAPS];
    int32_t across[NTP__MAX_TAPS];
} ntp__taps;

typedef struct ntp__kernel {
    const char *name;
    int32_t radius;
    int32_t denominator;
    /* |tap sum| and all its partial sums are at most gain * (range of the heights), with every
     * border.  The gain is the sum of |w| (|i| + 1)(|j| + 1), because an extrapolated h[-k] is
     * within k + 1 ranges of 0. */
    int32_t gain;
    int32_t terms;
    ntp__taps term[2];
} ntp__kernel;

#define NTP__ONE         { 0, 0, 0, 0, 1, 0, 0, 0, 0 }
#define NTP__DIFFERENCE  { 0, 0, 0, -1, 0, 1, 0, 0, 0 }
#define NTP__DIFFERENCE5 { 0, 0, -1, -2, 0, 2, 1, 0, 0 }
#define NTP__NO_TERM     { { 0 }, { 0 } }

/* Indexed by ntp_kernel. */
static const ntp__kernel ntp__kernel_table[] = {
    { "central", 1, 2, 4, 1, { { NTP__DIFFERENCE, NTP__ONE }, NTP__NO_TERM } },
    { "forward", 1, 1, 3, 1, { { { 0, 0, 0, 0, -1, 1, 0, 0, 0 }, NTP__ONE }, NTP__NO_TERM } },
    { "prewitt3",
      1,
      6,
      20,
      1,
      { { NTP__DIFFERENCE, { 0, 0, 0, 1, 1, 1, 0, 0, 0 } }, NTP__NO_TERM } },
    { "sobel3", 1, 8, 24, 1, { { NTP__DIFFERENCE, { 0, 0, 0, 1, 2, 1, 0, 0, 0 } }, NTP__NO_TERM } },
    { "scharr3",
      1,
      32,
      88,
      1,
      { { NTP__DIFFERENCE, { 0, 0, 0, 3, 10, 3, 0, 0, 0 } }, NTP__NO_TERM } },
    { "prewitt5",
      2,
      40,
      154,
      1,
      { { NTP__DIFFERENCE5, { 0, 0, 1, 1, 1, 1, 1, 0, 0 } }, NTP__NO_TERM } },
    { "sobel5",
      2,
      128,
      392,
      1,
      { { NTP__DIFFERENCE5, { 0, 0, 1, 4, 6, 4, 1, 0, 0 } }, NTP__NO_TERM } },
    { "gimp5",
      2,
      2592,
      8688,
      2,
      { { NTP__DIFFERENCE, { 0, 0, 56, 200, 280, 200, 56, 0, 0 } },
        { { 0, 0, -1, 0, 0, 0, 1, 0, 0 }, { 0, 0, 35, 56, 70, 56, 35, 0, 0 } } } },
    { "gimp7",
      3,
      248,
      914,
      2,
      { { { 0, -1, -2, -3, 0, 3, 2, 1, 0 }, { 0, 1, 1, 1, 1, 1, 1, 1, 0 } },
        { { 0, -1, -1, -1, 0, 1, 1, 1, 0 }, { 0, 0, 1, 2, 3, 2, 1, 0, 0 } } } },
    { "gimp9",
      4,
      680,
      2748,
      2,
      { { { -1, -2, -3, -4, 0, 4, 3, 2, 1 }, { 1, 1, 1, 1, 1, 1, 1, 1, 1 } },
        { { -1, -1, -1, -1, 0, 1, 1, 1, 1 }, { 0, 1, 2, 3, 4, 3, 2, 1, 0 } } } },
};

enum { NTP__KERNELS = sizeof ntp__kernel_table / sizeof ntp__kernel_table[0] };

#endif
