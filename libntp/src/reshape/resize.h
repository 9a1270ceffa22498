/* SPDX-License-Identifier: MIT */
/*
 * resize.h - what the files of ntp_resize share: the weights along one axis
 */
#ifndef NTP_RESIZE_H
#define NTP_RESIZE_H

#include "base/view.h"

/* The texels first..first + count - 1 that make one texel of the result. */
typedef struct ntp__span_of_taps {
    int32_t first; /* may lie outside; the border maps it */
    int32_t count;
    int32_t total; /* the sum of the weights: what stands for 1 */
} ntp__span_of_taps;

typedef struct ntp__axis {
    int32_t src, dst; /* texels */
    ntp_border border;
    int32_t stride;          /* weights from one texel of the result to the next */
    ntp__span_of_taps *span; /* dst of them */
    int32_t *weight;
} ntp__axis;

/* The greatest count. */
int32_t ntp__axis_stride(ntp_filter filter, int32_t src, int32_t dst);

/* Fills span and weight; the other fields are set. */
void ntp__axis_init(ntp__axis *axis, ntp_filter filter);

/* The texel inside that stands for texel i. */
int32_t ntp__axis_map(const ntp__axis *axis, int32_t i);

#endif
