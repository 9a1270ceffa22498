/* SPDX-License-Identifier: MIT */
/*
 * channels.c - the order in which a result stores x, y and z
 */
#include "channels.h"

#include <string.h>

enum { FULL = 4, ZERO = FULL, ONE }; /* what a channel gets: a sample of the pixel, or a number */

#define ARRANGE(TYPE, MAX)                                                                         \
    {                                                                                              \
        TYPE *p = (TYPE *) (void *) pixel;                                                         \
        TYPE was[] = { 0, 0, 0, 0, 0, MAX };                                                       \
        memcpy(was, p, count * sizeof *p);                                                         \
        for (size_t c = 0; c < count; c++)                                                         \
            p[c] = was[from[c]];                                                                   \
    }

static void arrange_pixel(unsigned char *pixel, ntp_type type, const unsigned char *from,
                          size_t count)
{
    if (type == NTP_TYPE_U8)
        ARRANGE(uint8_t, 255)
    else if (type == NTP_TYPE_U16)
        ARRANGE(uint16_t, 65535)
    else
        ARRANGE(float, 1)
}

void channels_arrange(const ntp_image *view, channel_order order, const ntp_rect *area)
{
    static const unsigned char FROM[][FULL] = { [ORDER_XYZ] = { 0, 1, 2, 3 },
                                                [ORDER_ZYX] = { 2, 1, 0, 3 },
                                                [ORDER_XZY] = { 0, 2, 1, 3 },
                                                [ORDER_DXT5NM] = { ONE, 1, ZERO, 0 } };
    if (order == ORDER_XYZ || (order == ORDER_DXT5NM && view->channels < FULL))
        return;
    for (int32_t y = area->y0; y < area->y1; y++) {
        unsigned char *pixel =
            (unsigned char *) view->data + y * view->row_stride + area->x0 * view->pixel_stride;
        for (int32_t x = area->x0; x < area->x1; x++, pixel += view->pixel_stride)
            arrange_pixel(pixel, view->type, FROM[order], (size_t) view->channels);
    }
}
