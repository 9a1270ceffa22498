/* SPDX-License-Identifier: MIT */
/*
 * resize_kernels.h - the loops of ntp_resize, compiled once for each instruction set
 */
#ifndef NTP_RESIZE_KERNELS_H
#define NTP_RESIZE_KERNELS_H

#include "texel/kernels.h"

/* A texel is x, y, z and 1 in four adjacent numbers. */
typedef struct ntp__resize_kernels {
    /* n texels of numerators from levels; to[] has room for whole lanes. */
    void (*place)(float *to, const int32_t *r, const int32_t *g, const int32_t *b, int32_t n,
                  int32_t m, int32_t zzero);
    /* sums = the sum of weight[t] rows[t], of `count` numbers, a multiple of 8, and `taps` rows, a
     * multiple of 2. */
    void (*add_rows)(double *sums, const float *const *rows, const int32_t *weight, int32_t taps,
                     int32_t count);
    /* The same where the weights from the last to the first are those from the first to the last. */
    void (*add_pairs)(double *sums, const float *const *rows, const int32_t *weight, int32_t taps,
                      int32_t count);
    /* The same for n texels of the result, from columns first[i] on and with an even number of
     * weights of their own. */
    void (*add_columns)(ntp__vectors *v, double *total, const double *sums, const int32_t *first,
                        const double *weight, int32_t taps, int32_t n);
} ntp__resize_kernels;

#endif
