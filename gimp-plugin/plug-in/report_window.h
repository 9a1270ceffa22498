/* SPDX-License-Identifier: MIT */
/* report_window.h - the report on a layer, with remedies, in a window of both GIMPs */
#ifndef NTP_PLUGIN_REPORT_WINDOW_H
#define NTP_PLUGIN_REPORT_WINDOW_H

#include "host.h"

/* Shows the report, which the user may repeat with other settings, and carries out the remedies
 * that the user chooses.  FALSE: there is no report; message says why, or is empty if the user
 * stopped it. */
gboolean report_window_run(settings *s, gint32 id, report *r, char message[HOST_TEXT]);

#endif
