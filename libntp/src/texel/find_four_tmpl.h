/* SPDX-License-Identifier: MIT */
/*
 * find_four_tmpl.h - lists of places, four at a time and without branches
 */
#ifndef NTP_FIND_FOUR_TMPL_H
#define NTP_FIND_FOUR_TMPL_H

#include <stdint.h>
#include <string.h>

/* Which of four are set, for each mask of four; and how many, as hexadecimal digits. */
static const uint8_t SET[16][4] = { { 0 },    { 0 },       { 1 },       { 0, 1 },
                                    { 2 },    { 0, 2 },    { 1, 2 },    { 0, 1, 2 },
                                    { 3 },    { 0, 3 },    { 1, 3 },    { 0, 1, 3 },
                                    { 2, 3 }, { 0, 2, 3 }, { 1, 2, 3 }, { 0, 1, 2, 3 } };
static const uint64_t COUNTS = UINT64_C(0x4332322132212110);

/* The places i to i + 3 of which the mask has a bit; returns how many.  Branches would be taken at
 * random. */
static inline int32_t find_four_bytes(uint8_t *at, int32_t i, uint32_t mask)
{
    uint32_t which;
    memcpy(&which, SET[mask], sizeof which);
    which += (uint32_t) i * 0x01010101;
    memcpy(at, &which, sizeof which);
    return (int32_t) (COUNTS >> 4 * mask & 15);
}

#endif
