/* SPDX-License-Identifier: MIT */
/*
 * transform_normals.c - ntp:transform-normals, mirrors and turns a normals texture, and scales its
 * slopes
 *
 * The same numbers as `ntp transform` with the same settings: the vectors are mirrored and turned
 * with the picture.  By an angle between quarter turns the picture turns about its middle.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_turned_encoding)
    NTP_ENCODING_CHOICES(enum_value)
enum_end(ntp_op_turned_encoding)

enum_start(ntp_op_turned_view)
    enum_value(NTP_OP_TURNED, "result", N_("Result"))
    enum_value(NTP_OP_TURNED_LIT, "lit", N_("Lit surface"))
enum_end(ntp_op_turned_view)

enum_start(ntp_op_turned_green)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_turned_green)

enum_start(ntp_op_turned_edge)
    enum_value(NTP_OP_TURNED_WRAP, "wrap", N_("Wrap (textures that tile)"))
    enum_value(NTP_OP_TURNED_CLAMP, "clamp", N_("Clamp"))
enum_end(ntp_op_turned_edge)

property_double(strength, LABEL(NTP_STRENGTH_LABEL), 1.0)
    description(_("Multiplies the slopes: 2 is twice as steep, 0 is flat"))
    value_range(-1024.0, 1024.0)
    ui_range(0.0, 10.0)
    ui_gamma(3.0)
    ui_steps(0.01, 0.1)
    ui_digits(3)
property_boolean(flip_x, _("Flip left and right"), FALSE)
    description(_("Exchange left and right, of the picture and of its vectors"))
property_boolean(flip_y, _("Flip top and bottom"), FALSE)
    description(_("Exchange top and bottom, of the picture and of its vectors. Both flips are half a turn"))
property_double(rotate, _("Rotate"), 0.0)
    description(_("Turn the picture clockwise, and its vectors. Quarter turns are exact"))
    value_range(-360.0, 360.0)
    ui_range(-180.0, 180.0)
    ui_steps(1.0, 15.0)
    ui_digits(2)
    ui_meta("unit", "degree")
    ui_meta("direction", "cw")
property_enum(border, _("Edges"), ntp_op_turned_edge, ntp_op_turned_edge, NTP_OP_TURNED_WRAP)
    description(_("What a turn brings in from beyond the edges"))
property_enum(from, LABEL(NTP_TO_LABEL), ntp_op_turned_encoding, ntp_op_turned_encoding, NTP_OP_STANDARD)
    description(_("What the blue channel stands for"))
property_enum(from_y, LABEL(NTP_TO_Y_LABEL), ntp_op_turned_green, ntp_op_turned_green, NTP_OP_UP)
    description(_("Which way green points in the layer: turns and the lit surface depend on it"))
property_enum(show, _("Show"), ntp_op_turned_view, ntp_op_turned_view, NTP_OP_TURNED)
    description(_("The lit surface is for looking at. Choose Result before you export"))
property_double(light_from, _("Light from"), 135.0)
    description(_("Where the light of the lit surface comes from: 0 is the right, 90 the top"))
    value_range(-360.0, 360.0)
    ui_range(0.0, 360.0)
    ui_meta("unit", "degree")
    ui_meta("direction", "ccw")
    ui_meta("visible", "show {lit}")
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_transform_normals
#  define GEGL_OP_C_SOURCE transform_normals.c

#  include <gegl-op.h>
#  include <math.h>

#  include "lit.h"
#  include "output.h"
#  include "surroundings.h"

/* The menu has the order of libntp's enumeration. */
G_STATIC_ASSERT((gint) NTP_OP_TURNED_CLAMP == (gint) NTP_BORDER_CLAMP);

enum {
    BLOCK_HEIGHT = 64,
    BLOCK_SIDE = 128, /* of what is turned by an angle: from about 181 x 181 texels */
    LIGHT_HEIGHT = 40 /* degrees above the surface */
};

/* Set by prepare(), read by the threads that process. */
typedef struct state {
    const blending *blending; /* shared by all */
} state;

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    output_formats(operation, &s->blending);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    g_free(o->user_data);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* The picture; FALSE: it has no edges, so it is not turned, or no texels. */
static gboolean find_edges(GeglOperation *operation, GeglRectangle *edges)
{
    const GeglRectangle *all = gegl_operation_source_get_bounding_box(operation, "input");
    if (all == NULL || gegl_rectangle_is_empty(all) || gegl_rectangle_is_infinite_plane(all))
        return FALSE;
    *edges = *all;
    return TRUE;
}

