/* SPDX-License-Identifier: MIT */
/*
 * verbs.h - the verbs of ntp
 *
 * The room of verbs: verb_NAME.c has the function NAME_run, which main.c calls.  check, diff and
 * dump run by themselves; the others fill a maker for write/.  Some have more files:
 *   verb_from_height.c  with verb_from_height_options.c
 *   verb_to_height.c    with verb_to_height_choose.c (what the options leave open) and
 *                       verb_to_height_report.c
 *   verb_diff.c         with diff_details.c (mips and blocks of a DDS or KTX2)
 *   verb_curvature.c    and verb_occlusion.c share relief.c
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
int to_depth_run(const options *o);
int curvature_run(const options *o);
int occlusion_run(const options *o);

#endif
