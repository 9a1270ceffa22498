/* SPDX-License-Identifier: MIT */
/*
 * side_image.h - a channel of another image, beside the one at work: an alpha, a mask
 */
#ifndef NTP_CLI_SIDE_IMAGE_H
#define NTP_CLI_SIDE_IMAGE_H

#include <libntp.h>
#include <ntpio.h>
#include <stdbool.h>

/*
 * Reads the first channel of the image at `path` into a packed plane of that type and size.  False
 * with an error where it cannot be read or has another size than `like`, which is called `what`.
 */
bool plane_read(unsigned char *plane, ntp_type type, const char *path, const ntpio_limits *limits,
                const ntpio_info *like, const char *what, ntpio_error *error);

#endif
