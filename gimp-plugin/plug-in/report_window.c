/* SPDX-License-Identifier: MIT */
/*
 * report_window.c - "is this map right?": the report, the lit layer as it would be after cleaning,
 * and a button that cleans it
 */
#include "report_window.h"
#include "about.h"
#include "help.h"
#include "view.h"

#include <libgimp/gimpui.h>

typedef struct window {
    settings *settings;
    gint32 id;
    report *report;
    char *message;
    GtkWidget *dialog, *text, *view, *from, *negative;
} window;

settings report_window_clean(const settings *s)
{
    enum { AUTO_METHOD = 2 };
    settings clean;
    settings_reset(&procedures[PROCEDURE_CLEAN], &clean);
    clean.value[FC_METHOD] = AUTO_METHOD;
    clean.value[FC_FROM] = s->value[FK_FROM];
    clean.value[FC_KEEP_NEGATIVE_Z] = s->value[FK_KEEP_NEGATIVE_Z];
    return clean;
}

static gboolean look(window *w)
{
    const gboolean done = host_check(w->settings, w->id, w->report, w->message);
    const report *found = w->report;
    const gboolean wrong =
        done && found->judged && !found->right && !found->misplaced && found->used > 0;
    gtk_label_set_text(GTK_LABEL(w->text), done ? w->report->text : w->message);
    gtk_dialog_set_response_sensitive(GTK_DIALOG(w->dialog), GTK_RESPONSE_OK, wrong);
    if (w->view != NULL) {
        const settings clean = report_window_clean(w->settings);
        view_update(w->view, &clean);
    }
    return done;
}

static void on_change(GtkWidget *widget, gpointer data)
{
    window *w = data;
    (void) widget;
    w->settings->value[FK_FROM] = gtk_combo_box_get_active(GTK_COMBO_BOX(w->from));
    w->settings->value[FK_KEEP_NEGATIVE_Z] =
        gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(w->negative));
    look(w);
}

static GtkWidget *column_new(void)
{
#if GTK_MAJOR_VERSION >= 3
    return gtk_box_new(GTK_ORIENTATION_VERTICAL, 12);
#else
    return gtk_vbox_new(FALSE, 12);
#endif
}

static void to_the_left(GtkWidget *label) /* and to the top */
{
#if GTK_MAJOR_VERSION >= 3
    gtk_label_set_xalign(GTK_LABEL(label), 0);
    gtk_label_set_yalign(GTK_LABEL(label), 0);
#else
    gtk_misc_set_alignment(GTK_MISC(label), 0, 0);
#endif
}

static GtkWidget *controls_new(window *w)
{
    const field *fields = procedures[PROCEDURE_CHECK].fields;
    GtkWidget *box = column_new();
    w->from = gtk_combo_box_text_new();
    for (int i = 0; i < choice_count(&fields[FK_FROM]); i++)
        gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(w->from),
                                       _(fields[FK_FROM].choices[i].label));
    gtk_combo_box_set_active(GTK_COMBO_BOX(w->from), (gint) w->settings->value[FK_FROM]);
    GtkWidget *label = gtk_label_new_with_mnemonic(_(fields[FK_FROM].label));
    gtk_label_set_mnemonic_widget(GTK_LABEL(label), w->from);
    w->negative = gtk_check_button_new_with_mnemonic(_(fields[FK_KEEP_NEGATIVE_Z].label));
    gtk_toggle_button_set_active(GTK_TOGGLE_BUTTON(w->negative),
                                 w->settings->value[FK_KEEP_NEGATIVE_Z] != 0);
    to_the_left(label);
    w->text = gtk_label_new("");
    to_the_left(w->text);
    gtk_label_set_line_wrap(GTK_LABEL(w->text), TRUE);
    gtk_label_set_selectable(GTK_LABEL(w->text), TRUE);
    gtk_widget_set_size_request(w->text, 330, -1);
    gtk_box_pack_start(GTK_BOX(box), w->text, TRUE, TRUE, 0);
    gtk_box_pack_start(GTK_BOX(box), label, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), w->from, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), w->negative, FALSE, FALSE, 0);
    g_signal_connect(w->from, "changed", G_CALLBACK(on_change), w);
    g_signal_connect(w->negative, "toggled", G_CALLBACK(on_change), w);
    return box;
}

gboolean report_window_run(settings *s, gint32 id, report *r, char message[HOST_TEXT])
{
    window w = { .settings = s, .id = id, .report = r, .message = message };
#if HOST_GIMP3
    gimp_ui_init(PLUGIN_NAME);
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 12);
#else
    gimp_ui_init(PLUGIN_NAME, FALSE);
    GtkWidget *box = gtk_hbox_new(FALSE, 12);
#endif
    w.dialog =
        gimp_dialog_new(_("Is this map right?"), PLUGIN_NAME, NULL, 0, (GimpHelpFunc) show_help,
                        procedures[PROCEDURE_CHECK].name, _("_Close"), GTK_RESPONSE_CANCEL,
                        _("C_lean"), GTK_RESPONSE_OK, NULL);
    gtk_container_set_border_width(GTK_CONTAINER(box), 12);
    gtk_box_pack_start(GTK_BOX(gtk_dialog_get_content_area(GTK_DIALOG(w.dialog))), box, TRUE, TRUE,
                       0);
    gtk_box_pack_start(GTK_BOX(box), controls_new(&w), TRUE, TRUE, 0);
    w.view = view_new(&procedures[PROCEDURE_CLEAN], id);
    gtk_box_pack_start(GTK_BOX(box), w.view, FALSE, FALSE, 0);
    gtk_widget_show_all(box);
    const gboolean known = look(&w);
    const gboolean clean = gimp_dialog_run(GIMP_DIALOG(w.dialog)) == GTK_RESPONSE_OK;
    gtk_widget_destroy(w.dialog);
    return known && clean;
}
