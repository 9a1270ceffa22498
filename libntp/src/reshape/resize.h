/* SPDX-License-Identifier: MIT */
/*
 * resize.h - the weights of a resizing filter along one axis
 *
 * This room makes new normals of old ones: in another size, turned, stronger, or with a detail.
 * New vectors are exact integers, and only their direction is rounded, once (texel/direction.h).
 *   resize.c          ntp_resize: sums of weighted vectors
 *   resize_plan.c     what it knows before; sides of mip levels
 *   resize_columns.c  its sums of columns
 *   resize_strip.c    its quick way for RGB, with resize_kernels.c and resize_avx2.c; resize_job.h
 *   resize_exact_avx2.c  what floats do not decide of halved 8 bit; resize_avx512.c: the busiest loops
 *   resize_read.c     the rows of its strips; resize_strip.h
 *   resize_weights.c  the weights of the filters, as integers
 *   transform.c       ntp_transform: flips, turns, strength
 *   rotate.c          its turns by other angles than quarter turns
 *   turn_floats.c     its flips and quarter turns of floats
 *   blend.c           ntp_blend: a detail texture over a base
 */
#ifndef NTP_RESIZE_H
#define NTP_RESIZE_H

#include "base/view.h"

/* The texels first..first + count - 1 that make one texel of the result. */
typedef struct ntp__span_of_taps {
    int32_t first; /* may lie outside; the border maps it */
    int32_t count;
    int32_t total; /* the sum of the weights, which stands for 1 */
} ntp__span_of_taps;

typedef struct ntp__axis {
    int32_t src, dst; /* texels */
    ntp_border border;
    int32_t stride;          /* places for weights of each texel of the result */
    ntp__span_of_taps *span; /* dst of them */
    int32_t *weight;
    int64_t most; /* the greatest sum of |weight| of a texel */
    double scale; /* a power of 2 that makes it at most 1 */
} ntp__axis;

/* The greatest count of a span. */
int32_t ntp__axis_stride(ntp_filter filter, int32_t src, int32_t dst);

/* Fills span, weight, most and scale.  The caller has set the other fields. */
void ntp__axis_init(ntp__axis *axis, ntp_filter filter);

/* The texel inside that stands for texel i. */
int32_t ntp__axis_map(const ntp__axis *axis, int32_t i);

#endif
