/* SPDX-License-Identifier: MIT */
/*
 * preview.h - what a dialog shows: texels of the result, and the lit surface, without GIMP
 */
#ifndef NTP_PLUGIN_PREVIEW_H
#define NTP_PLUGIN_PREVIEW_H

#include "heights.h"
#include "repair.h"

/* The scale that the heights suggest, measured once; zeroed at first, and when the heights change.
 */
typedef struct preview_scale {
    bool known;
    double value;
    ntp_normals_options of;
    bool biased;
} preview_scale;

/* The smoothed heights, made once for their settings; zeroed at first. */
typedef struct preview_heights {
    smoothed made; /* without data: none */
    smoothing forms;
    ntp_normals_options of;
    bool biased;
} preview_heights;

/* When the heights change, and in the end. */
void preview_heights_forget(preview_heights *h);

typedef struct preview {
    const procedure *procedure; /* normals, height, clean or check */
    const settings *settings;
    const raster *layer;
    const raster *heights;      /* another layer's height, or NULL */
    const report *found;        /* clean, if a report decides; or NULL */
    bool waiting;               /* clean, but the report is not there yet: show the layer */
    const repair_job *repair;   /* check: the remedy to show; NULL: none, show the layer */
    undo_kind accident;         /* that is undone first */
    ntp_y green;                /* of normals as they are after cleaning or a remedy */
    int32_t width, height;      /* pixels to fill */
    double x, y;                /* the texel position at their upper left corner */
    double step;                /* texels from one pixel to the next */
    int32_t first, end;         /* the rows of pixels to fill; both 0: all of them */
    int32_t most;               /* texels that a pixel averages on each axis; 0: all under it */
    const ntp_light *light;     /* or NULL */
    preview_scale *scale;       /* kept from call to call, or NULL */
    preview_heights *smoothed;  /* the same */
    const surroundings *around; /* or NULL */
} preview;

/*
 * Fills packed RGB.  map gets the texels that the procedure will write, converted to 8 bits.  A
 * pixel that covers several shows their mean: of normals, the normal of their mean slope.  lit gets
 * the plane with these normals, before (or NULL) the layer as it is.
 * Heights are made only from what the pixels show, as from a small texture; lit shows the normals
 * as they are.
 */
job_status preview_render(const preview *p, uint8_t *map, uint8_t *lit, uint8_t *before);

/* The heatmap of the layer as it is, by p->found: a pixel shows the worst texel under it. */
job_status preview_heatmap(const preview *p, ntp_palette palette, uint8_t *heat);

#endif