static gint quarters_of(const GeglProperties *o)
{
    return ntp_quarter_turns(pixels_as_typed(o->rotate));
}

/* The picture after it was turned: it lies down after an odd number of quarter turns. */
static GeglRectangle get_bounding_box(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const GeglRectangle *all = gegl_operation_source_get_bounding_box(operation, "input");
    GeglRectangle edges = all != NULL ? *all : (GeglRectangle) { 0, 0, 0, 0 };
    const gint quarters = quarters_of(o);
    if ((quarters == 1 || quarters == 3) && find_edges(operation, &edges))
        edges = (GeglRectangle) { edges.x, edges.y, edges.height, edges.width };
    return edges;
}

/* Where the texels of an area come from after flips and quarter turns. */
static GeglRectangle moved_from(const GeglProperties *o, const GeglRectangle *edges, gint quarters,
                                const GeglRectangle *area)
{
    const gint x = area->x - edges->x, y = area->y - edges->y;
    const gint right = edges->width - area->width - x, low = edges->height - area->height - y;
    GeglRectangle from = { x, y, area->width, area->height };
    if (quarters == 1)
        from = (GeglRectangle) { y, edges->height - area->width - x, area->height, area->width };
    else if (quarters == 2)
        from = (GeglRectangle) { right, low, area->width, area->height };
    else if (quarters == 3)
        from = (GeglRectangle) { edges->width - area->height - y, x, area->height, area->width };
    if (o->flip_x)
        from.x = edges->width - from.x - from.width;
    if (o->flip_y)
        from.y = edges->height - from.y - from.height;
    from.x += edges->x;
    from.y += edges->y;
    return from;
}

/* The same after a turn by an angle: enough, and beyond the edges where they wrap. */
static GeglRectangle turned_from(const GeglProperties *o, const GeglRectangle *edges,
                                 const GeglRectangle *area)
{
    const gdouble angle = o->rotate * G_PI / 180, c = cos(angle), s = sin(angle);
    const gdouble mid_x = edges->x + edges->width / 2.0, mid_y = edges->y + edges->height / 2.0;
    const gdouble u = area->x + area->width / 2.0 - mid_x;
    const gdouble v = area->y + area->height / 2.0 - mid_y;
    const gdouble x = (c * u + s * v) * (o->flip_x ? -1 : 1) + mid_x;
    const gdouble y = (c * v - s * u) * (o->flip_y ? -1 : 1) + mid_y;
    const gdouble wide = (fabs(c) * area->width + fabs(s) * area->height) / 2 + 2;
    const gdouble high = (fabs(s) * area->width + fabs(c) * area->height) / 2 + 2;
    GeglRectangle from = { (gint) floor(x - wide), (gint) floor(y - high), 0, 0 };
    from.width = (gint) ceil(x + wide) - from.x;
    from.height = (gint) ceil(y + high) - from.y;
    if (o->border == NTP_OP_TURNED_WRAP)
        return from;
    /* At least the texel at the edge. */
    const gint left = CLAMP(from.x, edges->x, edges->x + edges->width - 1);
    const gint top = CLAMP(from.y, edges->y, edges->y + edges->height - 1);
    const gint right = CLAMP(from.x + from.width, left + 1, edges->x + edges->width);
    const gint low = CLAMP(from.y + from.height, top + 1, edges->y + edges->height);
    return (GeglRectangle) { left, top, right - left, low - top };
}

static GeglRectangle get_required(GeglOperation *operation, const gchar *pad,
                                  const GeglRectangle *area)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const gint quarters = quarters_of(o);
    GeglRectangle edges;
    (void) pad;
    if (!find_edges(operation, &edges))
        return *area;
    if (quarters >= 0)
        return moved_from(o, &edges, quarters, area);
    const GeglRectangle from = turned_from(o, &edges, area);
    return surroundings_wrapped(&from, &edges);
}

static GeglRectangle get_changed(GeglOperation *operation, const gchar *pad,
                                 const GeglRectangle *area)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const gint quarters = quarters_of(o);
    GeglRectangle edges;
    (void) pad;
    if (!find_edges(operation, &edges))
        return *area;
    return quarters == 0 || quarters == 2 ? moved_from(o, &edges, quarters, area)
                                          : get_bounding_box(operation);
}

