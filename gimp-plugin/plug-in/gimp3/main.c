/* SPDX-License-Identifier: MIT */
/*
 * main.c - the plug-in as GIMP 3 knows it: procedures, their arguments, how they are called
 */
#include "about.h"
#include "confirm.h"
#include "dialog.h"
#include "host.h"
#include "report_window.h"

#include <libgimp/gimpui.h>

const char *host_program;

typedef struct Normals {
    GimpPlugIn parent;
} Normals;
typedef struct NormalsClass {
    GimpPlugInClass parent;
} NormalsClass;

GType normals_get_type(void);
G_DEFINE_TYPE(Normals, normals, GIMP_TYPE_PLUG_IN)

/* ----------------------------------------------------------------------------- arguments */

static void add_choice(GimpProcedure *pdb, const field *f)
{
    GimpChoice *options = gimp_choice_new();
    for (int i = 0; i < choice_count(f); i++)
        gimp_choice_add(options, f->choices[i].name, i, _(f->choices[i].label), NULL);
    gimp_procedure_add_choice_argument(pdb, f->name, _(f->label), _(f->help), options,
                                       f->choices[(int) f->value].name, G_PARAM_READWRITE);
}

static void add_argument(GimpProcedure *pdb, const field *f)
{
    switch (f->kind) {
    case FIELD_CHOICE:
        add_choice(pdb, f);
        break;
    case FIELD_SWITCH:
        gimp_procedure_add_boolean_argument(pdb, f->name, _(f->label), _(f->help), f->value != 0,
                                            G_PARAM_READWRITE);
        break;
    case FIELD_LAYER:
        gimp_procedure_add_drawable_argument(pdb, f->name, _(f->label), _(f->help), TRUE,
                                             G_PARAM_READWRITE);
        break;
    default:
        if (f->digits > 0)
            gimp_procedure_add_double_argument(pdb, f->name, _(f->label), _(f->help), f->low,
                                               f->high, f->value, G_PARAM_READWRITE);
        else
            gimp_procedure_add_int_argument(pdb, f->name, _(f->label), _(f->help), (gint) f->low,
                                            (gint) f->high, (gint) f->value, G_PARAM_READWRITE);
    }
}

static double read_field(GimpProcedureConfig *config, const field *f)
{
    gdouble number = 0;
    gint integer = 0;
    gboolean on = FALSE;
    GimpDrawable *drawable = NULL;
    switch (f->kind) {
    case FIELD_CHOICE:
        return gimp_procedure_config_get_choice_id(config, f->name);
    case FIELD_SWITCH:
        g_object_get(config, f->name, &on, NULL);
        return on;
    case FIELD_LAYER:
        g_object_get(config, f->name, &drawable, NULL);
        number = drawable != NULL ? gimp_item_get_id(GIMP_ITEM(drawable)) : -1;
        g_clear_object(&drawable);
        return number;
    default:
        if (f->digits > 0)
            g_object_get(config, f->name, &number, NULL);
        else
            g_object_get(config, f->name, &integer, NULL);
        return f->digits > 0 ? number : integer;
    }
}

void config_read(const procedure *p, GimpProcedureConfig *config, settings *s)
{
    settings_reset(p, s);
    for (int i = 0; i < p->count; i++)
        s->value[i] = read_field(config, &p->fields[i]);
}

/* --------------------------------------------------------------------------------- calls */

static GimpValueArray *give_up(GimpProcedure *pdb, GimpPDBStatusType status, const char *message)
{
    GError *error = message == NULL ? NULL : g_error_new_literal(GIMP_PLUG_IN_ERROR, 0, message);
    return gimp_procedure_new_return_values(pdb, status, error);
}

static void answer(GimpValueArray *values, const report *r)
{
    for (int i = 0; i < REPORT_VALUES; i++) {
        GValue *value = gimp_value_array_index(values, i + 1);
        if (report_value_table[i].is_text)
            g_value_set_string(value, report_text_of(r, i));
        else
            g_value_set_double(value, report_number_of(r, i));
    }
}

/* The report: users get a window, scripts get values. */
static gboolean check(settings *s, gint32 id, GimpRunMode mode, report *r, char message[HOST_TEXT])
{
    if (mode == GIMP_RUN_NONINTERACTIVE)
        return host_check(s, id, r, message);
    return report_window_run(s, id, r, message) || message[0] == 0;
}

