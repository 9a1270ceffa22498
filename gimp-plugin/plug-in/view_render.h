/* SPDX-License-Identifier: MIT */
/*
 * view_render.h - the pixels of the preview widget, when the program is idle
 */
#ifndef NTP_PLUGIN_VIEW_RENDER_H
#define NTP_PLUGIN_VIEW_RENDER_H

#include "view_paint.h"

/* Screen pixels for a texel; 0: all of the layer. */
typedef struct view_zoom {
    double zoom;
    const char *label;
} view_zoom;
enum { VIEW_ZOOMS = 5 };
extern const view_zoom view_zooms[VIEW_ZOOMS];

/* Renders all visible pixels anew, soon. */
void view_render_soon(view *v);

/* Ends what renders and looks; nothing is called after it. */
void view_render_stop(view *v);

#endif
