/* SPDX-License-Identifier: MIT */
/*
 * dialog.c - the dialogs of GIMP 2.10, made from the table of a procedure's fields
 *
 * It has what GIMP 3 provides for every plug-in: reset, settings in files, a preview.
 */
#include "dialog.h"
#include "../../presets.h"
#include "about.h"
#include "help.h"
#include "view.h"
#include "window.h"

#include <libgimp/gimpui.h>
#include <math.h>
#include <string.h>

enum { RESPONSE_RESET = 1, RESPONSE_LOAD, RESPONSE_SAVE };

typedef struct dialog {
    const procedure *procedure;
    settings *settings;
    GtkWidget *window, *view;
    GtkWidget *controls[MAX_FIELDS]; /* of numbers: NULL */
    GtkAdjustment *numbers[MAX_FIELDS];
    GtkWidget *first; /* the entry of the first number: typing goes there */
    gboolean filling; /* the widgets follow the settings, not the other way round */
} dialog;

/* ------------------------------------------------------------------- widgets and settings */

/* What is for scripts only has no widget. */
static bool is_shown(const dialog *d, int i)
{
    return d->procedure->fields[i].page >= 0;
}

static double read_control(const dialog *d, int i)
{
    gint id = -1;
    switch (d->procedure->fields[i].kind) {
    case FIELD_CHOICE:
        return gtk_combo_box_get_active(GTK_COMBO_BOX(d->controls[i]));
    case FIELD_SWITCH:
        return gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(d->controls[i]));
    case FIELD_LAYER:
        return gimp_int_combo_box_get_active(GIMP_INT_COMBO_BOX(d->controls[i]), &id) ? id : -1;
    default:
        return gtk_adjustment_get_value(d->numbers[i]);
    }
}

/* What a preset decides is gray. */
static void allow_what_the_preset_leaves(const dialog *d)
{
    const procedure *p = d->procedure;
    if (p != &procedures[PROCEDURE_NORMALS])
        return;
    for (int i = 0; i < p->count; i++) {
        if (p->fields[i].kind == FIELD_CHOICE)
            gtk_widget_set_sensitive(
                d->controls[i],
                !preset_decides((preset) d->settings->value[FN_PRESET], p->fields[i].name));
    }
}

static void on_change(gpointer widget, gpointer data)
{
    dialog *d = data;
    (void) widget;
    if (d->filling)
        return;
    for (int i = 0; i < d->procedure->count; i++) {
        if (is_shown(d, i))
            d->settings->value[i] = read_control(d, i);
    }
    allow_what_the_preset_leaves(d);
    if (d->view != NULL)
        view_update(d->view, d->settings);
}

static void fill(dialog *d)
{
    d->filling = TRUE;
    for (int i = 0; i < d->procedure->count; i++) {
        const double value = d->settings->value[i];
        if (!is_shown(d, i))
            continue;
        switch (d->procedure->fields[i].kind) {
        case FIELD_CHOICE:
            gtk_combo_box_set_active(GTK_COMBO_BOX(d->controls[i]), (gint) value);
            break;
        case FIELD_SWITCH:
            gtk_toggle_button_set_active(GTK_TOGGLE_BUTTON(d->controls[i]), value != 0);
            break;
        case FIELD_LAYER:
            gimp_int_combo_box_set_active(GIMP_INT_COMBO_BOX(d->controls[i]), (gint) value);
            break;
        default:
            gtk_adjustment_set_value(d->numbers[i], value);
        }
    }
    d->filling = FALSE;
    on_change(NULL, d);
}

/* ------------------------------------------------------------------------------- fields */

/*
 * A slider whose middle is an eighth of its end, so that small numbers have room.  GIMP's own
 * logarithmic ones do not follow an entry that takes more than the slider.
 */
typedef struct curve {
    GtkAdjustment *number, *share; /* share: of the slider's length */
    double end;
    gboolean busy;
} curve;

static void on_share(GtkAdjustment *share, gpointer data)
{
    curve *c = data;
    const double t = gtk_adjustment_get_value(share);
    if (c->busy)
        return;
    c->busy = TRUE;
    gtk_adjustment_set_value(c->number, floor(c->end * t * t * t * 100 + 0.5) / 100);
    c->busy = FALSE;
}

