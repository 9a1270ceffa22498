/* SPDX-License-Identifier: MIT */
/*
 * normals_from_height.c - ntp:normals-from-height, normals of the heightfield in a layer
 *
 * The same numbers as `ntp from-height` with the same settings.  The picture is made in blocks.
 * Each is read with its surroundings, so that libntp gets either the true edge of the layer or
 * enough texels beyond the block.  So the result does not depend on how GEGL divides the picture.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_source)
    NTP_HEIGHT_SOURCE_CHOICES(enum_value)
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

property_double(scale, _("Scale"), 10.0)
    description(_("How many texels white rises above black. 0 is flat; a negative scale inverts the relief"))
    value_range(-1e9, 1e9)
    ui_range(-100.0, 100.0)
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
/* clang-format on */

#else

#  define GEGL_OP_AREA_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_normals_from_height
#  define GEGL_OP_C_SOURCE normals_from_height.c

#  include <gegl-op.h>

#  include "blending.h"
#  include "pixels.h"

/* The menus above have the order of libntp's enumerations. */
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

/*
 * The number that was typed.  XCF files store single precision: 7.3 is read back as 7.30000019.  A
 * number that may come from there means the decimal of up to 7 digits nearest to it, so that a
 * layer effect is the same after its file was opened again.
 */
static gdouble as_typed(gdouble value)
{
    const gfloat single = (gfloat) value;
    if ((gdouble) single != value)
        return value;
    for (gint digits = 6; digits <= 7; digits++) {
        gchar format[8], text[G_ASCII_DTOSTR_BUF_SIZE];
        g_snprintf(format, sizeof format, "%%.%dg", digits);
        const gdouble typed =
            g_ascii_strtod(g_ascii_formatd(text, sizeof text, format, value), NULL);
        if ((gfloat) typed == single)
            return typed;
    }
    return value;
}

static ntp_normals_options options_of(GeglOperation *operation)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    return (ntp_normals_options) { .scale = as_typed(o->scale),
                                   .dx = as_typed(o->dx),
                                   .dy = as_typed(o->dy),
                                   .min_z = as_typed(o->min_z),
                                   .kernel = (ntp_kernel) o->kernel,
                                   .border_x = (ntp_border) o->border_x,
                                   .border_y = (ntp_border) o->border_y,
                                   .source = (ntp_height_source) o->source,
                                   .blue = (ntp_blue) o->blue,
                                   .alpha = (ntp_alpha) o->alpha,
                                   .invert = o->invert };
}

/* Set by prepare(), read by the threads that process. */
typedef struct state {
    pixels made;
    blending *blending;
} state;

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    const pixels in = pixels_of(gegl_operation_get_source_format(operation, "input"));
    const ahead next = blending_ahead(operation);
    /* GIMP drops an alpha channel that the layer does not have, and converts the others in doing
     * so. */
    const gboolean adds_alpha =
        next == AHEAD_OTHER && (o->alpha == NTP_OP_HEIGHT || o->alpha == NTP_OP_INVERSE_HEIGHT);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    s->made = pixels_as_rgb(in.format, in.channels % 2 == 0 || adds_alpha);
    const Babl *light = next == AHEAD_MASK ? blending_prepare(&s->blending, &in) : NULL;
    gegl_operation_set_format(operation, "input", in.format);
    gegl_operation_set_format(operation, "output", light != NULL ? light : s->made.format);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    state *s = o->user_data;
    if (s != NULL)
        blending_free(s->blending);
    g_free(s);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* ---------------------------------------------------------------- what surrounds an area */

typedef struct span {
    gint start, size;
} span;

/*
 * The texels from which those of a span are made.  With a wrapping border the span may begin before
 * the edge and end beyond it; otherwise it ends there.  The reach is chosen so that borders act on
 * this part as they do on the whole.
 */
static span spread(span at, span edges, gint reach, gboolean wrap)
{
    gint64 start = (gint64) at.start - reach;
    gint64 end = (gint64) at.start + at.size + reach;
    if (!wrap) {
        start = MAX(start, edges.start);
        end = MIN(end, (gint64) edges.start + edges.size);
    }
    return (span) { (gint) start, (gint) (end - start) };
}

/* The smallest span inside the edges that contains all of it after wrapping. */
static span within(span at, span edges)
{
    const gboolean beyond =
        at.start < edges.start || (gint64) at.start + at.size > (gint64) edges.start + edges.size;
    return beyond ? edges : at;
}

static GeglRectangle surroundings(GeglOperation *operation, const GeglRectangle *area,
                                  gboolean wrapped)
{
    const GeglRectangle *edges = gegl_operation_source_get_bounding_box(operation, "input");
    if (edges == NULL || gegl_rectangle_is_empty(edges) || gegl_rectangle_is_empty(area))
        return *area;
    const ntp_normals_options how = options_of(operation);
    const gint reach = ntp_normals_reach(&how);
    const span columns = { edges->x, edges->width }, rows = { edges->y, edges->height };
    span x =
        spread((span) { area->x, area->width }, columns, reach, how.border_x == NTP_BORDER_WRAP);
    span y = spread((span) { area->y, area->height }, rows, reach, how.border_y == NTP_BORDER_WRAP);
    if (wrapped) {
        x = within(x, columns);
        y = within(y, rows);
    }
    return (GeglRectangle) { x.start, y.start, x.size, y.size };
}

