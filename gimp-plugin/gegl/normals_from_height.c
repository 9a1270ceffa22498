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
    enum_value(NTP_OP_KEEP, "keep", N_("Unchanged"))
    enum_value(NTP_OP_ONE, "one", N_("Opaque"))
    enum_value(NTP_OP_INVERSE, "inverse", N_("Inverted"))
    enum_value(NTP_OP_HEIGHT, "height", N_("Height"))
    enum_value(NTP_OP_INVERSE_HEIGHT, "inverse-height", N_("Inverted height"))
enum_end(ntp_op_alpha)

enum_start(ntp_op_view)
    enum_value(NTP_OP_NORMALS, "result", N_("Result"))
    enum_value(NTP_OP_LIT, "lit", N_("Lit surface"))
enum_end(ntp_op_view)

property_double(strength, _("Strength"), 1.0)
    description(_("Multiplies the slopes. With a scale of 0, one in twenty of the slopes is steeper than 45 degrees at strength 1, whatever the size of the layer"))
    value_range(0.0, 1e6)
    ui_range(0.0, 10.0)
    ui_gamma(3.0)
    ui_steps(0.01, 0.1)
    ui_digits(3)
property_double(scale, _("Scale (0: from the layer)"), 0.0)
    description(_("How many texels white rises above black. 0: as the slopes of the layer suggest; a negative scale inverts the relief"))
    value_range(-1e9, 1e9)
    ui_range(0.0, 1000.0)
    ui_gamma(3.0)
    ui_steps(0.1, 1.0)
    ui_digits(3)
property_enum(kernel, _("Kernel"), ntp_op_kernel, ntp_op_kernel, NTP_OP_CENTRAL)
    description(_("How a slope is taken. A wider kernel is smoother, none is stronger"))
property_enum(source, _("Height"), ntp_op_source, ntp_op_source, NTP_OP_RED)
    description(_("Which number of a pixel is the height. In a gray picture red, green and blue are the gray value"))
property_boolean(invert, _("Invert height"), FALSE)
    description(_("Black is high and white is low"))
property_enum(to_y, _("Green points"), ntp_op_y, ntp_op_y, NTP_OP_UP)
    description(_("Up the picture: OpenGL, glTF, USD, Blender, Unity, Godot. Down: DirectX, Unreal"))
property_enum(border_x, _("Left and right edge"), ntp_op_border, ntp_op_border, NTP_OP_WRAP)
    description(_("The height beyond the left and right edge"))
property_enum(border_y, _("Top and bottom edge"), ntp_op_border, ntp_op_border, NTP_OP_WRAP)
    description(_("The height beyond the top and bottom edge"))
property_double(dx, _("Spacing X"), 1.0)
    description(_("Width of a texel, for textures that are stretched"))
    value_range(1e-6, 1e6)
    ui_range(0.1, 10.0)
    ui_digits(3)
property_double(dy, _("Spacing Y"), 1.0)
    description(_("Height of a texel"))
    value_range(1e-6, 1e6)
    ui_range(0.1, 10.0)
    ui_digits(3)
property_double(min_z, _("Minimum Z"), 0.0)
    description(_("Steeper slopes are made this steep"))
    value_range(0.0, 1.0)
    ui_range(0.0, 1.0)
    ui_digits(3)
property_enum(to, _("Range of blue"), ntp_op_to, ntp_op_to, NTP_OP_STANDARD)
    description(_("What the blue channel stands for"))
property_enum(blue, _("Blue"), ntp_op_blue, ntp_op_blue, NTP_OP_DERIVED)
    description(_("A derived blue survives any conversion"))
property_enum(alpha, _("Alpha"), ntp_op_alpha, ntp_op_alpha, NTP_OP_KEEP)
    description(_("What the alpha channel of the result holds. The height needs a layer with an alpha channel"))
property_enum(show, _("Show"), ntp_op_view, ntp_op_view, NTP_OP_NORMALS)
    description(_("The lit surface is for looking at. Choose Result before you export"))
property_double(light_from, _("Light from"), 135.0)
    description(_("Where the light of the lit surface comes from: 0 is the right, 90 the top"))
    value_range(-360.0, 360.0)
    ui_range(0.0, 360.0)
    ui_meta("unit", "degree")
    ui_meta("direction", "ccw")
    ui_meta("sensitive", "show {lit}")
property_double(light_height, _("Height of the light"), 40.0)
    description(_("The angle between the light and the surface"))
    value_range(1.0, 90.0)
    ui_range(1.0, 90.0)
    ui_meta("unit", "degree")
    ui_meta("sensitive", "show {lit}")
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_normals_from_height
#  define GEGL_OP_C_SOURCE normals_from_height.c

#  include <gegl-op.h>

#  include "lit.h"
#  include "output.h"
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

enum {
    BLOCK_WIDTH = 512, /* a block of RGBA heights and its normals fit into the second-level cache */
    BLOCK_HEIGHT = 64
};

