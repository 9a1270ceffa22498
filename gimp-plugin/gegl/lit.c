/* SPDX-License-Identifier: MIT */
/*
 * lit.c - the result as a lit surface, in place of its numbers
 */
#include "lit.h"

#include <math.h>
#include <string.h>

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

static ntp_image part_of(ntp_image view, const ntp_rect *area)
{
    view.data = (guchar *) view.data + area->y0 * view.row_stride + area->x0 * view.pixel_stride;
    view.width = area->x1 - area->x0;
    view.height = area->y1 - area->y0;
    return view;
}

/* libntp lights in 8 bit; deeper layers get the same levels by value.  Its checker begins where a picture
 * does, so the part lies in one that begins where a period of the layer's does. */
gboolean lit_paint(const pixels *p, const ntp_image *dst, const ntp_image *normals,
                   const ntp_light *light, const ntp_rect *area, gint x, gint y)
{
    enum { PERIOD = 16 /* texels: a bright cell and a dark one */ };
    const ntp_image from = part_of(*normals, area);
    ntp_image to = part_of(*dst, area);
    const ntp_rect inner = { x & (PERIOD - 1), y & (PERIOD - 1), (x & (PERIOD - 1)) + from.width,
                             (y & (PERIOD - 1)) + from.height };
    const pixels levels = { .type = NTP_TYPE_U8, .channels = p->channels };
    const gsize texels = (gsize) inner.x1 * (gsize) inner.y1;
    guchar *copy = g_malloc(texels * (gsize) p->bytes);
    guchar *colors = g_malloc(texels * (gsize) p->channels);
    ntp_image source = pixels_view(p, copy, inner.x1, inner.y1);
    const ntp_image picture = pixels_view(&levels, colors, inner.x1, inner.y1);
    const ntp_image inside = part_of(source, &inner), painted = part_of(picture, &inner);
    for (gint row = 0; row < from.height; row++)
        memcpy((guchar *) inside.data + row * inside.row_stride,
               (const guchar *) from.data + row * from.row_stride,
               (gsize) from.width * (gsize) p->bytes);
    source.encoding = normals->encoding;
    source.y = normals->y;
    to.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image seen = ntp_image_as_const(&source), shown = ntp_image_as_const(&painted);
    const gboolean ok = ntp_shade(&picture, &seen, light, &inner) == NTP_OK &&
                        ntp_convert(&to, &shown, NULL, NULL, NULL) == NTP_OK;
    g_free(colors);
    g_free(copy);
    return ok;
}
