/* SPDX-License-Identifier: MIT */
/*
 * clean_normals.c - ntp:clean-normals, repairs and converts the normals texture in a layer
 *
 * The same numbers as `ntp clean`, then `ntp convert`, with the same settings; or the picture of
 * `ntp heatmap`, which shows what is wrong with the layer as it is.  Texels are independent.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_encoding)
    NTP_ENCODING_CHOICES(enum_value)
enum_end(ntp_op_encoding)

enum_start(ntp_op_green)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_green)

enum_start(ntp_op_repair)
    NTP_LENGTH_CHOICES(enum_value)
    enum_value(NTP_OP_MIRROR_Z, "keep", N_("Turn negative Z around, nothing else"))
    enum_value(NTP_OP_NO_REPAIR, "none", N_("None"))
enum_end(ntp_op_repair)

enum_start(ntp_op_verdict)
    NTP_VERDICT_CHOICES(enum_value)
enum_end(ntp_op_verdict)

enum_start(ntp_op_show)
    enum_value(NTP_OP_RESULT, "result", N_("Result"))
    enum_value(NTP_OP_HEATMAP, "heatmap", N_("What is wrong: heatmap"))
    enum_value(NTP_OP_HEATMAP_SAFE, "heatmap-safe", N_("What is wrong: heatmap, safe colors"))
enum_end(ntp_op_show)

property_enum(show, _("Show"), ntp_op_show, ntp_op_show, NTP_OP_RESULT)
    description(_("The heatmaps judge the layer as it is: gray is good. The help explains the colors"))
property_enum(repair, LABEL(NTP_REPAIR_LABEL), ntp_op_repair, ntp_op_repair, NTP_OP_DERIVE)
    description(_("How vectors get length 1"))
property_boolean(only_failing, LABEL(NTP_ONLY_FAILING_LABEL), FALSE)
    description(_("Leave texels alone that pass the test below"))
property_enum(verdict, LABEL(NTP_VERDICT_LABEL), ntp_op_verdict, ntp_op_verdict, NTP_OP_NEIGHBOR)
    description(_("How strict the test is"))
    ui_meta("visible", "only-failing")
property_boolean(keep_negative_z, LABEL(NTP_KEEP_NEGATIVE_Z_LABEL), FALSE)
    description(_("Do not turn normals around that point into the surface"))
property_boolean(touch_unused, LABEL(NTP_TOUCH_UNUSED_LABEL), FALSE)
    description(_("Treat black, white and transparent texels like any other"))
property_enum(from, LABEL(NTP_TO_LABEL), ntp_op_encoding, ntp_op_encoding, NTP_OP_STANDARD)
    description(_("What blue stands for in the layer as it is"))
property_enum(to, _("Becomes"), ntp_op_encoding, ntp_op_encoding, NTP_OP_STANDARD)
    description(_("What blue stands for in the result"))
property_enum(from_y, LABEL(NTP_TO_Y_LABEL), ntp_op_green, ntp_op_green, NTP_OP_UP)
    description(_("Which way green points in the layer as it is"))
property_enum(to_y, _("Becomes"), ntp_op_green, ntp_op_green, NTP_OP_UP)
    description(_("Which way green points in the result; green is inverted if that differs"))
/* clang-format on */

#else

#  define GEGL_OP_POINT_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_clean_normals
#  define GEGL_OP_C_SOURCE clean_normals.c

#  include <gegl-op.h>

#  include "output.h"
#  include "pixels.h"

/* The menus above have the order of libntp's enumerations. */
G_STATIC_ASSERT((gint) NTP_OP_XY == (gint) NTP_ENCODING_XY);
G_STATIC_ASSERT((gint) NTP_OP_DOWN == (gint) NTP_Y_DOWN);
G_STATIC_ASSERT((gint) NTP_OP_MIRROR_Z == (gint) NTP_CLEAN_KEEP);
G_STATIC_ASSERT((gint) NTP_OP_EXACT == (gint) NTP_VERDICT_EXACT);

/* Set by prepare(), read by the threads that process. */
typedef struct state {
    ntp_clean_options how;
    const ntp_clean_plan *plan; /* of 8-bit layers; in memory */
    ntp_encoding plan_encoding;
    gpointer memory;
    const blending *blending;
} state;

/* If blue is not z, alpha is a height or another map: 0 does not make a texel unused. */
static uint32_t touched(const GeglProperties *o)
{
    return o->touch_unused ? NTP_UNUSED_ALL : o->from == NTP_OP_XY ? NTP_UNUSED_TRANSPARENT : 0;
}

static ntp_clean_options options_of(const GeglProperties *o)
{
    return (ntp_clean_options) { .method = (ntp_clean_method) o->repair,
                                 .keep_negative_z = o->keep_negative_z,
                                 .only_failing = o->only_failing,
                                 .verdict = (ntp_verdict) o->verdict,
                                 .touch_unused = touched(o) };
}

static gboolean same_options(const ntp_clean_options *a, const ntp_clean_options *b)
{
    return a->method == b->method && a->keep_negative_z == b->keep_negative_z &&
           a->only_failing == b->only_failing && a->verdict == b->verdict &&
           a->touch_unused == b->touch_unused;
}

/* GEGL prepares often, so the plan is made again only if something changed that it depends on.
 * */
