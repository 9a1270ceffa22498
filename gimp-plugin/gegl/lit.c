/* SPDX-License-Identifier: MIT */
/*
 * lit.c - the result as a lit surface, in place of its numbers
 */
#include "lit.h"

#include <math.h>

ntp_light lit_light(gdouble from, gdouble height)
{
    const gdouble around = from * G_PI / 180, above = height * G_PI / 180;
    return (ntp_light) { .direction = { cos(around) * cos(above), sin(around) * cos(above),
                                        sin(above) },
                         .ambient = 0.1,
                         .diffuse = 0.9,
                         .specular = 0.2,
                         .color = { 0.6, 0.6, 0.6 } };
}

/* libntp lights in 8 bit; deeper layers get the same levels by value. */
gboolean lit_paint(const pixels *p, const ntp_image *dst, const ntp_const_image *normals,
                   const ntp_light *light, const ntp_rect *area)
{
    ntp_image painted = *dst;
    painted.encoding = NTP_ENCODING_HEIGHT;
    if (p->type == NTP_TYPE_U8)
        return ntp_shade(&painted, normals, light, area) == NTP_OK;
    const pixels levels = { .type = NTP_TYPE_U8, .channels = p->channels };
    guchar *colors = g_malloc((gsize) dst->width * (gsize) dst->height * (gsize) p->channels);
    const ntp_image picture = pixels_view(&levels, colors, dst->width, dst->height);
    const ntp_const_image seen = ntp_image_as_const(&picture);
    const gboolean ok = ntp_shade(&picture, normals, light, area) == NTP_OK &&
                        ntp_convert(&painted, &seen, NULL, NULL, area) == NTP_OK;
    g_free(colors);
    return ok;
}
