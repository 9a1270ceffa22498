/* SPDX-License-Identifier: MIT */
/*
 * curvature.c - ntp:curvature, a curvature or cavity map of a heightfield or of normals
 *
 * The same numbers as `ntp curvature` with the same settings and the same range.  The automatic range
 * of the program depends on the whole picture; here the range is a slider.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_curvature_kind)
    enum_value(NTP_OP_CURVATURE_MEAN, "mean", N_("Edges bright, grooves dark (mean)"))
    enum_value(NTP_OP_CURVATURE_GAUSSIAN, "gaussian", N_("Knobs bright, saddles dark (Gaussian)"))
    enum_value(NTP_OP_CURVATURE_CONVEX, "convex", N_("Edges alone"))
    enum_value(NTP_OP_CURVATURE_CAVITY, "cavity", N_("Grooves alone, dark on white (cavity)"))
enum_end(ntp_op_curvature_kind)

enum_start(ntp_op_curvature_input)
    enum_value(NTP_OP_CURVATURE_NORMALS, "normals", N_("Normals"))
    enum_value(NTP_OP_CURVATURE_HEIGHT, "height", N_("Height"))
enum_end(ntp_op_curvature_input)

enum_start(ntp_op_curvature_green)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_curvature_green)

enum_start(ntp_op_curvature_edge)
    enum_value(NTP_OP_CURVATURE_AUTO, "auto", N_("As the edges show"))
    enum_value(NTP_OP_CURVATURE_WRAP, "wrap", N_("Wrap (textures that tile)"))
    enum_value(NTP_OP_CURVATURE_CLAMP, "clamp", N_("Clamp"))
enum_end(ntp_op_curvature_edge)

property_enum(kind, _("Show"), ntp_op_curvature_kind, ntp_op_curvature_kind, NTP_OP_CURVATURE_MEAN)
    description(_("What of the curvature is shown"))
property_double(range, _("Range"), 0.25)
    description(_("The curvature that is shown white or black, in 1/texel: 0.25 is that of an edge with a radius of 4 texels"))
    value_range(0.000001, 1000000.0)
    ui_range(0.001, 2.0)
    ui_gamma(3.0)
    ui_steps(0.001, 0.01)
    ui_digits(4)
property_enum(from, _("Layer holds"), ntp_op_curvature_input, ntp_op_curvature_input, NTP_OP_CURVATURE_NORMALS)
    description(_("Whether the layer is a normals texture, or a heightfield in its red or gray"))
property_double(scale, _("Scale"), 10.0)
    description(_("Of a heightfield: how many texels white rises above black"))
    value_range(-1000000.0, 1000000.0)
    ui_range(0.0, 1000.0)
    ui_gamma(3.0)
    ui_digits(3)
    ui_meta("visible", "from {height}")
property_enum(from_y, LABEL(NTP_TO_Y_LABEL), ntp_op_curvature_green, ntp_op_curvature_green, NTP_OP_UP)
    description(_("Which way green points in the layer"))
    ui_meta("visible", "from {normals}")
property_enum(border, _("Edges"), ntp_op_curvature_edge, ntp_op_curvature_edge, NTP_OP_CURVATURE_AUTO)
    description(_("What lies beyond the edges. As the edges show: clamp where opposite ones clearly do not fit together, else wrap"))
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_curvature
#  define GEGL_OP_C_SOURCE curvature.c

#  include <gegl-op.h>

#  include "gray_map.h"
#  include "output.h"
#  include "surroundings.h"

/* The menus have the order of libntp's enumerations, that of edges after its first. */
G_STATIC_ASSERT((gint) NTP_OP_CURVATURE_CAVITY == (gint) NTP_CURVATURE_CAVITY);
G_STATIC_ASSERT((gint) NTP_OP_CURVATURE_WRAP - 1 == (gint) NTP_BORDER_WRAP);
G_STATIC_ASSERT((gint) NTP_OP_CURVATURE_CLAMP - 1 == (gint) NTP_BORDER_CLAMP);

enum {
    BLOCK_HEIGHT = 64,
    REACH = 2 /* a texel at an edge has the value of the next one, which reads one more */
};

/* Set by prepare() and before threads process. */
typedef struct state {
    const blending *blending; /* shared by all */
    /* Of edges that show it: of the layer, since the last prepare(). */
    gboolean looked;
    ntp_border border_x, border_y;
} state;

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    output_formats(operation, &s->blending);
    s->looked = FALSE;
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    g_free(o->user_data);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

static GeglRectangle around(const GeglProperties *o, const GeglRectangle *area,
                            const GeglRectangle *edges)
{
    const state *s = o->user_data;
    return surroundings_of(area, edges, REACH, s->border_x == NTP_BORDER_WRAP,
                           s->border_y == NTP_BORDER_WRAP);
}

static GeglRectangle get_required(GeglOperation *operation, const gchar *pad,
                                  const GeglRectangle *area)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const GeglRectangle edges = gray_map_edges(operation, area);
    const gboolean wrap = o->border == NTP_OP_CURVATURE_WRAP;
    const GeglRectangle from = surroundings_of(area, &edges, REACH, wrap, wrap);
    (void) pad;
    if (o->border == NTP_OP_CURVATURE_AUTO)
        return edges;
    return surroundings_wrapped(&from, &edges);
}

