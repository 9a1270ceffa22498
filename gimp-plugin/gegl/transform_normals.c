/* SPDX-License-Identifier: MIT */
/*
 * transform_normals.c - ntp:transform-normals, mirrors a normals texture and scales its slopes
 *
 * The same numbers as `ntp transform` with the same settings: the vectors are mirrored with the
 * picture.
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

property_double(strength, _("Strength"), 1.0)
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
property_enum(from, _("Range of blue"), ntp_op_turned_encoding, ntp_op_turned_encoding, NTP_OP_STANDARD)
    description(_("What the blue channel stands for"))
property_enum(show, _("Show"), ntp_op_turned_view, ntp_op_turned_view, NTP_OP_TURNED)
    description(_("The lit surface is for looking at. Choose Result before you export"))
property_enum(from_y, _("Green points"), ntp_op_turned_green, ntp_op_turned_green, NTP_OP_UP)
    description(_("Which way green points in the layer; only the lit surface depends on it"))
    ui_meta("sensitive", "show {lit}")
property_double(light_from, _("Light from"), 135.0)
    description(_("Where the light of the lit surface comes from: 0 is the right, 90 the top"))
    value_range(-360.0, 360.0)
    ui_range(0.0, 360.0)
    ui_meta("unit", "degree")
    ui_meta("direction", "ccw")
    ui_meta("sensitive", "show {lit}")
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_transform_normals
#  define GEGL_OP_C_SOURCE transform_normals.c

#  include <gegl-op.h>

#  include "lit.h"
#  include "output.h"

enum {
    BLOCK_HEIGHT = 64,
    LIGHT_HEIGHT = 40 /* degrees above the surface */
};

/* Set by prepare(), read by the threads that process. */
typedef struct state {
    const blending *blending; /* shared by all */
} state;

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    const Babl *source = gegl_operation_get_source_format(operation, "input");
    const pixels p = pixels_as_rgb(source, source == NULL || babl_format_has_alpha(source));
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    const Babl *light =
        blending_ahead(operation) == AHEAD_MASK ? blending_prepare(&s->blending, &p) : NULL;
    gegl_operation_set_format(operation, "input", p.format);
    gegl_operation_set_format(operation, "output", light != NULL ? light : p.format);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    g_free(o->user_data);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* Where the texels of an area come from, which is also where those of that area go. */
static GeglRectangle mirrored(GeglOperation *operation, const GeglRectangle *area)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const GeglRectangle *all = gegl_operation_source_get_bounding_box(operation, "input");
    GeglRectangle from = *area;
    if (all == NULL || gegl_rectangle_is_empty(all) || gegl_rectangle_is_infinite_plane(all))
        return from;
    if (o->flip_x)
        from.x = 2 * all->x + all->width - area->x - area->width;
    if (o->flip_y)
        from.y = 2 * all->y + all->height - area->y - area->height;
    return from;
}

static GeglRectangle get_area(GeglOperation *operation, const gchar *pad, const GeglRectangle *area)
{
    (void) pad;
    return mirrored(operation, area);
}

static gboolean make_block(const GeglProperties *o, const pixels *p, const ntp_image *out,
                           const ntp_const_image *in, const ntp_image *picture)
{
    const ntp_transform_options how = { .flip_x = o->flip_x,
                                        .flip_y = o->flip_y,
                                        .use_strength = o->strength != 1,
                                        .strength = pixels_as_typed(o->strength) };
    const ntp_const_image made = ntp_image_as_const(out);
    const ntp_light light = lit_light(o->light_from, LIGHT_HEIGHT);
    return ntp_transform(out, in, &how, NULL) == NTP_OK &&
           (picture == NULL || lit_paint(p, picture, &made, &light, NULL));
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const pixels p = pixels_of(gegl_operation_get_format(operation, "input"));
    const Babl *format = gegl_operation_get_format(operation, "output");
    const gsize size = (gsize) area->width * BLOCK_HEIGHT * (gsize) p.bytes;
    guchar *read = g_malloc(size), *made = g_malloc(size);
    gboolean ok = TRUE;
    (void) level; /* everything is made at full size */
    for (gint y = 0; y < area->height && ok; y += BLOCK_HEIGHT) {
        const GeglRectangle block = { area->x, area->y + y, area->width,
                                      MIN(BLOCK_HEIGHT, area->height - y) };
        const GeglRectangle from = mirrored(operation, &block);
        gegl_buffer_get(input, &from, 1.0, p.format, read, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
        ntp_image in = pixels_view(&p, read, block.width, block.height);
        ntp_image out = pixels_view(&p, made, block.width, block.height);
        const ntp_image picture = in;
        in.encoding = out.encoding = (ntp_encoding) o->from;
        in.y = out.y = (ntp_y) o->from_y;
        const ntp_const_image seen = ntp_image_as_const(&in);
        const gboolean lit = o->show == NTP_OP_TURNED_LIT;
        ok = make_block(o, &p, &out, &seen, lit ? &picture : NULL);
        output_write(output, format, &block, &p, lit ? read : made, block.width * p.bytes,
                     s->blending);
    }
    g_free(read);
    g_free(made);
    return ok;
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
    operation_class->prepare = prepare;
    operation_class->get_required_for_output = get_area;
    operation_class->get_invalidated_by_change = get_area;
    operation_class->want_in_place = FALSE;
    operation_class->threaded = TRUE;
    operation_class->opencl_support = FALSE;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:transform-normals",
        "title", _("Transform Normals"),
        "categories", "generic:normal-map",
        "description", _("Make a normals texture (normal map) stronger or weaker, or flip it with its vectors"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("_Transform Normals..."),
        NULL);
    /* clang-format on */
}

#endif
