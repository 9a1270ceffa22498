/* SPDX-License-Identifier: MIT */
/*
 * blend_texels.c - details of normals laid over others, for both operations that blend
 */
#include "blend_texels.h"

#include <gegl-plugin.h>
#include <string.h>

void blend_texels_prepare(blend_texels *b, GeglOperation *operation, const Babl *base,
                          const Babl *detail)
{
    b->base = pixels_as_rgb(base, base == NULL || babl_format_has_alpha(base));
    /* Where the detail ends it is transparent or black, which is unused either way.  An alpha that it
     * does not have would cost exactness: babl adds one in single precision. */
    b->detail = pixels_as_rgb(detail, detail == NULL || babl_format_has_alpha(detail));
    const Babl *light =
        blending_ahead(operation) == AHEAD_MASK ? blending_prepare(&b->blending, &b->base) : NULL;
    b->light = light != NULL;
    gegl_operation_set_format(operation, "input", b->base.format);
    gegl_operation_set_format(operation, "output", b->light ? light : b->base.format);
}

static gboolean make(const blend_texels *b, const blend_how *how, guchar *in, guchar *aux,
                     gpointer out, gint texels)
{
    if (aux == NULL) {
        memcpy(out, in, (gsize) texels * (gsize) b->base.bytes);
        return TRUE;
    }
    ntp_image base = pixels_view(&b->base, in, texels, 1);
    ntp_image detail = pixels_view(&b->detail, aux, texels, 1);
    ntp_image dst = pixels_view(&b->base, out, texels, 1);
    base.encoding = detail.encoding = dst.encoding = how->encoding;
    base.y = dst.y = how->base_y;
    detail.y = how->detail_y;
    const ntp_const_image below = ntp_image_as_const(&base), above = ntp_image_as_const(&detail);
    return ntp_blend(&dst, &below, &above, &how->options, NULL) == NTP_OK;
}

gboolean blend_texels_make(const blend_texels *b, const blend_how *how, guchar *base,
                           guchar *detail, gpointer out, glong texels)
{
    const gsize bytes = (gsize) b->base.bytes;
    guint16 *made = b->light ? g_malloc((gsize) MIN(NTP_MAX_SIDE, texels) * bytes) : NULL;
    gboolean ok = TRUE;
    for (glong done = 0; done < texels && ok; done += NTP_MAX_SIDE) {
        const gint count = (gint) MIN(NTP_MAX_SIDE, texels - done);
        ok = make(b, how, base + (gsize) done * bytes,
                  detail == NULL ? NULL : detail + (gsize) done * (gsize) b->detail.bytes,
                  b->light ? (gpointer) made : (guchar *) out + (gsize) done * bytes, count);
        if (ok && b->light)
            blending_put(b->blending, b->base.channels, made, (gfloat *) out + 4 * done,
                         (gsize) count);
    }
    g_free(made);
    return ok;
}
