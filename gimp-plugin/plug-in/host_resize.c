/* SPDX-License-Identifier: MIT */
/*
 * host_resize.c - Resize Normals on a layer, or on an image with all its layers
 *
 * All results are computed first.  Then GIMP scales the layers, in one undo step, with masks, and
 * with channels and guides if it is the whole image; and the results take the place of the texels
 * that GIMP made.  Undo gives back the layer's former pixels as a whole, so nothing else has to be
 * recorded, and neither the selection nor a color profile has a part in it.
 */
#include "host.h"
#include "resize.h"

#include <math.h>
#include <stdlib.h>

typedef struct resized {
    gint32 id;
    gboolean shown; /* with effects, which the result contains */
    const Babl *format;
    resize_job job;
    gint x, y; /* where the layer begins */
    void *made;
} resized;

static void get_offsets(gint32 id, gint *x, gint *y)
{
#if HOST_GIMP3
    gimp_drawable_get_offsets(HOST_DRAWABLE(id), x, y);
#else
    gimp_drawable_offsets(id, x, y);
#endif
}

/* The image's layers, as IDs; free them. */
static gint32 *layers_of(gint32 id, gint *count)
{
#if HOST_GIMP3
    GimpLayer **layers = gimp_image_get_layers(gimp_item_get_image(HOST_ITEM(id)));
    for (*count = 0; layers[*count] != NULL;)
        ++*count;
    gint32 *ids = g_new(gint32, *count);
    for (gint i = 0; i < *count; i++)
        ids[i] = gimp_item_get_id(GIMP_ITEM(layers[i]));
    g_free(layers);
#else
    gint *layers = gimp_image_get_layers(gimp_item_get_image(id), count);
    gint32 *ids = g_new(gint32, *count);
    for (gint i = 0; i < *count; i++)
        ids[i] = layers[i];
    g_free(layers);
#endif
    return ids;
}

static void image_size(gint32 id, gint *width, gint *height)
{
#if HOST_GIMP3
    *width = gimp_image_get_width(gimp_item_get_image(HOST_ITEM(id)));
    *height = gimp_image_get_height(gimp_item_get_image(HOST_ITEM(id)));
#else
    *width = gimp_image_width(gimp_item_get_image(id));
    *height = gimp_image_height(gimp_item_get_image(id));
#endif
}

/* A side of a layer in an image that is scaled: its ends move as GIMP moves them. */
static gint32 scaled_side(gint offset, gint side, gint32 from, gint32 to)
{
    const gdouble factor = (gdouble) to / from;
    const gdouble first = offset * factor, end = (offset + side) * factor;
    const gint scaled = (gint) (floor(end + 0.5) - floor(first + 0.5));
    return MAX(1, scaled);
}

static job_status make(resized *r, const settings *s, gboolean whole)
{
    static report found;
    settings question = { { 0 } };
    host_layer layer;
    gint width, height;
    host_open(&layer, r->id);
    r->shown = layer.shown > 0;
    r->format = layer.format;
    get_offsets(r->id, &r->x, &r->y);
    r->job = resize_job_from(s);
    image_size(r->id, &width, &height);
    question.value[FK_FROM] = s->value[FZ_FROM];
    job_status status = !host_has_size_of(&layer, r->id) ? JOB_BEYOND
                        : layer.raster.channels < 3      ? JOB_GRAY
                                                         : JOB_DONE;
    if (status == JOB_DONE)
        status = host_find_normals(&found, &question, &layer.raster);
    if (status == JOB_DONE) {
        const raster *l = &layer.raster;
        r->job.encoding = found.encoding;
        r->job.how.touch_unused = found.touch;
        r->job.width = resize_side(s, s->value[FZ_WIDTH], whole ? width : l->width);
        r->job.height = resize_side(s, s->value[FZ_HEIGHT], whole ? height : l->height);
        if (r->job.width == 0 || r->job.height == 0)
            status = JOB_WRONG;
        else if (whole) {
            r->job.width = scaled_side(r->x, l->width, width, r->job.width);
            r->job.height = scaled_side(r->y, l->height, height, r->job.height);
        }
    }
    if (status == JOB_DONE)
        status = resize_job_run(&r->job, &layer.raster, &r->made, &host_surroundings);
    host_close(&layer);
    return status;
}

