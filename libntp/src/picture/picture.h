/* SPDX-License-Identifier: MIT */
/*
 * picture.h - what the operations share that paint a picture of a texture
 */
#ifndef NTP_PICTURE_H
#define NTP_PICTURE_H

#include "base/view.h"

/*
 * dst is a U8 picture of src's size with min_channels to 4 channels, but not 2, and either has
 * memory of its own or is src pixel by pixel: a block is read whole before it is written.
 */
ntp_status ntp__check_painting(const ntp_image *dst, const ntp_const_image *src,
                               int32_t min_channels);

/* Writes one pixel, opaque. */
static inline void ntp__paint(uint8_t *pixel, int32_t channels, const uint8_t rgb[3])
{
    pixel[0] = rgb[0];
    if (channels == 1)
        return;
    pixel[1] = rgb[1];
    pixel[2] = rgb[2];
    if (channels == 4)
        pixel[3] = 255;
}

#endif
