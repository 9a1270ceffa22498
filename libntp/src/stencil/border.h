/* SPDX-License-Identifier: MIT */
/*
 * border.h - what lies beyond the edges of an axis, and where a stencil has all its texels inside
 *
 * Every operation that reads texels beyond an edge asks here: gradients, blur, resizing, heights
 * from normals.  taps.h has the stencils themselves.
 */
#ifndef NTP_STENCIL_BORDER_H
#define NTP_STENCIL_BORDER_H

#include "libntp.h"
#include "stencil/taps.h"

#include <stdbool.h>

/* The texels that stand for index i of an axis of n: the sum of weight * h[index]. */
typedef struct ntp__mapped {
    int32_t count, index[2], weight[2];
} ntp__mapped;

/* border is a result of ntp__border_beyond. */
ntp__mapped ntp__border_map(ntp_border border, int32_t i, int32_t n);

/* What lies beyond an edge.  For repeat-slope it is extrapolated: a blur needs that at every edge,
 * slopes only where a stencil is longer than the axis. */
ntp_border ntp__border_beyond(ntp_border border);

/* The positions first..last of an axis. */
typedef struct ntp__span {
    int32_t first, last;
} ntp__span;

/* The positions of an axis of n at which slopes are taken.  `along`: the axis runs along the slope,
 * else across it.  Repeat-slope takes the nearest of these positions for all others. */
ntp__span ntp__stencil_span(const ntp__kernel *k, bool along, ntp_border border, int32_t n);

static inline int32_t ntp__clamp(int32_t v, ntp__span span)
{
    return v < span.first ? span.first : v > span.last ? span.last : v;
}

#endif
