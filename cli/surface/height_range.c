/* SPDX-License-Identifier: MIT */
/*
 * height_range.c - the range that most heights lie in, and clipping to it
 *
 * The k-th height is found by counting, in two passes and without a copy of the heights.  The bits
 * of a float, with the order of negative numbers reversed, are an integer that grows with it.  The
 * first pass counts the upper halves of these integers, the second the lower halves of those that
 * share the upper half of the height wanted.
 */
#include "surface/height_range.h"

#include <stdlib.h>
#include <string.h>

#include "cli.h"

enum { BINS = 65536 };

static uint32_t order_of(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits >> 31 != 0 ? ~bits : bits | 0x80000000u;
}

static float height_of(uint32_t order)
{
    const uint32_t bits = order >> 31 != 0 ? order & 0x7fffffffu : ~order;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The bin that holds the item of this rank; *rank becomes that inside the bin. */
static uint32_t bin_of(const size_t *bins, size_t *rank)
{
    uint32_t bin = 0;
    for (; bin < BINS - 1 && *rank >= bins[bin]; bin++)
        *rank -= bins[bin];
    return bin;
}

height_range heights_middle(const float *heights, size_t count, bool holes, double percent)
{
    size_t *upper = need(calloc(3 * (size_t) BINS, sizeof *upper));
    size_t *const low = upper + BINS, *const high = low + BINS;
    size_t used = 0;
    for (size_t i = 0; i < count; i++) {
        if (holes && heights[i] == 0)
            continue;
        upper[order_of(heights[i]) >> 16]++;
        used++;
    }
    if (used == 0) {
        free(upper);
        return (height_range) { 0, 0 };
    }
    size_t first = (size_t) ((double) used * percent / 100), last = used - 1 - first;
    const uint32_t first_bin = bin_of(upper, &first), last_bin = bin_of(upper, &last);
    for (size_t i = 0; i < count; i++) {
        const uint32_t order = order_of(heights[i]);
        if (holes && heights[i] == 0)
            continue;
        low[order & 0xffff] += order >> 16 == first_bin;
        high[order & 0xffff] += order >> 16 == last_bin;
    }
    const height_range range = { height_of(first_bin << 16 | bin_of(low, &first)),
                                 height_of(last_bin << 16 | bin_of(high, &last)) };
    free(upper);
    return range;
}

uint64_t heights_clip(float *heights, size_t count, height_range range)
{
    uint64_t clipped = 0;
    for (size_t i = 0; i < count; i++) {
        const float h = heights[i];
        clipped += h < range.least || h > range.greatest;
        heights[i] = h < range.least ? range.least : h > range.greatest ? range.greatest : h;
    }
    return clipped;
}