static void prepare_plan(state *s, const GeglProperties *o)
{
    const ntp_clean_options how = options_of(o);
    const ntp_encoding encoding = (ntp_encoding) o->from;
    if (s->plan != NULL && s->plan_encoding == encoding && same_options(&s->how, &how))
        return;
    const gsize size = ntp_clean_plan_size();
    if (s->memory == NULL)
        s->memory = g_malloc(size + 16);
    const gsize odd = (gsize) s->memory % 16;
    ntp_clean_plan *plan = NULL;
    ntp_clean_plan_init(&plan, (guchar *) s->memory + (16 - odd), size, encoding, &how);
    s->plan = plan;
    s->plan_encoding = encoding;
    s->how = how;
}

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    const pixels p = output_formats(operation, &s->blending);
    if (p.type == NTP_TYPE_U8 && o->repair != NTP_OP_NO_REPAIR && o->show == NTP_OP_RESULT)
        prepare_plan(s, o);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    state *s = o->user_data;
    if (s != NULL)
        g_free(s->memory);
    g_free(s);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* libntp makes heatmaps in 8 bit; deeper layers get the same levels by value. */
static gboolean paint(const GeglProperties *o, const pixels *p, const ntp_const_image *src,
                      ntp_image *dst)
{
    const ntp_palette palette =
        o->show == NTP_OP_HEATMAP ? NTP_PALETTE_REFERENCE : NTP_PALETTE_SAFE;
    const uint32_t touch = touched(o);
    dst->encoding = NTP_ENCODING_HEIGHT;
    if (p->type == NTP_TYPE_U8)
        return ntp_heatmap(dst, src, palette, touch, NULL) == NTP_OK;
    const pixels levels = { .type = NTP_TYPE_U8, .channels = p->channels };
    guchar *colors = g_malloc((gsize) src->width * (gsize) p->channels);
    ntp_image picture = pixels_view(&levels, colors, src->width, 1);
    const ntp_const_image painted = ntp_image_as_const(&picture);
    const gboolean ok = ntp_heatmap(&picture, src, palette, touch, NULL) == NTP_OK &&
                        ntp_convert(dst, &painted, NULL, NULL, NULL) == NTP_OK;
    g_free(colors);
    return ok;
}

static gboolean repair_and_convert(const GeglProperties *o, const pixels *p,
                                   const ntp_const_image *src, ntp_image *dst)
{
    const state *s = o->user_data;
    const ntp_clean_options how = options_of(o);
    const ntp_convert_options convert = { .touch_unused = how.touch_unused };
    const gboolean converts = o->from != o->to || o->from_y != o->to_y;
    ntp_const_image from = *src;
    if (o->repair != NTP_OP_NO_REPAIR) {
        dst->encoding = src->encoding;
        dst->y = src->y;
        if (ntp_clean(dst, src, &how, p->type == NTP_TYPE_U8 ? s->plan : NULL, NULL, NULL) !=
            NTP_OK)
            return FALSE;
        from = ntp_image_as_const(dst);
        if (!converts)
            return TRUE;
    }
    dst->encoding = (ntp_encoding) o->to;
    dst->y = (ntp_y) o->to_y;
    return ntp_convert(dst, &from, &convert, NULL, NULL) == NTP_OK;
}

static gboolean make(const GeglProperties *o, const pixels *p, gpointer in, gpointer out,
                     gint texels)
{
    ntp_image read = pixels_view(p, in, texels, 1);
    read.encoding = (ntp_encoding) o->from;
    read.y = (ntp_y) o->from_y;
    const ntp_const_image src = ntp_image_as_const(&read);
    ntp_image dst = pixels_view(p, out, texels, 1);
    return o->show == NTP_OP_RESULT ? repair_and_convert(o, p, &src, &dst)
                                    : paint(o, p, &src, &dst);
}

static gboolean process(GeglOperation *operation, void *in, void *out, glong texels,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const pixels p = pixels_of(gegl_operation_get_format(operation, "input"));
    const gboolean blended = p.format != gegl_operation_get_format(operation, "output");
    guint16 *made = blended ? g_malloc((gsize) MIN(NTP_MAX_SIDE, texels) * (gsize) p.bytes) : NULL;
    gboolean ok = TRUE;
    (void) area; /* no texel depends on its position */
    (void) level;
    for (glong done = 0; done < texels && ok; done += NTP_MAX_SIDE) {
        const gint count = (gint) MIN(NTP_MAX_SIDE, texels - done);
        const gsize at = (gsize) done * (gsize) p.bytes;
        ok =
            make(o, &p, (guchar *) in + at, blended ? (gpointer) made : (guchar *) out + at, count);
        if (ok && blended)
            blending_put(s->blending, p.channels, made, (gfloat *) out + 4 * done, (gsize) count);
    }
    g_free(made);
    return ok;
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationPointFilterClass *point_class = GEGL_OPERATION_POINT_FILTER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    operation_class->prepare = prepare;
    operation_class->opencl_support = FALSE;
    point_class->process = process;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:clean-normals",
        "title", _("Clean Normals"),
        "categories", "generic:normal-map",
        "description", _("Repair and convert a normals texture (normal map), or show what is wrong with it"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("_Clean Normals..."),
        NULL);
    /* clang-format on */
}

#endif
