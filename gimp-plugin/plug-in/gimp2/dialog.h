/* SPDX-License-Identifier: MIT */
/*
 * dialog.h - the dialogs of GIMP 2.10
 */
#ifndef NTP_PLUGIN_DIALOG_H
#define NTP_PLUGIN_DIALOG_H

#include "host.h"

/* Lets the user choose; FALSE: cancelled. */
gboolean dialog_run(const procedure *p, settings *s, gint32 id);

#endif
