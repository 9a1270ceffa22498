/* SPDX-License-Identifier: MIT */
/*
 * layer_occlusion.c - ambient occlusion of a whole layer of heights, made once
 */
#include "layer_occlusion.h"

#include "../occlusion.h"
#include "parts.h"
#include "surroundings.h"

/* All on which the occlusion depends, but for the input. */
static gchar *settings_of(const occluded *of, ntp_type type)
{
    return g_strdup_printf("%p %d %.17g %d %d %d %d %.17g %.17g %.17g %.17g %d %d %d %d",
                           (const void *) of->in.format, (int) type, of->how.scale, of->how.invert,
                           (int) of->how.source, (int) of->how.border_x, (int) of->how.border_y,
                           of->forms.blur, of->forms.small, of->forms.middle, of->forms.large,
                           of->edges->x, of->edges->y, of->edges->width, of->edges->height);
}

/* Smooths the heights of the whole layer, if that is asked; else they are as read. */
static gboolean whole_heights(const occluded *of, guchar *data, gfloat **smooth, ntp_image *heights,
                              ntp_normals_options *how)
{
    const gint channels = smoothing_channels(of->in.channels);
    const ntp_image read = pixels_view(&of->in, data, of->edges->width, of->edges->height);
    const ntp_const_image seen = ntp_image_as_const(&read);
    *heights = read;
    if (!smoothing_acts(&of->forms))
        return TRUE;
    *smooth = g_try_malloc((gsize) of->edges->width * (gsize) of->edges->height * (gsize) channels *
                           sizeof **smooth);
    *heights =
        ntp_image_packed(*smooth, of->edges->width, of->edges->height, channels, NTP_TYPE_F32);
    heights->encoding = NTP_ENCODING_HEIGHT;
    const gboolean ok = *smooth != NULL && smoothing_run(&of->forms, heights, &seen, how) == NTP_OK;
    how->source = NTP_HEIGHT_SOURCE_RED;
    return ok;
}

gboolean layer_occlusion_make(layer_occlusion *l, const occluded *of, ntp_type type)
{
    static const gsize BYTES[] = { 1, 2, 4 }; /* of a sample, by ntp_type */
    const gsize texels = (gsize) of->edges->width * (gsize) of->edges->height;
    ntp_normals_options how = of->how;
    gchar *with = settings_of(of, type);
    ntp_image heights;
    gfloat *smooth = NULL;
    if (l->map.data != NULL && g_strcmp0(with, l->with) == 0) {
        g_free(with);
        return TRUE;
    }
    g_free(l->map.data);
    g_free(l->with);
    l->with = with;
    l->map = ntp_image_packed(g_try_malloc(texels * BYTES[type]), of->edges->width,
                              of->edges->height, 1, type);
    guchar *data = g_try_malloc(texels * (gsize) of->in.bytes);
    gboolean ok = l->map.data != NULL && data != NULL;
    if (ok) {
        surroundings_read(of->input, &of->in, of->edges, of->edges, data);
        ok = whole_heights(of, data, &smooth, &heights, &how);
    }
    if (ok) {
        const ntp_const_image seen = ntp_image_as_const(&heights);
        const ntp_hooks hooks = parts_hooks(of->operation);
        parts_tell(of->operation, 0);
        ok = occlusion_make(&l->map, &seen, &how, &hooks) == NTP_OK;
        parts_tell(of->operation, 1);
    }
    if (!ok)
        layer_occlusion_forget(l);
    g_free(smooth);
    g_free(data);
    return ok;
}

void layer_occlusion_forget(layer_occlusion *l)
{
    g_clear_pointer(&l->map.data, g_free);
}
