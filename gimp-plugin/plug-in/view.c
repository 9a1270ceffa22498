/* SPDX-License-Identifier: MIT */
/*
 * view.c - the preview widget
 *
 * Only visible texels are computed, when the program is idle.  "Fit" shows all of the layer with
 * its own proportions.  Dragging in the map moves it, dragging in the lit picture moves the light,
 * and the wheel zooms.
 */
#include "view.h"
#include "preview.h"
#include "repair.h"

#include <math.h>
#include <string.h>

enum { SIDE = 288, MARKER = 5 };
#define VIEW_KEY "ntp-view"
#define N_(TEXT) TEXT

/* Screen pixels for a texel; 0: all of the layer. */
static const struct {
    double zoom;
    const char *label;
} zooms[] = { { 0, N_("Fit") }, { 1, "1:1" }, { 2, "2:1" }, { 4, "4:1" }, { 8, "8:1" } };

typedef struct view {
    const procedure *procedure;
    settings settings;
    host_layer layer, heights;
    gint32 heights_id;
    report found; /* for cleaning: what the layer is, and the method for it */
    gboolean looked;
    settings question; /* that it answers */
    ntp_light light;
    int zoom;
    double x, y;       /* the texel in the middle */
    int width, height; /* of the pictures */
    double step;
    uint8_t *map, *lit; /* packed RGB */
    GtkWidget *areas[2], *note, *combo;
    guint pending;
    gboolean dragging;
    double last_x, last_y;
} view;

enum { MAP, LIT };

/* ------------------------------------------------------------------------------ geometry */

static void fit(view *v)
{
    const double width = v->layer.raster.width, height = v->layer.raster.height;
    const double longer = MAX(width, height);
    const double zoom = zooms[v->zoom].zoom > 0 ? zooms[v->zoom].zoom : SIDE / longer;
    v->step = 1 / zoom;
    v->width = CLAMP((int) (width * zoom + 0.5), 1, SIDE);
    v->height = CLAMP((int) (height * zoom + 0.5), 1, SIDE);
    const double half_width = v->width * v->step / 2, half_height = v->height * v->step / 2;
    v->x = width > 2 * half_width ? CLAMP(v->x, half_width, width - half_width) : width / 2;
    v->y = height > 2 * half_height ? CLAMP(v->y, half_height, height - half_height) : height / 2;
}

/* ---------------------------------------------------------------------------- rendering */