static void on_number(GtkAdjustment *number, gpointer data)
{
    curve *c = data;
    if (c->busy)
        return;
    c->busy = TRUE;
    gtk_adjustment_set_value(c->share,
                             cbrt(CLAMP(gtk_adjustment_get_value(number) / c->end, 0, 1)));
    c->busy = FALSE;
}

static void add_curved(dialog *d, GtkTable *table, gint row, int i)
{
    enum { DIGITS = 9 };
    const field *f = &d->procedure->fields[i];
    const guint top = (guint) row, bottom = top + 1;
    const double step = f->digits == 0 ? 1 : 0.1;
    curve *c = g_new0(curve, 1);
    c->end = f->soft_high;
    c->number = GTK_ADJUSTMENT(gtk_adjustment_new(f->value, f->low, f->high, step, 10 * step, 0));
    c->share = GTK_ADJUSTMENT(gtk_adjustment_new(0, 0, 1, 0.005, 0.05, 0));
    GtkWidget *label = gtk_label_new_with_mnemonic(_(f->label));
    GtkWidget *slider = gtk_hscale_new(c->share);
    GtkWidget *entry = gtk_spin_button_new(c->number, step, (guint) f->digits);
    gtk_misc_set_alignment(GTK_MISC(label), 0, 0.5);
    gtk_label_set_mnemonic_widget(GTK_LABEL(label), entry);
    gtk_scale_set_draw_value(GTK_SCALE(slider), FALSE);
    gtk_entry_set_width_chars(GTK_ENTRY(entry), DIGITS);
    gimp_help_set_help_data(slider, _(f->help), NULL);
    gimp_help_set_help_data(entry, _(f->help), NULL);
    gtk_table_attach(table, label, 0, 1, top, bottom, GTK_FILL, 0, 0, 0);
    gtk_table_attach(table, slider, 1, 2, top, bottom, GTK_EXPAND | GTK_FILL, 0, 0, 0);
    gtk_table_attach(table, entry, 2, 3, top, bottom, GTK_FILL, 0, 0, 0);
    on_number(c->number, c);
    g_signal_connect(c->share, "value-changed", G_CALLBACK(on_share), c);
    g_signal_connect(c->number, "value-changed", G_CALLBACK(on_number), c);
    g_signal_connect(c->number, "value-changed", G_CALLBACK(on_change), d);
    g_object_set_data_full(G_OBJECT(entry), "ntp-curve", c, g_free);
    d->numbers[i] = c->number;
    if (d->first == NULL)
        d->first = entry;
}

static void add_number(dialog *d, GtkTable *table, gint row, int i)
{
    enum { SCALE_WIDTH = 150, SPIN_WIDTH = 9 };
    const field *f = &d->procedure->fields[i];
    const double step = 0.01;
    GtkObject *number = gimp_scale_entry_new(
        table, 0, row, _(f->label), SCALE_WIDTH, SPIN_WIDTH, f->value, f->soft_low, f->soft_high,
        step, 10 * step, (guint) f->digits, FALSE, f->low, f->high, _(f->help), NULL);
    d->numbers[i] = GTK_ADJUSTMENT(number);
    g_signal_connect(number, "value-changed", G_CALLBACK(on_change), d);
    if (d->first == NULL)
        d->first = GIMP_SCALE_ENTRY_SPINBUTTON(number);
}

/* The choice that needs another layer is gray until there is one. */
static void allow_alpha_layer(GtkCellLayout *combo, GtkCellRenderer *cell, GtkTreeModel *rows,
                              GtkTreeIter *row, gpointer data)
{
    const dialog *d = data;
    GtkTreePath *path = gtk_tree_model_get_path(rows, row);
    const gboolean needs = gtk_tree_path_get_indices(path)[0] == ALPHA_LAYER;
    (void) combo;
    gtk_tree_path_free(path);
    g_object_set(cell, "sensitive",
                 !needs || host_is_layer((gint32) d->settings->value[FN_ALPHA_LAYER]), NULL);
}

static GtkWidget *choice_new(dialog *d, const field *f)
{
    GtkWidget *combo = gtk_combo_box_text_new();
    for (int k = 0; k < choice_count(f); k++)
        gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(combo), _(f->choices[k].label));
    if (f == &procedures[PROCEDURE_NORMALS].fields[FN_ALPHA]) {
        GList *cells = gtk_cell_layout_get_cells(GTK_CELL_LAYOUT(combo));
        gtk_cell_layout_set_cell_data_func(GTK_CELL_LAYOUT(combo), GTK_CELL_RENDERER(cells->data),
                                           allow_alpha_layer, d, NULL);
        g_list_free(cells);
    }
    return combo;
}

