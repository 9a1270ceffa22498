/* SPDX-License-Identifier: MIT */
/*
 * whole_image.h - for verbs whose rows depend on rows far away: the whole input in memory
 *
 * Rows of the input are kept as they come.  Then the output is made and written a few rows at a
 * time.  So a file takes the memory of its samples.
 */
#ifndef NTP_CLI_WHOLE_IMAGE_H
#define NTP_CLI_WHOLE_IMAGE_H

#include "write/write_run.h"

/* For `begin`: reserves memory; returns false with an error if the image is too large. */
bool whole_begin(production *p, ntpio_error *error);

/* For `rows`: keeps the rows; returns true if they were the last. */
bool whole_add(production *p, const ntp_rect *area);

/* Makes the area of dst, which has the samples of src. */
typedef ntp_status make_rows(void *context, const ntp_image *dst, const ntp_const_image *src,
                             const ntp_rect *area);

/* After the last row: makes an image of this size and writes it. */
bool whole_write(production *p, ntpio_writer *writer, int32_t width, int32_t height,
                 make_rows *make, void *context, ntpio_error *error);

#endif