static ntp_normals_options options_of(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    return (ntp_normals_options) { .scale = pixels_as_typed(o->scale),
                                   .dx = pixels_as_typed(o->dx),
                                   .dy = pixels_as_typed(o->dy),
                                   .min_z = pixels_as_typed(o->min_z),
                                   .kernel = (ntp_kernel) o->kernel,
                                   .border_x = (ntp_border) o->border_x,
                                   .border_y = (ntp_border) o->border_y,
                                   .source = o->source == NTP_OP_LUMINANCE
                                                 ? NTP_HEIGHT_SOURCE_RED /* the only sample */
                                                 : (ntp_height_source) o->source,
                                   .blue = (ntp_blue) o->blue,
                                   .alpha = (ntp_alpha) o->alpha,
                                   .invert = o->invert };
}

/* Set before the threads process, and read by them. */
typedef struct state {
    pixels made;
    const blending *blending;
    gboolean measured; /* the scale that suits the layer, and what it depends on */
    gdouble scale;
    ntp_normals_options of;
    const Babl *of_format; /* the luminance is read as red of another format */
    GeglRectangle edges;
} state;

static gboolean is_measured(GeglOperation *operation, const ntp_normals_options *how,
                            const GeglRectangle *edges)
{
    const state *s = GEGL_PROPERTIES(operation)->user_data;
    return s != NULL && s->measured &&
           s->of_format == gegl_operation_get_format(operation, "input") &&
           s->of.kernel == how->kernel && s->of.source == how->source &&
           s->of.border_x == how->border_x && s->of.border_y == how->border_y &&
           s->of.dx == how->dx && s->of.dy == how->dy && gegl_rectangle_equal(&s->edges, edges);
}

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    const Babl *source = gegl_operation_get_source_format(operation, "input");
    const pixels stored = pixels_of(source);
    const pixels in = o->source == NTP_OP_LUMINANCE ? pixels_luminance(source) : stored;
    const ahead next = blending_ahead(operation);
    /* GIMP drops an alpha channel that the layer does not have, and converts the others in doing
     * so. */
    const gboolean adds_alpha =
        next == AHEAD_OTHER && (o->alpha == NTP_OP_HEIGHT || o->alpha == NTP_OP_INVERSE_HEIGHT);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    s->made = pixels_as_rgb(stored.format, stored.channels % 2 == 0 || adds_alpha);
    s->measured = s->measured && in.format == gegl_operation_get_format(operation, "input");
    const Babl *light = next == AHEAD_MASK ? blending_prepare(&s->blending, &stored) : NULL;
    gegl_operation_set_format(operation, "input", in.format);
    gegl_operation_set_format(operation, "output", light != NULL ? light : s->made.format);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    state *s = o->user_data;
    g_free(s);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* ---------------------------------------------------------------- what surrounds an area */

/* The whole layer, if the result depends on all of it; NULL: it does not, or there is no such
 * thing. */
static const GeglRectangle *all_of(GeglOperation *operation)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    return options_of(operation).scale == 0 && edges != NULL && !gegl_rectangle_is_empty(edges) &&
                   !gegl_rectangle_is_infinite_plane(edges)
               ? edges
               : NULL;
}

/* The reach is chosen so that borders act on this part as they do on the whole. */
static GeglRectangle surroundings(GeglOperation *operation, const GeglRectangle *area)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    if (edges == NULL || gegl_rectangle_is_empty(edges) || gegl_rectangle_is_empty(area))
        return *area;
    const ntp_normals_options how = options_of(operation);
    return surroundings_of(area, edges, ntp_normals_reach(&how), how.border_x == NTP_BORDER_WRAP,
                           how.border_y == NTP_BORDER_WRAP);
}

static GeglRectangle inside(GeglOperation *operation, const GeglRectangle *area)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    const GeglRectangle wide = surroundings(operation, area);
    return edges == NULL || gegl_rectangle_is_empty(edges) ? wide
                                                           : surroundings_wrapped(&wide, edges);
}

static GeglRectangle get_required_for_output(GeglOperation *operation, const gchar *pad,
                                             const GeglRectangle *area)
{
    const GeglRectangle *all = all_of(operation);
    const ntp_normals_options how = options_of(operation);
    (void) pad;
    if (all != NULL && !is_measured(operation, &how, all))
        return *all;
    return inside(operation, area);
}

/* The stencil is as wide to the left as to the right, so this is the same. */
static GeglRectangle get_invalidated_by_change(GeglOperation *operation, const gchar *pad,
                                               const GeglRectangle *area)
{
    state *s = GEGL_PROPERTIES(operation)->user_data;
    const GeglRectangle *all = all_of(operation);
    (void) pad;
    if (s != NULL)
        s->measured = FALSE;
    return all != NULL ? *all : inside(operation, area);
}

/* ---------------------------------------------------------------- the scale of the layer */

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