/* What one call of process() works with. */
typedef struct run {
    const GeglProperties *o;
    GeglBuffer *input, *output;
    const Babl *format;
    const blending *blending;
    pixels p;
    GeglRectangle edges;
    gint quarters; /* -1: an angle */
} run;

static GeglRectangle source_of(const run *r, const GeglRectangle *block)
{
    return r->quarters >= 0 ? moved_from(r->o, &r->edges, r->quarters, block)
                            : turned_from(r->o, &r->edges, block);
}

static gboolean make_block(const run *r, const GeglRectangle *block)
{
    const GeglProperties *o = r->o;
    const GeglRectangle from = source_of(r, block), *edges = &r->edges;
    guchar *read = g_malloc((gsize) from.width * (gsize) from.height * (gsize) r->p.bytes);
    guchar *made = g_malloc((gsize) block->width * (gsize) block->height * (gsize) r->p.bytes);
    ntp_image in = pixels_view(&r->p, read, from.width, from.height);
    ntp_image out = pixels_view(&r->p, made, block->width, block->height);
    const ntp_part part = { edges->width,      edges->height,       from.x - edges->x,
                            from.y - edges->y, block->x - edges->x, block->y - edges->y };
    const ntp_transform_options how = { .flip_x = o->flip_x,
                                        .flip_y = o->flip_y,
                                        .quarter_turns = MAX(r->quarters, 0),
                                        .use_strength = o->strength != 1,
                                        .strength = pixels_as_typed(o->strength),
                                        .angle = r->quarters < 0 ? pixels_as_typed(o->rotate) : 0,
                                        .part = &part };
    surroundings_read(r->input, &r->p, edges, &from, read);
    in.encoding = out.encoding = (ntp_encoding) o->from;
    in.y = out.y = (ntp_y) o->from_y;
    const ntp_const_image seen = ntp_image_as_const(&in);
    gboolean ok = ntp_transform(&out, &seen, &how, NULL) == NTP_OK;
    guchar *shown = made;
    if (ok && o->show == NTP_OP_TURNED_LIT) {
        const ntp_light light = lit_light(o->light_from, LIGHT_HEIGHT);
        shown = g_malloc((gsize) block->width * (gsize) block->height * (gsize) r->p.bytes);
        const ntp_image picture = pixels_view(&r->p, shown, block->width, block->height);
        const ntp_rect all = { 0, 0, block->width, block->height };
        ok = lit_paint(&r->p, &picture, &out, &light, &all, block->x - edges->x,
                       block->y - edges->y);
    }
    if (ok)
        output_write(r->output, r->format, block, &r->p, shown, block->width * r->p.bytes,
                     r->blending);
    if (shown != made)
        g_free(shown);
    g_free(made);
    g_free(read);
    return ok;
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    run r = { .o = o,
              .input = input,
              .output = output,
              .format = gegl_operation_get_format(operation, "output"),
              .blending = s->blending,
              .p = pixels_of(gegl_operation_get_format(operation, "input")),
              .edges = *area,
              .quarters = quarters_of(o) };
    gboolean ok = TRUE;
    (void) level; /* everything is made at full size */
    if (!find_edges(operation, &r.edges))
        r.quarters = 0;
    const gint high = r.quarters < 0 ? BLOCK_SIDE : BLOCK_HEIGHT;
    const gint wide = r.quarters < 0 ? BLOCK_SIDE : area->width;
    for (gint y = 0; y < area->height && ok; y += high) {
        for (gint x = 0; x < area->width && ok; x += wide) {
            const GeglRectangle block = { area->x + x, area->y + y, MIN(wide, area->width - x),
                                          MIN(high, area->height - y) };
            ok = make_block(&r, &block);
        }
    }
    return ok;
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
    operation_class->prepare = prepare;
    operation_class->get_bounding_box = get_bounding_box;
    operation_class->get_required_for_output = get_required;
    operation_class->get_invalidated_by_change = get_changed;
    operation_class->want_in_place = FALSE;
    operation_class->threaded = TRUE;
    operation_class->opencl_support = FALSE;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:transform-normals",
        "title", _("Transform Normals"),
        "categories", "generic:normal-map",
        "description", _("Make a normals texture (normal map) stronger or weaker, or flip and rotate it with its vectors"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("_Transform Normals..."),
        NULL);
    /* clang-format on */
}

#endif
