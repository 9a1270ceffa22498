/* SPDX-License-Identifier: MIT */
/*
 * state.h - from the state of a file, as POSIX has it
 */
#ifndef NTP_OS_STATE_H
#define NTP_OS_STATE_H

#include <sys/stat.h>

#include "os/files.h"

os_file os__file_of(const struct stat *st);

#endif
