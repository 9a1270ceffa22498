/* SPDX-License-Identifier: MIT */
/*
 * normals_from_height.c - ntp:normals-from-height, normals of the heightfield in a layer
 *
 * The same numbers as `ntp from-height` with the same settings.  A scale of 0 is first replaced by
 * the one that suits the layer, for which the whole layer is read.  The picture is made in blocks.
 * Each is read with its surroundings, so that libntp gets either the true edge of the layer or
 * enough texels beyond the block.  So the result does not depend on how GEGL divides the picture.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_source)
    NTP_HEIGHT_SOURCE_CHOICES(enum_value)
    NTP_LUMINANCE_CHOICE(enum_value)
enum_end(ntp_op_source)

enum_start(ntp_op_kernel)
    NTP_KERNEL_CHOICES(enum_value)
enum_end(ntp_op_kernel)

enum_start(ntp_op_border)
    NTP_BORDER_CHOICES(enum_value)
enum_end(ntp_op_border)

enum_start(ntp_op_to)
    NTP_ENCODING_CHOICES(enum_value)
enum_end(ntp_op_to)

enum_start(ntp_op_y)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_y)

enum_start(ntp_op_blue)
    NTP_BLUE_CHOICES(enum_value)
enum_end(ntp_op_blue)

enum_start(ntp_op_alpha)
    NTP_ALPHA_CHOICES(enum_value)
enum_end(ntp_op_alpha)

enum_start(ntp_op_channels)
    NTP_CHANNEL_CHOICES(enum_value)
enum_end(ntp_op_channels)

enum_start(ntp_op_dither)
    NTP_DITHER_CHOICES(enum_value)
enum_end(ntp_op_dither)

enum_start(ntp_op_preset)
    NTP_PRESET_CHOICES(enum_value)
enum_end(ntp_op_preset)

enum_start(ntp_op_page)
    enum_value(NTP_OP_PAGE_NORMALS, "normals", N_("Normals"))
    enum_value(NTP_OP_PAGE_FORMS, "forms", N_("Forms and edges"))
    enum_value(NTP_OP_PAGE_MORE, "more", N_("More"))
enum_end(ntp_op_page)

enum_start(ntp_op_view)
    enum_value(NTP_OP_NORMALS, "result", N_("Result"))
    enum_value(NTP_OP_LIT, "lit", N_("Lit surface"))
enum_end(ntp_op_view)

property_enum(page, _("Options"), ntp_op_page, ntp_op_page, NTP_OP_PAGE_NORMALS)
    description(_("Which options are shown, so that the dialog fits the screen. It changes nothing in the result"))
property_enum(preset, LABEL(NTP_PRESET_LABEL), ntp_op_preset, ntp_op_preset, NTP_OP_NO_PRESET)
    description(_(NTP_PRESET_HELP))
    ui_meta("visible", "page {normals}")
property_double(strength, LABEL(NTP_STRENGTH_LABEL), 1.0)
    description(_(NTP_STRENGTH_HELP))
    value_range(0.0, 1e6)
    ui_range(0.0, 10.0)
    ui_gamma(3.0)
    ui_steps(0.01, 0.1)
    ui_digits(3)
    ui_meta("visible", "page {normals}")
property_double(scale, LABEL(NTP_SCALE_LABEL), 0.0)
    description(_(NTP_SCALE_HELP))
    value_range(-1e9, 1e9)
    ui_range(0.0, 1000.0)
    ui_gamma(3.0)
    ui_steps(0.1, 1.0)
    ui_digits(3)
    ui_meta("visible", "page {normals}")
property_enum(source, LABEL(NTP_SOURCE_LABEL), ntp_op_source, ntp_op_source, NTP_OP_RED)
    description(_(NTP_SOURCE_HELP))
    ui_meta("sensitive", "! preset {gimp, gimp-normalmap}")
    ui_meta("visible", "page {normals}")
property_boolean(invert, LABEL(NTP_INVERT_LABEL), FALSE)
    description(_(NTP_INVERT_HELP))
    ui_meta("visible", "page {normals}")
property_enum(to_y, LABEL(NTP_TO_Y_LABEL), ntp_op_y, ntp_op_y, NTP_OP_UP)
    description(_(NTP_TO_Y_HELP))
    ui_meta("sensitive", "preset {none}")
    ui_meta("visible", "page {normals}")
property_enum(kernel, LABEL(NTP_KERNEL_LABEL), ntp_op_kernel, ntp_op_kernel, NTP_OP_CENTRAL)
    description(_(NTP_KERNEL_HELP))
    ui_meta("sensitive", "! preset {gimp}")
    ui_meta("visible", "page {forms}")
property_enum(border_x, LABEL(NTP_BORDER_X_LABEL), ntp_op_border, ntp_op_border, NTP_OP_WRAP)
    description(_(NTP_BORDER_X_HELP))
    ui_meta("sensitive", "! preset {gimp, gimp-normalmap}")
    ui_meta("visible", "page {forms}")
property_enum(border_y, LABEL(NTP_BORDER_Y_LABEL), ntp_op_border, ntp_op_border, NTP_OP_WRAP)
    description(_(NTP_BORDER_Y_HELP))
    ui_meta("sensitive", "! preset {gimp, gimp-normalmap}")
    ui_meta("visible", "page {forms}")
property_double(blur, LABEL(NTP_BLUR_LABEL), 0.0)
    description(_(NTP_BLUR_HELP))
    value_range(0.0, 64.0)
    ui_range(0.0, 16.0)
    ui_gamma(2.0)
    ui_steps(0.1, 1.0)
    ui_digits(2)
    ui_meta("visible", "page {forms}")
property_double(small, LABEL(NTP_SMALL_LABEL), 1.0)
    description(_(NTP_SMALL_HELP))
    value_range(-100.0, 100.0)
    ui_range(0.0, 4.0)
    ui_steps(0.01, 0.1)
    ui_digits(2)
    ui_meta("visible", "page {forms}")
property_double(middle, LABEL(NTP_MIDDLE_LABEL), 1.0)
    description(_(NTP_MIDDLE_HELP))
    value_range(-100.0, 100.0)
    ui_range(0.0, 4.0)
    ui_steps(0.01, 0.1)
    ui_digits(2)
    ui_meta("visible", "page {forms}")
property_double(large, LABEL(NTP_LARGE_LABEL), 1.0)
    description(_(NTP_LARGE_HELP))
    value_range(-100.0, 100.0)
    ui_range(0.0, 4.0)
    ui_steps(0.01, 0.1)
    ui_digits(2)
    ui_meta("visible", "page {forms}")
property_double(min_z, LABEL(NTP_MIN_Z_LABEL), 0.0)
    description(_(NTP_MIN_Z_HELP))
    value_range(0.0, 1.0)
    ui_range(0.0, 1.0)
    ui_digits(3)
    ui_meta("visible", "page {forms}")
property_double(dx, LABEL(NTP_DX_LABEL), 1.0)
    description(_(NTP_DX_HELP))
    value_range(1e-6, 1e6)
    ui_range(0.1, 10.0)
    ui_digits(3)
    ui_meta("visible", "page {more}")
property_double(dy, LABEL(NTP_DY_LABEL), 1.0)
    description(_(NTP_DY_HELP))
    value_range(1e-6, 1e6)
    ui_range(0.1, 10.0)
    ui_digits(3)
    ui_meta("visible", "page {more}")
property_enum(to, LABEL(NTP_TO_LABEL), ntp_op_to, ntp_op_to, NTP_OP_STANDARD)
    description(_(NTP_TO_HELP))
    ui_meta("sensitive", "preset {none}")
    ui_meta("visible", "page {more}")
property_boolean(occlusion, LABEL(NTP_OCCLUSION_LABEL), FALSE)
    description(_(NTP_OCCLUSION_HELP))
    ui_meta("sensitive", "to {xy} | preset {labpbr}")
    ui_meta("visible", "page {more}")
property_enum(blue, LABEL(NTP_BLUE_LABEL), ntp_op_blue, ntp_op_blue, NTP_OP_DERIVED)
    description(_(NTP_BLUE_HELP))
    ui_meta("sensitive", "! preset {gimp}")
    ui_meta("visible", "page {more}")
property_enum(alpha, LABEL(NTP_ALPHA_LABEL), ntp_op_alpha, ntp_op_alpha, NTP_OP_KEEP)
    description(_("What the alpha channel of the result holds. The height needs a layer with an alpha channel"))
    ui_meta("sensitive", "! preset {labpbr}")
    ui_meta("visible", "page {more}")
property_enum(channels, LABEL(NTP_CHANNELS_LABEL), ntp_op_channels, ntp_op_channels, NTP_OP_XYZ)
    description(_(NTP_CHANNELS_HELP))
    ui_meta("sensitive", "preset {none}")
    ui_meta("visible", "page {more}")
property_enum(dither, LABEL(NTP_DITHER_LABEL), ntp_op_dither, ntp_op_dither, NTP_OP_NO_DITHER)
    description(_(NTP_DITHER_HELP))
    ui_meta("visible", "page {more}")
property_enum(show, _("Show"), ntp_op_view, ntp_op_view, NTP_OP_NORMALS)
    description(_("The lit surface is for looking at. Choose Result before you export"))
    ui_meta("visible", "page {normals}")
property_double(light_from, _("Light from"), 135.0)
    description(_("Where the light of the lit surface comes from: 0 is the right, 90 the top"))
    value_range(-360.0, 360.0)
    ui_range(0.0, 360.0)
    ui_meta("unit", "degree")
    ui_meta("direction", "ccw")
    ui_meta("visible", "page {normals} & show {lit}")
property_double(light_height, _("Height of the light"), 40.0)
    description(_("The angle between the light and the surface"))
    value_range(1.0, 90.0)
    ui_range(1.0, 90.0)
    ui_meta("unit", "degree")
    ui_meta("visible", "page {normals} & show {lit}")
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_normals_from_height
#  define GEGL_OP_C_SOURCE normals_from_height.c

#  include <gegl-op.h>

#  include "../channels.h"
#  include "layer_occlusion.h"
#  include "layer_scale.h"
#  include "lit.h"
#  include "normals_area.h"
#  include "surroundings.h"

/* The menus above have the order of libntp's enumerations. */
G_STATIC_ASSERT((gint) NTP_OP_LUMINANCE == (gint) NTP_HEIGHT_SOURCE_SCREEN + 1);
G_STATIC_ASSERT((gint) NTP_OP_SCREEN == (gint) NTP_HEIGHT_SOURCE_SCREEN);
G_STATIC_ASSERT((gint) NTP_OP_GIMP9 == (gint) NTP_KERNEL_GIMP9);
G_STATIC_ASSERT((gint) NTP_OP_REPEAT_SLOPE == (gint) NTP_BORDER_REPEAT_SLOPE);
G_STATIC_ASSERT((gint) NTP_OP_XY == (gint) NTP_ENCODING_XY);
G_STATIC_ASSERT((gint) NTP_OP_DOWN == (gint) NTP_Y_DOWN);
G_STATIC_ASSERT((gint) NTP_OP_NEAREST == (gint) NTP_BLUE_NEAREST);
G_STATIC_ASSERT((gint) NTP_OP_INVERSE_HEIGHT == (gint) NTP_ALPHA_INVERSE_HEIGHT);
G_STATIC_ASSERT((gint) NTP_OP_DXT5NM == (gint) ORDER_DXT5NM);
G_STATIC_ASSERT((gint) NTP_OP_GIMP_NORMALMAP == (gint) PRESET_GIMP_NORMALMAP);