static GtkWidget *layers_new(void)
{
    GtkWidget *combo = gimp_layer_combo_box_new(NULL, NULL);
    gimp_int_combo_box_prepend(GIMP_INT_COMBO_BOX(combo), GIMP_INT_STORE_VALUE, -1,
                               GIMP_INT_STORE_LABEL, _("None"), -1);
    return combo;
}

static void add_field(dialog *d, GtkTable *table, gint row, int i)
{
    const field *f = &d->procedure->fields[i];
    if (f->kind == FIELD_NUMBER) {
        if (f->soft_high > 100)
            add_curved(d, table, row, i);
        else
            add_number(d, table, row, i);
        return;
    }
    GtkWidget *control = f->kind == FIELD_SWITCH   ? gtk_check_button_new_with_mnemonic(_(f->label))
                         : f->kind == FIELD_CHOICE ? choice_new(d, f)
                                                   : layers_new();
    const char *signal = f->kind == FIELD_SWITCH ? "toggled" : "changed";
    d->controls[i] = control;
    gimp_help_set_help_data(control, _(f->help), NULL);
    g_signal_connect(control, signal, G_CALLBACK(on_change), d);
    if (f->kind == FIELD_SWITCH)
        gtk_table_attach(table, control, 0, 3, (guint) row, (guint) row + 1, GTK_FILL, 0, 0, 0);
    else
        gimp_table_attach_aligned(table, 0, row, _(f->label), 0, 0.5, control, 2, FALSE);
}

/* The fields of a page; NULL: there are none. */
static GtkWidget *page_new(dialog *d, int page)
{
    int fields[MAX_FIELDS];
    const int count = fields_on_page(d->procedure, page, fields);
    if (count == 0)
        return NULL;
    GtkWidget *table = gtk_table_new((guint) count, 3, FALSE);
    gtk_table_set_col_spacings(GTK_TABLE(table), 6);
    gtk_table_set_row_spacings(GTK_TABLE(table), 6);
    gtk_container_set_border_width(GTK_CONTAINER(table), 12);
    for (int row = 0; row < count; row++)
        add_field(d, GTK_TABLE(table), row, fields[row]);
    GtkWidget *box = gtk_vbox_new(FALSE, 0); /* so that rows keep their height beside the preview */
    gtk_box_pack_start(GTK_BOX(box), table, FALSE, FALSE, 0);
    return window_scrolled(box);
}

static GtkWidget *controls_new(dialog *d)
{
    const char *const titles[PAGES] = { _("Normals"), _("Forms"), _("More") };
    GtkWidget *first = page_new(d, 0), *second = page_new(d, 1);
    if (second == NULL)
        return first;
    GtkWidget *const pages[PAGES] = { first, second, page_new(d, 2) };
    GtkWidget *book = gtk_notebook_new();
    for (int i = 0; i < PAGES; i++)
        gtk_notebook_append_page(GTK_NOTEBOOK(book), pages[i], gtk_label_new(titles[i]));
    return book;
}

/* -------------------------------------------------------------------- settings in files */

static gchar *settings_directory(void)
{
    gchar *path = g_build_filename(gimp_directory(), PLUGIN_NAME, NULL);
    g_mkdir_with_parents(path, 0700);
    return path;
}

/* The file that the user chose; NULL: none. */
static gchar *choose_file(const dialog *d, gboolean save)
{
    GtkWidget *chooser = gtk_file_chooser_dialog_new(
        save ? _("Save settings") : _("Load settings"), GTK_WINDOW(d->window),
        save ? GTK_FILE_CHOOSER_ACTION_SAVE : GTK_FILE_CHOOSER_ACTION_OPEN, GTK_STOCK_CANCEL,
        GTK_RESPONSE_CANCEL, save ? GTK_STOCK_SAVE : GTK_STOCK_OPEN, GTK_RESPONSE_OK, NULL);
    gchar *directory = settings_directory(), *name = NULL;
    gtk_file_chooser_set_current_folder(GTK_FILE_CHOOSER(chooser), directory);
    gtk_file_chooser_set_do_overwrite_confirmation(GTK_FILE_CHOOSER(chooser), TRUE);
    if (save)
        gtk_file_chooser_set_current_name(GTK_FILE_CHOOSER(chooser), "normals.settings");
    if (gtk_dialog_run(GTK_DIALOG(chooser)) == GTK_RESPONSE_OK)
        name = gtk_file_chooser_get_filename(GTK_FILE_CHOOSER(chooser));
    gtk_widget_destroy(chooser);
    g_free(directory);
    return name;
}

