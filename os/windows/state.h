/* SPDX-License-Identifier: MIT */
/*
 * state.h - the state of an open file
 */
#ifndef NTP_OS_STATE_H
#define NTP_OS_STATE_H

#include "os/files.h"

bool os__look_at_handle(void *handle, os_file *file);

#endif
