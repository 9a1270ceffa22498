/* SPDX-License-Identifier: MIT */
/*
 * counts.h - which texels count, and how much they matter
 *
 * For `ntp check` and for the report of the GIMP plug-in, so that both say the same.  It needs
 * nothing but libntp.
 */
#ifndef NTP_CLI_COUNTS_H
#define NTP_CLI_COUNTS_H

#include "libntp.h"

#include <stdbool.h>

typedef enum finding_level { LEVEL_INFO, LEVEL_WARNING, LEVEL_ERROR } finding_level;

/* The defaults of --max-angle (degrees), --max-fail (percent) and --max-tilt (mean component). */
#define COUNTS_MAX_ANGLE 5.0
#define COUNTS_MAX_FAIL  2.0
#define COUNTS_MAX_TILT  0.1

/* Texels that are judged: neither unused nor padding of another color. */
uint64_t counts_judged(const ntp_stats *s);

/* Texels that fail a verdict, read as NTP_ENCODING_STANDARD, ZZERO or XY; used: judged ones. */
void counts_failing(const ntp_stats *s, ntp_encoding encoding, ntp_verdict verdict,
                    bool keep_negative_z, uint64_t *all, uint64_t *used);

/* Judged texels whose red and green are too long, and those whose z is negative. */
uint64_t counts_xy_too_long(const ntp_stats *s);
uint64_t counts_z_negative(const ntp_stats *s);

/* By what a renderer shows, for every format and depth: `judged` texels with this harm. */
finding_level counts_level(const ntp_harm *harm, uint64_t judged, double max_angle,
                           double max_fail);

/* Of the mean of x or of y, that which is further from 0. */
double counts_tilt(const ntp_stats *s);

/* Does alpha hold a map, as in LabPBR?  A cutout has 0 and M, and little else. */
bool counts_alpha_map(const ntp_stats *s);

/* Has it channels in wrong places, or numbers that were converted? */
bool counts_misplaced(const ntp_classification *type, int32_t channels);

#endif
