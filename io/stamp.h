/* SPDX-License-Identifier: MIT */
/*
 * stamp.h - which version of a file was read
 */
#ifndef NTPIO_STAMP_H
#define NTPIO_STAMP_H

#include "ntpio.h"

/* Of an open file; not known if it is not a regular one. */
ntpio_stamp ntpio__stamp_of(int fd);

/* Has the file of this name in a directory that stamp?  False if there is none. */
bool ntpio__has_stamp(int directory, const char *name, const ntpio_stamp *stamp);

#endif
