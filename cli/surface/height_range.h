/* SPDX-License-Identifier: MIT */
/*
 * height_range.h - the range that most heights lie in, and clipping to it
 */
#ifndef NTP_CLI_HEIGHT_RANGE_H
#define NTP_CLI_HEIGHT_RANGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct height_range {
    float least, greatest;
} height_range;

/* The range of what is left when `percent` of the heights, rounded down, are left out at each end;
 * percent is below 50.  holes: a height of exactly 0 stands for a hole and does not count. */
height_range heights_middle(const float *heights, size_t count, bool holes, double percent);

/* Moves heights into the range; returns how many lay outside. */
uint64_t heights_clip(float *heights, size_t count, height_range range);

#endif
