/* SPDX-License-Identifier: MIT */
/*
 * ambient_occlusion.c - ntp:ambient-occlusion, the ambient occlusion of a heightfield or of normals
 *
 * The same numbers as `ntp occlusion` with the same settings.  Light depends on texels far away, so
 * the whole picture is made at once, by all threads of GEGL.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_occlusion_input)
    enum_value(NTP_OP_OCCLUSION_HEIGHT, "height", N_("Height"))
    enum_value(NTP_OP_OCCLUSION_NORMALS, "normals", N_("Normals"))
enum_end(ntp_op_occlusion_input)

enum_start(ntp_op_occlusion_green)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_occlusion_green)

enum_start(ntp_op_occlusion_edge)
    enum_value(NTP_OP_OCCLUSION_AUTO, "auto", N_("As the edges show"))
    enum_value(NTP_OP_OCCLUSION_WRAP, "wrap", N_("Wrap (textures that tile)"))
    enum_value(NTP_OP_OCCLUSION_CLAMP, "clamp", N_("Clamp"))
enum_end(ntp_op_occlusion_edge)

property_enum(from, _("Layer holds"), ntp_op_occlusion_input, ntp_op_occlusion_input, NTP_OP_OCCLUSION_HEIGHT)
    description(_("Whether the layer is a heightfield, in its red or gray, or a normals texture, of which the heights are found first"))
property_double(scale, _("Scale"), 10.0)
    description(_("Of a heightfield: how many texels white rises above black"))
    value_range(-1000000.0, 1000000.0)
    ui_range(0.0, 1000.0)
    ui_gamma(3.0)
    ui_digits(3)
    ui_meta("visible", "from {height}")
property_enum(from_y, LABEL(NTP_TO_Y_LABEL), ntp_op_occlusion_green, ntp_op_occlusion_green, NTP_OP_UP)
    description(_("Which way green points in the layer"))
    ui_meta("visible", "from {normals}")
property_double(radius, _("Radius (0: all)"), 0.0)
    description(_("What is farther away, in texels, casts no shade; 0: the longer side of the layer"))
    value_range(0.0, 100000.0)
    ui_range(0.0, 512.0)
    ui_gamma(2.0)
    ui_digits(1)
property_enum(border, _("Edges"), ntp_op_occlusion_edge, ntp_op_occlusion_edge, NTP_OP_OCCLUSION_AUTO)
    description(_("What lies beyond the edges. As the edges show: clamp where opposite ones clearly do not fit together, else wrap"))
/* clang-format on */

#else

#  define GEGL_OP_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_ambient_occlusion
#  define GEGL_OP_C_SOURCE ambient_occlusion.c

#  include <gegl-op.h>

#  include "gray_map.h"
#  include "output.h"
#  include "parts.h"
#  include "surface_heights.h"

/* After the first one the menu has the order of libntp's enumeration. */
G_STATIC_ASSERT((gint) NTP_OP_OCCLUSION_WRAP - 1 == (gint) NTP_BORDER_WRAP);
G_STATIC_ASSERT((gint) NTP_OP_OCCLUSION_CLAMP - 1 == (gint) NTP_BORDER_CLAMP);

enum { ALIGNMENT = 64 };

/* Set by prepare(), read by process(). */
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

static GeglRectangle get_required(GeglOperation *operation, const gchar *pad,
                                  const GeglRectangle *area)
{
    (void) pad;
    return gray_map_edges(operation, area);
}

static GeglRectangle get_cached(GeglOperation *operation, const GeglRectangle *area)
{
    return gray_map_edges(operation, area);
}

static ntp_status occlude(const ntp_image *map, const ntp_const_image *heights,
                          const ntp_occlusion_options *how, const ntp_hooks *hooks)
{
    const gsize size =
        ntp_occlusion_scratch_size(how, heights->width, heights->height, hooks->parts);
    guchar *memory = g_malloc(size + ALIGNMENT);
    guchar *scratch = memory + (ALIGNMENT - GPOINTER_TO_SIZE(memory) % ALIGNMENT) % ALIGNMENT;
    const ntp_status status = ntp_occlusion(map, heights, how, scratch, size, hooks);
    g_free(memory);
    return size > 0 ? status : NTP_ERR_ARGUMENT;
}

