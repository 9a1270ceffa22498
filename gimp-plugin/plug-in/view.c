/* SPDX-License-Identifier: MIT */
/*
 * view.c - the preview widget
 *
 * "Fit" shows all of the layer with its own proportions, in pictures that grow with the window.
 * Dragging in the map moves it, dragging in the lit picture moves the light, and the wheel zooms.
 */
#include "view.h"
#include "view_render.h"

#include <math.h>
#include <string.h>

enum {
    SIDE = 170,   /* of a picture, at least */
    NARROW = 160, /* of three beside each other */
    GRIP = 6      /* so near to the line between before and after a press takes it */
};
#define VIEW_KEY "ntp-view"
#define N_(TEXT) TEXT

/* -------------------------------------------------------------------------------- mouse */

static void move_light(view *v, GtkWidget *area, double x, double y)
{
    const place at = view_place(v, area);
    double dx = 2 * (x - at.x) / at.width - 1;
    double dy = 2 * (y - at.y) / at.height - 1;
    const double length = sqrt(dx * dx + dy * dy);
    const double most = 0.97; /* never exactly from the side */
    if (length > most) {
        dx *= most / length;
        dy *= most / length;
    }
    v->light.direction[0] = dx;
    v->light.direction[1] = -dy;
    v->light.direction[2] = sqrt(1 - MIN(length, most) * MIN(length, most));
}

static gboolean over_line(const view *v, GtkWidget *area, double x)
{
    const place at = view_place(v, area);
    return area == v->areas[MAP] && view_is_on(v->compare) &&
           fabs(x - at.x - v->line * at.width) <= GRIP;
}

static void move_line(view *v, GtkWidget *area, double x)
{
    const place at = view_place(v, area);
    v->line = CLAMP((x - at.x) / at.width, 0, 1);
    gtk_widget_queue_draw(area);
}

static void drag(view *v, GtkWidget *area, double x, double y)
{
    if (v->dragging == DRAG_LINE) {
        move_line(v, area, x);
        return;
    }
    if (area == v->areas[LIT]) {
        move_light(v, area, x, y);
    } else {
        v->x -= (x - v->last_x) * v->step * view_density(v);
        v->y -= (y - v->last_y) * v->step * view_density(v);
    }
    v->last_x = x;
    v->last_y = y;
    view_render_soon(v);
}

static gboolean on_press(GtkWidget *area, GdkEventButton *event, gpointer data)
{
    view *v = data;
    if (event->button != 1)
        return FALSE;
    v->dragging = over_line(v, area, event->x) ? DRAG_LINE : DRAG_PICTURE;
    v->last_x = event->x;
    v->last_y = event->y;
    drag(v, area, event->x, event->y);
    return TRUE;
}

static gboolean on_release(GtkWidget *area, GdkEventButton *event, gpointer data)
{
    (void) area;
    (void) event;
    ((view *) data)->dragging = NO_DRAG;
    return TRUE;
}

static gboolean on_motion(GtkWidget *area, GdkEventMotion *event, gpointer data)
{
    view *v = data;
    if (v->dragging)
        drag(v, area, event->x, event->y);
    return TRUE;
}

static void on_zoom(GtkComboBox *combo, gpointer data)
{
    view *v = data;
    v->zoom = MAX(gtk_combo_box_get_active(combo), 0);
    view_render_soon(v);
}

static void on_toggle(GtkToggleButton *button, gpointer data)
{
    view *v = data;
    (void) button;
    gtk_widget_set_sensitive(v->combo, !view_is_on(v->tile));
    view_render_soon(v);
}

static void on_resize(GtkWidget *area, GdkRectangle *size, gpointer data)
{
    (void) area;
    (void) size;
    view_render_soon(data);
}

static gboolean on_scroll(GtkWidget *area, GdkEventScroll *event, gpointer data)
{
    view *v = data;
    const int change = event->direction == GDK_SCROLL_UP     ? 1
                       : event->direction == GDK_SCROLL_DOWN ? -1
                                                             : 0;
    const int zoom = CLAMP(v->zoom + change, 0, (int) G_N_ELEMENTS(view_zooms) - 1);
    (void) area;
    gtk_combo_box_set_active(GTK_COMBO_BOX(v->combo), zoom);
    return TRUE;
}

/* ------------------------------------------------------------------------------- making */

static GtkWidget *box_new(gboolean vertical)
{
#if GTK_MAJOR_VERSION >= 3
    return gtk_box_new(vertical ? GTK_ORIENTATION_VERTICAL : GTK_ORIENTATION_HORIZONTAL, 6);
#else
    return vertical ? gtk_vbox_new(FALSE, 6) : gtk_hbox_new(FALSE, 6);
#endif
}

