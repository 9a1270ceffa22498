/* SPDX-License-Identifier: MIT */
/*
 * srgb_levels.h - the exact inverse of sRGB (IEC 61966-2-1), level by level
 */
#ifndef NTP_CLI_SRGB_LEVELS_H
#define NTP_CLI_SRGB_LEVELS_H

#include <stdint.h>

/* For each sRGB level 0..max: the linear level, correctly rounded, and by how many levels that may
 * be off if the stored level was once rounded from a linear level. */
typedef struct srgb_levels {
    uint32_t max; /* 255 or 65535 */
    uint16_t *linear;
    uint8_t *loss;
} srgb_levels;

/* The table for 255 or 65535.  It is made once, and all threads share it. */
const srgb_levels *srgb_levels_of(uint32_t max);

#endif
