/* SPDX-License-Identifier: MIT */
/*
 * paths.h - which files a run is about, and where each one's output goes
 */
#ifndef NTP_CLI_PATHS_H
#define NTP_CLI_PATHS_H

#include <stdbool.h>
#include <stddef.h>

#include "options/options.h"

typedef enum name_y { NAME_Y_NONE, NAME_Y_UP, NAME_Y_DOWN } name_y;

typedef struct input {
    char *path;     /* as it is opened and shown; "-" is standard input */
    char *relative; /* where it goes below -o DIR, with the input's own ending */
    char *output;   /* where the output goes; NULL: nowhere yet */
    char *problem;  /* a directory that could not be read: why; NULL for files */
    bool named;     /* given by name: always judged */
    bool hinted;    /* its name is that of a normals texture */
    name_y y;       /* what the name says about green */
} input;

typedef struct input_list {
    input *at;
    size_t count;
    bool from_directory; /* a directory was among the paths */
} input_list;

/*
 * Collects the inputs of a run: named files in the order given, the files of a directory sorted by
 * name; each file once.  Returns false after telling of wrong usage.
 */
bool inputs_collect(input_list *list, const options *o);
void inputs_free(input_list *list);

/*
 * Gives each input its output from -o, or from --in-place.  Returns false after telling of wrong
 * usage: several inputs for one file, two inputs with one output, an output below -o DIR that is an
 * input, a format that is not written.
 */
bool outputs_plan(input_list *list, const options *o);

/* For verbs of two files: are there two, of which standard input is one at most?  False, after telling:
 * "ntp VERB takes two files", and what they are called. */
bool inputs_are_two(const options *o, const char *called);

/* For an output that is of another kind than the inputs: false, after telling, when it is one, or has
 * the name of a format that is not written. */
bool output_is_allowed(const char *output, const options *o);

/* Are both there, and one file, by whatever names? */
bool is_same_file(const char *a, const char *b);

/* For an output that no input asked for: is the path neither an input nor the output of one? */
bool output_is_free(const input_list *list, const char *path);

/* Makes the directories that lead to a file. */
bool make_parents(const char *path, text *why);

/* name_hints.c */
bool name_is_normals(const char *path);
name_y name_orientation(const char *path);
bool name_is_image(const char *path);
/* The ending of the last component with its dot, or "" */
const char *name_ending(const char *path);

#endif
