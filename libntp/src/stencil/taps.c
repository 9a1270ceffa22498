/* SPDX-License-Identifier: MIT */
/*
 * taps.c - the table of the gradient kernels
 */
#include "stencil/taps.h"

#define TAPS(ALONG, ACROSS) { NTP__##ALONG, NTP__##ACROSS, NTP__LINE_##ALONG, NTP__LINE_##ACROSS }

const ntp__kernel ntp__kernel_table[NTP__KERNELS] = {
    { "central", 1, 2, 4, 1, { TAPS(DIFFERENCE, ONE) } },
    { "forward", 1, 1, 3, 1, { TAPS(FORWARD, ONE) } },
    { "prewitt3", 1, 6, 20, 1, { TAPS(DIFFERENCE, BOX3) } },
    { "sobel3", 1, 8, 24, 1, { TAPS(DIFFERENCE, TENT3) } },
    { "scharr3", 1, 32, 88, 1, { TAPS(DIFFERENCE, SCHARR3) } },
    { "prewitt5", 2, 40, 154, 1, { TAPS(DIFFERENCE5, BOX5) } },
    { "sobel5", 2, 128, 392, 1, { TAPS(DIFFERENCE5, SOBEL5) } },
    { "gimp5", 2, 2592, 8688, 2, { TAPS(DIFFERENCE, INNER5), TAPS(OUTER5, BROAD5) } },
    { "gimp7", 3, 248, 914, 2, { TAPS(SLOPE7, BOX7), TAPS(STEP7, TENT5) } },
    { "gimp9", 4, 680, 2748, 2, { TAPS(SLOPE9, BOX9), TAPS(STEP9, TENT7) } },
};
