/* SPDX-License-Identifier: MIT */
/*
 * relief.h - what ntp curvature and ntp occlusion share: heights or normals in, a gray map out
 */
#ifndef NTP_CLI_RELIEF_H
#define NTP_CLI_RELIEF_H

#include "verbs/verb_to_height.h"

typedef struct relief_settings {
    to_height_settings solve; /* first: the functions of ntp to-height read it */
    double scale, blur;
    bool scale_given;
    bool measures;          /* --scale auto */
    int border_x, border_y; /* or AUTO */
    ntp_height_source source;
    int depth; /* 1: 8 bit, 2: 16, 3: float; 0: as the input */
} relief_settings;

typedef struct relief_state {
    to_height_state solve; /* first, as above */
    double scale;          /* of heights; 0: the input is normals */
    ntp_type type;         /* of the output */
    ntp_border border_x, border_y;
} relief_state;

/* Reads the options that both have.  Returns false after a message. */
bool relief_read_settings(relief_settings *set, const options *o);

/* For the maker: the whole input is held; what is not known is asked for. */
bool relief_begin(production *p, ntpio_write_options *shape, ntpio_error *error);
bool relief_rows(production *p, const ntp_rect *area, ntpio_error *error);
bool relief_knows(production *p, text *why);

/* The input is heights, and no normals. */
bool relief_is_height(const production *p);

/* Before all that follows: the borders that were asked for, or those that the edges show. */
bool relief_choose_borders(production *p, ntpio_error *error);

/* The heights of the file, or those of its normals; as floats, but where the file has them as they
 * are needed.  They lie in memory of the worker. */
bool relief_heights(production *p, ntp_const_image *heights, ntpio_error *error);

/* Blurs one channel of src. */
ntp_status relief_blur(const ntp_image *dst, const ntp_const_image *src, const production *p,
                       ntp_height_source channel, double sigma);

/* Starts the output.  key: NULL, or that of a text with a number, which is stored in a PNG. */
bool relief_start(production *p, const char *key, double number, ntpio_error *error);

/* Adds what both report. */
void relief_describe(const production *p, text *line, json_t *object);

#endif
