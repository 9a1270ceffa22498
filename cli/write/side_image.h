/* SPDX-License-Identifier: MIT */
/*
 * side_image.h - a channel of a second image: an alpha, a mask
 */
#ifndef NTP_CLI_SIDE_IMAGE_H
#define NTP_CLI_SIDE_IMAGE_H

#include <libntp.h>
#include <ntpio.h>
#include <stdbool.h>

/*
 * Reads the first channel of the image at `path` into a packed plane of this type.  Returns false
 * with an error if it cannot be read, or if its size is not that of `like`, which messages call
 * `what`.
 */
bool side_image_read(unsigned char *plane, ntp_type type, const char *path,
                     const ntpio_limits *limits, const ntpio_info *like, const char *what,
                     ntpio_error *error);

#endif
