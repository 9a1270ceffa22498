/* SPDX-License-Identifier: MIT */
/*
 * blend_file.c - ntp:blend-normals-file, lays the details of a picture file over normals
 *
 * The same numbers as `ntp blend`.  Texels are independent.  It is another operation than
 * ntp:blend-normals because GIMP 3.0.4 takes none with a pad "aux" as a layer effect
 * (drawable_append_filter_private_invoker, gimp_filter_tool_create_filter).
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_blend_mode_file)
    enum_value(NTP_OP_RNM, "rnm", N_("Reoriented (RNM)"))
    enum_value(NTP_OP_WHITEOUT, "whiteout", N_("Whiteout"))
    enum_value(NTP_OP_UDN, "udn", N_("UDN"))
    enum_value(NTP_OP_LINEAR, "linear", N_("Mean of both"))
enum_end(ntp_op_blend_mode_file)

enum_start(ntp_op_blended_encoding_file)
    NTP_ENCODING_CHOICES(enum_value)
enum_end(ntp_op_blended_encoding_file)

enum_start(ntp_op_blended_green_file)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_blended_green_file)

property_string(path, _("Path of the detail"), "")
    description(_("The same for scripts; what is chosen in the dialog comes first"))
    ui_meta("visible", "0")
property_enum(mode, _("Mode"), ntp_op_blend_mode_file, ntp_op_blend_mode_file, NTP_OP_RNM)
    description(_("Reoriented: as if the detail lay on the surface of the base. UDN keeps less of it on slopes"))
property_double(strength, LABEL(NTP_STRENGTH_LABEL), 1.0)
    description(_("Multiplies red and green of the detail"))
    value_range(-1024.0, 1024.0)
    ui_range(0.0, 10.0)
    ui_gamma(3.0)
    ui_steps(0.01, 0.1)
    ui_digits(3)
property_boolean(detail_alpha, _("Alpha fades the detail"), FALSE)
    description(_("Where the detail is half transparent it counts half: erase with a soft brush, or take the alpha as a mask"))
property_enum(from, LABEL(NTP_TO_LABEL), ntp_op_blended_encoding_file, ntp_op_blended_encoding_file, NTP_OP_STANDARD)
    description(_("What the blue channel stands for"))
property_enum(base_y, _("Green of the base points"), ntp_op_blended_green_file, ntp_op_blended_green_file, NTP_OP_UP)
    description(_("Which way green points in the layer, and in the result"))
property_enum(detail_y, _("Green of the detail points"), ntp_op_blended_green_file, ntp_op_blended_green_file, NTP_OP_UP)
    description(_("Which way green points in the detail"))
/* The last: scripts of GIMP 3.0 see no property from the first file path on. */
property_file_path(file, _("File of the detail"), "")
    description(_("A picture with the details, as large as the layer. It is read again when it has changed and the layer is drawn"))
/* clang-format on */

#else

#  define GEGL_OP_POINT_FILTER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_blend_file
#  define GEGL_OP_C_SOURCE blend_file.c

#  include <gegl-op.h>

#  include "blend_texels.h"
#  include "detail_file.h"

/* The menu has the order of libntp's enumeration. */
G_STATIC_ASSERT((gint) NTP_OP_LINEAR == (gint) NTP_BLEND_LINEAR);

typedef struct state {
    blend_texels texels;
    detail_file file;
    gint place[2]; /* where the input's 0, 0 is in the file */
} state;

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    if (o->user_data == NULL)
        o->user_data = g_new0(state, 1);
    state *s = o->user_data;
    detail_file_look(&s->file, o->file != NULL && o->file[0] != 0 ? o->file : o->path);
    detail_file_place(operation, s->place);
    blend_texels_prepare(&s->texels, operation,
                         gegl_operation_get_source_format(operation, "input"),
                         s->file.picture == NULL ? NULL : gegl_buffer_get_format(s->file.picture));
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    state *s = o->user_data;
    if (s != NULL)
        detail_file_look(&s->file, NULL);
    g_free(s);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

/* The detail of an area, to be freed; NULL: there is none. */
static guchar *read_detail(const state *s, const GeglRectangle *area)
{
    if (s->file.picture == NULL)
        return NULL;
    const pixels *p = &s->texels.detail;
    const GeglRectangle part = { area->x + s->place[0], area->y + s->place[1], area->width,
                                 area->height };
    guchar *detail = g_malloc((gsize) part.width * (gsize) part.height * (gsize) p->bytes);
    gegl_buffer_get(s->file.picture, &part, 1.0, p->format, detail, GEGL_AUTO_ROWSTRIDE,
                    GEGL_ABYSS_NONE);
    return detail;
}

static gboolean process(GeglOperation *operation, void *in, void *out, glong texels,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const state *s = o->user_data;
    const blend_how how = { .options = { .mode = (ntp_blend_mode) o->mode,
                                         .use_strength = o->strength != 1,
                                         .strength = pixels_as_typed(o->strength),
                                         .detail_alpha = o->detail_alpha },
                            .encoding = (ntp_encoding) o->from,
                            .base_y = (ntp_y) o->base_y,
                            .detail_y = (ntp_y) o->detail_y };
    guchar *detail = read_detail(s, area);
    (void) level;
    const gboolean ok = blend_texels_make(&s->texels, &how, in, detail, out, texels);
    g_free(detail);
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
        "name", "ntp:blend-normals-file",
        "title", _("Blend Normals with a File"),
        "categories", "generic:normal-map",
        "description", _("Lay the details of a normals texture (normal map) in a file over the layer; also as a layer effect"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("Blend Normals with a _File..."),
        NULL);
    /* clang-format on */
}

#endif