/* FALSE: GIMP gave the layer another size than was computed. */
static gboolean put(const resized *r)
{
    GeglBuffer *buffer = gimp_drawable_get_buffer(HOST_DRAWABLE(r->id));
    const gboolean fits = gegl_buffer_get_width(buffer) == r->job.width &&
                          gegl_buffer_get_height(buffer) == r->job.height;
    if (fits)
        gegl_buffer_set(buffer, GEGL_RECTANGLE(0, 0, r->job.width, r->job.height), 0, r->format,
                        r->made, GEGL_AUTO_ROWSTRIDE);
    g_object_unref(buffer); /* GIMP gets the pixels now */
    gimp_drawable_update(HOST_DRAWABLE(r->id), 0, 0, r->job.width, r->job.height);
    return fits;
}

static void scale_layer(const resized *r)
{
    gimp_layer_scale(HOST_LAYER(r->id), r->job.width, r->job.height, FALSE);
    gimp_layer_set_offsets(HOST_LAYER(r->id), r->x, r->y);
}

/* In one undo step. */
static job_status apply(const resized *all, gint count, const settings *s, gboolean whole)
{
    gint width, height;
    gboolean fits = TRUE;
    image_size(all[0].id, &width, &height);
    gimp_image_undo_group_start(gimp_item_get_image(HOST_ITEM(all[0].id)));
    gimp_context_push();
    gimp_context_set_interpolation(GIMP_INTERPOLATION_LINEAR); /* of masks and channels */
#if HOST_GIMP3
    for (gint i = 0; i < count; i++) {
        if (all[i].shown)
            gimp_drawable_merge_filters(HOST_DRAWABLE(all[i].id));
    }
#endif
    if (whole)
        gimp_image_scale(gimp_item_get_image(HOST_ITEM(all[0].id)),
                         resize_side(s, s->value[FZ_WIDTH], width),
                         resize_side(s, s->value[FZ_HEIGHT], height));
    else
        scale_layer(&all[0]);
    for (gint i = 0; i < count; i++)
        fits = put(&all[i]) && fits;
    gimp_context_pop();
    gimp_image_undo_group_end(gimp_item_get_image(HOST_ITEM(all[0].id)));
    return fits ? JOB_DONE : JOB_NO_PIXELS;
}

gboolean host_resize(const procedure *p, const settings *s, gint32 id, char message[HOST_TEXT])
{
    const gboolean whole = s->value[FZ_SCOPE] == 0;
    gint count = 1;
    gint32 *ids = whole ? layers_of(id, &count) : g_memdup2(&id, sizeof id);
    resized *all = g_new0(resized, count);
    const char *refusal = NULL;
    job_status status = JOB_DONE;
    for (gint i = 0; i < count && refusal == NULL; i++)
        refusal = host_refusal(p, ids[i]);
    gimp_progress_init(_("Normals texture"));
    for (gint i = 0; i < count && refusal == NULL && status == JOB_DONE; i++) {
        all[i].id = ids[i];
        status = make(&all[i], s, whole);
        gimp_progress_update((gdouble) (i + 1) / count);
    }
    if (refusal == NULL && status == JOB_DONE)
        status = apply(all, count, s, whole);
    gimp_progress_end();
    if (refusal != NULL || status != JOB_DONE)
        g_strlcpy(message, refusal != NULL ? refusal : _(job_status_text(status)), HOST_TEXT);
    for (gint i = 0; i < count; i++)
        free(all[i].made);
    g_free(all);
    g_free(ids);
    return refusal == NULL && status == JOB_DONE;
}
