/* SPDX-License-Identifier: MIT */
/*
 * output.c - finished texels go to GEGL
 */
#include "output.h"

#include <gegl-plugin.h>

pixels output_formats(GeglOperation *operation, const blending **b)
{
    const Babl *source = gegl_operation_get_source_format(operation, "input");
    const pixels p = pixels_as_rgb(source, source == NULL || babl_format_has_alpha(source));
    const Babl *light = blending_ahead(operation) == AHEAD_MASK ? blending_prepare(b, &p) : NULL;
    gegl_operation_set_format(operation, "input", p.format);
    gegl_operation_set_format(operation, "output", light != NULL ? light : p.format);
    return p;
}

void output_write(GeglBuffer *output, const Babl *format, const GeglRectangle *block,
                  const pixels *made, const guchar *first, gint stride, const blending *b)
{
    if (format == made->format) {
        gegl_buffer_set(output, block, 0, format, first, stride);
        return;
    }
    gfloat *light = g_new(gfloat, 4 * (gsize) block->width * (gsize) block->height);
    for (gsize y = 0; y < (gsize) block->height; y++)
        blending_put(b, made->channels,
                     (const guint16 *) (gconstpointer) (first + y * (gsize) stride),
                     light + 4 * y * (gsize) block->width, (gsize) block->width);
    gegl_buffer_set(output, block, 0, format, light, GEGL_AUTO_ROWSTRIDE);
    g_free(light);
}
