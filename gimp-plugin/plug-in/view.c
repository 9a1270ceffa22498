/* SPDX-License-Identifier: MIT */
/*
 * view.c - the preview widget
 *
 * Only visible texels are computed, when the program is idle: first few of them for each pixel, so
 * that a slider can be dragged, and when nothing changes any more all.  "Fit" shows all of the layer
 * with its own proportions, in pictures that grow with the window.  Dragging in the map moves it,
 * dragging in the lit picture moves the light, and the wheel zooms.
 */
#include "view.h"
#include "repair.h"
#include "view_paint.h"

#include <math.h>
#include <string.h>

enum {
    SIDE = 170,    /* of a picture, at least */
    NARROW = 160,  /* of three beside each other */
    SLICE = 30000, /* microseconds to show rows in full, so that the window stays alive */
    GRIP = 6,      /* so near to the line between before and after a press takes it */
    FEW = 2,       /* texels on each axis that a pixel shows while something changes */
    PATIENCE = 150 /* milliseconds without a change until all texels are shown */
};
#define VIEW_KEY "ntp-view"
#define N_(TEXT) TEXT

/* Screen pixels for a texel; 0: all of the layer. */
static const struct {
    double zoom;
    const char *label;
} zooms[] = { { 0, N_("Fit") }, { 1, "1:1" }, { 2, "2:1" }, { 4, "4:1" }, { 8, "8:1" } };

/* ------------------------------------------------------------------------------ geometry */

/* The pixels of a picture, or of one of the four tiles in it. */
static void room(const view *v, int *width, int *height)
{
    GtkAllocation size;
    gtk_widget_get_allocation(v->areas[MAP], &size);
    const int parts = view_is_on(v->tile) ? 2 : 1;
    *width = MAX(size.width, 2) * view_density(v) / parts;
    *height = MAX(size.height, 2) * view_density(v) / parts;
}

static void fit(view *v)
{
    const double width = v->layer.raster.width, height = v->layer.raster.height;
    int most_width, most_height;
    room(v, &most_width, &most_height);
    const double whole = MIN(most_width / width, most_height / height);
    const double chosen = view_is_on(v->tile) ? 0 : zooms[v->zoom].zoom * view_density(v);
    const double zoom = chosen > 0 ? chosen : whole;
    v->step = 1 / zoom;
    v->width = CLAMP((int) (width * zoom + 0.5), 1, most_width);
    v->height = CLAMP((int) (height * zoom + 0.5), 1, most_height);
    const double half_width = v->width * v->step / 2, half_height = v->height * v->step / 2;
    v->x = width > 2 * half_width ? CLAMP(v->x, half_width, width - half_width) : width / 2;
    v->y = height > 2 * half_height ? CLAMP(v->y, half_height, height - half_height) : height / 2;
}

/* ---------------------------------------------------------------------------- rendering */

/* Another layer's heights, the luminance of that or of the layer, or NULL: the layer itself. */
static const raster *other_heights(view *v)
{
    const gboolean normals = v->procedure == &procedures[PROCEDURE_NORMALS];
    const gint32 id = normals ? (gint32) v->settings.value[FN_HEIGHT_LAYER] : -1;
    const gboolean light = normals && normals_job_from(&v->settings).luminance;
    if (id != v->heights_id || light != v->luminance) {
        host_close(&v->heights);
        v->heights_id = id;
        v->luminance = light;
        v->scale.known = false;
        preview_heights_forget(&v->smoothed);
        if (light)
            host_open_luminance(&v->heights, host_is_layer(id) ? id : v->layer.id);
        else if (host_is_layer(id))
            host_open(&v->heights, id);
    }
    return v->heights.buffer != NULL ? &v->heights.raster : NULL;
}

static gboolean same_settings(const settings *a, const settings *b)
{
    for (int i = 0; i < MAX_FIELDS; i++) {
        if (a->value[i] != b->value[i])
            return FALSE;
    }
    return TRUE;
}

