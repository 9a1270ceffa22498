/* SPDX-License-Identifier: MIT */
/*
 * line.h - the slopes of a stretch of a line
 */
#ifndef NTP_LINE_H
#define NTP_LINE_H

#include "base/view.h"

typedef struct ntp__line {
    double p[NTP__BLOCK + 1], q[NTP__BLOCK + 1]; /* slopes along and across, from index 1 on */
    bool bad[NTP__BLOCK];                        /* no normal */
    double step[NTP__BLOCK], noise[NTP__BLOCK];
    ntp__block block;
} ntp__line;

/* Reads n texels.  Channel `along` holds the component along the line.  Slopes are x/z and y/z. */
void ntp__read_line(ntp__line *l, const ntp_const_image *src, uint32_t touch, int32_t along,
                    int32_t x, int32_t y, int32_t n);

#endif
