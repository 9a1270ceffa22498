/* SPDX-License-Identifier: MIT */
/*
 * channels.h - the order in which a result stores x, y and z
 */
#ifndef NTP_GIMP_CHANNELS_H
#define NTP_GIMP_CHANNELS_H

#include "libntp.h"

typedef enum channel_order { /* in the order of NTP_CHANNEL_CHOICES */
                             ORDER_XYZ,
                             ORDER_ZYX,
                             ORDER_XZY,
                             ORDER_DXT5NM /* 1, y, 0, and x in alpha; without alpha as ORDER_XYZ */
} channel_order;

/* Moves x, y and z of an area of packed pixels to their places. */
void channels_arrange(const ntp_image *view, channel_order order, const ntp_rect *area);

#endif
