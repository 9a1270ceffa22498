/* SPDX-License-Identifier: MIT */
/*
 * side_image.c - a channel of a second image: an alpha, a mask
 *
 * Rows are read one by one and converted by value to the depth of the first image.
 */
#include "write/side_image.h"

#include <stdio.h>
#include <stdlib.h>

#include "examine/read_blocks.h"
#include "examine/samples.h"
#include "text/text.h"

static bool read_rows(unsigned char *plane, ntp_type type, ntpio_reader *reader, ntpio_error *error)
{
    const ntpio_info *info = ntpio_reader_info(reader);
    const size_t row = (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
    const size_t plane_row = (size_t) info->width * sample_size(type);
    unsigned char *line = need(malloc(row));
    ntp_image in = ntp_image_packed(line, (int32_t) info->width, 1, info->channels,
                                    sample_type(info->sample_bytes));
    in.channels = 1;
    in.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image seen = ntp_image_as_const(&in);
    bool ok = true;
    for (uint32_t y = 0; ok && y < info->height; y++) {
        ok = ntpio_read_rows(reader, line, (ptrdiff_t) row, 1, error);
        const ntp_image out =
            ntp_image_packed(plane + y * plane_row, (int32_t) info->width, 1, 1, type);
        if (ok)
            ntp_convert(&out, &seen, NULL, NULL, NULL);
    }
    free(line);
    return ok && ntpio_read_end(reader, error);
}

bool side_image_read(unsigned char *plane, ntp_type type, const char *path,
                     const ntpio_limits *limits, const ntpio_info *like, const char *what,
                     ntpio_error *error)
{
    ntpio_reader *reader = ntpio_open(path, limits, error);
    if (reader == NULL)
        return false;
    const ntpio_info *info = ntpio_reader_info(reader);
    const bool fits = info->width == like->width && info->height == like->height;
    char problem[80];
    snprintf(problem, sizeof problem, "not of the size of the %s", what);
    const bool ok = fits ? read_rows(plane, type, reader, error)
                         : file_error(error, NTPIO_ERR_USAGE, path, problem);
    ntpio_close(reader);
    return ok;
}