/* The settings, as the preset has them. */
static recipe recipe_of(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    recipe r = { .how = { .scale = pixels_as_typed(o->scale),
                          .dx = pixels_as_typed(o->dx),
                          .dy = pixels_as_typed(o->dy),
                          .min_z = pixels_as_typed(o->min_z),
                          .kernel = (ntp_kernel) o->kernel,
                          .border_x = (ntp_border) o->border_x,
                          .border_y = (ntp_border) o->border_y,
                          .source = (ntp_height_source) o->source,
                          .blue = (ntp_blue) o->blue,
                          .alpha = (ntp_alpha) o->alpha,
                          .invert = o->invert },
                 .luminance = o->source == NTP_OP_LUMINANCE,
                 .y = (ntp_y) o->to_y,
                 .to = (ntp_encoding) o->to,
                 .channels = (int) o->channels };
    preset_apply((preset) o->preset, &r);
    if (r.luminance)
        r.how.source = NTP_HEIGHT_SOURCE_RED; /* the only sample */
    return r;
}

static ntp_normals_options options_of(GeglOperation *operation)
{
    return recipe_of(operation).how;
}

static smoothing smoothing_of(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    return (smoothing) { pixels_as_typed(o->blur), pixels_as_typed(o->small),
                         pixels_as_typed(o->middle), pixels_as_typed(o->large) };
}