static void save_settings(const dialog *d)
{
    gchar *name = choose_file(d, TRUE);
    char text[2000];
    GError *error = NULL;
    if (name == NULL)
        return;
    settings_write(d->procedure, d->settings, text, sizeof text);
    if (!g_file_set_contents(name, text, -1, &error))
        g_message("%s", error->message);
    g_clear_error(&error);
    g_free(name);
}

static void load_settings(dialog *d)
{
    gchar *name = choose_file(d, FALSE), *text = NULL;
    GError *error = NULL;
    if (name == NULL)
        return;
    if (g_file_get_contents(name, &text, NULL, &error)) {
        settings_read(d->procedure, d->settings, text);
        fill(d);
    } else {
        g_message("%s", error->message);
    }
    g_clear_error(&error);
    g_free(text);
    g_free(name);
}

/* ------------------------------------------------------------------------------ dialogs */

static gboolean run_window(dialog *d)
{
    for (;;) {
        const gint response = gimp_dialog_run(GIMP_DIALOG(d->window));
        if (response == RESPONSE_RESET) {
            settings_reset(d->procedure, d->settings);
            fill(d);
        } else if (response == RESPONSE_LOAD) {
            load_settings(d);
        } else if (response == RESPONSE_SAVE) {
            save_settings(d);
        } else {
            return response == GTK_RESPONSE_OK;
        }
    }
}

static void add_notice(GtkWidget *box, const procedure *p, gint32 id)
{
    char text[HOST_TEXT];
    host_notice(p, id, FALSE, text);
    if (text[0] == 0)
        return;
    GtkWidget *hint = gimp_hint_box_new(text);
    gtk_container_set_border_width(GTK_CONTAINER(hint), 12);
    gtk_box_pack_start(GTK_BOX(box), hint, FALSE, FALSE, 0);
    gtk_widget_show(hint);
}

gboolean dialog_run(const procedure *p, settings *s, gint32 id)
{
    dialog d = { .procedure = p, .settings = s };
    gimp_ui_init(PLUGIN_NAME, FALSE);
    d.window = gimp_dialog_new(_(p->in_gimp2.title), PLUGIN_NAME, NULL, 0, show_help, p->name,
                               _("_Load..."), RESPONSE_LOAD, _("_Save..."), RESPONSE_SAVE,
                               GIMP_STOCK_RESET, RESPONSE_RESET, GTK_STOCK_CANCEL,
                               GTK_RESPONSE_CANCEL, GTK_STOCK_OK, GTK_RESPONSE_OK, NULL);
    gimp_window_set_transient(GTK_WINDOW(d.window));
    gtk_dialog_set_default_response(GTK_DIALOG(d.window), GTK_RESPONSE_OK);
    GtkWidget *box = gtk_hbox_new(FALSE, 12);
    gtk_container_set_border_width(GTK_CONTAINER(box), 12);
    add_notice(gtk_dialog_get_content_area(GTK_DIALOG(d.window)), p, id);
    gtk_box_pack_start(GTK_BOX(gtk_dialog_get_content_area(GTK_DIALOG(d.window))), box, TRUE, TRUE,
                       0);
    const gboolean alone =
        p == &procedures[PROCEDURE_CHECK] || p == &procedures[PROCEDURE_RESIZE]; /* no preview */
    gtk_box_pack_start(GTK_BOX(box), controls_new(&d), alone, TRUE, 0);
    if (!alone) {
        d.view = view_new(p, id);
        gtk_box_pack_start(GTK_BOX(box), d.view, TRUE, TRUE, 0);
    }
    gtk_widget_show_all(box);
    fill(&d);
    if (d.first != NULL) {
        gtk_widget_grab_focus(d.first);
        gtk_entry_set_activates_default(GTK_ENTRY(d.first), TRUE);
    }
    window_fit(d.window, d.view, alone ? 0 : VIEW_WIDER, VIEW_HIGHER);
    const gboolean done = run_window(&d);
    gtk_widget_destroy(d.window);
    return done;
}
