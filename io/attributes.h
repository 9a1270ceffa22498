/* SPDX-License-Identifier: MIT */
/*
 * attributes.h - what a file keeps when another takes its place: owner, permissions, attributes
 */
#ifndef NTPIO_ATTRIBUTES_H
#define NTPIO_ATTRIBUTES_H

#include <sys/stat.h>

#include "ntpio.h"

/* Gives the new file what the old one at `path` has; *old is its state.  Where an access control
 * list or an attribute cannot be kept, it fails with a message about `name`. */
bool ntpio__keep_attributes(int fd, const char *path, const struct stat *old, const char *name,
                            ntpio_error *error);

#endif
