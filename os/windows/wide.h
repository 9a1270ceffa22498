/* SPDX-License-Identifier: MIT */
/*
 * wide.h - between UTF-8 with slashes and what Windows takes; its errors as errno
 */
#ifndef NTP_OS_WIDE_H
#define NTP_OS_WIDE_H

#include <stdbool.h>
#include <wchar.h>

/* To be freed; NULL with errno: no memory.  Half a surrogate pair, which names may hold, survives. */
wchar_t *os__wide(const char *utf8);
char *os__narrow(const wchar_t *wide);

/* A path for any call: with backslashes, and in the long form where it is long. */
wchar_t *os__wide_path(const char *path);

/* Sets errno from the last error, or from one that is given; returns false. */
bool os__failed(void);
bool os__failed_with(unsigned long error);

#endif