static GimpValueArray *run(GimpProcedure *pdb, GimpRunMode mode, GimpImage *image,
                           GimpDrawable **drawables, GimpProcedureConfig *config, gpointer data)
{
    const procedure *p = data;
    const bool checks = p == &procedures[PROCEDURE_CHECK];
    static report found;
    char message[HOST_TEXT] = "", notice[HOST_TEXT] = "";
    settings s;
    (void) image;
    gegl_init(NULL, NULL);
    if (drawables == NULL || drawables[0] == NULL || drawables[1] != NULL)
        return give_up(pdb, GIMP_PDB_EXECUTION_ERROR, _("Select one layer."));
    const gint32 id = gimp_item_get_id(GIMP_ITEM(drawables[0]));
    const char *refusal = host_refusal(p, id);
    if (refusal != NULL)
        return give_up(pdb, GIMP_PDB_EXECUTION_ERROR, refusal);
    if (mode != GIMP_RUN_INTERACTIVE && !checks)
        host_notice(p, id, TRUE, notice);
    if (mode == GIMP_RUN_INTERACTIVE && !checks && !dialog_run(p, pdb, config, id))
        return give_up(pdb, GIMP_PDB_CANCEL, NULL);
    config_read(p, config, &s);
    settings_check(p, &s);
    if (mode == GIMP_RUN_INTERACTIVE && !confirm(p, &s, id))
        return give_up(pdb, GIMP_PDB_CANCEL, NULL);
    if (!(checks ? check(&s, id, mode, &found, message) : host_run(p, &s, id, message)))
        return give_up(pdb, GIMP_PDB_EXECUTION_ERROR, message);
    if (mode != GIMP_RUN_NONINTERACTIVE)
        gimp_displays_flush();
    if (notice[0] != 0)
        g_message("%s", notice);
    if (message[0] != 0)
        g_message("%s", message);
    GimpValueArray *values = gimp_procedure_new_return_values(pdb, GIMP_PDB_SUCCESS, NULL);
    if (checks)
        answer(values, &found);
    return values;
}

/* ------------------------------------------------------------------------------- the plug-in */

static GList *query_procedures(GimpPlugIn *plug_in)
{
    GList *names = NULL;
    (void) plug_in;
    for (int i = 0; i < PROCEDURE_COUNT; i++)
        names = g_list_append(names, g_strdup(procedures[i].name));
    return names;
}

static void describe(GimpProcedure *made, const procedure *p)
{
    gimp_procedure_set_image_types(made, "RGB*, GRAY*");
    gimp_procedure_set_sensitivity_mask(made, GIMP_PROCEDURE_SENSITIVE_DRAWABLE);
    gimp_procedure_set_documentation(made, _(p->blurb), _(p->help), p->name);
    gimp_procedure_set_attribution(made, PLUGIN_AUTHORS, PLUGIN_COPYRIGHT, PLUGIN_DATE);
    if (p->in_gimp3.menu != NULL) {
        gimp_procedure_set_menu_label(made, _(p->in_gimp3.menu));
        /* GIMP 3 shows a submenu that it does not have by the name in the path. */
        gchar *path = g_strconcat(PLUGIN_MENU_IN "/", _("Normal Map"), NULL);
        gimp_procedure_add_menu_path(made, path);
        g_free(path);
    }
}

static GimpProcedure *create_procedure(GimpPlugIn *plug_in, const gchar *name)
{
    const procedure *p = procedure_find(name);
    if (p == NULL)
        return NULL;
    GimpProcedure *made = gimp_image_procedure_new(plug_in, name, GIMP_PDB_PROC_TYPE_PLUGIN, run,
                                                   (gpointer) (guintptr) p, NULL);
    describe(made, p);
    for (int i = 0; i < p->count; i++)
        add_argument(made, &p->fields[i]);
    for (int i = 0; i < REPORT_VALUES && p == &procedures[PROCEDURE_CHECK]; i++) {
        const report_value *v = &report_value_table[i];
        if (v->is_text)
            gimp_procedure_add_string_return_value(made, v->name, v->name, v->help, NULL,
                                                   G_PARAM_READWRITE);
        else
            gimp_procedure_add_double_return_value(made, v->name, v->name, v->help, 0, G_MAXDOUBLE,
                                                   0, G_PARAM_READWRITE);
    }
    return made;
}

static gboolean set_i18n(GimpPlugIn *plug_in, const gchar *name, gchar **domain, gchar **directory)
{
    (void) plug_in;
    (void) name;
    (void) directory; /* "locale", beside the program */
    *domain = g_strdup(GETTEXT_PACKAGE);
    return TRUE;
}

static void normals_class_init(NormalsClass *class)
{
    GimpPlugInClass *plug_in = GIMP_PLUG_IN_CLASS(class);
    plug_in->query_procedures = query_procedures;
    plug_in->create_procedure = create_procedure;
    plug_in->set_i18n = set_i18n;
}

static void normals_init(Normals *plug_in)
{
    (void) plug_in;
}

int main(int argc, char *argv[])
{
    host_program = argv[0];
    host_begin();
    return gimp_main(normals_get_type(), argc, argv);
}
