/* SPDX-License-Identifier: MIT */
/*
 * window.c - windows that fit the screen, at any scale of it
 */
#include "window.h"

enum { FRAME = 40 }; /* of a window: its title */

/* The part of the screen that panels leave, in pixels of GTK. */
static GdkRectangle room(void)
{
    GdkRectangle free = { 0 };
#if GTK_MAJOR_VERSION >= 3
    GdkDisplay *display = gdk_display_get_default();
    GdkMonitor *monitor = gdk_display_get_primary_monitor(display);
    if (monitor == NULL)
        monitor = gdk_display_get_monitor(display, 0);
    if (monitor != NULL)
        gdk_monitor_get_workarea(monitor, &free);
#else
    GdkScreen *screen = gdk_screen_get_default();
    gdk_screen_get_monitor_geometry(screen, gdk_screen_get_primary_monitor(screen), &free);
#endif
    free.height -= FRAME;
    return free;
}

#if GTK_MAJOR_VERSION >= 3
int window_scaled(int pixels)
{
    return pixels;
}

static GtkRequisition least(GtkWidget *widget)
{
    GtkRequisition size;
    gtk_widget_get_preferred_size(widget, NULL, &size);
    return size;
}

GtkWidget *window_scrolled(GtkWidget *child)
{
    GtkWidget *scrolled = gtk_scrolled_window_new(NULL, NULL);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scrolled), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
    gtk_scrolled_window_set_propagate_natural_height(GTK_SCROLLED_WINDOW(scrolled), TRUE);
    gtk_scrolled_window_set_overlay_scrolling(GTK_SCROLLED_WINDOW(scrolled), FALSE); /* in sight */
    gtk_container_add(GTK_CONTAINER(scrolled), child);
    return scrolled;
}

#else
int window_scaled(int pixels)
{
    const gdouble usual = 96, dots = gdk_screen_get_resolution(gdk_screen_get_default());
    return (int) (pixels * MAX(dots / usual, 1));
}

/* GTK 2 knows one size only: the least. */
static GtkRequisition least(GtkWidget *widget)
{
    GtkRequisition size;
    gtk_widget_size_request(widget, &size);
    return size;
}

static void on_size(GtkWidget *scrolled, GtkRequisition *size, gpointer data)
{
    (void) scrolled;
    const GdkRectangle most = room();
    size->height = MIN(least(data).height, most.height * 7 / 10); /* buttons and hints are below */
}

GtkWidget *window_scrolled(GtkWidget *child)
{
    GtkWidget *scrolled = gtk_scrolled_window_new(NULL, NULL);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scrolled), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
    gtk_scrolled_window_add_with_viewport(GTK_SCROLLED_WINDOW(scrolled), child);
    gtk_viewport_set_shadow_type(GTK_VIEWPORT(gtk_bin_get_child(GTK_BIN(scrolled))),
                                 GTK_SHADOW_NONE);
    g_signal_connect(scrolled, "size-request", G_CALLBACK(on_size), child);
    return scrolled;
}

#endif

void window_fit(GtkWidget *window, GtkWidget *view, int wider, int higher)
{
    const GdkRectangle most = room();
    const GtkRequisition size = least(window);
    const int box = view != NULL ? least(gtk_widget_get_parent(view)).height : 0;
    const int more = view != NULL ? MAX(least(view).height + window_scaled(higher) - box, 0) : 0;
    gtk_window_set_default_size(GTK_WINDOW(window),
                                MIN(size.width + window_scaled(wider), most.width),
                                MIN(size.height + more, most.height));
}
