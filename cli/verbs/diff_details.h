/* SPDX-License-Identifier: MIT */
/*
 * diff_details.h - what ntp diff says of a DDS or KTX2 besides: its mips, its worst blocks
 */
#ifndef NTP_CLI_DIFF_DETAILS_H
#define NTP_CLI_DIFF_DETAILS_H

#include "examine/examine.h"

enum { WORST_BLOCKS = 10, MIPS_MAX = 32 };

typedef struct block_facts {
    int32_t x, y; /* the first texel */
    ntp_angles angles;
} block_facts;

typedef struct mip_facts {
    int32_t width, height;
    ntp_angles angles; /* to the right mip: the box filter of whole vectors, as ntp resize --mips */
} mip_facts;

typedef struct diff_details {
    bool known;
    int blocks, mips; /* mips[0] is mip 1 */
    block_facts worst[WORST_BLOCKS];
    mip_facts mip[MIPS_MAX];
} diff_details;

/* Compares two sources of one size whose views are set, from their first rows.  `texture` is the
 * DDS or KTX2, whose mips are opened by its name. */
bool diff_details_find(diff_details *d, source *plain, source *texture, ntpio_error *error);

#endif
