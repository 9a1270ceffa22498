/* SPDX-License-Identifier: MIT */
/*
 * taps.h - the gradient kernels, as integers
 *
 * This room says which texels a slope is made of, and with which weights.  from_height/ and
 * to_height/ both take slopes by it, so that the two agree.
 *   taps.h, taps.c      the weights of every kernel
 *   border.h, border.c  what lies beyond the edges of an image
 *
 * Each kernel is a sum of one or two separable terms.  The slope to the right weights columns by
 * `along` and rows by `across`; the slope down is the transpose.  Index 4 is the texel itself.
 * Divided by the denominator, every kernel has gain 1 on a ramp.
 *
 * Sources: forward, central: D. Eberly, Reconstructing a Height Field from a Normal Map, eq. 3
 * and 5.  sobel3: as in J. Zima's shader; I. Sobel, An Isotropic 3x3 Image Gradient Operator.
 * prewitt3: J. Prewitt, Object Enhancement and Extraction (1970).  scharr3: H. Scharr,
 * dissertation (2000).  prewitt5, sobel5, gimp5, gimp7, gimp9: the taps of the gimp-normalmap
 * plug-in, scaled to gain 1.
 */
#ifndef NTP_GRADIENT_TAPS_H
#define NTP_GRADIENT_TAPS_H

#include "libntp.h"

#include <stdint.h>

enum { NTP__MAX_RADIUS = 4, NTP__MAX_TAPS = 2 * NTP__MAX_RADIUS + 1 };

/* All taps along or across; ONE is the identity. */
#define NTP__ONE         { 0, 0, 0, 0, 1, 0, 0, 0, 0 }
#define NTP__FORWARD     { 0, 0, 0, 0, -1, 1, 0, 0, 0 }
#define NTP__DIFFERENCE  { 0, 0, 0, -1, 0, 1, 0, 0, 0 }
#define NTP__DIFFERENCE5 { 0, 0, -1, -2, 0, 2, 1, 0, 0 }
#define NTP__OUTER5      { 0, 0, -1, 0, 0, 0, 1, 0, 0 }
#define NTP__SLOPE7      { 0, -1, -2, -3, 0, 3, 2, 1, 0 }
#define NTP__STEP7       { 0, -1, -1, -1, 0, 1, 1, 1, 0 }
#define NTP__SLOPE9      { -1, -2, -3, -4, 0, 4, 3, 2, 1 }
#define NTP__STEP9       { -1, -1, -1, -1, 0, 1, 1, 1, 1 }
#define NTP__BOX3        { 0, 0, 0, 1, 1, 1, 0, 0, 0 }
#define NTP__BOX5        { 0, 0, 1, 1, 1, 1, 1, 0, 0 }
#define NTP__BOX7        { 0, 1, 1, 1, 1, 1, 1, 1, 0 }
#define NTP__BOX9        { 1, 1, 1, 1, 1, 1, 1, 1, 1 }
#define NTP__TENT3       { 0, 0, 0, 1, 2, 1, 0, 0, 0 }
#define NTP__TENT5       { 0, 0, 1, 2, 3, 2, 1, 0, 0 }
#define NTP__TENT7       { 0, 1, 2, 3, 4, 3, 2, 1, 0 }
#define NTP__SCHARR3     { 0, 0, 0, 3, 10, 3, 0, 0, 0 }
#define NTP__SOBEL5      { 0, 0, 1, 4, 6, 4, 1, 0, 0 }
#define NTP__INNER5      { 0, 0, 56, 200, 280, 200, 56, 0, 0 }
#define NTP__BROAD5      { 0, 0, 35, 56, 70, 56, 35, 0, 0 }

#define NTP__EACH_LINE(DO)                                                                         \
    DO(ONE)                                                                                        \
    DO(FORWARD)                                                                                    \
    DO(DIFFERENCE)                                                                                 \
    DO(DIFFERENCE5)                                                                                \
    DO(OUTER5)                                                                                     \
    DO(SLOPE7)                                                                                     \
    DO(STEP7)                                                                                      \
    DO(SLOPE9)                                                                                     \
    DO(STEP9)                                                                                      \
    DO(BOX3)                                                                                       \
    DO(BOX5)                                                                                       \
    DO(BOX7)                                                                                       \
    DO(BOX9)                                                                                       \
    DO(TENT3)                                                                                      \
    DO(TENT5)                                                                                      \
    DO(TENT7)                                                                                      \
    DO(SCHARR3)                                                                                    \
    DO(SOBEL5)                                                                                     \
    DO(INNER5)                                                                                     \
    DO(BROAD5)

#define NTP__LINE_NAME(NAME) NTP__LINE_##NAME,
typedef enum ntp__tap_line { NTP__EACH_LINE(NTP__LINE_NAME) NTP__LINES } ntp__tap_line;
#undef NTP__LINE_NAME

typedef struct ntp__taps {
    int32_t along[NTP__MAX_TAPS];
    int32_t across[NTP__MAX_TAPS];
    ntp__tap_line along_line, across_line; /* which they are */
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

enum { NTP__KERNELS = NTP_KERNEL_GIMP9 + 1 };

/* Indexed by ntp_kernel. */
extern const ntp__kernel ntp__kernel_table[NTP__KERNELS];

#endif
