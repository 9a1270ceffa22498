/* SPDX-License-Identifier: MIT */
/* undone.h - a layer whose accident is undone while it is read, as by `ntp clean --undo` */
#ifndef NTP_PLUGIN_UNDONE_H
#define NTP_PLUGIN_UNDONE_H

#include "raster.h"
#include "write/undo_rows.h"

typedef struct undone {
    raster raster; /* of the layer's shape */
    const raster *layer;
    undo_kind kind;
} undone;

/* Opens the layer with this accident undone: u->raster.user is u, which must not move. */
void undone_open(undone *u, const raster *layer, undo_kind kind);

/* Can it be undone in such samples?  (sRGB not in floats.) */
bool undone_is_possible(undo_kind kind, const raster *layer);

#endif
