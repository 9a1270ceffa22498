/* SPDX-License-Identifier: MIT */
/*
 * most_used_square.h - the square of a texture that has the most used texels
 */
#ifndef NTP_CLI_MOST_USED_SQUARE_H
#define NTP_CLI_MOST_USED_SQUARE_H

#include <libntp.h>
#include <stdint.h>

/* Returns how many texels of the square are used; 0 if there is no square.  side: a multiple of 16.
 * flags: those of ntp_validate, packed. */
uint32_t most_used_square(ntp_rect *square, const uint8_t *flags, int32_t width, int32_t height,
                          int32_t side);

#endif
