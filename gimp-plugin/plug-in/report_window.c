/* SPDX-License-Identifier: MIT */
/*
 * report_window.c - "is this map right?": the report, the heatmap, the layer before and after a
 * remedy, and a button for each remedy
 *
 * The layer is measured in the background, so that the window stays alive and the user can stop it.
 */
#include "report_window.h"
#include "about.h"
#include "background.h"
#include "help.h"
#include "view.h"
#include "window.h"

#include <libgimp/gimpui.h>

enum {
    TICK = 50,    /* milliseconds from one look at the progress to the next */
    WIDTH = 300,  /* of the text */
    HEIGHT = 100, /* of it, at least */
    WIDER = 400,  /* than the least: the window at first */
    HIGHER = 250  /* than that: its view */
};

typedef struct window {
    settings *settings;
    gint32 id;
    char *message;
    host_layer layer; /* that is measured */
    background *looking;
    findings findings;
    job_status status; /* of looking */
    gboolean known;    /* the findings are there */
    guint ticks;
    GtkWidget *dialog, *text, *bar, *again, *view, *from, *negative, *remedies[REMEDIES];
} window;

/* ---------------------------------------------------------------------------- measuring */

static void measure(void *data, const surroundings *around)
{
    window *w = data;
    w->status = remedy_look(&w->findings, w->settings, &w->layer.raster, host_translate, around);
}

static void show_remedies(window *w)
{
    const gboolean up = w->findings.found.green.y == NTP_Y_UP;
    const char *refusal = host_refusal(&procedures[PROCEDURE_CLEAN], w->id);
    for (int i = 0; i < REMEDIES; i++) {
        const gboolean helps = w->known && remedy_applies((remedy) i, &w->findings);
        gtk_widget_set_visible(w->remedies[i], helps);
        gtk_widget_set_sensitive(w->remedies[i], refusal == NULL);
    }
    if (!w->known)
        return;
    gtk_button_set_label(GTK_BUTTON(w->remedies[REMEDY_GREEN]),
                         !w->findings.found.green.decided ? _("_Flip green")
                         : up                             ? _("_Flip green: down, DirectX")
                                                          : _("_Flip green: up, OpenGL"));
    gchar *undo = g_strdup_printf(_("U_ndo it and clean (%.0f %% sure)"),
                                  100 * w->findings.found.type.confidence);
    gtk_button_set_label(GTK_BUTTON(w->remedies[REMEDY_UNDO]), undo);
    g_free(undo);
}

static void show_progress_bar(window *w, gboolean busy)
{
    gtk_widget_set_visible(w->bar, busy);
    gtk_button_set_label(GTK_BUTTON(w->again), busy ? _("_Stop") : _("Check _again"));
}

static void end_look(window *w)
{
    background_stop(w->looking);
    if (w->looking != NULL)
        host_close(&w->layer);
    w->looking = NULL;
    if (w->ticks != 0)
        g_source_remove(w->ticks);
    w->ticks = 0;
}

/* The first line stands out, and lines stand apart. */
static void set_text(window *w, const char *text)
{
    gchar **lines = g_strsplit(text, "\n", 0);
    GString *made = g_string_new(NULL);
    for (gsize i = 0; lines[i] != NULL; i++) {
        gchar *safe = g_markup_escape_text(lines[i], -1);
        g_string_append_printf(made, i == 0 ? "<b>%s</b>" : "\n<span size=\"4000\">\n</span>%s",
                               safe);
        g_free(safe);
    }
    gtk_label_set_markup(GTK_LABEL(w->text), made->str);
    g_string_free(made, TRUE);
    g_strfreev(lines);
}

static void show(window *w, const char *text)
{
    set_text(w, text);
    show_remedies(w);
    show_progress_bar(w, FALSE);
    view_show(w->view, w->known ? &w->findings : NULL,
              w->known ? remedy_needed(&w->findings) : (remedy) REMEDIES);
}

static void on_measured(void *data)
{
    window *w = data;
    const gboolean effects = w->layer.shown > 0;
    end_look(w);
    w->known = w->status == JOB_DONE;
    if (w->known && effects)
        host_add_effects(&w->findings.found);
    g_strlcpy(w->message, w->known ? "" : _(job_status_text(w->status)), HOST_TEXT);
    show(w, w->known ? w->findings.found.text : w->message);
}

static gboolean tick(gpointer data)
{
    window *w = data;
    gtk_progress_bar_set_fraction(GTK_PROGRESS_BAR(w->bar),
                                  CLAMP(background_share(w->looking), 0, 1));
    return TRUE;
}

