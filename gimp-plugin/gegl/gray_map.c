/* SPDX-License-Identifier: MIT */
/*
 * gray_map.c - what the operations share that make a gray map of a layer
 */
#include "gray_map.h"

#include <gegl-plugin.h>
#include <string.h>

GeglRectangle gray_map_edges(GeglOperation *operation, const GeglRectangle *area)
{
    const GeglRectangle *all = gegl_operation_source_get_bounding_box(operation, "input");
    const gboolean bounded =
        all != NULL && !gegl_rectangle_is_empty(all) && !gegl_rectangle_is_infinite_plane(all);
    return bounded ? *all : *area;
}

void gray_map_paint(guchar *made, const guchar *map, const guchar *read, const pixels *p,
                    gint count)
{
    const gsize sample = (gsize) p->bytes / (gsize) p->channels;
    for (gint i = 0; i < count; i++) {
        for (gint c = 0; c < 3; c++)
            memcpy(made + (gsize) c * sample, map, sample);
        if (p->channels == 4)
            memcpy(made + 3 * sample, read + 3 * sample, sample);
        made += p->bytes;
        read += p->bytes;
        map += sample;
    }
}
