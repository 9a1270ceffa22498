/* SPDX-License-Identifier: MIT */
/*
 * repair.h - jobs on independent texels, without GIMP: cleaning, and "Normalize only" and "DU/DV to
 * normal" of gimp-normalmap
 */
#ifndef NTP_PLUGIN_REPAIR_H
#define NTP_PLUGIN_REPAIR_H

#include "normals.h"
#include "report.h"

typedef struct repair_job {
    ntp_encoding from; /* that of the result as well, but for: */
    bool derive;       /* NTP_ENCODING_XY in, NTP_ENCODING_STANDARD out */
    bool convert;      /* to this encoding, and green the other way, as `ntp convert` does */
    ntp_encoding to;
    bool turn_green;
    bool alpha_is_data; /* alpha 0 does not mean an unused texel */
    bool clean;         /* by these options */
    ntp_clean_options how;
    bool strengthen; /* slopes times strength, each normal computed again */
    double strength;
    double min_z; /* 0: no limit; steeper ones keep their direction */
    bool flip_x, flip_y, swap;
    dudv_format dudv;
    alpha_rule alpha; /* not the height */
} repair_job;

/* True if a report on the layer has to decide some settings of PROCEDURE_CLEAN.  Then *question
 * gets the settings of that report. */
bool repair_finds_out(const settings *s, settings *question);

/* The job for the settings of PROCEDURE_CLEAN.  found: the report; NULL if none is needed. */
repair_job repair_job_from(const settings *s, const report *found);

/* layer and result have the same size; result has 3 or 4 channels.  *changed: texels that cleaning
 * changed; may be NULL. */
job_status repair_job_run(const repair_job *job, const raster *layer, const raster *alpha,
                          const raster *result, const ntp_rect *area, const surroundings *around,
                          uint64_t *changed);

/* The same on rows in memory: `rows` is a view of 3 or 4 channels, changed in place. */
job_status repair_rows(const repair_job *job, const ntp_image *rows, uint64_t *changed);

#endif
