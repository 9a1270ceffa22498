/* SPDX-License-Identifier: MIT */
/*
 * merge.h - how parts of a measurement add up
 */
#ifndef NTP_MERGE_H
#define NTP_MERGE_H

#include <stddef.h>
#include <stdint.h>

/* judged_sums.c */
void ntp__merge_counts(uint32_t *restrict into, const uint32_t *restrict from, size_t n);

static inline void ntp__merge_max(uint32_t *into, uint32_t from)
{
    if (from > *into)
        *into = from;
}

#endif