static void look(window *w)
{
    end_look(w);
    w->known = FALSE;
    w->message[0] = 0;
    show(w, _("Looking at the layer..."));
    host_open(&w->layer, w->id);
    w->layer.raster.user = &w->layer;
    gtk_progress_bar_set_fraction(GTK_PROGRESS_BAR(w->bar), 0);
    show_progress_bar(w, TRUE);
    w->looking = background_start(measure, on_measured, w);
    w->ticks = g_timeout_add(TICK, tick, w);
}

/* ----------------------------------------------------------------------------- controls */

static void on_change(GtkWidget *widget, gpointer data)
{
    window *w = data;
    (void) widget;
    w->settings->value[FK_FROM] = gtk_combo_box_get_active(GTK_COMBO_BOX(w->from));
    w->settings->value[FK_KEEP_NEGATIVE_Z] =
        gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(w->negative));
    look(w);
}

static void on_again(GtkWidget *button, gpointer data)
{
    window *w = data;
    (void) button;
    if (w->looking == NULL) {
        view_show(w->view, NULL, (remedy) REMEDIES);
        view_reload(w->view);
        look(w);
        return;
    }
    end_look(w);
    show(w, _("Stopped: there is no report. Nothing was changed."));
}

static remedy remedy_of(const window *w, const GtkWidget *button)
{
    int i = 0;
    while (i < REMEDIES && w->remedies[i] != button)
        i++;
    return (remedy) i;
}

/* The preview shows the remedy that the pointer or the keyboard is at. */
static gboolean on_near(GtkWidget *button, GdkEvent *event, gpointer data)
{
    window *w = data;
    (void) event;
    if (w->known)
        view_show(w->view, &w->findings, remedy_of(w, button));
    return FALSE;
}

static void on_remedy(GtkWidget *button, gpointer data)
{
    window *w = data;
    char said[HOST_TEXT];
    if (!w->known)
        return;
    const gboolean done = host_remedy(remedy_of(w, button), &w->findings, w->id, said);
    gimp_displays_flush();
    if (!done || said[0] != 0) {
        show(w, said);
        return;
    }
    view_show(w->view, NULL, (remedy) REMEDIES);
    view_reload(w->view);
    look(w);
}

/* ------------------------------------------------------------------------------- making */

static GtkWidget *column_new(void)
{
#if GTK_MAJOR_VERSION >= 3
    return gtk_box_new(GTK_ORIENTATION_VERTICAL, 6);
#else
    return gtk_vbox_new(FALSE, 6);
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

/* The findings may be many: they scroll. */
static GtkWidget *text_new(window *w)
{
    GtkWidget *scrolled = gtk_scrolled_window_new(NULL, NULL);
    w->text = gtk_label_new("");
    to_the_left(w->text);
    gtk_label_set_line_wrap(GTK_LABEL(w->text), TRUE);
    gtk_label_set_selectable(GTK_LABEL(w->text), TRUE);
    gtk_widget_set_size_request(w->text, window_scaled(WIDTH), -1);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scrolled), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
#if GTK_MAJOR_VERSION >= 3
    gtk_container_add(GTK_CONTAINER(scrolled), w->text);
    gtk_scrolled_window_set_overlay_scrolling(GTK_SCROLLED_WINDOW(scrolled), FALSE); /* in sight */
    gtk_widget_set_margin_end(w->text, 6);
#else
    GtkWidget *beside = gtk_alignment_new(0, 0, 1, 0); /* the scroll bar, which it would touch */
    gtk_alignment_set_padding(GTK_ALIGNMENT(beside), 0, 0, 0, 6);
    gtk_container_add(GTK_CONTAINER(beside), w->text);
    gtk_scrolled_window_add_with_viewport(GTK_SCROLLED_WINDOW(scrolled), beside);
    gtk_viewport_set_shadow_type(GTK_VIEWPORT(gtk_bin_get_child(GTK_BIN(scrolled))),
                                 GTK_SHADOW_NONE);
#endif
    gtk_widget_set_size_request(scrolled, -1, window_scaled(HEIGHT));
    return scrolled;
}

