/* SPDX-License-Identifier: MIT */
/*
 * stamp.h - which version of a file was read
 */
#ifndef NTPIO_STAMP_H
#define NTPIO_STAMP_H

#include "ntpio.h"
#include "os/files.h"

/* Not known if it is not a regular file. */
ntpio_stamp ntpio__stamp_of(const os_file *file);

/* Of a stamp that is known. */
os_file ntpio__version_of(const ntpio_stamp *stamp);

#endif
