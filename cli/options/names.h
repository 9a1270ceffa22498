/* SPDX-License-Identifier: MIT */
/*
 * names.h - names of values that libntp does not name; they are the words of the options
 */
#ifndef NTP_CLI_NAMES_H
#define NTP_CLI_NAMES_H

#include <libntp.h>

const char *encoding_name(ntp_encoding encoding);
const char *y_name(ntp_y y);
const char *y_title(ntp_y y); /* for people: OpenGL (Y up) */
const char *verdict_name(ntp_verdict verdict);
const char *clean_method_name(ntp_clean_method method);
const char *source_name(ntp_height_source source);
const char *decode_name(ntp_decode decode);
const char *z_name(ntp_z z);

#endif
