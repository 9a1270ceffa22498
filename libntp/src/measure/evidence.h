/* SPDX-License-Identifier: MIT */
/*
 * evidence.h - what the classifier asks of a tally beyond the facts that users read
 */
#ifndef NTP_EVIDENCE_H
#define NTP_EVIDENCE_H

#include "texel/judged.h"

/*
 * Padding that was compressed or flipped is not pure black or white, and so counts as used.  But
 * red and green both near an end are no x, y, however damaged.  What is said here of used texels
 * leaves these out, `stats` apart; there `used_mean` does too.
 */

/* How well the used texels fit one encoding. */
typedef struct ntp__fit_evidence {
    double length_mean, length_sd;
    double near_unit[3]; /* share with |length - 1| <= 1/32, 1/16, 1/8 */
    double too_short;    /* share that is not `rounded` and too short */
    double too_long;     /* the same, too long */
} ntp__fit_evidence;

typedef struct ntp__evidence {
    ntp_stats stats;
    ntp__fit_evidence fit[2]; /* standard, Z-zero */
    uint64_t padding; /* used texels that are left out; 0 where hardly others would be left */
    uint64_t used_z_negative;
    /* Used texels by steepness, read as standard: how many there are, how many are not `rounded`,
     * how many are not `neighbor`, and the mean of |length - 1|. */
    uint64_t steepness[NTP__STEEPNESS_BINS];
    uint64_t steepness_not_rounded[NTP__STEEPNESS_BINS];
    uint64_t steepness_not_neighbor[NTP__STEEPNESS_BINS];
    double steepness_length_error[NTP__STEEPNESS_BINS];
    /* From the used texels of sampled rows, like stats.used_mean.  Counts are scaled to all used
     * texels. */
    double used_sd[4];
    double correlation[3]; /* r-g, r-b, g-b; 0 where a channel is constant */
    uint64_t red_low;      /* used texels with r <= (M-1)/2, so that x is negative */
    uint64_t green_low;
    double gamma_near_unit; /* share of used with |length - 1| <= 1/8 after decoding sRGB */
    double ag_in_disc;      /* share of used whose (alpha, g) as x, y are not too long */
    double block_step[3];   /* mean |step| across columns 8k-1|8k over that elsewhere; 0: none */
    /* How blue depends on red and green, in 8-bit levels; 16-bit content is sampled.  A texel is
     * tilted where x, y are not too long and the blues derived as standard and as Z-zero lie more
     * than a level apart. */
    uint64_t tilted;       /* used texels; of 16-bit content sampled ones */
    double tilted_gap;     /* mean distance between these two blues */
    double tilted_off[2];  /* mean |blue - derived blue|, at most 32 each; standard, Z-zero */
    double tilted_near[2]; /* share of tilted with at most 3 levels between them */
    double tilted_above;   /* share of tilted with blue more than 4 levels above standard's */
    /* How far the mean blue lies below M, over how far the mean derived blue does: 1 for standard, 2
     * for Z-zero, 0 for a blue of M.  Compression keeps means, and so keeps this.  Where all is flat:
     * 1. */
    double blue_drop;
    double blue_slope; /* regression of blue on the derived one (x, y not too long); Z-zero: 2 */
    double blue_correlation;
} ntp__evidence;

/* Works out all evidence; it is kept in the tally, until that changes.  An empty tally is NTP_ERR_ARGUMENT. */
ntp_status ntp__gather_evidence(const ntp__evidence **evidence, ntp_tally *tally);

#endif
