/* SPDX-License-Identifier: MIT */
/*
 * texture_output.h - an output that is a DDS or KTX2: its mips and its blocks
 */
#ifndef NTP_CLI_TEXTURE_OUTPUT_H
#define NTP_CLI_TEXTURE_OUTPUT_H

#include "write/write_run.h"

typedef struct texture_output {
    bool used; /* the output has such a name */
    ntpio_texture how;
    ntp_image whole; /* the shape of the picture; its data are those that come */
    ntp_block_options quality;
    uint32_t touch_unused;
    int threads;
} texture_output;

/* Is the output a DDS or KTX2? */
bool texture_is_output(const production *p);

/*
 * Prepares for rows of this shape, of channels x, y, or of heights, by --compression, --quality and
 * --mips.  Sets the field of `shape` to it; `t` lives until the commit.  Does nothing for an output
 * of another format.
 */
bool texture_begin(texture_output *t, const production *p, const ntp_image *rows,
                   ntpio_write_options *shape, ntpio_error *error);

/* "BC5 (red and green), 11 mips". */
void texture_describe(const texture_output *t, text *line);

/* "bc5", "bc4" or "none". */
const char *texture_compression(const texture_output *t);
uint32_t texture_mips(const texture_output *t);

#endif
