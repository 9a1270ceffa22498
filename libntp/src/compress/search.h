/* SPDX-License-Identifier: MIT */
/*
 * search.h - the two ends of a block of one channel, and which of its values each texel takes
 *
 * A block of BC4 has two ends a and b of 8 bit.  Eight values divide the line between them in
 * sevenths where a > b; elsewhere six divide it in fifths, and 0 and 255 are the other two.
 */
#ifndef NTP_SEARCH_H
#define NTP_SEARCH_H

#include "base/cpu.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    NTP__TEXELS = 16, /* of a block, rows from the top */
    NTP__VALUES = 8,  /* of its palette */
    NTP__LANES = 16,  /* lines that are tried at once */
    NTP__PARTS = 35   /* of a level: sevenths and fifths */
};

/* What a channel shall be: 16-bit levels, or between them, and how much an error of each counts. */
typedef struct ntp__wanted {
    double level[NTP__TEXELS], weight[NTP__TEXELS];
} ntp__wanted;

/* The ends: low <= high, and into how many parts the line is divided, 7 or 5. */
typedef struct ntp__ends {
    int32_t low, high, parts;
} ntp__ends;

/* Lines of one length, sorted texels, and what the best line has cost until now. */
typedef struct ntp__lines {
    float value[NTP__TEXELS]; /* 16-bit levels x parts */
    float weight[NTP__TEXELS];
    float cap[NTP__TEXELS]; /* the error of the nearer one of 0 and 65535, squared */
    int32_t count;          /* of texels */
    float step;             /* from a value to the next, in the same unit */
    float last;             /* the index of the last value on the line */
    float enough;           /* sums from here on are of no use */
} ntp__lines;

/* error[l] is the sum for the line whose first value is first + l * apart.  Returns the least of
 * them; from `enough` on, the errors are not set. */
typedef float ntp__try_lines_fn(float error[NTP__LANES], const ntp__lines *lines, float first,
                                float apart);

ntp__try_lines_fn *ntp__try_lines_for(int mask);

/* The best ends.  Their error is the least of all 65536 pairs where `all`, and else that of those
 * near to the range of the texels. */
ntp__ends ntp__search_ends(const ntp__wanted *wanted, bool all);

/* 16-bit levels in parts, from the low end to the high one; then 0 and 65535. */
void ntp__palette(int32_t palette[NTP__VALUES], const ntp__ends *ends);

#endif
