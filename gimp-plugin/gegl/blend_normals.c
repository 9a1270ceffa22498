/* SPDX-License-Identifier: MIT */
/*
 * blend_normals.c - ntp:blend-normals, lays the details of one normals texture over another
 *
 * The same numbers as `ntp blend`.  The input is the base, the pad "aux" has the detail, in the
 * same place.  Texels are independent.
 */
#include "../choices.h"
#include "translate.h"

#ifdef GEGL_PROPERTIES

/* clang-format off */
enum_start(ntp_op_blend_mode)
    enum_value(NTP_OP_RNM, "rnm", N_("Reoriented (RNM)"))
    enum_value(NTP_OP_WHITEOUT, "whiteout", N_("Whiteout"))
    enum_value(NTP_OP_UDN, "udn", N_("UDN"))
    enum_value(NTP_OP_LINEAR, "linear", N_("Mean of both"))
enum_end(ntp_op_blend_mode)

enum_start(ntp_op_blended_encoding)
    NTP_ENCODING_CHOICES(enum_value)
enum_end(ntp_op_blended_encoding)

enum_start(ntp_op_blended_green)
    NTP_GREEN_CHOICES(enum_value)
enum_end(ntp_op_blended_green)

property_enum(mode, _("Mode"), ntp_op_blend_mode, ntp_op_blend_mode, NTP_OP_RNM)
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
property_enum(from, LABEL(NTP_TO_LABEL), ntp_op_blended_encoding, ntp_op_blended_encoding, NTP_OP_STANDARD)
    description(_("What the blue channel stands for"))
property_enum(base_y, _("Green of the base points"), ntp_op_blended_green, ntp_op_blended_green, NTP_OP_UP)
    description(_("Which way green points in the layer, and in the result"))
property_enum(detail_y, _("Green of the detail points"), ntp_op_blended_green, ntp_op_blended_green, NTP_OP_UP)
    description(_("Which way green points in the detail"))
/* clang-format on */

#else

#  define GEGL_OP_POINT_COMPOSER
#  define GEGL_OP_BUNDLE
#  define GEGL_OP_NAME     ntp_blend_normals
#  define GEGL_OP_C_SOURCE blend_normals.c

#  include <gegl-op.h>

#  include "blend_texels.h"

/* The menu has the order of libntp's enumeration. */
G_STATIC_ASSERT((gint) NTP_OP_LINEAR == (gint) NTP_BLEND_LINEAR);

static void prepare(GeglOperation *operation)
{
    GeglProperties *o = GEGL_PROPERTIES(operation);
    if (o->user_data == NULL)
        o->user_data = g_new0(blend_texels, 1);
    blend_texels *b = o->user_data;
    blend_texels_prepare(b, operation, gegl_operation_get_source_format(operation, "input"),
                         gegl_operation_get_source_format(operation, "aux"));
    gegl_operation_set_format(operation, "aux", b->detail.format);
}

static void finalize(GObject *object)
{
    GeglProperties *o = GEGL_PROPERTIES(object);
    g_free(o->user_data);
    o->user_data = NULL;
    G_OBJECT_CLASS(gegl_op_parent_class)->finalize(object);
}

static gboolean process(GeglOperation *operation, void *in, void *aux, void *out, glong texels,
                        const GeglRectangle *area, gint level)
{
    const GeglProperties *o = GEGL_PROPERTIES(operation);
    const blend_how how = { .options = { .mode = (ntp_blend_mode) o->mode,
                                         .use_strength = o->strength != 1,
                                         .strength = pixels_as_typed(o->strength),
                                         .detail_alpha = o->detail_alpha },
                            .encoding = (ntp_encoding) o->from,
                            .base_y = (ntp_y) o->base_y,
                            .detail_y = (ntp_y) o->detail_y };
    (void) area; /* no texel depends on its position */
    (void) level;
    return blend_texels_make(o->user_data, &how, in, aux, out, texels);
}

static void gegl_op_class_init(GeglOpClass *klass)
{
    GeglOperationClass *operation_class = GEGL_OPERATION_CLASS(klass);
    GeglOperationPointComposerClass *point_class = GEGL_OPERATION_POINT_COMPOSER_CLASS(klass);

    G_OBJECT_CLASS(klass)->finalize = finalize;
    operation_class->prepare = prepare;
    operation_class->opencl_support = FALSE;
    point_class->process = process;

    /* clang-format off */
    gegl_operation_class_set_keys(operation_class,
        "name", "ntp:blend-normals",
        "title", _("Blend Normals"),
        "categories", "generic:normal-map",
        "description", _("Lay the details of a normals texture (normal map), the Aux Input, over the layer"),
        "gimp:menu-path", "<Image>/Filters/Generic",
        "gimp:menu-label", _("_Blend Normals..."),
        NULL);
    /* clang-format on */
}

#endif