/* Set before the threads process, and read by them. */
typedef struct state {
    pixels made;
    const blending *blending;
    layer_scale scale;    /* that suits the layer */
    layer_occlusion open; /* for blue */
} state;

/* How its heights are read, once it is prepared. */
static pixels heights_read(GeglOperation *operation)
{
    const Babl *input = gegl_operation_get_format(operation, "input");
    const pixels stored = pixels_of(input);
    const gboolean color = stored.channels >= 3; /* gray is its own luminance */
    return recipe_of(operation).luminance && color ? pixels_luminance(input) : stored;
}

static gboolean is_measured(GeglOperation *operation, const ntp_normals_options *how,
                            const GeglRectangle *edges)
{
    const state *s = GEGL_PROPERTIES(operation)->user_data;
    return s != NULL && layer_scale_is_known(&s->scale, how, heights_read(operation).format, edges);
}

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    const Babl *source = gegl_operation_get_source_format(operation, "input");
    const pixels stored = pixels_of(source);
    const recipe made = recipe_of(operation);
    const ahead next = blending_ahead(operation);
    /* GIMP drops an alpha channel that the layer does not have, and converts the others in doing
     * so. */
    const gboolean adds_alpha = next == AHEAD_OTHER && (made.how.alpha >= NTP_ALPHA_HEIGHT ||
                                                        made.channels == NTP_OP_DXT5NM);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    s->made = pixels_as_rgb(stored.format, stored.channels % 2 == 0 || adds_alpha);
    s->scale.measured =
        s->scale.measured && stored.format == gegl_operation_get_format(operation, "input");
    const Babl *light = next == AHEAD_MASK ? blending_prepare(&s->blending, &stored) : NULL;
    gegl_operation_set_format(operation, "input", stored.format);
    gegl_operation_set_format(operation, "output", light != NULL ? light : s->made.format);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    state *s = o->user_data;
    if (s != NULL) {
        layer_occlusion_forget(&s->open);
        g_free(s->open.with);
    }
    g_free(s);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* ---------------------------------------------------------------- what surrounds an area */