static GtkWidget *picture_new(view *v, int which, const char *title, const char *tip)
{
    GtkWidget *box = box_new(TRUE);
    GtkWidget *area = gtk_drawing_area_new();
    v->areas[which] = area;
    const int side = v->procedure == &procedures[PROCEDURE_CHECK] ? NARROW : SIDE;
    gtk_widget_set_size_request(area, side, side);
    gtk_widget_set_tooltip_text(area, tip);
    gtk_widget_add_events(area, GDK_BUTTON_PRESS_MASK | GDK_BUTTON_RELEASE_MASK |
                                    GDK_BUTTON1_MOTION_MASK | GDK_SCROLL_MASK);
    view_paint_area(v, area);
    g_signal_connect(area, "button-press-event", G_CALLBACK(on_press), v);
    g_signal_connect(area, "button-release-event", G_CALLBACK(on_release), v);
    g_signal_connect(area, "motion-notify-event", G_CALLBACK(on_motion), v);
    g_signal_connect(area, "scroll-event", G_CALLBACK(on_scroll), v);
    GtkWidget *label = gtk_label_new(title);
    if (which == MAP)
        v->title = label;
    gtk_box_pack_start(GTK_BOX(box), label, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), area, TRUE, TRUE, 0);
    return box;
}

static GtkWidget *toggle_new(view *v, const char *label, const char *tip)
{
    GtkWidget *toggle = gtk_check_button_new_with_label(label);
    gtk_widget_set_tooltip_text(toggle, tip);
    g_signal_connect(toggle, "toggled", G_CALLBACK(on_toggle), v);
    return toggle;
}

static GtkWidget *zoom_new(view *v)
{
    const gboolean narrow = v->procedure != &procedures[PROCEDURE_CHECK];
    GtkWidget *box = box_new(FALSE), *both = box_new(TRUE);
    v->tile = toggle_new(v, _("Tile 2 x 2"), _("Four times the whole layer, to look for seams"));
    v->compare = toggle_new(v, _("Before and after"),
                            _("The layer as it is on the left. Drag the line between them"));
    v->combo = gtk_combo_box_text_new();
    for (gsize i = 0; i < G_N_ELEMENTS(view_zooms); i++)
        gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(v->combo), _(view_zooms[i].label));
    gtk_combo_box_set_active(GTK_COMBO_BOX(v->combo), 0);
    g_signal_connect(v->combo, "changed", G_CALLBACK(on_zoom), v);
    gtk_box_pack_start(GTK_BOX(box), gtk_label_new(_("Preview:")), FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), v->combo, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), v->tile, FALSE, FALSE, 6);
    gtk_box_pack_start(GTK_BOX(narrow ? both : box), v->compare, FALSE, FALSE, narrow ? 0 : 6);
    gtk_box_pack_start(GTK_BOX(both), box, FALSE, FALSE, 0);
    gtk_box_reorder_child(GTK_BOX(both), box, 0);
    return both;
}

static void explain(view *v)
{
    const char *reference = _("Red: red and green too long. Green: wrong length. Blue: points into "
                              "the surface. Gray: right.");
    const char *safe = _("Orange: red and green too long. Light blue: wrong length. Yellow: points "
                         "into the surface. Gray: right.");
    gtk_label_set_text(GTK_LABEL(v->legend), v->palette == NTP_PALETTE_SAFE ? safe : reference);
}

static void on_palette(GtkToggleButton *button, gpointer data)
{
    view *v = data;
    v->palette = gtk_toggle_button_get_active(button) ? NTP_PALETTE_SAFE : NTP_PALETTE_REFERENCE;
    explain(v);
    view_render_soon(v);
}

/* A text from the left that takes as many lines as it needs. */
static void wrap(GtkWidget *label)
{
    enum { CHARS = 46 };
    gtk_label_set_line_wrap(GTK_LABEL(label), TRUE);
#if GTK_MAJOR_VERSION >= 3
    gtk_label_set_xalign(GTK_LABEL(label), 0);
    gtk_label_set_max_width_chars(GTK_LABEL(label), CHARS);
#else
    gtk_misc_set_alignment(GTK_MISC(label), 0, 0.5);
    gtk_label_set_width_chars(GTK_LABEL(label), CHARS);
#endif
}

/* What the colors of the heatmap mean, and other colors. */
static GtkWidget *legend_new(view *v)
{
    GtkWidget *box = box_new(FALSE);
    GtkWidget *safe = gtk_check_button_new_with_label(_("Colors for everybody"));
    gtk_widget_set_tooltip_text(
        safe, _("Colors of the heatmap that can be told apart with every kind of color vision"));
    g_signal_connect(safe, "toggled", G_CALLBACK(on_palette), v);
    v->legend = gtk_label_new("");
    explain(v);
    wrap(v->legend);
    gtk_box_pack_start(GTK_BOX(box), v->legend, TRUE, TRUE, 0);
    gtk_box_pack_start(GTK_BOX(box), safe, FALSE, FALSE, 6);
    return box;
}

