/* SPDX-License-Identifier: MIT */
/*
 * hold_image.h - a file held whole in memory
 */
#ifndef NTP_CLI_HOLD_IMAGE_H
#define NTP_CLI_HOLD_IMAGE_H

#include "examine/read_blocks.h"

/* Is the image, as it is seen, small enough? */
bool hold_is_possible(const source *s);

/* The same; false with an error. */
bool hold_check(const source *s, ntpio_error *error);

/* Copies rows that source_next delivered to their place in the held image. */
void hold_rows(unsigned char *held, const source *s, const ntp_rect *area);

/* Reads all rows of a source, of which none was read yet.  The caller frees *data, also on
 * failure. */
bool hold_all(ntp_image *image, void **data, source *s, ntpio_error *error);

#endif
