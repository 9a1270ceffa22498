/* SPDX-License-Identifier: MIT */
/* report_window.h - the report on a layer in a window of both GIMPs */
#ifndef NTP_PLUGIN_REPORT_WINDOW_H
#define NTP_PLUGIN_REPORT_WINDOW_H

#include "host.h"

/* Shows the report, which the user may repeat with other settings; TRUE: clean the layer.  message:
 * why there is no report. */
gboolean report_window_run(settings *s, gint32 id, report *r, char message[HOST_TEXT]);

/* The settings of PROCEDURE_CLEAN that correspond to those of a report. */
settings report_window_clean(const settings *s);

#endif
