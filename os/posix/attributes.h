/* SPDX-License-Identifier: MIT */
/*
 * attributes.h - what a file keeps when another takes its place: owner, permissions, attributes
 */
#ifndef NTP_OS_ATTRIBUTES_H
#define NTP_OS_ATTRIBUTES_H

#include <sys/stat.h>

#include "os/output.h"

/* Gives the new file what the old one at `path` has; *old is its state.  False where an access
 * control list or an attribute cannot be kept. */
bool os__keep_attributes(int fd, const char *path, const struct stat *old, os_problem *problem);

#endif
