/* SPDX-License-Identifier: MIT */
/*
 * most_used_square.h - the part of a texture in which most texels are used
 */
#ifndef NTP_CLI_MOST_USED_SQUARE_H
#define NTP_CLI_MOST_USED_SQUARE_H

#include <libntp.h>
#include <stdint.h>

/* The square of `side` texels, a multiple of 16, with most used texels; how many they are, 0: there
 * is none.  flags: of ntp_validate, packed. */
uint32_t fullest_square(ntp_rect *square, const uint8_t *flags, int32_t width, int32_t height,
                        int32_t side);

#endif
