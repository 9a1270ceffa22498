/* SPDX-License-Identifier: MIT */
/*
 * view.h - the preview of the dialogs: the map, and beside it the surface lit by a movable light
 *
 * One widget for GTK 2 and GTK 3.
 */
#ifndef NTP_PLUGIN_VIEW_H
#define NTP_PLUGIN_VIEW_H

#include "host.h"

#include <gtk/gtk.h>

/* The preview of the result of the procedure.  It starts with the defaults. */
GtkWidget *view_new(const procedure *p, gint32 id);

/* Shows the result of these settings, soon. */
void view_update(GtkWidget *view, const settings *s);

#endif
