/* SPDX-License-Identifier: MIT */
/*
 * dialog.c - GIMP 3's own dialog for the arguments, with the preview beside it
 *
 * GIMP keeps the last values, resets, saves and loads them.
 */
#include "dialog.h"
#include "../../presets.h"
#include "help.h"
#include "view.h"
#include "window.h"

#include <libgimp/gimpui.h>

typedef struct connection {
    const procedure *procedure;
    GimpProcedureDialog *dialog;
    GtkWidget *view;
} connection;

/* The choice that needs another layer is gray until there is one. */
static void allow_alpha_layer(GObject *config, const settings *s)
{
    GParamSpec *alpha = g_object_class_find_property(G_OBJECT_GET_CLASS(config), "alpha");
    gimp_choice_set_sensitive(gimp_param_spec_choice_get_choice(alpha), "layer",
                              host_is_layer((gint32) s->value[FN_ALPHA_LAYER]));
}

/* What a preset decides is gray. */
static void allow_what_the_preset_leaves(GimpProcedureDialog *dialog, const settings *s)
{
    const procedure *p = &procedures[PROCEDURE_NORMALS];
    for (int i = 0; i < p->count; i++) {
        if (p->fields[i].kind == FIELD_CHOICE)
            gimp_procedure_dialog_set_sensitive(
                dialog, p->fields[i].name,
                !preset_decides((preset) s->value[FN_PRESET], p->fields[i].name), NULL, NULL,
                FALSE);
    }
}

static void on_change(GObject *config, GParamSpec *spec, gpointer data)
{
    const connection *c = data;
    settings s;
    (void) spec;
    config_read(c->procedure, GIMP_PROCEDURE_CONFIG(config), &s);
    if (c->procedure == &procedures[PROCEDURE_NORMALS]) {
        allow_alpha_layer(config, &s);
        allow_what_the_preset_leaves(c->dialog, &s);
    }
    if (c->view != NULL)
        view_update(c->view, &s);
}

/* The slider covers usual values, and its entry takes all allowed ones.  On a long one the middle is
 * an eighth of its end, so that small numbers have room; drags in its lower half are fine ones. */
static void make_slider(GimpProcedureDialog *dialog, const field *f)
{
    const gboolean curved = f->soft_high > 100;
    const gdouble step = f->digits == 0 ? 1 : curved ? 0.1 : 0.01;
    GtkWidget *slider = gimp_procedure_dialog_get_spin_scale(dialog, f->name, 1);
    gimp_spin_scale_set_scale_limits(GIMP_SPIN_SCALE(slider), f->soft_low, f->soft_high);
    gimp_spin_scale_set_gamma(GIMP_SPIN_SCALE(slider), curved ? 3 : 1);
    gtk_spin_button_set_increments(GTK_SPIN_BUTTON(slider), step, 10 * step);
    gtk_spin_button_set_digits(GTK_SPIN_BUTTON(slider), (guint) f->digits);
}

/* NULL: it has none.  What chooses a layer is a box that begins with it; its own function for that
 * is deprecated in GIMP 3.2. */
static GtkWidget *label_of(GtkWidget *widget)
{
    if (GIMP_IS_LABELED(widget))
        return gimp_labeled_get_label(GIMP_LABELED(widget));
    if (!GTK_IS_BOX(widget))
        return NULL;
    GList *inside = gtk_container_get_children(GTK_CONTAINER(widget));
    GtkWidget *first = inside != NULL ? inside->data : NULL;
    g_list_free(inside);
    return first != NULL && GTK_IS_LABEL(first) ? first : NULL;
}

/* GIMP puts the choices below each other, but not the layers among them. */
static void align_labels(GimpProcedureDialog *dialog, const procedure *p, const int *fields,
                         int count)
{
    GtkSizeGroup *group = gtk_size_group_new(GTK_SIZE_GROUP_HORIZONTAL);
    for (int i = 0; i < count; i++) {
        const field *f = &p->fields[fields[i]];
        GtkWidget *label = NULL;
        if (f->kind == FIELD_CHOICE || f->kind == FIELD_LAYER)
            label = label_of(gimp_procedure_dialog_get_widget(dialog, f->name, G_TYPE_NONE));
        if (label != NULL)
            gtk_size_group_add_widget(group, label);
    }
    g_object_unref(group);
}

