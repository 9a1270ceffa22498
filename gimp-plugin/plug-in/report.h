/* SPDX-License-Identifier: MIT */
/*
 * report.h - what a layer is and what is wrong with it, in numbers and in words, without GIMP
 */
#ifndef NTP_PLUGIN_REPORT_H
#define NTP_PLUGIN_REPORT_H

#include "fields.h"
#include "findings/counts.h"
#include "undone.h"

/* Texels that are wrong beyond rounding: in length (red and green alone included), in red and green
 * alone, by negative z. */
typedef enum report_harm { REPORT_LENGTH, REPORT_XY, REPORT_Z, REPORT_HARMS } report_harm;

typedef struct report {
    int32_t width, height, channels;
    ntp_type samples;
    ntp_stats stats;
    ntp_harm harm[REPORT_HARMS]; /* over: by more than COUNTS_MAX_ANGLE */
    ntp_classification type;
    ntp_orientation_result green;
    ntp_encoding encoding;   /* as which it was judged; NTP_ENCODING_HEIGHT: not judged */
    ntp_clean_method method; /* that suits its errors */
    uint32_t touch;          /* unused kinds that are normals: alpha 0 where alpha is a height */
    undo_kind accident;      /* that can be undone exactly */
    uint64_t used;           /* texels that are judged: neither unused nor padding */
    uint64_t failing;        /* of them, those that are not unit vectors to within a level */
    uint64_t inexact;        /* those whose blue is not that of red and green */
    bool told;               /* the user says how blue stores z */
    bool keeps;              /* negative z is meant so */
    bool judged;             /* the counts above are valid */
    bool misplaced;          /* channels are exchanged or were converted, so cleaning would harm */
    bool right;              /* a normals texture with no texel to repair */
    int errors, warnings;    /* among the findings */
    char text[6000];         /* for users */
} report;

enum { REPORT_VALUES = 15 };

/* The values for scripts, in this order. */
typedef struct report_value {
    const char *name;
    const char *help;
    bool is_text;
} report_value;
extern const report_value report_value_table[REPORT_VALUES];

double report_number_of(const report *r, int value);
const char *report_text_of(const report *r, int value);

/* Reads the layer and fills the report by the settings of PROCEDURE_CHECK.  translate: for the
 * text; NULL: English. */
job_status report_run(report *r, const settings *s, const raster *layer,
                      const char *(*translate)(const char *text), const surroundings *around);

#endif
