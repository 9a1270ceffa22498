/* SPDX-License-Identifier: MIT */
/*
 * output.c - finished texels go to GEGL
 */
#include "output.h"

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
