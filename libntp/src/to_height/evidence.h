/* SPDX-License-Identifier: MIT */
/*
 * evidence.h - what decode.c asks the texels
 */
#ifndef NTP_LEVEL_EVIDENCE_H
#define NTP_LEVEL_EVIDENCE_H

#include "base/view.h"

enum {
    RINGS = 12, /* levels to each side of zero that tell about flat ground */
    AROUND = 2 * RINGS,
    FIRST_AROUND = 128 - RINGS,
    STRIDE = 32, /* at least AROUND + 1; the last level stands for all others */
    /* Texels of the same red and green have the same rounding error: a ramp would tell nothing a
     * million times.  So only a few of each pair vote.  Low bits of both stand for the pair. */
    MOST_VOTES = 8,
    VOTE_BITS = 6,
    VOTE_MASK = (1 << VOTE_BITS) - 1,
    NEUTRAL_PAIR = 1 << 2 * VOTE_BITS /* of all neutral texels, which have no vote */
};

typedef struct rule {
    double zero, unit; /* v = (2 c - zero) unit */
    double sum, gain, gain2;
} rule;

typedef struct evidence {
    rule unorm, trunc, snorm;
    double count;        /* texels in the sums of the rules */
    double all, lengths; /* texels of any depth, read as UNORM; squares of 2 m^2 times the error */
    double longer;       /* those of lengths above 1 */
    double most_rest;    /* z^2 of a tilted texel is below this, in units of levels squared */
    double most_off;     /* twice the square of the error of a right one, in squares of these */
    double tilted, derived;
    double too_long;                  /* texels whose x, y are longer than 1 */
    double right;                     /* texels whose length is off by rounding alone */
    double rest, rest2, z2, z4, both; /* sums of 1 - x^2 - y^2 and z^2, of their products */
    double negative, negative2;       /* texels whose z is below 0, and its squares */
    double pile[2], beside;           /* of red: texels at 127, at 128, beside them */
    double level;                     /* of green: texels at 128 */
    int32_t asked;                    /* so many texels were looked at for what follows */
    int32_t near[AROUND + 1][STRIDE]; /* by red and green: texels at each pair near zero */
    uint8_t votes[NEUTRAL_PAIR + 1];
} evidence;

/* Looks at up to 256 rows.  with_rules: also for what the levels mean. */
typedef void ntp__gather_evidence_fn(evidence *e, const ntp_const_image *src, uint32_t touch,
                                     bool with_rules);

extern ntp__gather_evidence_fn ntp__gather_evidence_base, ntp__gather_evidence_avx2;

#endif
