/* SPDX-License-Identifier: MIT */
/*
 * operation.c - normals by the operation, which runs inside GIMP
 *
 * A plug-in gets every texel from GIMP and sends every texel back, which takes longer than
 * computing the normals.  So the operation processes a whole layer, if its result is the same: it
 * has no access to other layers and no DU/DV, and GIMP blends it differently at the soft edge of a
 * selection.
 */
#include "operation.h"
#include "../../channels.h"
#include "../../presets.h"

#define OPERATION "ntp:normals-from-height"

/* The whole layer, and nothing between the operation's texels and the layer's. */
static gboolean takes_layer(const host_layer *layer)
{
    GimpDrawable *drawable = HOST_DRAWABLE(layer->id);
    GimpImage *image = gimp_item_get_image(HOST_ITEM(layer->id));
    GimpDrawableFilter **effects = gimp_drawable_get_filters(drawable);
    const gboolean bare = effects == NULL || effects[0] == NULL;
    g_free(effects);
    return bare && layer->raster.channels >= 3 && gimp_selection_is_empty(image) &&
           layer->format == gimp_drawable_get_format(drawable);
}

/* The operation takes a number of single precision for the decimal nearest to it. */
static gboolean takes_number(double value)
{
    char text[G_ASCII_DTOSTR_BUF_SIZE];
    if ((double) (float) value != value)
        return TRUE;
    return g_ascii_strtod(g_ascii_formatd(text, sizeof text, "%.6g", value), NULL) == value;
}

static gboolean takes_settings(const settings *s, gboolean has_alpha)
{
    for (int i = 0; i < FN_COUNT; i++) {
        const field *f = &procedures[PROCEDURE_NORMALS].fields[i];
        if (f->kind == FIELD_NUMBER && !takes_number(s->value[i]))
            return FALSE;
    }
    const double source = s->value[FN_SOURCE];
    const preset chosen = (preset) s->value[FN_PRESET];
    if (chosen == PRESET_GIMP || chosen == PRESET_LABPBR || s->value[FN_DITHER] != 0 ||
        (s->value[FN_CHANNELS] == ORDER_DXT5NM && !has_alpha))
        return FALSE;
    if (source > NTP_HEIGHT_SOURCE_SCREEN || (source == NTP_HEIGHT_SOURCE_ALPHA && !has_alpha))
        return FALSE;
    return !host_is_layer((gint32) s->value[FN_HEIGHT_LAYER]) && s->value[FN_ALPHA] == ALPHA_KEEP &&
           s->value[FN_FLIP_X] == 0 && s->value[FN_SWAP] == 0 && s->value[FN_DUDV] == DUDV_NONE;
}

/* The filter; NULL: this GIMP has no such operation, and the user is not told. */
static GimpDrawableFilter *filter_new(GimpDrawable *drawable)
{
    GimpPlugIn *plug_in = gimp_get_plug_in();
    gimp_plug_in_set_pdb_error_handler(plug_in, GIMP_PDB_ERROR_HANDLER_PLUGIN);
    GimpDrawableFilter *filter = gimp_drawable_filter_new(drawable, OPERATION, NULL);
    gimp_plug_in_set_pdb_error_handler(plug_in, GIMP_PDB_ERROR_HANDLER_INTERNAL);
    return filter;
}

/* Sets the properties, which have the same names; FALSE: some are missing. */
static gboolean fill(GObject *config, const settings *s)
{
    for (int i = FN_SCALE; i < FN_COUNT; i++) {
        if ((i > FN_BLUE && i < FN_PRESET) || i == FN_FORCE)
            continue;
        const field *f = &procedures[PROCEDURE_NORMALS].fields[i];
        if (g_object_class_find_property(G_OBJECT_GET_CLASS(config), f->name) == NULL)
            return FALSE;
        if (f->kind == FIELD_CHOICE)
            g_object_set(config, f->name, f->choices[(int) s->value[i]].name, NULL);
        else if (f->kind == FIELD_SWITCH)
            g_object_set(config, f->name, (gboolean) (s->value[i] != 0), NULL);
        else
            g_object_set(config, f->name, s->value[i], NULL);
    }
    return TRUE;
}

gboolean operation_merge(const settings *s, const host_layer *layer)
{
    GimpDrawable *drawable = HOST_DRAWABLE(layer->id);
    GimpImage *image = gimp_item_get_image(HOST_ITEM(layer->id));
    GimpDrawableFilter *filter =
        takes_settings(s, layer->raster.channels == 4) && takes_layer(layer) ? filter_new(drawable)
                                                                             : NULL;
    if (filter == NULL)
        return FALSE;
    if (!fill(G_OBJECT(gimp_drawable_filter_get_config(filter)), s)) {
        gimp_drawable_filter_delete(filter);
        return FALSE;
    }
    gimp_drawable_filter_update(filter);
    gimp_image_undo_group_start(image);
    gimp_drawable_merge_filter(drawable, filter);
    const gboolean done = gimp_pdb_get_last_status(gimp_get_pdb()) == GIMP_PDB_SUCCESS;
    gimp_image_undo_group_end(image);
    return done;
}
