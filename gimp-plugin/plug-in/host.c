/* SPDX-License-Identifier: MIT */
/*
 * host.c - GIMP's layers as rasters, and results into layers
 *
 * A layer is read and written in its own model, type and space: the numbers are data, and no color
 * conversion may change them.  8-bit, 16-bit and float samples are used as stored; other types
 * (32-bit integers, half, double) are converted to float, within the same model and space.
 */
#include "host.h"

#include <string.h>

#if HOST_GIMP3
#  define drawable_width(ID)  gimp_drawable_get_width(HOST_DRAWABLE(ID))
#  define drawable_height(ID) gimp_drawable_get_height(HOST_DRAWABLE(ID))
#else
#  define drawable_width(ID)  gimp_drawable_width(ID)
#  define drawable_height(ID) gimp_drawable_height(ID)
#endif

/* ------------------------------------------------------------------------------- reading */

/* The same samples in a type that libntp supports. */
static const Babl *readable(const Babl *format, ntp_type *type)
{
    const Babl *stored = babl_format_get_type(format, 0);
    const char *encoding = babl_format_get_encoding(format);
    const char *end = strrchr(encoding, ' ');
    *type = stored == babl_type("u8")    ? NTP_TYPE_U8
            : stored == babl_type("u16") ? NTP_TYPE_U16
                                         : NTP_TYPE_F32;
    if (*type != NTP_TYPE_F32 || stored == babl_type("float") || end == NULL)
        return format;
    char *name = g_strdup_printf("%.*s float", (int) (end - encoding), encoding);
    const Babl *floats = babl_format_with_space(name, format);
    g_free(name);
    return floats;
}

