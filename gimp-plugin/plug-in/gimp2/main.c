/* SPDX-License-Identifier: MIT */
/*
 * gimp2.c - the plug-in as GIMP 2.10 knows it: procedures, their arguments, how they are called
 */
#include "about.h"
#include "confirm.h"
#include "dialog.h"
#include "host.h"
#include "report_window.h"

#include <libgimp/gimpui.h>
#include <string.h>

enum { FIXED_ARGUMENTS = 3 }; /* run mode, image, drawable */

/* What plug-in-ntp-check-normals returns to scripts; the order is that of report_value. */
static GimpParamDef report_values[REPORT_VALUES];

static GimpPDBArgType type_of(const field *f)
{
    return f->kind == FIELD_NUMBER && f->digits > 0 ? GIMP_PDB_FLOAT : GIMP_PDB_INT32;
}

/* "0 Wrap, 1 Clamp, ...": with the help of a choice. */
static gchar *describe(const field *f)
{
    GString *text = g_string_new(f->help);
    for (int i = 0; i < choice_count(f); i++)
        g_string_append_printf(text, "%s%d %s", i == 0 ? " (" : ", ", i, f->choices[i].name);
    if (f->choices != NULL)
        g_string_append_c(text, ')');
    if (f->kind == FIELD_LAYER)
        g_string_append(text, " (-1: none)");
    return g_string_free(text, FALSE);
}

static void install(const procedure *p)
{
    static gchar mode[] = "run-mode", image[] = "image", layer[] = "drawable";
    static gchar mode_help[] = "1: by these arguments", image_help[] = "The image",
                 layer_help[] = "The layer";
    GimpParamDef arguments[FIXED_ARGUMENTS + MAX_FIELDS] = {
        { GIMP_PDB_INT32, mode, mode_help },
        { GIMP_PDB_IMAGE, image, image_help },
        { GIMP_PDB_DRAWABLE, layer, layer_help },
    };
    const bool reports = p == &procedures[PROCEDURE_CHECK];
    for (int i = 0; i < p->count; i++) {
        const field *f = &p->fields[i];
        arguments[FIXED_ARGUMENTS + i] =
            (GimpParamDef) { type_of(f), g_strdup(f->name), describe(f) };
    }
    gimp_install_procedure(p->name, p->blurb, p->help, PLUGIN_AUTHORS, PLUGIN_COPYRIGHT,
                           PLUGIN_DATE, p->in_gimp2.menu, "RGB*, GRAY*", GIMP_PLUGIN,
                           FIXED_ARGUMENTS + p->count, reports ? REPORT_VALUES : 0, arguments,
                           reports ? report_values : NULL);
    if (p->in_gimp2.menu != NULL)
        gimp_plugin_menu_register(p->name, PLUGIN_MENU);
    for (int i = 0; i < p->count; i++) {
        g_free(arguments[FIXED_ARGUMENTS + i].name);
        g_free(arguments[FIXED_ARGUMENTS + i].description);
    }
}

static void name_report_values(void)
{
    for (int i = 0; i < REPORT_VALUES; i++) {
        const report_value *v = &report_value_table[i];
        report_values[i] = (GimpParamDef) { v->is_text ? GIMP_PDB_STRING : GIMP_PDB_FLOAT,
                                            g_strdup(v->name), g_strdup(v->help) };
    }
}

static void query(void)
{
    name_report_values();
    gimp_plugin_menu_branch_register(PLUGIN_MENU_IN, N_("Normal Map"));
    gchar *locale = host_beside("locale");
    gimp_plugin_domain_register(GETTEXT_PACKAGE, locale);
    g_free(locale);
    for (int i = 0; i < PROCEDURE_COUNT; i++)
        install(&procedures[i]);
}

/* --------------------------------------------------------------------------------- calls */

static void take_arguments(const procedure *p, settings *s, const GimpParam *params, int given)
{
    for (int i = 0; i < p->count && FIXED_ARGUMENTS + i < given; i++) {
        const GimpParam *a = &params[FIXED_ARGUMENTS + i];
        s->value[i] = a->type == GIMP_PDB_FLOAT ? a->data.d_float : a->data.d_int32;
    }
}

static void last_values(const procedure *p, settings *s)
{
    settings kept;
    if (gimp_get_data_size(p->name) != (gint) sizeof kept || !gimp_get_data(p->name, &kept))
        return;
    for (int i = 0; i < p->count; i++) { /* layer IDs may now mean other layers */
        if (p->fields[i].kind != FIELD_LAYER)
            s->value[i] = kept.value[i];
    }
    settings_check(p, s);
}