/* The layer; NULL: there is none, or it has no end. */
static const GeglRectangle *layer_of(GeglOperation *operation)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    return edges != NULL && !gegl_rectangle_is_empty(edges) &&
                   !gegl_rectangle_is_infinite_plane(edges)
               ? edges
               : NULL;
}

/* The whole layer, if its scale is to be measured. */
static const GeglRectangle *all_of(GeglOperation *operation)
{
    return options_of(operation).scale == 0 ? layer_of(operation) : NULL;
}

/* Is a texel made after all those above it and to its left? */
static gboolean dithers(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    return s != NULL && o->dither == NTP_OP_INTEGRABLE && s->made.type != NTP_TYPE_F32 &&
           layer_of(operation) != NULL;
}

/* Does blue hold ambient occlusion? */
static gboolean occludes(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    return o->occlusion && recipe_of(operation).to == NTP_ENCODING_XY &&
           layer_of(operation) != NULL;
}

/* What of the layer an area depends on. */
static GeglRectangle inside(GeglOperation *operation, const GeglRectangle *area)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    const ntp_normals_options how = options_of(operation);
    const smoothing forms = smoothing_of(operation);
    if (edges == NULL || gegl_rectangle_is_empty(edges) || gegl_rectangle_is_empty(area))
        return *area;
    const GeglRectangle wide = normals_area_reads(&how, &forms, area, edges);
    return surroundings_wrapped(&wide, edges);
}

static GeglRectangle get_required_for_output(GeglOperation *operation, const gchar *pad,
                                             const GeglRectangle *area)
{
    const GeglRectangle *all = all_of(operation);
    const ntp_normals_options how = options_of(operation);
    (void) pad;
    if (all != NULL && !is_measured(operation, &how, all))
        return *all;
    return dithers(operation) || occludes(operation) ? *layer_of(operation)
                                                     : inside(operation, area);
}

