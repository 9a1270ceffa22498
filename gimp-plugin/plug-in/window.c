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
GtkWidget *window_scrolled(GtkWidget *child)
{
    GtkWidget *scrolled = gtk_scrolled_window_new(NULL, NULL);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scrolled), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
    gtk_scrolled_window_set_propagate_natural_height(GTK_SCROLLED_WINDOW(scrolled), TRUE);
    gtk_container_add(GTK_CONTAINER(scrolled), child);
    return scrolled;
}

void window_fit(GtkWidget *window, int wider, int higher)
{
    const GdkRectangle most = room();
    GtkRequisition size;
    gtk_widget_get_preferred_size(window, NULL, &size);
    gtk_window_set_default_size(GTK_WINDOW(window), MIN(size.width + wider, most.width),
                                MIN(size.height + higher, most.height));
}
#else
/* GTK 2 knows one size only: the least. */
static void on_size(GtkWidget *scrolled, GtkRequisition *size, gpointer data)
{
    GtkRequisition child;
    (void) scrolled;
    gtk_widget_size_request(data, &child);
    const GdkRectangle most = room();
    size->height = MIN(child.height, most.height * 7 / 10); /* buttons and hints are below */
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

void window_fit(GtkWidget *window, int wider, int higher)
{
    const GdkRectangle most = room();
    GtkRequisition size;
    gtk_widget_size_request(window, &size);
    gtk_window_set_default_size(GTK_WINDOW(window), MIN(size.width + wider, most.width),
                                MIN(size.height + higher, most.height));
}
#endif
