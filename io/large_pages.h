/* SPDX-License-Identifier: MIT */
/*
 * large_pages.h - large buffers with few page faults
 */
#ifndef NTPIO_LARGE_PAGES_H
#define NTPIO_LARGE_PAGES_H

#include "ntpio.h"

/* As malloc, to be freed; a large one is rounded up to large pages. */
void *ntpio__large_alloc(size_t size);

#endif
