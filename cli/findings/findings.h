/* SPDX-License-Identifier: MIT */
/*
 * findings.h - what `ntp check` can find, and the judging of one file
 *
 * The room of findings.
 *   findings.c     the table: id, level, title, reason and remedy; docs/findings.md is made from it
 *   counts.c       which texels count, and how much they matter; the GIMP plug-in has it, too
 *   rules.c        from the facts of a file to its findings; judgement.h is what its parts share
 *   class_rules.c  what a texture is, and what was done to it as a whole
 *   texel_rules.c  lengths, z, flat color, tilt
 *   file_rules.c   name, green, surface, storage
 */
#ifndef NTP_CLI_FINDINGS_H
#define NTP_CLI_FINDINGS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "examine/examine.h"
#include "findings/counts.h"
#include "options/options.h"

typedef enum finding_id {
    NT001,
    NT002,
    NT003,
    NT004,
    NT005,
    NT006,
    NT007,
    NT008,
    NT009,
    NT010,
    NT011,
    NT012,
    NT013,
    NT014,
    NT020,
    NT021,
    NT022,
    NT023,
    NT030,
    NT031,
    NT032,
    NT033,
    NT034,
    NT035,
    NT036,
    NT040,
    NT041,
    NT042,
    NT044,
    NT045,
    NT050,
    NT051,
    NT052,
    NT053,
    NT054,
    FINDING_COUNT
} finding_id;

typedef struct finding_spec {
    const char *id;
    const char *anchor; /* in docs/findings.md */
    const char *levels; /* "error", or "warning or error" where the amount decides */
    const char *title;
    const char *why;
    const char *remedy;
} finding_spec;

extern const finding_spec FINDING_TABLE[FINDING_COUNT];

typedef struct finding {
    finding_id id;
    finding_level level;
    finding_level if_named; /* the level that it has in a file whose name is that of normals */
    bool known;             /* in the baseline: shown but not counted */
    uint64_t count;
    char message[400];
} finding;

typedef struct finding_list {
    finding at[FINDING_COUNT];
    size_t count;
} finding_list;

/* How to judge; from the options. */
typedef struct judge_rules {
    bool strict;      /* every texel that fails the verdict counts, however little it is off */
    double max_angle; /* degrees; not used if strict */
    ntp_verdict verdict;
    bool keep_negative_z;
    double max_fail, max_tilt; /* percent; mean component */
    int y;                     /* 0 auto, 1 up, 2 down */
} judge_rules;

judge_rules judge_rules_from(const options *o);

/* Texels that are judged: neither unused nor padding of another color. */
uint64_t judged_texels(const facts *f);

/* Counts the texels that fail a verdict in the file's own encoding.  Returns false if verdicts mean
 * nothing there. */
bool failing_texels(const facts *f, ntp_verdict verdict, bool keep_negative_z, uint64_t *all,
                    uint64_t *used);

/* The worst level that new findings would have if the file had the name of normals. */
finding_level worst_if_named(const finding_list *list);

void judge(finding_list *list, const facts *f, const judge_rules *rules);
const char *level_name(finding_level level);

#endif