static ntp_status occlude_normals(const ntp_image *map, const ntp_const_image *normals,
                                  ntp_occlusion_options *how, gboolean wrap, const ntp_hooks *hooks)
{
    const pixels one = { .type = NTP_TYPE_F32, .channels = 1 };
    const gsize texels = (gsize) normals->width * (gsize) normals->height;
    gfloat *data = g_new(gfloat, texels);
    const ntp_image heights = pixels_view(&one, data, normals->width, normals->height);
    const ntp_const_image seen = ntp_image_as_const(&heights);
    const bool wraps[2] = { wrap, wrap };
    ntp_status status = surface_heights(&heights, normals, wraps, hooks);
    how->scale = 1;
    if (status == NTP_OK)
        status = occlude(map, &seen, how, hooks);
    g_free(data);
    return status;
}

static gboolean make(GeglOperation *operation, const ntp_image *map, ntp_image *layer)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const gboolean normals = o->from == NTP_OP_OCCLUSION_NORMALS;
    layer->encoding = normals ? NTP_ENCODING_STANDARD : NTP_ENCODING_HEIGHT;
    layer->y = (ntp_y) o->from_y;
    const ntp_const_image src = ntp_image_as_const(layer);
    ntp_occlusion_options how = { .radius = pixels_as_typed(o->radius) };
    const ntp_hooks hooks = parts_hooks(operation);
    how.border_x = how.border_y = (ntp_border) (o->border - 1);
    if (o->border == NTP_OP_OCCLUSION_AUTO &&
        ntp_relief_borders(&how.border_x, &how.border_y, &src) != NTP_OK)
        return FALSE;
    /* 0 is flat here; libntp takes it for 1. */
    how.scale = o->scale != 0 ? pixels_as_typed(o->scale) : G_MINDOUBLE;
    return (normals ? occlude_normals(map, &src, &how, o->border == NTP_OP_OCCLUSION_WRAP, &hooks)
                    : occlude(map, &src, &how, &hooks)) == NTP_OK;
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const state *s = GEGL_PROPERTIES(operation)->user_data;
    const pixels p = pixels_of(gegl_operation_get_format(operation, "input"));
    const Babl *format = gegl_operation_get_format(operation, "output");
    const GeglRectangle all = gray_map_edges(operation, area);
    const pixels one = { .type = p.type, .channels = 1 };
    const gsize texels = (gsize) all.width * (gsize) all.height;
    const gsize sample = (gsize) p.bytes / (gsize) p.channels;
    guchar *read = g_malloc(texels * (gsize) p.bytes), *map = g_malloc(texels * sample);
    guchar *made = g_malloc((gsize) area->width * (gsize) p.bytes);
    ntp_image in = pixels_view(&p, read, all.width, all.height);
    const ntp_image out = pixels_view(&one, map, all.width, all.height);
    (void) level; /* everything is made at full size */
    gegl_buffer_get(input, &all, 1.0, p.format, read, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
    parts_tell(operation, 0);
    const gboolean ok = make(operation, &out, &in);
    parts_tell(operation, 1); /* until then GIMP takes neither clicks nor keys */
    for (gint y = 0; y < area->height && ok; y++) {
        const gsize at =
            (gsize) (area->y + y - all.y) * (gsize) all.width + (gsize) (area->x - all.x);
        const GeglRectangle row = { area->x, area->y + y, area->width, 1 };
        gray_map_paint(made, map + at * sample, read + at * (gsize) p.bytes, &p, area->width);
        output_write(output, format, &row, &p, made, area->width * p.bytes, s->blending);
    }
    g_free(made);
    g_free(map);
    g_free(read);
    return ok;
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
    operation_class->prepare = prepare;
    operation_class->get_required_for_output = get_required;
    operation_class->get_invalidated_by_change = get_required;
    operation_class->get_cached_region = get_cached;
    operation_class->threaded = FALSE;
    operation_class->opencl_support = FALSE;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:ambient-occlusion",
        "title", _("Ambient Occlusion"),
        "categories", "generic:normal-map",
        "description", _("Make an ambient occlusion map from a heightfield or a normals texture (normal map): how much of the sky each place sees"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("_Ambient Occlusion..."),
        NULL);
    /* clang-format on */
}

#endif
