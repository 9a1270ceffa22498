/* SPDX-License-Identifier: MIT */
/* help.h - the help pages, which are installed beside the program */
#ifndef NTP_PLUGIN_HELP_H
#define NTP_PLUGIN_HELP_H

/* Opens the help page in the web browser; the arguments are those of GimpHelpFunc. */
void show_help(const char *id, void *data);

#endif
