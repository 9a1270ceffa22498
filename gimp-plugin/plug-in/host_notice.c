/* SPDX-License-Identifier: MIT */
/*
 * host_notice.c - what users should know before a procedure runs: effects, and a layer of the wrong
 * kind
 */
#include "host.h"

#include <string.h>

enum { BANDS = 4, BAND = 48, SAMPLED = BANDS * BAND }; /* rows, which tell what a layer is */

/* Some bands of a layer as a smaller layer: GIMP sends few of its tiles. */
static bool read_sampled(void *user, int32_t y0, int32_t y1, void *rows)
{
    const raster *layer = user;
    guchar *to = rows;
    for (int32_t y = y0; y < y1; y++, to += raster_row(layer)) {
        const int32_t from = (layer->height - BAND) / (BANDS - 1) * (y / BAND) + y % BAND;
        if (!layer->read(layer->user, from, from + 1, to))
            return false;
    }
    return true;
}

static ntp_class kind_of(host_layer *layer)
{
    static report found;
    const settings question = { { 0 } };
    raster sampled = layer->raster;
    if (sampled.height > SAMPLED) {
        sampled.user = &layer->raster;
        sampled.read = read_sampled;
        sampled.height = SAMPLED;
    }
    return report_run(&found, &question, &sampled, NULL, NULL) == JOB_DONE ? found.type.type
                                                                           : NTP_CLASS_ONE_COLOR;
}

/* NULL: the layer suits the procedure, as far as one can tell. */
static const char *misfit(const procedure *p, host_layer *layer)
{
    if (layer->raster.channels < 3 ||
        (p != &procedures[PROCEDURE_NORMALS] && p != &procedures[PROCEDURE_HEIGHT]))
        return NULL;
    const ntp_class kind = kind_of(layer);
    const gboolean normals =
        kind == NTP_CLASS_STANDARD || kind == NTP_CLASS_ZZERO || kind == NTP_CLASS_XY;
    if (p == &procedures[PROCEDURE_NORMALS])
        return normals ? _("The layer shows normals already: this makes normals of their colors.")
                       : NULL;
    return kind == NTP_CLASS_HEIGHT
               ? _("This looks like a heightfield (bump map), not like normals.")
               : NULL;
}

void host_notice(const procedure *p, gint32 id, gboolean only_effects, char notice[HOST_TEXT])
{
    host_layer layer;
    notice[0] = 0;
    if (only_effects && !host_has_effects(id))
        return;
    host_open(&layer, id);
    if (layer.shown > 0)
        g_strlcpy(notice,
                  _("The layer has effects: this begins with what they show, and a result in the "
                    "layer takes their place."),
                  HOST_TEXT);
    const char *kind = misfit(p, &layer);
    if (kind != NULL && notice[0] != 0)
        g_strlcat(notice, "\n", HOST_TEXT);
    if (kind != NULL)
        g_strlcat(notice, kind, HOST_TEXT);
    host_close(&layer);
}
