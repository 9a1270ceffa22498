/* SPDX-License-Identifier: MIT */
/*
 * verbs.h - the verbs of ntp, one file for each: verb_check.c, verb_clean.c ...
 *
 * A verb reads its options into settings and either runs a batch of its own (check, diff, dump) or
 * fills a maker and lets write/ run it over the inputs: then it says what a pass begins with, what
 * is done with rows, and how it is told.  Where a verb is more than a file, what its files share is
 * in a header: verb_from_height.h (options apart), verb_to_height.h (choices and report apart).
 */
#ifndef NTP_CLI_VERBS_H
#define NTP_CLI_VERBS_H

#include "options/options.h"

/* Each returns the exit code. */
int check_run(const options *o);
int clean_run(const options *o);
int convert_run(const options *o);
int heatmap_run(const options *o);
int dump_run(const options *o);
int diff_run(const options *o);
int from_height_run(const options *o);
int transform_run(const options *o);
int resize_run(const options *o);
int blend_run(const options *o);
int to_height_run(const options *o);

#endif
