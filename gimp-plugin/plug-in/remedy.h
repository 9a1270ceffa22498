/* SPDX-License-Identifier: MIT */
/*
 * remedy.h - what a report suggests to do with a layer, without GIMP
 *
 * Each remedy is what a verb of `ntp` does: clean, convert --to-y, convert --to standard, and
 * clean --undo.
 */
#ifndef NTP_PLUGIN_REMEDY_H
#define NTP_PLUGIN_REMEDY_H

#include "repair.h"

typedef enum remedy { REMEDY_UNDO, REMEDY_CLEAN, REMEDY_STANDARD, REMEDY_GREEN } remedy;
enum { REMEDIES = REMEDY_GREEN + 1 };

/* A report, and one on the layer as it would be without its accident. */
typedef struct findings {
    report found;
    report undone; /* if undoes */
    bool undoes;
} findings;

/* Fills both by the settings of PROCEDURE_CHECK; see report_run. */
job_status remedy_look(findings *f, const settings *s, const raster *layer,
                       const char *(*translate)(const char *text), const surroundings *around);

/* Can it do something for this layer? */
bool remedy_applies(remedy which, const findings *f);

/* The remedy that the layer needs most; REMEDIES: none. */
remedy remedy_needed(const findings *f);

/* The job, on the layer with this accident undone. */
repair_job remedy_job(remedy which, const findings *f, undo_kind *accident);

/* Which way green points afterwards; up where nothing tells it. */
ntp_y remedy_green(remedy which, const findings *f);

#endif