/* The fields of a page as a box; NULL: there are none. */
static GtkWidget *page_new(GimpProcedureDialog *dialog, const procedure *p, int page)
{
    int fields[MAX_FIELDS];
    const int count = fields_on_page(p, page, fields);
    GList *names = NULL;
    gchar *id = g_strdup_printf("page-%d", page);
    GtkWidget *box = NULL;
    for (int i = 0; i < count; i++) {
        const field *f = &p->fields[fields[i]];
        if (f->kind == FIELD_NUMBER)
            make_slider(dialog, f);
        names = g_list_append(names, (gpointer) (guintptr) f->name);
    }
    if (names != NULL)
        box = gimp_procedure_dialog_fill_box_list(dialog, id, names);
    if (box != NULL) {
        gtk_container_set_border_width(GTK_CONTAINER(box), 6);
        align_labels(dialog, p, fields, count);
    }
    g_list_free(names);
    g_free(id);
    return box != NULL ? window_scrolled(box) : NULL;
}

static GtkWidget *controls_new(GimpProcedureDialog *dialog, const procedure *p)
{
    const char *const titles[PAGES] = { _("Normals"), _("Forms"), _("More") };
    GtkWidget *first = page_new(dialog, p, 0), *second = page_new(dialog, p, 1);
    if (second == NULL)
        return first;
    GtkWidget *const pages[PAGES] = { first, second, page_new(dialog, p, 2) };
    GtkWidget *book = gtk_notebook_new();
    for (int i = 0; i < PAGES; i++)
        gtk_notebook_append_page(GTK_NOTEBOOK(book), pages[i], gtk_label_new(titles[i]));
    return book;
}

/* As gimp_procedure_dialog_new, with our help pages instead of GIMP's manual. */
static GtkWidget *dialog_new(const procedure *p, GimpProcedure *pdb_procedure,
                             GimpProcedureConfig *config)
{
    gboolean header = FALSE;
    g_object_get(gtk_settings_get_default(), "gtk-dialogs-use-header", &header, NULL);
    return g_object_new(GIMP_TYPE_PROCEDURE_DIALOG, "procedure", pdb_procedure, "config", config,
                        "title", _(p->in_gimp3.title), "help-func", show_help, "help-id", p->name,
                        "use-header-bar", header, NULL);
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

gboolean dialog_run(const procedure *p, GimpProcedure *pdb_procedure, GimpProcedureConfig *config,
                    gint32 id)
{
    connection c = { .procedure = p };
    gimp_ui_init(p->name);
    GtkWidget *dialog = dialog_new(p, pdb_procedure, config);
    c.dialog = GIMP_PROCEDURE_DIALOG(dialog);
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 12);
    gtk_container_set_border_width(GTK_CONTAINER(box), 12);
    add_notice(gtk_dialog_get_content_area(GTK_DIALOG(dialog)), p, id);
    GtkWidget *controls = controls_new(GIMP_PROCEDURE_DIALOG(dialog), p);
    gtk_widget_set_hexpand(controls, p == &procedures[PROCEDURE_RESIZE]); /* room: to the preview */
    gtk_box_pack_start(GTK_BOX(box), controls, FALSE, TRUE, 0);
    if (p != &procedures[PROCEDURE_RESIZE]) {
        c.view = view_new(p, id);
        gtk_box_pack_start(GTK_BOX(box), c.view, TRUE, TRUE, 0);
    }
    gtk_box_pack_start(GTK_BOX(gtk_dialog_get_content_area(GTK_DIALOG(dialog))), box, TRUE, TRUE,
                       0);
    gtk_widget_show_all(box);
    const gulong handler = g_signal_connect(config, "notify", G_CALLBACK(on_change), &c);
    on_change(G_OBJECT(config), NULL, &c);
    window_fit(dialog, c.view, c.view != NULL ? VIEW_WIDER : 0, VIEW_HIGHER);
    const gboolean done = gimp_procedure_dialog_run(GIMP_PROCEDURE_DIALOG(dialog));
    g_signal_handler_disconnect(config, handler);
    gtk_widget_destroy(dialog);
    return done;
}
