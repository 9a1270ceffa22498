/* SPDX-License-Identifier: MIT */
/*
 * library.h - a shared library that is loaded when it is needed
 */
#ifndef NTP_OS_LIBRARY_H
#define NTP_OS_LIBRARY_H

#include <stdbool.h>
#include <stddef.h>

/* Loads a library where the system looks for it, for good, and fills `functions`, pointers to functions,
 * with those of these names.  False: the library or one of its functions is missing. */
bool os_load_library(const char *library, const char *const *names, size_t count, void *functions);

#endif
