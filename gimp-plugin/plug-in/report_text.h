/* SPDX-License-Identifier: MIT */
/* report_text.h - the words of a report */
#ifndef NTP_PLUGIN_REPORT_TEXT_H
#define NTP_PLUGIN_REPORT_TEXT_H

#include "report.h"

/* Fills r->text, a sentence for each line.  translate: NULL for English. */
void report_write(report *r, const char *(*translate)(const char *text));

#endif