static void look_at(void *data, const surroundings *around)
{
    view *v = data;
    if (report_run(&v->found, &v->question, &v->seen.raster, NULL, around) != JOB_DONE)
        v->found.judged = false;
}

static void render_soon(view *v);

static void stop_looking(view *v)
{
    background_stop(v->looking);
    if (v->looking != NULL)
        host_close(&v->seen);
    v->looking = NULL;
}

static void on_looked(void *data)
{
    view *v = data;
    stop_looking(v);
    v->looked = LOOKED;
    render_soon(v);
}

/* Detects what the settings leave open, as cleaning will; again when they change.  NULL: they leave
 * nothing open, or it is not known yet. */
static const report *look(view *v)
{
    settings question;
    if (v->procedure == &procedures[PROCEDURE_CHECK])
        return v->findings != NULL ? &v->findings->found : NULL;
    if (v->procedure != &procedures[PROCEDURE_CLEAN] || v->layer.raster.channels < 3 ||
        !repair_finds_out(&v->settings, &question)) {
        stop_looking(v);
        v->looked = NOT_LOOKED;
        return NULL;
    }
    if (v->looked == NOT_LOOKED || !same_settings(&question, &v->question)) {
        stop_looking(v);
        v->looked = LOOKS;
        v->question = question;
        host_open(&v->seen, v->layer.id);
        v->seen.raster.user = &v->seen;
        v->looking = background_start(look_at, on_looked, v);
    }
    return v->looked == LOOKED ? &v->found : NULL;
}

static void say(const view *v, job_status status)
{
    const gboolean measured = v->procedure == &procedures[PROCEDURE_NORMALS] &&
                              v->settings.value[FN_SCALE] == 0 && v->scale.value > 0;
    gchar *found = measured ? g_strdup_printf(_("Scale from the layer: %g"), v->scale.value)
                            : g_strdup(v->looked == LOOKS ? _("Looking at the layer...") : "");
    gtk_label_set_text(GTK_LABEL(v->note), status == JOB_DONE ? found : _(job_status_text(status)));
    g_free(found);
}

/* The remedy that is shown, and which way green points after it. */
static const repair_job *shown_remedy(view *v, undo_kind *accident, ntp_y *green)
{
    *accident = UNDO_NOTHING;
    if (v->findings == NULL)
        return NULL;
    *green = remedy_green(v->remedy, v->findings);
    if (v->remedy == (remedy) REMEDIES || !remedy_applies(v->remedy, v->findings))
        return NULL;
    v->repair = remedy_job(v->remedy, v->findings, accident);
    return &v->repair;
}

/* The rows of pixels first .. end - 1.  most: texels that a pixel shows on each axis; 0: all. */
static job_status render_rows(view *v, int first, int end, int most)
{
    surroundings around = host_surroundings;
    around.progress = NULL;
    preview p = { .procedure = v->procedure,
                  .settings = &v->settings,
                  .layer = &v->layer.raster,
                  .heights = other_heights(v),
                  .found = look(v),
                  .waiting = v->looked == LOOKS,
                  .width = v->width,
                  .height = v->height,
                  .x = v->x - v->width * v->step / 2,
                  .y = v->y - v->height * v->step / 2,
                  .step = v->step,
                  .first = first,
                  .end = end,
                  .most = most,
                  .light = &v->light,
                  .scale = &v->scale,
                  .smoothed = &v->smoothed,
                  .around = &around };
    p.repair = shown_remedy(v, &p.accident, &p.green);
    if (v->procedure == &procedures[PROCEDURE_CLEAN] && v->settings.value[FC_UNDO] != 0 &&
        p.found != NULL && undone_is_possible(p.found->accident, p.layer))
        p.accident = p.found->accident;
    job_status status =
        preview_render(&p, v->map, v->lit, view_is_on(v->compare) ? v->before : NULL);
    if (status == JOB_DONE && v->areas[HEAT] != NULL && p.found != NULL && p.found->judged)
        status = preview_heatmap(&p, v->palette, v->heat);
    for (int i = 0; i < AREAS; i++) {
        if (v->areas[i] != NULL)
            gtk_widget_queue_draw(v->areas[i]);
    }
    return status;
}

