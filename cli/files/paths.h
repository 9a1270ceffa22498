/* SPDX-License-Identifier: MIT */
/*
 * paths.h - which files a run reads, and where each output goes
 *
 * The room of file names; nothing here reads an image.
 *   paths.c         from the command line to a list of inputs: directories, globs, lists
 *   plan_outputs.c  the output of each input; refuses what would destroy a file
 *   name_hints.c    what a name says: a normals texture? green up or down?
 */
#ifndef NTP_CLI_PATHS_H
#define NTP_CLI_PATHS_H

#include <stdbool.h>
#include <ntpio.h>
#include <stddef.h>

#include "options/options.h"

typedef enum name_y { NAME_Y_NONE, NAME_Y_UP, NAME_Y_DOWN } name_y;

typedef struct input {
    char *path;     /* as it is opened and shown; "-" is standard input */
    char *relative; /* its place below -o DIR, still with its own ending */
    char *output;   /* where the output goes; NULL: not decided */
    char *outside;  /* --in-place: the file that would be replaced, if links lead to it from a
                     * directory that was named, and out of all that was; else NULL */
    char *problem;  /* why a directory could not be read; NULL for files */
    bool named;     /* given by name: always judged */
    bool hinted;    /* it has the name of a normals texture */
    bool foreign;   /* found in a directory, by the name of a format that is not read */
    name_y y;       /* what the name says about green */
} input;

typedef struct input_list {
    input *at;
    size_t count;
    bool from_directory; /* a directory was among the paths */
    char **roots;        /* the directories that were named, without links */
    size_t root_count;
} input_list;

/*
 * Collects the inputs of a run, each file once: named files in the order given, the files of a
 * directory sorted by name: images, and files of other formats that have the name of a normals
 * texture, so that no texture is passed over in silence.  Returns false after a message about wrong
 * usage.
 */
bool inputs_collect(input_list *list, const options *o);
void inputs_free(input_list *list);

/*
 * Gives each input its output from -o, or from --in-place.  Returns false after a message about
 * wrong usage: several inputs for one file, two inputs with one output, an output that is an input
 * (unless --force is given and it is its own), a format that is not written.
 */
bool outputs_plan(input_list *list, const options *o);

/* For verbs of two files: are there two, and at most one is standard input?  Returns false after a
 * message; `called` ends "ntp VERB takes two files". */
bool inputs_are_two(const options *o, const char *called);

/* For an output of another kind than the inputs.  Returns false after a message, if it is an
 * input or has the name of a format that is not written. */
bool output_is_allowed(const char *output, const options *o);

/* Do both names lead to the same file? */
bool is_same_file(const char *a, const char *b);

/* "JPEG", of a format that is read and not written; NULL of others. */
const char *unwritten_name(const ntpio_info *info);

/* For an additional output: is the path neither an input nor the output of one? */
bool output_is_free(const input_list *list, const char *path);

/* Makes the directories that lead to a file. */
bool make_parents(const char *path, text *why);

/* name_hints.c */
bool name_is_normals(const char *path);
name_y name_orientation(const char *path);
/* Does the name say that blue is no z (xy, rg, bc5, ati2, dxn), or that it is 0..1 (zzero)? */
bool name_promises(const char *path, bool zzero);
bool name_is_image(const char *path);
/* The ending is that of a format that is neither read nor written. */
bool name_is_foreign(const char *path);
/* The ending of the last component with its dot, or "" */
const char *name_ending(const char *path);

#endif