static GeglRectangle get_required_for_output(GeglOperation *operation, const gchar *pad,
                                             const GeglRectangle *area)
{
    (void) pad;
    return surroundings(operation, area, TRUE);
}

/* The stencil is as wide to the left as to the right, so this is the same. */
static GeglRectangle get_invalidated_by_change(GeglOperation *operation, const gchar *pad,
                                               const GeglRectangle *area)
{
    (void) pad;
    return surroundings(operation, area, TRUE);
}

/* ------------------------------------------------------------------------------- a block */

/* The first piece of a span that does not cross an edge: where it is read, and how long it is. */
static span piece(span at, span edges)
{
    gint64 place = ((gint64) at.start - edges.start) % edges.size;
    if (place < 0)
        place += edges.size;
    return (span) { (gint) (edges.start + place), (gint) MIN(at.size, edges.size - place) };
}

/* Reads an area that may lie partly beyond the edges, where the picture is repeated. */
static void read_wrapped(GeglBuffer *input, const pixels *in, const GeglRectangle *edges,
                         const GeglRectangle *area, guchar *data)
{
    const gsize stride = (gsize) area->width * (gsize) in->bytes;
    span y = { area->y, area->height };
    while (y.size > 0) {
        const span rows = piece(y, (span) { edges->y, edges->height });
        guchar *to = data + (gsize) (y.start - area->y) * stride;
        span x = { area->x, area->width };
        while (x.size > 0) {
            const span columns = piece(x, (span) { edges->x, edges->width });
            const GeglRectangle part = { columns.start, rows.start, columns.size, rows.size };
            gegl_buffer_get(input, &part, 1.0, in->format, to, (gint) stride, GEGL_ABYSS_NONE);
            to += (gsize) columns.size * (gsize) in->bytes;
            x = (span) { x.start + columns.size, x.size - columns.size };
        }
        y = (span) { y.start + rows.size, y.size - rows.size };
    }
}

typedef struct job {
    ntp_normals_options how;
    pixels in, out;
    ntp_encoding to;
    ntp_y to_y;
    const GeglRectangle *edges;
    const Babl *format; /* of the output */
    const blending *blending;
    guchar *heights, *normals;
} job;

/* Outputs a block of finished texels, in the form for GIMP's blending if there is one. */
static void put(const job *j, GeglBuffer *output, const GeglRectangle *block, const guchar *first,
                gint stride)
{
    if (j->format == j->out.format) {
        gegl_buffer_set(output, block, 0, j->format, first, stride);
        return;
    }
    gfloat *light = g_new(gfloat, 4 * (gsize) block->width * (gsize) block->height);
    for (gsize y = 0; y < (gsize) block->height; y++)
        blending_put(j->blending, j->out.channels,
                     (const guint16 *) (gconstpointer) (first + y * (gsize) stride),
                     light + 4 * y * (gsize) block->width, (gsize) block->width);
    gegl_buffer_set(output, block, 0, j->format, light, GEGL_AUTO_ROWSTRIDE);
    g_free(light);
}

static gboolean make_block(GeglOperation *operation, const job *j, GeglBuffer *input,
                           GeglBuffer *output, const GeglRectangle *block)
{
    const GeglRectangle around = surroundings(operation, block, FALSE);
    read_wrapped(input, &j->in, j->edges, &around, j->heights);

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
    const guchar *first =
        (const guchar *) dst.data + area.y0 * dst.row_stride + area.x0 * dst.pixel_stride;
    put(j, output, block, first, (gint) dst.row_stride);
    return TRUE;
}

static gboolean process(GeglOperation *operation, GeglBuffer *input, GeglBuffer *output,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    job j = { .how = options_of(operation),
              .in = pixels_of(gegl_operation_get_format(operation, "input")),
              .out = s->made,
              .format = gegl_operation_get_format(operation, "output"),
              .blending = s->blending,
              .to = (ntp_encoding) o->to,
              .to_y = (ntp_y) o->to_y,
              .edges = gegl_operation_source_get_bounding_box(operation, "input") };
    (void) level; /* everything is made at full size */
    if (j.edges == NULL || gegl_rectangle_is_empty(j.edges))
        return TRUE;
    const gsize margin = 2 * (gsize) ntp_normals_reach(&j.how);
    const gsize most = (BLOCK_WIDTH + margin) * (BLOCK_HEIGHT + margin);
    j.heights = g_malloc(most * (gsize) j.in.bytes);
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

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationFilterClass *filter_class = GEGL_OPERATION_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    filter_class->process = process;
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
