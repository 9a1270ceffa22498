/* SPDX-License-Identifier: MIT */
/* verb_from_height.h - what the options of ntp from-height ask for */
#ifndef NTP_CLI_VERB_FROM_HEIGHT_H
#define NTP_CLI_VERB_FROM_HEIGHT_H

#include "options/options.h"
#include "write/write_run.h"

enum {
    MAX_OCTAVES = 8, /* the last is blurred by NTP_MAX_SIGMA */
    FULL = 4,        /* channels of the rows made: x, y, z, alpha or height; plain RGB: 3 */
    ALPHA = 3,
};

typedef struct from_height_settings {
    ntp_normals_options how;
    bool measures; /* the heights say what is still to be multiplied with the scale */
    ntp_encoding to;
    ntp_y to_y;
    int depth;         /* bytes of a sample; 0: as the input */
    int8_t out[FULL];  /* for each channel of the file: 0..3 of the rows made, or FROM_* */
    int32_t out_count; /* 0: by the encoding and the alpha */
    double blur;
    double octave[MAX_OCTAVES]; /* weights */
    int octaves;                /* 0: no sum of octaves */
    bool dither;
    bool alpha_given;
    const char *alpha_file, *ao_file;
    const char *alpha_name;
    ntpio_limits limits;
} from_height_settings;

/* Returns false after a message about what is wrong. */
bool from_height_read_settings(from_height_settings *set, const options *o);

#endif
