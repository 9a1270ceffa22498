/* SPDX-License-Identifier: MIT */
/*
 * question.h - what the rules of the classification read
 */
#ifndef NTP_QUESTION_H
#define NTP_QUESTION_H

#include "measure/evidence.h"

#include <stdbool.h>

typedef struct question {
    ntp_classification *out;
    const ntp__evidence *e;
    const ntp_stats *s; /* of e */
    /* Shares of the used texels; the arrays by reading, standard and Z-zero. */
    double unit[2], near[2], rounded[2], negative, red_low, green_low, too_long;
    double used, all_used, lean; /* used ones without padding; with it */
} question;

static inline double distance(double a, double b)
{
    return a < b ? b - a : a - b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

static inline double least(double a, double b)
{
    return a < b ? a : b;
}

/* `low` where t is 0 or less, `high` where it is 1 or more, between them in proportion. */
static inline double blend(double low, double high, double t)
{
    return t <= 0 ? low : t >= 1 ? high : low + (high - low) * t;
}

/* How far the mean of a channel lies from the middle, where that of x or y lies. */
static inline double off_middle(double mean)
{
    return distance(mean, 0.5);
}

/* The share of texels on the rarer side. */
static inline double rarer(double share)
{
    return share < 0.5 ? share : 1 - share;
}

/* The number of texels in these bins of steepness. */
double ntp__count_bins(const ntp__evidence *e, int32_t first_bin, int32_t end_bin);

/* Their mean length error, read as standard; 0 where there are none. */
double ntp__length_error(const ntp__evidence *e, int32_t first_bin, int32_t end_bin);

/* Do two channels keep to a line?  The variances along and across its direction tell. */
bool ntp__keep_to_a_line(const ntp__evidence *e, int32_t first, int32_t second);

/* The second greatest of the steps at block borders, of three channels. */
double ntp__block_step(const ntp__evidence *e);

/* Gray but for the tint of block compression? */
bool ntp__is_tinted_gray(const ntp__evidence *e);

/* Are all three channels spread alike around one mean? */
bool ntp__is_noise(const ntp__evidence *e);

/* Does blue hold nothing: constant, or near an end whatever the z of red and green is? */
bool ntp__blue_is_idle(const ntp__evidence *e);

/* How far the mean blue lies below M, over how far that of the derived blue does, as before JPEG:
 * 1 for standard, 2 for Z-zero. */
double ntp__blue_drop_before(const ntp__evidence *e);

/* How closely blue varies with red or green themselves, whatever the sign; 0 where it varies
 * little. */
double ntp__blue_alike(const ntp__evidence *e);

/* Sets the shares of texels by the counts. */
void ntp__set_shares(question *q);

/* Are enough texels steeper than 1/8 to tell anything? */
bool ntp__has_slopes(const question *q);

/* The share of texels that are steeper than 1/2. */
double ntp__steep_share(const question *q);

/* The share of all used texels whose x, y are too long; where blue does not tell, padding counts
 * as well. */
double ntp__too_long(const question *q);

#endif
