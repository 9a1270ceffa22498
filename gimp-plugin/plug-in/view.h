/* SPDX-License-Identifier: MIT */
/*
 * view.h - the preview of the dialogs: the map, and beside it the surface lit by a movable light
 *
 * One widget for GTK 2 and GTK 3.
 */
#ifndef NTP_PLUGIN_VIEW_H
#define NTP_PLUGIN_VIEW_H

#include "host.h"
#include "remedy.h"

#include <gtk/gtk.h>

enum { VIEW_WIDER = 240, VIEW_HIGHER = 120 }; /* than the least: at first, with two pictures */

/* The preview of the result of the procedure.  It starts with the defaults.  That of
 * PROCEDURE_CHECK has the heatmap, too, and shows remedies. */
GtkWidget *view_new(const procedure *p, gint32 id);

/* Shows the result of these settings, soon. */
void view_update(GtkWidget *view, const settings *s);

/* Of PROCEDURE_CHECK: what was found, which must stay there (NULL: nothing yet), and the remedy to
 * show (REMEDIES: none, the layer as it is). */
void view_show(GtkWidget *view, const findings *f, remedy which);

/* The layer has changed: reads it again. */
void view_reload(GtkWidget *view);

#endif
