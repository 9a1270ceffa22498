/* SPDX-License-Identifier: MIT */
/*
 * hold_image.h - all rows of a file in memory
 */
#ifndef NTP_CLI_HOLD_IMAGE_H
#define NTP_CLI_HOLD_IMAGE_H

#include "examine/read_blocks.h"

/* Is the image, as it is seen, no larger than what is held of one? */
bool hold_is_possible(const source *s);

/* The same; false with an error. */
bool hold_check(const source *s, ntpio_error *error);

/* Copies rows that source_next delivered to their place in an image that is held. */
void hold_rows(unsigned char *held, const source *s, const ntp_rect *area);

/* Reads all rows of a source that nobody has read from yet; *data is to be freed. */
bool hold_all(ntp_image *image, void **data, source *s, ntpio_error *error);

#endif
