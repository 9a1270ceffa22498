/* SPDX-License-Identifier: MIT */
/*
 * baseline.h - findings of an earlier check, which are known and do not count again
 */
#ifndef NTP_CLI_BASELINE_H
#define NTP_CLI_BASELINE_H

#include <jansson.h>

#include "findings/findings.h"
#include "text/text.h"

typedef struct baseline {
    json_t *keys; /* object of "path\nid": true; NULL: nothing is known */
    text here;    /* the working directory with a slash at its end; empty: unknown */
} baseline;

/* Reads a JSON report of ntp check.  NULL is no file.  Returns false after a message. */
bool baseline_read(baseline *b, const char *name);
void baseline_free(baseline *b);

/* Sets `known` of the findings that the baseline has. */
void baseline_mark(const baseline *b, const input *in, finding_list *list);

#endif