static bool read_layer(void *user, int32_t y0, int32_t y1, void *rows)
{
    const host_layer *layer = user;
    gegl_buffer_get(layer->buffer, GEGL_RECTANGLE(0, y0, layer->raster.width, y1 - y0), 1,
                    layer->format, rows, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
    return true;
}

static bool read_luminance(void *user, int32_t y0, int32_t y1, void *rows)
{
    const host_layer *layer = user;
    const gsize width = (gsize) layer->raster.width;
    guchar *colors = g_malloc(width * (gsize) babl_format_get_bytes_per_pixel(layer->format));
    gfloat *to = rows;
    for (int32_t y = y0; y < y1; y++, to += width) {
        gegl_buffer_get(layer->buffer, GEGL_RECTANGLE(0, y, layer->raster.width, 1), 1,
                        layer->format, colors, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
        luminance_make(layer->luminance, colors, to, width, FALSE);
    }
    g_free(colors);
    return true;
}

static bool write_layer(void *user, const ntp_rect *area, const void *pixels, ptrdiff_t row_bytes)
{
    const host_layer *layer = user;
    gegl_buffer_set(layer->buffer,
                    GEGL_RECTANGLE(area->x0, area->y0, area->x1 - area->x0, area->y1 - area->y0), 0,
                    layer->format, pixels, (gint) row_bytes);
    return true;
}

gboolean host_has_effects(gint32 id)
{
    gboolean found = FALSE;
#if HOST_GIMP3
    GimpDrawableFilter **effects = gimp_drawable_get_filters(HOST_DRAWABLE(id));
    for (gint i = 0; effects != NULL && effects[i] != NULL; i++)
        found = found || gimp_drawable_filter_get_visible(effects[i]);
    g_free(effects);
#else
    (void) id;
#endif
    return found;
}

/*
 * A plug-in gets the pixels below the effects.  In a copy that belongs to no image GIMP merges them
 * in the layer's own format, without an undo step, to the same bits as in the layer itself.
 */
static gint32 show_effects(gint32 id)
{
#if HOST_GIMP3
    if (!host_has_effects(id))
        return 0;
    GimpLayer *copy = gimp_layer_copy(HOST_LAYER(id));
    gimp_drawable_merge_filters(GIMP_DRAWABLE(copy));
    return gimp_item_get_id(GIMP_ITEM(copy));
#else
    (void) id;
    return 0;
#endif
}

static void open_drawable(host_layer *layer, gint32 id)
{
    const Babl *format = gimp_drawable_get_format(HOST_DRAWABLE(id));
    ntp_type type = NTP_TYPE_U8;
    *layer = (host_layer) { .id = id, .buffer = gimp_drawable_get_buffer(HOST_DRAWABLE(id)) };
    layer->format = readable(format, &type);
    layer->raster = (raster) { .user = layer,
                               .read = read_layer,
                               .width = drawable_width(id),
                               .height = drawable_height(id),
                               .channels = babl_format_get_n_components(format),
                               .type = type };
}

void host_open(host_layer *layer, gint32 id)
{
    const gint32 shown = show_effects(id);
    open_drawable(layer, shown > 0 ? shown : id);
    layer->id = id;
    layer->shown = shown;
}

void host_open_luminance(host_layer *layer, gint32 id)
{
    host_open(layer, id);
    if (layer->raster.channels < 3)
        return;
    layer->luminance = luminance_of(layer->format);
    if (layer->luminance != NULL)
        layer->raster.read = read_luminance;
    else
        layer->format = babl_format_with_space("Y' float", layer->format);
    layer->raster.channels = 1;
    layer->raster.type = NTP_TYPE_F32;
}

gboolean host_has_size_of(const host_layer *layer, gint32 id)
{
    return layer->raster.width == drawable_width(id) && layer->raster.height == drawable_height(id);
}

void host_close(host_layer *layer)
{
    g_clear_object(&layer->buffer);
    if (layer->shown > 0)
        gimp_item_delete(HOST_ITEM(layer->shown));
    layer->shown = 0;
}

/* ------------------------------------------------------------------------------- writing */

/* The layer's shadow: merging copies it to the layer, where it is selected. */
static void open_shadow(host_layer *shadow, gint32 id)
{
    open_drawable(shadow, id);
    g_object_unref(shadow->buffer);
    shadow->buffer = gimp_drawable_get_shadow_buffer(HOST_DRAWABLE(id));
    shadow->raster.user = shadow;
    shadow->raster.write = write_layer;
}

/* Memory for a result that is not written to the shadow as it is. */
static void open_store(host_layer *store, const host_layer *layer, int32_t channels)
{
    static const char *const NAMES[][2] = { { "R'G'B' u8", "R'G'B'A u8" },
                                            { "R'G'B' u16", "R'G'B'A u16" },
                                            { "R'G'B' float", "R'G'B'A float" } };
    *store = (host_layer) { .id = layer->id, .raster = layer->raster, .apart = TRUE };
    store->format = babl_format(NAMES[layer->raster.type][channels == 4]);
    store->buffer = gegl_buffer_new(GEGL_RECTANGLE(0, 0, layer->raster.width, layer->raster.height),
                                    store->format);
    store->raster.user = store;
    store->raster.write = write_layer;
    store->raster.channels = channels;
}

/* Moves samples as they are: the formats mean different colors, not different numbers. */
static void copy_samples(const host_layer *to, const host_layer *from, const ntp_rect *area)
{
    enum { ROWS = 64 };
    const int32_t width = area->x1 - area->x0;
    guchar *rows = g_malloc(raster_pixel(&from->raster) * (gsize) width * ROWS);
    for (int32_t y = area->y0; y < area->y1; y += ROWS) {
        const int32_t count = MIN(ROWS, area->y1 - y);
        const GeglRectangle part = { area->x0, y, width, count };
        gegl_buffer_get(from->buffer, &part, 1, from->format, rows, GEGL_AUTO_ROWSTRIDE,
                        GEGL_ABYSS_NONE);
        gegl_buffer_set(to->buffer, &part, 0, to->format, rows, GEGL_AUTO_ROWSTRIDE);
    }
    g_free(rows);
}

/*
 * GIMP 3 blends the selected part into the layer in single precision and in the linear light of the
 * image's profile, and it converts when it adds an alpha channel.  babl does this by
 * approximations.  For a gamma curve their error exceeds a level of 16 bits; for the curve of sRGB
 * every level is preserved.
 */
static gboolean is_blended_coarsely(const host_layer *layer)
{
#if HOST_GIMP3
    GimpImage *image = gimp_item_get_image(HOST_ITEM(layer->id));
    if (layer->raster.type == NTP_TYPE_U8 || gimp_selection_is_empty(image))
        return FALSE;
    GimpColorProfile *profile = gimp_image_get_color_profile(image);
    const gboolean has_profile = profile != NULL;
    g_clear_object(&profile);
    return has_profile;
#else
    (void) layer;
    return FALSE;
#endif
}

void host_open_result(host_layer *result, const host_layer *layer, int32_t channels)
{
    if (channels == layer->raster.channels && layer->shown == 0 && !is_blended_coarsely(layer))
        open_shadow(result, layer->id);
    else
        open_store(result, layer, channels);
}

/* Copies memory into the shadow, and merges that into the layer, which gets alpha if needed. */
static void merge(host_layer *result, const ntp_rect *area)
{
    const gint32 id = result->id;
    if (result->apart) {
        host_layer shadow;
        if (result->raster.channels == 4 && !gimp_drawable_has_alpha(HOST_DRAWABLE(id)))
            gimp_layer_add_alpha(HOST_LAYER(id));
        open_shadow(&shadow, id);
        copy_samples(&shadow, result, area);
        host_close(&shadow);
    }
    host_close(result); /* GIMP gets the shadow's pixels now */
    gimp_drawable_merge_shadow(HOST_DRAWABLE(id), TRUE);
    gimp_drawable_update(HOST_DRAWABLE(id), area->x0, area->y0, area->x1 - area->x0,
                         area->y1 - area->y0);
}

#if HOST_GIMP3
/*
 * The numbers stay as they are; only the space in which they are blended changes.  So the undo step
 * contains two changes of the profile that cancel each other.  There is no way around both (in GIMP
 * 3.0.4: gimp_drawable_merge_shadow_buffer and gimp_drawable_real_apply_buffer):
 *   - Merging the shadow is the only way to write pixels with an undo step.  It blends by the
 *     selection, in the linear light of the layer's space.  So for that moment either the space or
 *     the selection must be another one.  The selection could only be put aside in a new channel,
 *     which is four entries of the undo step.
 *   - The undo step keeps the former pixels in the space that the layer has while it is merged.  If
 *     the changes of the profile were not recorded (gimp_image_undo_freeze), undo would convert
 *     those pixels to the layer's own space, and so change them.
 */
static void merge_as_srgb(host_layer *result, const ntp_rect *area)
{
    GimpImage *image = gimp_item_get_image(HOST_ITEM(result->id));
    GimpColorProfile *own = gimp_image_get_color_profile(image);
    GimpColorProfile *srgb = gimp_color_profile_new_rgb_srgb();
    gimp_image_set_color_profile(image, srgb);
    merge(result, area);
    gimp_image_set_color_profile(image, own);
    g_object_unref(srgb);
    g_object_unref(own);
}
#endif

void host_put_result(host_layer *result, const host_layer *layer, const ntp_rect *area)
{
    gimp_image_undo_group_start(gimp_item_get_image(HOST_ITEM(layer->id)));
#if HOST_GIMP3
    if (layer->shown > 0)
        gimp_drawable_merge_filters(HOST_DRAWABLE(layer->id));
#endif
    if (gimp_drawable_is_gray(HOST_DRAWABLE(layer->id)) && result->raster.channels > 2)
        gimp_image_convert_rgb(gimp_item_get_image(HOST_ITEM(layer->id)));
#if HOST_GIMP3
    if (result->apart && is_blended_coarsely(layer))
        merge_as_srgb(result, area);
    else
#endif
        merge(result, area);
    gimp_image_undo_group_end(gimp_item_get_image(HOST_ITEM(layer->id)));
}

/* ------------------------------------------------------------------------- which layers */

gboolean host_is_layer(gint32 id)
{
#if HOST_GIMP3
    GimpItem *item = id > 0 ? gimp_item_get_by_id(id) : NULL;
    return item != NULL && GIMP_IS_LAYER(item);
#else
    return id > 0 && gimp_item_is_valid(id) && gimp_item_is_layer(id);
#endif
}

/* GIMP 3.2 makes texels of texts, files and paths by one command, and has no other for texts. */
static const char *refusal_of_text(void)
{
#if HOST_GIMP3
    gchar *version = gimp_version();
    const gboolean rasterizes = !g_str_has_prefix(version, "3.0.");
    g_free(version);
    if (rasterizes)
        return _("This is a text layer, and texels would take the place of its text. First choose "
                 "Layer > Rasterize.");
#endif
    return _("This is a text layer, and texels would take the place of its text. First choose "
             "Layer > Discard Text Information.");
}

/* Only reading leaves a text as it is, or a file that a layer shows. */
static const char *refusal_to_write(gint32 id)
{
    if (gimp_item_is_text_layer(HOST_ITEM(id)))
        return refusal_of_text();
#if HOST_GIMP3
    const char *kind = G_OBJECT_TYPE_NAME(gimp_item_get_by_id(id)); /* from GIMP 3.2 on */
    if (g_str_equal(kind, "GimpLinkLayer") || g_str_equal(kind, "GimpVectorLayer"))
        return _("This layer shows a file or paths, so its texels cannot be changed. First choose "
                 "Layer > Rasterize.");
#endif
    if (gimp_item_get_lock_content(HOST_ITEM(id)))
        return _("The layer's pixels are locked. Unlock them in the Layers dialog.");
    return NULL;
}

const char *host_refusal(const procedure *p, gint32 id)
{
    if (!host_is_layer(id))
        return _("This works on layers. Select the layer itself, not its mask or a channel.");
    if (gimp_item_is_group(HOST_ITEM(id)))
        return _("This is a layer group. Select a layer in it, or merge the group.");
    if (gimp_drawable_is_indexed(HOST_DRAWABLE(id)))
        return _("Indexed images hold numbers of colors, not heights or normals. First choose "
                 "Image > Mode > RGB.");
    return p == &procedures[PROCEDURE_CHECK] ? NULL : refusal_to_write(id);
}

gboolean host_selection(const host_layer *layer, ntp_rect *area)
{
    gint x = 0, y = 0, width = 0, height = 0;
    if (!gimp_drawable_mask_intersect(HOST_DRAWABLE(layer->id), &x, &y, &width, &height))
        return FALSE;
    *area = (ntp_rect) { x, y, x + width, y + height };
    return TRUE;
}

/* -------------------------------------------------------------------------- surroundings */

static bool show_progress(void *user, double share)
{
    (void) user;
    gimp_progress_update(share);
    return true; /* cancelling ends the process, before anything is merged */
}

typedef struct range {
    void (*task)(void *work, int32_t index);
    void *work;
} range;

static void run_range(gsize offset, gsize size, gpointer data)
{
    const range *r = data;
    for (gsize i = offset; i < offset + size; i++)
        r->task(r->work, (int32_t) i);
}

static void run_parallel(void *user, int32_t count, void (*task)(void *work, int32_t index),
                         void *work)
{
    (void) user;
    range r = { task, work };
    gegl_parallel_distribute_range((gsize) count, 0, run_range, &r);
}

const surroundings host_surroundings = { .progress = show_progress,
                                         .parallel = run_parallel,
                                         .threads = 8 };