/* The settings by the run mode; FALSE: the user cancelled, or *wrong says why. */
static gboolean settle(const procedure *p, settings *s, const GimpParam *params, int given,
                       gchar **wrong)
{
    const GimpRunMode mode = params[0].data.d_int32;
    settings_reset(p, s);
    if (mode == GIMP_RUN_NONINTERACTIVE) {
        if (given != FIXED_ARGUMENTS + p->count) {
            *wrong = g_strdup_printf(_("%s takes %d arguments, not %d."), p->name,
                                     FIXED_ARGUMENTS + p->count, given);
            return FALSE;
        }
        take_arguments(p, s, params, given);
        const field *f = settings_check(p, s);
        if (f != NULL)
            *wrong = g_strdup_printf(_("The argument %s of %s is out of range."), f->name, p->name);
        return f == NULL;
    }
    last_values(p, s);
    if (mode == GIMP_RUN_WITH_LAST_VALS || p == &procedures[PROCEDURE_CHECK])
        return TRUE;
    return dialog_run(p, s, params[2].data.d_drawable);
}

/* The settings of this run alone: an answer is not kept for the next one. */
static gboolean agreed(const procedure *p, const settings *s, settings *asked, GimpRunMode mode,
                       gint32 id)
{
    *asked = *s;
    return mode != GIMP_RUN_INTERACTIVE || confirm(p, asked, id);
}

/* The report: users get a window, scripts get values. */
static gboolean check(settings *s, gint32 id, GimpRunMode mode, report *r, char message[HOST_TEXT])
{
    if (mode == GIMP_RUN_NONINTERACTIVE)
        return host_check(s, id, r, message);
    return report_window_run(s, id, r, message) || message[0] == 0;
}

static void answer(GimpParam *values, gint *count, const report *r)
{
    for (int i = 0; i < REPORT_VALUES; i++) {
        const report_value *v = &report_value_table[i];
        values[1 + i].type = v->is_text ? GIMP_PDB_STRING : GIMP_PDB_FLOAT;
        if (v->is_text)
            values[1 + i].data.d_string = g_strdup(report_text_of(r, i));
        else
            values[1 + i].data.d_float = report_number_of(r, i);
    }
    *count = 1 + REPORT_VALUES;
}

static void run(const gchar *name, gint given, const GimpParam *params, gint *count,
                GimpParam **results)
{
    static GimpParam values[1 + REPORT_VALUES];
    const procedure *p = procedure_find(name);
    settings s, asked;
    static report found;
    char message[HOST_TEXT] = "";
    gchar *wrong = NULL;
    *count = 1;
    *results = values;
    values[0].type = GIMP_PDB_STATUS;
    values[0].data.d_status = GIMP_PDB_CALLING_ERROR;
    if (p == NULL || given < FIXED_ARGUMENTS)
        return;
    gegl_init(NULL, NULL);
    gimp_plugin_enable_precision();
    host_begin();
    const gint32 id = params[2].data.d_drawable;
    const GimpRunMode mode = params[0].data.d_int32;
    const char *refusal = host_refusal(p, id);
    gboolean done = FALSE;
    if (refusal != NULL) {
        values[0].data.d_status = GIMP_PDB_EXECUTION_ERROR;
        g_strlcpy(message, refusal, sizeof message);
    } else if (!settle(p, &s, params, given, &wrong)) {
        if (wrong == NULL)
            values[0].data.d_status = GIMP_PDB_CANCEL;
    } else if (!agreed(p, &s, &asked, mode, id)) {
        values[0].data.d_status = GIMP_PDB_CANCEL;
    } else {
        values[0].data.d_status = GIMP_PDB_EXECUTION_ERROR;
        done = p == &procedures[PROCEDURE_CHECK] ? check(&s, id, mode, &found, message)
                                                 : host_run(p, &asked, id, message);
    }
    if (done) {
        values[0].data.d_status = GIMP_PDB_SUCCESS;
        if (mode != GIMP_RUN_NONINTERACTIVE)
            gimp_displays_flush();
        if (mode == GIMP_RUN_INTERACTIVE)
            gimp_set_data(p->name, &s, sizeof s);
        if (p == &procedures[PROCEDURE_CHECK])
            answer(values, count, &found);
        if (message[0] != 0)
            g_message("%s", message);
    } else if (wrong != NULL || message[0] != 0) {
        values[1].type = GIMP_PDB_STRING;
        values[1].data.d_string = wrong != NULL ? wrong : g_strdup(message);
        *count = 2;
    }
}

const GimpPlugInInfo PLUG_IN_INFO = { NULL, NULL, query, run };

const char *host_program;

int main(int argc, char *argv[])
{
    host_program = argv[0];
    return gimp_main(&PLUG_IN_INFO, argc, argv);
}