static const raster *other_heights(view *v)
{
    const gint32 id = v->procedure == &procedures[PROCEDURE_NORMALS]
                          ? (gint32) v->settings.value[FN_HEIGHT_LAYER]
                          : -1;
    if (id != v->heights_id) {
        host_close(&v->heights);
        v->heights_id = id;
        if (host_is_layer(id))
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

/* Detects what the settings leave open, as cleaning will; again when they change. */
static const report *look(view *v)
{
    settings question;
    if (v->procedure != &procedures[PROCEDURE_CLEAN] || v->layer.raster.channels < 3 ||
        !repair_finds_out(&v->settings, &question))
        return NULL;
    if (!v->looked || !same_settings(&question, &v->question)) {
        v->looked = TRUE;
        v->question = question;
        if (report_run(&v->found, &question, &v->layer.raster, NULL, NULL) != JOB_DONE)
            v->found.judged = false;
    }
    return &v->found;
}

static void render(view *v)
{
    fit(v);
    const gsize size = (gsize) v->width * (gsize) v->height * 3;
    v->map = g_realloc(v->map, size);
    v->lit = g_realloc(v->lit, size);
    memset(v->map, 0, size);
    memset(v->lit, 0, size);
    const preview p = { .procedure = v->procedure,
                        .settings = &v->settings,
                        .layer = &v->layer.raster,
                        .heights = other_heights(v),
                        .found = look(v),
                        .width = v->width,
                        .height = v->height,
                        .x = v->x - v->width * v->step / 2,
                        .y = v->y - v->height * v->step / 2,
                        .step = v->step,
                        .light = &v->light };
    double scale = 0;
    const job_status status = preview_render(&p, v->map, v->lit, &scale);
    gchar *found = scale > 0 ? g_strdup_printf(_("Scale from the layer: %g"), scale) : g_strdup("");
    gtk_label_set_text(GTK_LABEL(v->note), status == JOB_DONE ? found : _(job_status_text(status)));
    g_free(found);
    gtk_widget_queue_draw(v->areas[MAP]);
    gtk_widget_queue_draw(v->areas[LIT]);
}

static gboolean render_idle(gpointer data)
{
    view *v = data;
    v->pending = 0;
    render(v);
    return FALSE;
}

static void render_soon(view *v)
{
    if (v->pending == 0)
        v->pending = g_idle_add(render_idle, v);
}

/* ------------------------------------------------------------------------------ drawing */

static void paint(cairo_t *cr, const view *v, const uint8_t *rgb, int width, int height)
{
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, v->width, v->height);
    const int stride = cairo_image_surface_get_stride(surface);
    unsigned char *data = cairo_image_surface_get_data(surface);
    cairo_surface_flush(surface);
    for (int y = 0; y < v->height; y++) {
        for (int x = 0; x < v->width; x++, rgb += 3) {
            const guint32 color = (guint32) rgb[0] << 16 | (guint32) rgb[1] << 8 | rgb[2];
            memcpy(data + y * stride + x * 4, &color, sizeof color);
        }
    }
    cairo_surface_mark_dirty(surface);
    const int left = (width - v->width) / 2, above = (height - v->height) / 2;
    cairo_set_source_surface(cr, surface, left, above);
    cairo_paint(cr);
    cairo_surface_destroy(surface);
}

/* The position of the light over the lit picture, -1..1 to the right and down. */
static void light_place(const view *v, double *x, double *y)
{
    const double *d = v->light.direction;
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    *x = d[0] / length;
    *y = -d[1] / length;
}

static void paint_light(cairo_t *cr, const view *v, int width, int height)
{
    double x, y;
    light_place(v, &x, &y);
    cairo_arc(cr, width / 2.0 + x * v->width / 2, height / 2.0 + y * v->height / 2, MARKER, 0,
              2 * G_PI);
    cairo_set_source_rgb(cr, 1, 0.85, 0.2);
    cairo_fill_preserve(cr);
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_set_line_width(cr, 1);
    cairo_stroke(cr);
}

static void draw(GtkWidget *area, cairo_t *cr, const view *v)
{
    GtkAllocation size;
    gtk_widget_get_allocation(area, &size);
    const gboolean lit = area == v->areas[LIT];
    const uint8_t *rgb = lit ? v->lit : v->map;
    if (rgb == NULL)
        return;
    paint(cr, v, rgb, size.width, size.height);
    if (lit)
        paint_light(cr, v, size.width, size.height);
}

#if GTK_MAJOR_VERSION >= 3
static gboolean on_draw(GtkWidget *area, cairo_t *cr, gpointer data)
{
    draw(area, cr, data);
    return FALSE;
}
#else
static gboolean on_draw(GtkWidget *area, GdkEventExpose *event, gpointer data)
{
    cairo_t *cr = gdk_cairo_create(event->window);
    draw(area, cr, data);
    cairo_destroy(cr);
    return FALSE;
}
#endif

/* -------------------------------------------------------------------------------- mouse */

static void move_light(view *v, GtkWidget *area, double x, double y)
{
    GtkAllocation size;
    gtk_widget_get_allocation(area, &size);
    double dx = (x - size.width / 2.0) / (v->width / 2.0);
    double dy = (y - size.height / 2.0) / (v->height / 2.0);
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

static void drag(view *v, GtkWidget *area, double x, double y)
{
    if (area == v->areas[LIT]) {
        move_light(v, area, x, y);
    } else {
        v->x -= (x - v->last_x) * v->step;
        v->y -= (y - v->last_y) * v->step;
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
    v->dragging = TRUE;
    v->last_x = event->x;
    v->last_y = event->y;
    drag(v, area, event->x, event->y);
    return TRUE;
}

static gboolean on_release(GtkWidget *area, GdkEventButton *event, gpointer data)
{
    (void) area;
    (void) event;
    ((view *) data)->dragging = FALSE;
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
    GtkWidget *frame = gtk_frame_new(NULL), *area = gtk_drawing_area_new();
    v->areas[which] = area;
    gtk_widget_set_size_request(area, SIDE, SIDE);
    gtk_widget_set_tooltip_text(area, tip);
    gtk_widget_add_events(area, GDK_BUTTON_PRESS_MASK | GDK_BUTTON_RELEASE_MASK |
                                    GDK_BUTTON1_MOTION_MASK | GDK_SCROLL_MASK);
#if GTK_MAJOR_VERSION >= 3
    g_signal_connect(area, "draw", G_CALLBACK(on_draw), v);
#else
    g_signal_connect(area, "expose-event", G_CALLBACK(on_draw), v);
#endif
    g_signal_connect(area, "button-press-event", G_CALLBACK(on_press), v);
    g_signal_connect(area, "button-release-event", G_CALLBACK(on_release), v);
    g_signal_connect(area, "motion-notify-event", G_CALLBACK(on_motion), v);
    g_signal_connect(area, "scroll-event", G_CALLBACK(on_scroll), v);
    gtk_box_pack_start(GTK_BOX(box), gtk_label_new(title), FALSE, FALSE, 0);
    gtk_container_add(GTK_CONTAINER(frame), area);
    gtk_box_pack_start(GTK_BOX(box), frame, FALSE, FALSE, 0);
    return box;
}

static GtkWidget *zoom_new(view *v)
{
    GtkWidget *box = box_new(FALSE);
    v->combo = gtk_combo_box_text_new();
    for (gsize i = 0; i < G_N_ELEMENTS(zooms); i++)
        gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(v->combo), _(zooms[i].label));
    gtk_combo_box_set_active(GTK_COMBO_BOX(v->combo), 0);
    g_signal_connect(v->combo, "changed", G_CALLBACK(on_zoom), v);
    gtk_box_pack_start(GTK_BOX(box), gtk_label_new(_("Preview:")), FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(box), v->combo, FALSE, FALSE, 0);
    return box;
}

static void view_free(gpointer data)
{
    view *v = data;
    if (v->pending != 0)
        g_source_remove(v->pending);
    host_close(&v->layer);
    host_close(&v->heights);
    g_free(v->map);
    g_free(v->lit);
    g_free(v);
}

GtkWidget *view_new(const procedure *p, gint32 id)
{
    view *v = g_new0(view, 1);
    GtkWidget *all = box_new(TRUE), *pictures = box_new(FALSE);
    v->procedure = p;
    v->heights_id = -1;
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
    gtk_box_pack_start(GTK_BOX(pictures),
                       picture_new(v, MAP, height ? _("Height (about)") : _("Result"),
                                   _("Drag to move, turn the wheel to zoom")),
                       FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(pictures),
                       picture_new(v, LIT, _("Lit"), _("Drag to move the light")), FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(all), pictures, FALSE, FALSE, 0);
    gtk_box_pack_start(GTK_BOX(all), zoom_new(v), FALSE, FALSE, 0);
    v->note = gtk_label_new("");
    gtk_label_set_line_wrap(GTK_LABEL(v->note), TRUE);
    gtk_box_pack_start(GTK_BOX(all), v->note, FALSE, FALSE, 0);
    g_object_set_data_full(G_OBJECT(all), VIEW_KEY, v, view_free);
    gtk_widget_show_all(all);
    render_soon(v);
    return all;
}

void view_update(GtkWidget *widget, const settings *s)
{
    view *v = g_object_get_data(G_OBJECT(widget), VIEW_KEY);
    v->settings = *s;
    settings_check(v->procedure, &v->settings);
    render_soon(v);
}
