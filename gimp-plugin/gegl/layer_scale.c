/* SPDX-License-Identifier: MIT */
/*
 * layer_scale.c - the scale that suits a layer of heights, measured once
 */
#include "layer_scale.h"

#include "surroundings.h"

gboolean layer_scale_is_known(const layer_scale *s, const ntp_normals_options *how,
                              const Babl *format, const GeglRectangle *edges)
{
    return s->measured && s->format == format && s->of.kernel == how->kernel &&
           s->of.source == how->source && s->of.border_x == how->border_x &&
           s->of.border_y == how->border_y && s->of.dx == how->dx && s->of.dy == how->dy &&
           gegl_rectangle_equal(&s->edges, edges);
}

/* Counts the slopes of row y, which is counted from the upper edge. */
static void measure_row(ntp_relief *relief, const ntp_normals_options *how, const pixels *in,
                        GeglBuffer *input, const GeglRectangle *edges, gint y, guchar *rows)
{
    int32_t first = 0;
    const int32_t step = ntp_relief_row(edges->width, edges->height, y, &first);
    if (step == 0)
        return;
    const GeglRectangle row = { edges->x, edges->y + y, edges->width, 1 };
    const gboolean wrap = how->border_y == NTP_BORDER_WRAP;
    const GeglRectangle around = surroundings_of(&row, edges, ntp_normals_reach(how), FALSE, wrap);
    ntp_normals_options local = *how;
    if (wrap)
        local.border_y = NTP_BORDER_CLAMP; /* what lies beyond was read */
    surroundings_read(input, in, edges, &around, rows);
    const ntp_image view = pixels_view(in, rows, around.width, around.height);
    const ntp_const_image seen = ntp_image_as_const(&view);
    ntp_relief_add(relief, &seen, &local, first, row.y - around.y, step);
}

void layer_scale_measure(layer_scale *s, const ntp_normals_options *how, const pixels *in,
                         GeglBuffer *input, const GeglRectangle *edges)
{
    const gsize rows = 1 + 2 * (gsize) ntp_normals_reach(how);
    guchar *data = g_malloc(rows * (gsize) edges->width * (gsize) in->bytes);
    ntp_relief *relief = g_new0(ntp_relief, 1);
    for (gint y = 0; y < edges->height; y++)
        measure_row(relief, how, in, input, edges, y, data);
    *s = (layer_scale) { .measured = TRUE,
                         .value = ntp_relief_scale(relief),
                         .of = *how,
                         .format = in->format,
                         .edges = *edges };
    g_free(relief);
    g_free(data);
}