static void measure(GeglOperation *operation, GeglBuffer *input)
{
    state *s = GEGL_PROPERTIES(operation)->user_data;
    const GeglRectangle *edges = all_of(operation);
    const ntp_normals_options how = options_of(operation);
    if (s == NULL || input == NULL || edges == NULL || is_measured(operation, &how, edges))
        return;
    const pixels in = pixels_of(gegl_operation_get_format(operation, "input"));
    const gsize rows = 1 + 2 * (gsize) ntp_normals_reach(&how);
    guchar *data = g_malloc(rows * (gsize) edges->width * (gsize) in.bytes);
    ntp_relief *relief = g_new0(ntp_relief, 1);
    for (gint y = 0; y < edges->height; y++)
        measure_row(relief, &how, &in, input, edges, y, data);
    s->scale = ntp_relief_scale(relief);
    s->of = how;
    s->of_format = in.format;
    s->edges = *edges;
    s->measured = TRUE;
    g_free(relief);
    g_free(data);
}

/* ------------------------------------------------------------------------------- a block */

typedef struct job {
    ntp_normals_options how;
    pixels in, out;
    ntp_encoding to;
    ntp_y to_y;
    const GeglRectangle *edges;
    const Babl *format; /* of the output */
    const blending *blending;
    const ntp_light *light; /* NULL: output the normals */
    guchar *heights, *normals;
} job;

static gboolean make_block(GeglOperation *operation, const job *j, GeglBuffer *input,
                           GeglBuffer *output, const GeglRectangle *block)
{
    const GeglRectangle around = surroundings(operation, block);
    surroundings_read(input, &j->in, j->edges, &around, j->heights);

    /* Both views cover what was read; only the block of the normals is in memory. */
    const ntp_rect area = { block->x - around.x, block->y - around.y,
                            block->x - around.x + block->width,
                            block->y - around.y + block->height };
    ntp_image heights = pixels_view(&j->in, j->heights, around.width, around.height);
    const ntp_const_image src = ntp_image_as_const(&heights);
    ntp_image dst = pixels_view(&j->out, j->normals, around.width, around.height);
    dst.encoding = j->to;
    dst.y = j->to_y;
    if (ntp_normals_from_height(&dst, &src, &j->how, NULL, &area) != NTP_OK)
        return FALSE;
    const ntp_const_image normals = ntp_image_as_const(&dst);
    if (j->light != NULL) {
        dst = pixels_view(&j->out, j->heights, around.width, around.height);
        if (!lit_paint(&j->out, &dst, &normals, j->light, &area))
            return FALSE;
    }
    const guchar *first =
        (const guchar *) dst.data + area.y0 * dst.row_stride + area.x0 * dst.pixel_stride;
    output_write(output, j->format, block, &j->out, first, (gint) dst.row_stride, j->blending);
    return TRUE;
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const ntp_light light = lit_light(o->light_from, o->light_height);
    job j = { .how = options_of(operation),
              .in = pixels_of(gegl_operation_get_format(operation, "input")),
              .out = s->made,
              .format = gegl_operation_get_format(operation, "output"),
              .blending = s->blending,
              .light = o->show == NTP_OP_LIT ? &light : NULL,
              .to = (ntp_encoding) o->to,
              .to_y = (ntp_y) o->to_y,
              .edges = gegl_operation_source_get_bounding_box(operation, "input") };
    (void) level; /* everything is made at full size */
    if (j.edges == NULL || gegl_rectangle_is_empty(j.edges))
        return TRUE;
    j.how.scale = (j.how.scale == 0 ? s->scale : j.how.scale) * pixels_as_typed(o->strength);
    const gsize margin = 2 * (gsize) ntp_normals_reach(&j.how);
    const gsize most = (BLOCK_WIDTH + margin) * (BLOCK_HEIGHT + margin);
    /* The lit picture takes the place of the heights. */
    j.heights = g_malloc(most * (gsize) MAX(j.in.bytes, j.out.bytes));
    j.normals = g_malloc(most * (gsize) j.out.bytes);
    /* The stencils stay inside what was read, so nothing beyond it is needed. */
    if (j.how.border_x == NTP_BORDER_WRAP)
        j.how.border_x = NTP_BORDER_CLAMP;
    if (j.how.border_y == NTP_BORDER_WRAP)
        j.how.border_y = NTP_BORDER_CLAMP;

    gboolean ok = TRUE;
    for (gint y = 0; y < area->height && ok; y += BLOCK_HEIGHT) {
        for (gint x = 0; x < area->width && ok; x += BLOCK_WIDTH) {
            const GeglRectangle block = { area->x + x, area->y + y,
                                          MIN(BLOCK_WIDTH, area->width - x),
                                          MIN(BLOCK_HEIGHT, area->height - y) };
            ok = make_block(operation, &j, input, output, &block);
        }
    }
    g_free(j.heights);
    g_free(j.normals);
    return ok;
}

/* What threads share comes first. */
static gboolean process_all(GeglOperation *operation, GeglOperationContext *context,
                            const gchar *pad, const GeglRectangle *area, gint level)
{
    GeglBuffer *input = GEGL_BUFFER(gegl_operation_context_get_object(context, "input"));
    measure(operation, input);
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
