/* SPDX-License-Identifier: MIT */
/* about.h - what the plug-in says about itself */
#ifndef NTP_PLUGIN_ABOUT_H
#define NTP_PLUGIN_ABOUT_H

#define PLUGIN_NAME      "ntp-normals"
#define PLUGIN_MENU_IN   "<Image>/Filters"
#define PLUGIN_MENU      PLUGIN_MENU_IN "/Normal Map"
#define PLUGIN_AUTHORS   "The libntp authors"
#define PLUGIN_COPYRIGHT "MIT license"
#define PLUGIN_DATE      "2026"

#endif
