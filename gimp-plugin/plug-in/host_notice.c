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

static ntp_class kind_of(const raster *layer)
{
    static report found;
    const settings question = { { 0 } };
    raster sampled = *layer;
    if (sampled.height > SAMPLED) {
        sampled.user = (void *) (guintptr) layer;
        sampled.read = read_sampled;
        sampled.height = SAMPLED;
    }
    return report_run(&found, &question, &sampled, NULL, NULL) == JOB_DONE ? found.type.type
                                                                           : NTP_CLASS_ONE_COLOR;
}

static gboolean is_normals(ntp_class kind)
{
    return kind == NTP_CLASS_STANDARD || kind == NTP_CLASS_ZZERO || kind == NTP_CLASS_XY ||
           kind == NTP_CLASS_OBJECT_SPACE;
}

/* NULL: the layer suits the procedure, as far as one can tell. */
static const char *misfit(const procedure *p, host_layer *layer)
{
    if (layer->raster.channels < 3 ||
        (p != &procedures[PROCEDURE_NORMALS] && p != &procedures[PROCEDURE_HEIGHT]))
        return NULL;
    const ntp_class kind = kind_of(&layer->raster);
    if (p == &procedures[PROCEDURE_NORMALS])
        return is_normals(kind)
                   ? _("The layer shows normals already: this makes normals of their colors.")
                   : NULL;
    return kind == NTP_CLASS_HEIGHT
               ? _("This looks like a heightfield (bump map), not like normals.")
               : NULL;
}

/* What it is takes a pass over every texel, unless some of them are clearly a heightfield's. */
static gboolean holds_normals(const raster *layer)
{
    static const double SURE = 0.9; /* that of `ntp` */
    static report found;
    const settings question = { { 0 } };
    surroundings quiet = host_surroundings;
    quiet.progress = NULL; /* it would open a window beside the question */
    if (layer->channels < 3 || kind_of(layer) == NTP_CLASS_HEIGHT)
        return FALSE;
    return report_run(&found, &question, layer, NULL, &quiet) == JOB_DONE &&
           is_normals(found.type.type) && found.type.confidence >= SURE;
}

gboolean host_shows_normals(const settings *s, const host_layer *layer)
{
    const ntp_height_source source = normals_job_from(s).how.source;
    const gint32 other_id = (gint32) s->value[FN_HEIGHT_LAYER];
    if (s->value[FN_FORCE] != 0 || source == NTP_HEIGHT_SOURCE_GREEN ||
        source == NTP_HEIGHT_SOURCE_BLUE || source == NTP_HEIGHT_SOURCE_ALPHA)
        return FALSE;
    if (!host_is_layer(other_id))
        return holds_normals(&layer->raster);
    host_layer other;
    host_open(&other, other_id);
    const gboolean found = holds_normals(&other.raster);
    host_close(&other);
    return found;
}

gboolean host_must_ask(const settings *s, gint32 id)
{
    host_layer layer;
    host_open(&layer, id);
    const gboolean found = host_shows_normals(s, &layer);
    host_close(&layer);
    return found;
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
