/* SPDX-License-Identifier: MIT */
/*
 * stamp.h - which version of a file was read
 */
#ifndef NTPIO_STAMP_H
#define NTPIO_STAMP_H

#include "ntpio.h"

/* Of an open file; not known if it is not a regular one. */
ntpio_stamp ntpio__stamp_of(int fd);

#endif