/* The stencil is as wide to the left as to the right, so this is the same. */
static GeglRectangle get_invalidated_by_change(GeglOperation *operation, const gchar *pad,
                                               const GeglRectangle *area)
{
    state *s = GEGL_PROPERTIES(operation)->user_data;
    const GeglRectangle *all = all_of(operation);
    (void) pad;
    if (s != NULL) {
        s->scale.measured = FALSE;
        layer_occlusion_forget(&s->open);
    }
    if (all == NULL && s != NULL && (dithers(operation) || occludes(operation)))
        all = layer_of(operation);
    return all != NULL ? *all : inside(operation, area);
}

/* Dithered, it is made at once. */
static GeglRectangle get_cached_region(GeglOperation *operation, const GeglRectangle *area)
{
    return dithers(operation) ? *layer_of(operation) : *area;
}

/* ------------------------------------------------------------------------------- normals */

/* The scale with which normals are made, once it is measured. */
static gdouble scale_of(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const gdouble scale = options_of(operation).scale;
    return (scale == 0 ? s->scale.value : scale) * pixels_as_typed(o->strength);
}

static void measure(GeglOperation *operation, GeglBuffer *input)
{
    state *s = GEGL_PROPERTIES(operation)->user_data;
    const GeglRectangle *edges = all_of(operation);
    const ntp_normals_options how = options_of(operation);
    if (s == NULL || input == NULL || edges == NULL || is_measured(operation, &how, edges))
        return;
    const pixels in = heights_read(operation);
    layer_scale_measure(&s->scale, &how, &in, input, edges);
}

static gboolean occlude(GeglOperation *operation, GeglBuffer *input)
{
    state *s = GEGL_PROPERTIES(operation)->user_data;
    occluded of = { .operation = operation,
                    .input = input,
                    .in = heights_read(operation),
                    .edges = layer_of(operation),
                    .forms = smoothing_of(operation),
                    .how = options_of(operation) };
    of.how.scale = scale_of(operation);
    return layer_occlusion_make(&s->open, &of, s->made.type);
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const ntp_light light = lit_light(o->light_from, o->light_height);
    GeglRectangle made = *area;
    normals_area j = { .recipe = recipe_of(operation),
                       .forms = smoothing_of(operation),
                       .in = heights_read(operation),
                       .out = s->made,
                       .format = gegl_operation_get_format(operation, "output"),
                       .blending = s->blending,
                       .light = o->show == NTP_OP_LIT ? &light : NULL,
                       .edges = gegl_operation_source_get_bounding_box(operation, "input") };
    (void) level; /* everything is made at full size */
    if (j.edges == NULL || gegl_rectangle_is_empty(j.edges))
        return TRUE;
    j.how = j.recipe.how;
    j.how.scale = scale_of(operation);
    if (dithers(operation)) { /* every row above is needed, from one edge to the other */
        made = *j.edges;
        made.height = area->y + area->height - made.y;
        j.errors = g_malloc0(ntp_normals_dithered_scratch_size(made.width));
    }
    if (occludes(operation) && s->open.map.data != NULL)
        j.open = &s->open.map;
    const gboolean ok = normals_area_make(&j, input, output, &made, area);
    g_free(j.errors);
    return ok;
}

/* What threads share comes first. */
static gboolean process_all(GeglOperation *operation, GeglOperationContext *context,
                            const gchar *pad, const GeglRectangle *area, gint level)
{
    GeglBuffer *input = GEGL_BUFFER(gegl_operation_context_get_object(context, "input"));
    measure(operation, input);
    if (input != NULL && occludes(operation) && !occlude(operation, input))
        return FALSE;
    if (input != NULL && dithers(operation))
        return process(operation, input, gegl_operation_context_get_target(context, "output"), area,
                       level);
    return GEGL_OPERATION_CLASS(gegl_op_parent_class)
        ->process(operation, context, pad, area, level);
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
    operation_class->process = process_all;
    operation_class->prepare = prepare;
    operation_class->get_required_for_output = get_required_for_output;
    operation_class->get_invalidated_by_change = get_invalidated_by_change;
    operation_class->get_cached_region = get_cached_region;
    operation_class->want_in_place = FALSE;
    operation_class->threaded = TRUE;
    operation_class->opencl_support = FALSE;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:normals-from-height",
        "title", _("Normals from Height"),
        "categories", "generic:normal-map",
        "description", _("Make a normals texture (normal map) of a heightfield, exact to the level"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("Normals from _Height..."),
        NULL);
    /* clang-format on */
}

#endif
