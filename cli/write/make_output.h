/* SPDX-License-Identifier: MIT */
/*
 * make_output.h - the passes over one file, from its first row to the output in its place
 */
#ifndef NTP_CLI_MAKE_OUTPUT_H
#define NTP_CLI_MAKE_OUTPUT_H

#include "write/write_run.h"

typedef enum outcome {
    MADE,      /* written, or would be */
    UNCHANGED, /* nothing to write */
    SKIPPED,   /* in a directory, and not a normals texture */
    REFUSED,   /* named, but of a kind that this verb does not work on */
    UNREADABLE,
    FAILED /* not written */
} outcome;

/* Reads the source of a production, makes the output and puts it in place. */
outcome make_output(production *p, ntpio_error *error);

bool is_dry_run(const maker *m);
bool is_in_place(const maker *m);

#endif
