/* SPDX-License-Identifier: MIT */
/*
 * verb_to_height.h - what the three files of ntp to-height share
 */
#ifndef NTP_CLI_VERB_TO_HEIGHT_H
#define NTP_CLI_VERB_TO_HEIGHT_H

#include "write/green.h"
#include "write/write_run.h"

enum { AUTO = -1 }; /* the evidence decides */

/* From the options. */
typedef struct to_height_settings {
    ntp_height_options how; /* without kernel, borders and mask */
    int kernel, border_x, border_y;
    int y; /* an ntp_y, or AUTO */
    bool is_float;
    double clip; /* percent of the heights at each end */
    const char *mask_file;
    ntpio_limits limits;
} to_height_settings;

/* How a choice was made. */
typedef enum chosen_by { BY_OPTION, BY_TEXELS, BY_DEFAULT } chosen_by;

typedef struct to_height_state {
    ntp_const_image src; /* the whole texture */
    ntp_height_options how;
    ntp_height_result result;
    green y;
    chosen_by kernel_by, border_by[2];
    double scale, offset; /* of the output */
    bool cut_short;       /* Ctrl-C ended the refinement; the best heights so far are written */
    uint64_t clipped;
    double middle_share; /* of the range: that of the middle 98 % of the heights */
} to_height_state;

enum { READ_PERMILLE = 400, SOLVE_PERMILLE = 600 }; /* the progress after reading, after choosing */

/* Sets the view of the whole texture, which was read. */
void to_height_see(production *p);

/* Decides Y of the whole texture.  Returns false after *why asked. */
bool to_height_knows(production *p, text *why);

/* Decides the kernel and the borders where the options leave them open. */
ntp_status to_height_choose(to_height_state *st, const to_height_settings *set, worker *w);

/* Solves for the heights, in memory of the worker.  Returns false with an error. */
bool to_height_solve(production *p, ntp_image *heights, ntpio_error *error);

/* Adds what was done to the file's line or JSON object. */
void to_height_describe(const production *p, text *line, json_t *object);
void to_height_warn(const production *p, text *line);

#endif
