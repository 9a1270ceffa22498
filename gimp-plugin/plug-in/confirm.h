/* SPDX-License-Identifier: MIT */
/*
 * confirm.h - what a user is asked after the dialog, before a procedure runs
 */
#ifndef NTP_PLUGIN_CONFIRM_H
#define NTP_PLUGIN_CONFIRM_H

#include "host.h"

/* Where normals would be made of normals, the user is asked, and the settings insist after a yes.
 * FALSE: the answer is no. */
gboolean confirm(const procedure *p, settings *s, gint32 id);

#endif
