/* SPDX-License-Identifier: MIT */
/*
 * view_paint.h - the state of the preview widget, and its pictures as they are painted
 */
#ifndef NTP_PLUGIN_VIEW_PAINT_H
#define NTP_PLUGIN_VIEW_PAINT_H

#include "background.h"
#include "host.h"
#include "preview.h"
#include "remedy.h"

#include <gtk/gtk.h>

enum { MAP, LIT, HEAT, AREAS };

typedef struct view {
    const procedure *procedure;
    settings settings;
    host_layer layer, heights;
    gint32 heights_id;
    gboolean luminance; /* heights are that */
    /* For cleaning: what the layer is, and the method for it, found in the background. */
    host_layer seen;
    background *looking;
    report found;
    settings question; /* that it answers */
    enum { NOT_LOOKED, LOOKS, LOOKED } looked;
    /* For the report: what it found, and the remedy to show. */
    const findings *findings;
    remedy remedy;
    repair_job repair;
    ntp_palette palette;
    ntp_light light;
    int zoom;
    double x, y;       /* the texel in the middle */
    int width, height; /* of the pictures, in pixels of the screen */
    double step;
    preview_scale scale;
    preview_heights smoothed;
    uint8_t *map, *lit, *before, *heat; /* packed RGB */
    int row;                            /* of pixels, that is the next to be shown in full */
    int rows, most;                     /* at once; texels that they show, 0: all */
    gsize size;                         /* of a picture */
    GtkWidget *areas[AREAS], *note, *title, *legend, *combo, *tile, *compare;
    guint pending, refining;
    enum { NO_DRAG, DRAG_PICTURE, DRAG_LINE } dragging;
    double last_x, last_y;
    double line; /* between before and after, 0 to 1 */
} view;

/* Pixels of the screen for one of GTK. */
int view_density(const view *v);

gboolean view_is_on(GtkWidget *toggle);

/* Where the pictures are in an area: its upper left corner and its size, in pixels of GTK. */
typedef struct place {
    double x, y, width, height;
} place;
place view_place(const view *v, GtkWidget *area);

/* Connects the areas with what paints them. */
void view_paint_area(view *v, GtkWidget *area);

#endif