static void view_free(gpointer data)
{
    view *v = data;
    view_render_stop(v);
    host_close(&v->layer);
    host_close(&v->heights);
    g_free(v->map);
    g_free(v->lit);
    g_free(v->before);
    g_free(v->heat);
    preview_heights_forget(&v->smoothed);
    g_free(v);
}

GtkWidget *view_new(const procedure *p, gint32 id)
{
    view *v = g_new0(view, 1);
    GtkWidget *all = box_new(TRUE), *pictures = box_new(FALSE);
    v->procedure = p;
    v->heights_id = -1;
    v->line = 0.5;
    settings_reset(p, &v->settings);
    host_open(&v->layer, id);
    v->layer.raster.user = &v->layer;
    v->x = v->layer.raster.width / 2.0;
    v->y = v->layer.raster.height / 2.0;
    v->light = (ntp_light) { .direction = { -0.5, 0.5, 0.7 },
                             .ambient = 0.1,
                             .diffuse = 0.9,
                             .specular = 0.2,
                             .color = { 0.6, 0.6, 0.6 } };
    const bool height = p == &procedures[PROCEDURE_HEIGHT];
    const bool check = p == &procedures[PROCEDURE_CHECK];
    if (check)
        gtk_box_pack_start(
            GTK_BOX(pictures),
            picture_new(v, HEAT, _("Heatmap"),
                        _("Where the layer is wrong, as it is now. A pixel shows the worst texel "
                          "under it")),
            TRUE, TRUE, 0);
    gtk_box_pack_start(GTK_BOX(pictures),
                       picture_new(v, MAP, height ? _("Approximate height") : _("Result"),
                                   height ? _("Made from the pixels shown here. The result is made "
                                              "from all texels of the layer.\n"
                                              "Drag to move, turn the wheel to zoom")
                                          : _("Drag to move, turn the wheel to zoom")),
                       TRUE, TRUE, 0);
    gtk_box_pack_start(GTK_BOX(pictures),
                       picture_new(v, LIT, _("Lit"), _("Drag to move the light")), TRUE, TRUE, 0);
    gtk_box_set_homogeneous(GTK_BOX(pictures), TRUE);
    gtk_box_pack_start(GTK_BOX(all), pictures, TRUE, TRUE, 0);
    if (check)
        gtk_box_pack_start(GTK_BOX(all), legend_new(v), FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(all), zoom_new(v), FALSE, FALSE, 0);
    v->note = gtk_label_new("");
    gtk_label_set_line_wrap(GTK_LABEL(v->note), TRUE);
    gtk_box_pack_start(GTK_BOX(all), v->note, FALSE, FALSE, 0);
    g_object_set_data_full(G_OBJECT(all), VIEW_KEY, v, view_free);
    g_signal_connect(v->areas[MAP], "size-allocate", G_CALLBACK(on_resize), v);
    gtk_toggle_button_set_active(GTK_TOGGLE_BUTTON(v->compare), check);
    gtk_widget_show_all(all);
    view_render_soon(v);
    return all;
}

static view *view_of(GtkWidget *widget)
{
    return g_object_get_data(G_OBJECT(widget), VIEW_KEY);
}

void view_update(GtkWidget *widget, const settings *s)
{
    view *v = view_of(widget);
    v->settings = *s;
    settings_check(v->procedure, &v->settings);
    view_render_soon(v);
}

void view_show(GtkWidget *widget, const findings *f, remedy which)
{
    static const char *const TITLES[REMEDIES + 1] = { [REMEDY_UNDO] = N_("After undoing it"),
                                                      [REMEDY_CLEAN] = N_("After cleaning"),
                                                      [REMEDY_STANDARD] = N_("With standard blue"),
                                                      [REMEDY_GREEN] = N_("With green flipped"),
                                                      [REMEDIES] = N_("The layer") };
    view *v = view_of(widget);
    if (v->findings == f && v->remedy == which)
        return;
    v->findings = f;
    v->remedy = which;
    gtk_label_set_text(GTK_LABEL(v->title), _(TITLES[which]));
    view_render_soon(v);
}

void view_reload(GtkWidget *widget)
{
    view *v = view_of(widget);
    const gint32 id = v->layer.id;
    host_close(&v->layer);
    host_open(&v->layer, id);
    v->layer.raster.user = &v->layer;
    v->findings = NULL;
    view_render_soon(v);
}