static GeglRectangle get_bounding_box(GeglOperation *operation)
{
    const GeglRectangle *all = gegl_operation_source_get_bounding_box(operation, "input");
    return all != NULL ? *all : (GeglRectangle) { 0, 0, 0, 0 };
}

static void set_view(const GeglProperties *o, ntp_image *in)
{
    in->encoding =
        o->from == NTP_OP_CURVATURE_NORMALS ? NTP_ENCODING_STANDARD : NTP_ENCODING_HEIGHT;
    in->y = (ntp_y) o->from_y;
}

/* Do opposite edges of the layer fit together? */
static void look_at_edges(GeglOperation *operation, GeglBuffer *input, const GeglRectangle *edges)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    state *s = o->user_data;
    if (s->looked)
        return;
    s->looked = TRUE;
    s->border_x = s->border_y = NTP_BORDER_WRAP;
    if (o->border != NTP_OP_CURVATURE_AUTO) {
        s->border_x = s->border_y = (ntp_border) (o->border - 1);
        return;
    }
    const pixels p = pixels_of(gegl_operation_get_format(operation, "input"));
    guchar *all = g_malloc((gsize) edges->width * (gsize) edges->height * (gsize) p.bytes);
    ntp_image in = pixels_view(&p, all, edges->width, edges->height);
    set_view(o, &in);
    const ntp_const_image seen = ntp_image_as_const(&in);
    gegl_buffer_get(input, edges, 1.0, p.format, all, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
    ntp_relief_borders(&s->border_x, &s->border_y, &seen);
    g_free(all);
}

static gboolean make_block(const GeglProperties *o, GeglBuffer *input, GeglBuffer *output,
                           const Babl *format, const GeglRectangle *block,
                           const GeglRectangle *edges, const pixels *p)
{
    const state *s = o->user_data;
    const GeglRectangle from = around(o, block, edges);
    const gint left = block->x - from.x, top = block->y - from.y;
    const gsize texels = (gsize) from.width * (gsize) from.height;
    guchar *read = g_malloc(texels * (gsize) p->bytes), *map = g_malloc(texels * sizeof(gfloat));
    guchar *made = g_malloc((gsize) block->width * (gsize) block->height * (gsize) p->bytes);
    ntp_image in = pixels_view(p, read, from.width, from.height);
    const pixels one = { .type = p->type, .channels = 1 };
    const ntp_image gray = pixels_view(&one, map, from.width, from.height);
    const ntp_rect area = { left, top, left + block->width, top + block->height };
    const ntp_curvature_options how = { .kind = (ntp_curvature_kind) o->kind,
                                        .scale = pixels_as_typed(o->scale),
                                        .range = pixels_as_typed(o->range),
                                        .border_x = s->border_x,
                                        .border_y = s->border_y };
    surroundings_read(input, p, edges, &from, read);
    set_view(o, &in);
    const ntp_const_image seen = ntp_image_as_const(&in);
    const gboolean ok = ntp_curvature(&gray, &seen, &how, &area) == NTP_OK;
    for (gint y = 0; y < block->height && ok; y++) {
        const gsize at = (gsize) (top + y) * (gsize) from.width + (gsize) left;
        gray_map_paint(made + (gsize) y * (gsize) block->width * (gsize) p->bytes,
                       map + at * (gsize) gray.pixel_stride, read + at * (gsize) p->bytes, p,
                       block->width);
    }
    if (ok)
        output_write(output, format, block, p, made, block->width * p->bytes, s->blending);
    g_free(made);
    g_free(map);
    g_free(read);
    return ok;
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const pixels p = pixels_of(gegl_operation_get_format(operation, "input"));
    const Babl *format = gegl_operation_get_format(operation, "output");
    const GeglRectangle edges = gray_map_edges(operation, area);
    gboolean ok = TRUE;
    (void) level; /* everything is made at full size */
    for (gint y = 0; y < area->height && ok; y += BLOCK_HEIGHT) {
        const GeglRectangle block = { area->x, area->y + y, area->width,
                                      MIN(BLOCK_HEIGHT, area->height - y) };
        ok = make_block(o, input, output, format, &block, &edges, &p);
    }
    return ok;
}

/* What threads share comes first. */
static gboolean process_all(GeglOperation *operation, GeglOperationContext *context,
                            const gchar *pad, const GeglRectangle *area, gint level)
{
    GeglBuffer *input = GEGL_BUFFER(gegl_operation_context_get_object(context, "input"));
    const GeglRectangle edges = gray_map_edges(operation, area);
    if (input != NULL)
        look_at_edges(operation, input, &edges);
    return GEGL_OPERATION_CLASS(gegl_op_parent_class)
        ->process(operation, context, pad, area, level);
}

static GeglRectangle get_changed(GeglOperation *operation, const gchar *pad,
                                 const GeglRectangle *area)
{
    return get_required(operation, pad, area);
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
    operation_class->process = process_all;
    operation_class->prepare = prepare;
    operation_class->get_bounding_box = get_bounding_box;
    operation_class->get_required_for_output = get_required;
    operation_class->get_invalidated_by_change = get_changed;
    operation_class->want_in_place = FALSE;
    operation_class->threaded = TRUE;
    operation_class->opencl_support = FALSE;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:curvature",
        "title", _("Curvature"),
        "categories", "generic:normal-map",
        "description", _("Make a curvature or cavity map from a normals texture (normal map) or a heightfield"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("C_urvature..."),
        NULL);
    /* clang-format on */
}

#endif