/* Room for the pictures; they stay until they are painted over, if their size does. */
static void make_room(view *v)
{
    fit(v);
    const gsize size = (gsize) v->width * (gsize) v->height * 3;
    uint8_t **const pictures[] = { &v->map, &v->lit, &v->before, &v->heat };
    const gboolean fits = v->size == size;
    for (gsize i = 0; i < G_N_ELEMENTS(pictures) && !fits; i++) {
        g_free(*pictures[i]);
        *pictures[i] = g_malloc0(size);
    }
    v->size = size;
}

/* Some more rows, as many as a moment allows.  Heights depend on all rows. */
static gboolean refine(gpointer data)
{
    view *v = data;
    const gboolean whole = v->procedure == &procedures[PROCEDURE_HEIGHT];
    const int end = whole ? v->height : MIN(v->row + v->rows, v->height);
    const gint64 began = g_get_monotonic_time();
    say(v, render_rows(v, v->row, end, v->most));
    const gint64 taken = g_get_monotonic_time() - began;
    v->rows = (int) CLAMP(v->rows * (double) SLICE / (double) MAX(taken, 1), 1, 2 * v->rows + 1);
    v->row = end;
    v->refining = end < v->height ? g_idle_add(refine, v) : 0;
    if (end == v->height && v->most > 0 && v->step > v->most) {
        v->row = v->most = 0;
        v->rows = 1;
        v->refining = g_timeout_add(PATIENCE, refine, v);
    }
    return FALSE;
}

/* First few texels for each pixel.  Where a slider may be dragged, at once, for it would begin again
 * and again at the top. */
static gboolean render_idle(gpointer data)
{
    view *v = data;
    v->pending = 0;
    make_room(v);
    v->row = 0;
    v->rows = v->procedure == &procedures[PROCEDURE_CHECK] ? 1 : v->height;
    v->most = FEW;
    refine(v);
    return FALSE;
}

static void render_soon(view *v)
{
    if (v->refining != 0)
        g_source_remove(v->refining);
    v->refining = 0;
    if (v->pending == 0)
        v->pending = g_idle_add(render_idle, v);
}

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
    render_soon(v);
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
    render_soon(v);
}

static void on_toggle(GtkToggleButton *button, gpointer data)
{
    view *v = data;
    (void) button;
    gtk_widget_set_sensitive(v->combo, !view_is_on(v->tile));
    render_soon(v);
}

static void on_resize(GtkWidget *area, GdkRectangle *size, gpointer data)
{
    (void) area;
    (void) size;
    render_soon(data);
}

static gboolean on_scroll(GtkWidget *area, GdkEventScroll *event, gpointer data)
{
    view *v = data;
    const int change = event->direction == GDK_SCROLL_UP     ? 1
                       : event->direction == GDK_SCROLL_DOWN ? -1
                                                             : 0;
    const int zoom = CLAMP(v->zoom + change, 0, (int) G_N_ELEMENTS(zooms) - 1);
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
    for (gsize i = 0; i < G_N_ELEMENTS(zooms); i++)
        gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(v->combo), _(zooms[i].label));
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
    render_soon(v);
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
    if (v->pending != 0)
        g_source_remove(v->pending);
    if (v->refining != 0)
        g_source_remove(v->refining);
    stop_looking(v);
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
    render_soon(v);
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
    render_soon(v);
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
    render_soon(v);
}

void view_reload(GtkWidget *widget)
{
    view *v = view_of(widget);
    const gint32 id = v->layer.id;
    host_close(&v->layer);
    host_open(&v->layer, id);
    v->layer.raster.user = &v->layer;
    v->findings = NULL;
    render_soon(v);
}