static GtkWidget *remedies_new(window *w)
{
    static const char *const TIPS[REMEDIES] = {
        [REMEDY_UNDO] = N_("Puts channels in their places, or takes back the conversion to sRGB, "
                           "then cleans, as ntp clean --undo"),
        [REMEDY_CLEAN] = N_("Makes every texel a unit vector, as ntp clean"),
        [REMEDY_STANDARD] = N_("Blue stores z in -1..1 afterwards, as ntp convert --to standard"),
        [REMEDY_GREEN] = N_("Exchanges OpenGL and DirectX; unused texels stay, as ntp convert "
                            "--to-y"),
    };
    GtkWidget *box = column_new();
    for (int i = 0; i < REMEDIES; i++) {
        w->remedies[i] =
            gtk_button_new_with_mnemonic(i == REMEDY_CLEAN      ? _("C_lean")
                                         : i == REMEDY_STANDARD ? _("Make blue _standard")
                                                                : "");
        gtk_button_set_use_underline(GTK_BUTTON(w->remedies[i]), TRUE);
        gtk_widget_set_tooltip_text(w->remedies[i], _(TIPS[i]));
        gtk_widget_set_no_show_all(w->remedies[i], TRUE);
        g_signal_connect(w->remedies[i], "clicked", G_CALLBACK(on_remedy), w);
        g_signal_connect(w->remedies[i], "enter-notify-event", G_CALLBACK(on_near), w);
        g_signal_connect(w->remedies[i], "focus-in-event", G_CALLBACK(on_near), w);
        gtk_box_pack_start(GTK_BOX(box), w->remedies[i], FALSE, FALSE, 0);
    }
    return box;
}

static GtkWidget *progress_new(window *w)
{
    GtkWidget *box = column_new();
    w->bar = gtk_progress_bar_new();
    gtk_widget_set_no_show_all(w->bar, TRUE);
    w->again = gtk_button_new_with_mnemonic("");
    gtk_button_set_use_underline(GTK_BUTTON(w->again), TRUE);
    g_signal_connect(w->again, "clicked", G_CALLBACK(on_again), w);
    gtk_box_pack_start(GTK_BOX(box), w->bar, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), w->again, FALSE, FALSE, 0);
    return box;
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
    to_the_left(label);
    w->negative = gtk_check_button_new_with_mnemonic(_(fields[FK_KEEP_NEGATIVE_Z].label));
    gtk_toggle_button_set_active(GTK_TOGGLE_BUTTON(w->negative),
                                 w->settings->value[FK_KEEP_NEGATIVE_Z] != 0);
    gtk_box_pack_start(GTK_BOX(box), text_new(w), TRUE, TRUE, 0);
    gtk_box_pack_start(GTK_BOX(box), remedies_new(w), FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), label, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), w->from, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), w->negative, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), progress_new(w), FALSE, FALSE, 0);
    g_signal_connect(w->from, "changed", G_CALLBACK(on_change), w);
    g_signal_connect(w->negative, "toggled", G_CALLBACK(on_change), w);
    return box;
}

gboolean report_window_run(settings *s, gint32 id, report *r, char message[HOST_TEXT])
{
    static window made; /* the findings are large */
    window *w = &made;
    *w = (window) { .settings = s, .id = id, .message = message };
#if HOST_GIMP3
    gimp_ui_init(PLUGIN_NAME);
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 12);
#else
    gimp_ui_init(PLUGIN_NAME, FALSE);
    GtkWidget *box = gtk_hbox_new(FALSE, 12);
#endif
    w->dialog =
        gimp_dialog_new(_("Is this map right?"), PLUGIN_NAME, NULL, 0, (GimpHelpFunc) show_help,
                        procedures[PROCEDURE_CHECK].name, _("_Close"), GTK_RESPONSE_CANCEL, NULL);
    gtk_container_set_border_width(GTK_CONTAINER(box), 12);
    gtk_box_pack_start(GTK_BOX(gtk_dialog_get_content_area(GTK_DIALOG(w->dialog))), box, TRUE, TRUE,
                       0);
    gtk_box_pack_start(GTK_BOX(box), controls_new(w), FALSE, TRUE, 0);
    w->view = view_new(&procedures[PROCEDURE_CHECK], id);
    gtk_box_pack_start(GTK_BOX(box), w->view, TRUE, TRUE, 0);
    gtk_widget_show_all(box);
    window_fit(w->dialog, w->view, WIDER, HIGHER);
    gtk_widget_grab_focus(w->from); /* not the text, which would be selected */
    look(w);
    gimp_dialog_run(GIMP_DIALOG(w->dialog));
    end_look(w);
    gtk_widget_destroy(w->dialog);
    *r = w->findings.found;
    return w->known;
}
