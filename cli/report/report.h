/* SPDX-License-Identifier: MIT */
/*
 * report.h - results as text, JSON, CSV and lists
 *
 * The room of what is printed.
 *   report_text.c  what `ntp check` prints for people, its CSV, and colors
 *   baseline.c     findings of an earlier check
 *   report_json.c  JSON of every verb; the report of `ntp check` (docs/schema/check-1.json)
 */
#ifndef NTP_CLI_REPORT_H
#define NTP_CLI_REPORT_H

#include <jansson.h>

#include "examine/examine.h"
#include "findings/findings.h"
#include "options/options.h"

/* ---- colors */

typedef enum paint {
    PAINT_NONE,
    PAINT_BOLD,
    PAINT_RED,
    PAINT_YELLOW,
    PAINT_BLUE,
    PAINT_GREEN
} paint;

/* Do --color, NO_COLOR, CLICOLOR_FORCE and the terminal ask for colors? */
bool colors_wanted(const options *o);
void text_paint(text *t, bool colors, paint p, const char *words);

/* ---- JSON: report_json.c; used by every verb */

/* One object that opens: {"schema_version": 1, "tool": {...}, "files": [ */
void json_begin(text *t);
/* An item of that list, on a line of its own, after a comma; takes the reference. */
void json_item(text *t, json_t *item);
/* Takes the comma off the first item that is printed. */
void json_begin_list(text *item, bool *any);
/* Closes the list and adds the summary; takes the reference. */
void json_end(text *t, json_t *summary);
/* A whole document: "schema_version" and "tool", then the body. */
void json_document(text *t, json_t *body);

/* Sets `key` to a name in valid UTF-8.  If that loses bytes, also sets `key`_base64. */
void json_set_name(json_t *object, const char *key, const char *name);
/* Rounded to 0.001. */
json_t *json_angle(double degrees);
json_t *json_angles(const ntp_angles *angles);
json_t *json_count(uint64_t count);
/* Sets "changed" and "angle_deg" of an output.  NULL: input and output cannot be compared. */
void json_set_changes(json_t *object, const ntp_diff_stats *stats);
/* The object of a file: its path, its status, and a message or null. */
json_t *json_file(const input *in, const char *status, const char *message);

/* ---- check */

typedef struct check_settings {
    judge_rules rules;
    finding_level fail_level;
    bool fail_never;
    bool colors, quiet, verbose, nul;
} check_settings;

/* A checked file. */
typedef struct checked {
    bool readable;
    ntpio_error error;
    facts f;
    finding_list list;
    bool fails; /* a finding that counts has the level of --fail-on or above */
} checked;

typedef struct check_summary {
    size_t files, unreadable, failing, left_out;
    size_t foreign; /* unreadable files with the names of other formats */
    size_t by_class[NTP_CLASS_NOT_NORMALS + 1];
    size_t worst[LEVEL_ERROR + 1]; /* files by their worst counting finding */
    size_t well_formed;            /* counting files without warnings and errors */
    size_t possible;               /* those that would have some if their names were of normals */
    size_t only_known;             /* those whose warnings and errors are all in the baseline */
    size_t notes, known;
    size_t found[FINDING_COUNT];
} check_summary;

void check_text(text *t, const input *in, const checked *c, const check_settings *s);
void check_text_summary(text *t, const check_summary *sum, const check_settings *s);
json_t *check_json(const input *in, const checked *c, const check_settings *s);
json_t *check_json_summary(const check_summary *sum, const check_settings *s);
void check_csv_header(text *t);
void check_csv(text *t, const input *in, const checked *c, const check_settings *s);

#endif
