/* SPDX-License-Identifier: MIT */
/*
 * dialog.h - the dialogs of GIMP 3
 */
#ifndef NTP_PLUGIN_DIALOG_H
#define NTP_PLUGIN_DIALOG_H

#include "host.h"

/* Lets the user choose the values of config; FALSE: cancelled. */
gboolean dialog_run(const procedure *p, GimpProcedure *pdb_procedure, GimpProcedureConfig *config,
                    gint32 id);

/* The settings that a config holds. */
void config_read(const procedure *p, GimpProcedureConfig *config, settings *s);

#endif
