/* SPDX-License-Identifier: MIT */
/*
 * module.c - what GEGL expects in a file of operations
 */
#include <gegl-plugin.h>
#include <gmodule.h>
#include <libintl.h>

void gegl_op_ntp_normals_from_height_register_type(GTypeModule *module);
void gegl_op_ntp_clean_normals_register_type(GTypeModule *module);
void gegl_op_ntp_transform_normals_register_type(GTypeModule *module);
void gegl_op_ntp_blend_normals_register_type(GTypeModule *module);
void gegl_op_ntp_blend_file_register_type(GTypeModule *module);
void gegl_op_ntp_curvature_register_type(GTypeModule *module);
void gegl_op_ntp_ambient_occlusion_register_type(GTypeModule *module);

G_MODULE_EXPORT const GeglModuleInfo *gegl_module_query(GTypeModule *module);
G_MODULE_EXPORT gboolean gegl_module_register(GTypeModule *module);

const GeglModuleInfo *gegl_module_query(GTypeModule *module)
{
    static const GeglModuleInfo INFO = { GEGL_MODULE_ABI_VERSION };
    (void) module;
    return &INFO;
}

gboolean gegl_module_register(GTypeModule *module)
{
    /* This comes before the classes are made, because they look up their texts. */
    bindtextdomain(GETTEXT_PACKAGE, NTP_LOCALE_DIR);
    bind_textdomain_codeset(GETTEXT_PACKAGE, "UTF-8");
    gegl_op_ntp_normals_from_height_register_type(module);
    gegl_op_ntp_clean_normals_register_type(module);
    gegl_op_ntp_transform_normals_register_type(module);
    gegl_op_ntp_blend_normals_register_type(module);
    gegl_op_ntp_blend_file_register_type(module);
    gegl_op_ntp_curvature_register_type(module);
    gegl_op_ntp_ambient_occlusion_register_type(module);
    return TRUE;
}
