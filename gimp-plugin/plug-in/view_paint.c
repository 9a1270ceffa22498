/* SPDX-License-Identifier: MIT */
/*
 * view_paint.c - the pictures of the preview widget, with the light and the line between halves
 */
#include "view_paint.h"

#include <math.h>
#include <string.h>

enum { MARKER = 5 };

int view_density(const view *v)
{
#if GTK_MAJOR_VERSION >= 3
    return gtk_widget_get_scale_factor(v->areas[MAP]);
#else
    (void) v;
    return 1;
#endif
}

gboolean view_is_on(GtkWidget *toggle)
{
    return gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(toggle));
}

place view_place(const view *v, GtkWidget *area)
{
    const double parts = view_is_on(v->tile) ? 2 : 1;
    GtkAllocation size;
    gtk_widget_get_allocation(area, &size);
    const double width = v->width * parts / view_density(v);
    const double height = v->height * parts / view_density(v);
    return (place) { (size.width - width) / 2, (size.height - height) / 2, width, height };
}

static cairo_surface_t *surface_of(const view *v, const uint8_t *rgb)
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
    return surface;
}

/* The part of a picture from its left to a share of its width. */
static void paint(cairo_t *cr, const view *v, const uint8_t *rgb, const place *at, double share)
{
    cairo_surface_t *surface = surface_of(v, rgb);
    cairo_save(cr);
    cairo_rectangle(cr, at->x, at->y, share * at->width, at->height);
    cairo_clip(cr);
    cairo_translate(cr, at->x, at->y);
    cairo_scale(cr, 1.0 / view_density(v), 1.0 / view_density(v));
    cairo_set_source_surface(cr, surface, 0, 0);
    cairo_pattern_set_extend(cairo_get_source(cr), CAIRO_EXTEND_REPEAT);
    cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_NEAREST);
    cairo_paint(cr);
    cairo_restore(cr);
    cairo_surface_destroy(surface);
}

static void paint_line(cairo_t *cr, const view *v, const place *at)
{
    cairo_move_to(cr, at->x + v->line * at->width, at->y);
    cairo_rel_line_to(cr, 0, at->height);
    cairo_set_line_width(cr, 3);
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_stroke_preserve(cr);
    cairo_set_line_width(cr, 1);
    cairo_set_source_rgb(cr, 1, 1, 1);
    cairo_stroke(cr);
}

static void paint_light(cairo_t *cr, const view *v, const place *at)
{
    const double *d = v->light.direction;
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const double x = d[0] / length, y = -d[1] / length; /* -1 to 1 to the right and down */
    cairo_arc(cr, at->x + (1 + x) * at->width / 2, at->y + (1 + y) * at->height / 2, MARKER, 0,
              2 * G_PI);
    cairo_set_source_rgb(cr, 1, 0.85, 0.2);
    cairo_fill_preserve(cr);
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_set_line_width(cr, 1);
    cairo_stroke(cr);
}

static void draw(GtkWidget *area, cairo_t *cr, const view *v)
{
    const gboolean lit = area == v->areas[LIT];
    const uint8_t *rgb = lit ? v->lit : area == v->areas[HEAT] ? v->heat : v->map;
    const place at = view_place(v, area);
    if (rgb == NULL)
        return;
    paint(cr, v, rgb, &at, 1);
    if (lit) {
        paint_light(cr, v, &at);
    } else if (area == v->areas[MAP] && view_is_on(v->compare)) {
        paint(cr, v, v->before, &at, v->line);
        paint_line(cr, v, &at);
    }
}

#if GTK_MAJOR_VERSION >= 3
#  define SIGNAL "draw"
static gboolean on_draw(GtkWidget *area, cairo_t *cr, gpointer data)
{
    draw(area, cr, data);
    return FALSE;
}
#else
#  define SIGNAL "expose-event"
static gboolean on_draw(GtkWidget *area, GdkEventExpose *event, gpointer data)
{
    cairo_t *cr = gdk_cairo_create(event->window);
    draw(area, cr, data);
    cairo_destroy(cr);
    return FALSE;
}
#endif

void view_paint_area(view *v, GtkWidget *area)
{
    g_signal_connect(area, SIGNAL, G_CALLBACK(on_draw), v);
}
