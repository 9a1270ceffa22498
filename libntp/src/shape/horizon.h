/* SPDX-License-Identifier: MIT */
/*
 * horizon.h - the horizon of each sample of a line of heights
 */
#ifndef NTP_SHAPE_HORIZON_H
#define NTP_SHAPE_HORIZON_H

#include <stdint.h>

/* Some samples of a line, from `first` to before `last`, every `step`-th of them. */
typedef struct ntp__some {
    int32_t first, last, step;
} ntp__some;

/*
 * For each of these samples i: best[i] is the index of that of the samples i + 1 .. i + reach on a
 * line of n to which the slope from i is greatest; -1 if there is none.  |v| < 2^30; reach is at
 * least 1.  stack has room for 2 n numbers.  best is changed between first and last only.
 */
void ntp__horizons(int32_t *best, const int32_t *v, int32_t n, ntp__some which, int32_t reach,
                   int32_t *stack);

#endif
