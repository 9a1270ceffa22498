/* SPDX-License-Identifier: MIT */
/*
 * write_run.h - a run of a verb that writes: from inputs to outputs
 *
 * The room that the writing verbs share.  A verb fills a `maker`; the run reads each file, finds
 * out what it is, lets the verb make rows, and writes and reports.
 *   write_run.c    the run over all files, and what is reported about each
 *   make_output.c  the passes over one file
 *   green.c        which way green points, and the question where it is not known
 *   question.c     what the input is, and whether the verb can work on it
 *   undo.c         accidents that are exactly undone (undo_rows.c: levels, which the GIMP plug-in has,
 *                  too; srgb_levels.c: the inverse of sRGB)
 *   refusal.c      which files are refused, and the words for it
 *   whole_image.c  for verbs that need the whole input in memory
 *   side_image.c   a channel of a second image: an alpha, a mask
 *
 * Most files need one pass: a file is first taken for a standard texture (or what --type says), and
 * its output is written while it is measured.  If the measurement says otherwise, the output is
 * dropped and the file is read again.
 */
#ifndef NTP_CLI_WRITE_RUN_H
#define NTP_CLI_WRITE_RUN_H

#include <jansson.h>

#include "examine/examine.h"
#include "options/options.h"
#include "run/jobs.h"
#include "write/undo.h"

typedef struct maker maker;

/* One output in the making. */
typedef struct production {
    const maker *m;
    const input *in;
    const input_list *inputs; /* all of the run */
    worker *w;
    source s;
    facts f;              /* complete when `finish` and `describe` are called */
    int forced;           /* the maker's, or what --force takes a refused file for */
    bool known;           /* the facts are known before the rows come */
    undo undone;          /* the accident that is undone while rows are read */
    uint32_t touch;       /* unused texels to treat like others, for this encoding */
    ntpio_writer *writer; /* NULL: nothing is written in this pass */
    bool probing;         /* this pass only finds out whether anything changes */
    bool changes;         /* set by the verb's rows as soon as a sample changes */
    void *state;          /* the verb's */
} production;

/* When the rows of an output are made, and what is known about the texels then. */
typedef enum maker_plan {
    /* While the file is read for the first time, and taken for a standard texture (or what --type
     * says).  If the facts say otherwise at the end, the output is dropped and made again. */
    PLAN_WHILE_READING,
    /* While the file is read for the second time: the rows need the facts. */
    PLAN_MEASURE_FIRST,
    /* While the file is read: the options say what the texels are.  Named files are never refused.
     * With a forced class the facts may be those of the first row. */
    PLAN_AS_TOLD,
    /* In `finish`, which opens the writer.  Until then the verb keeps the rows. */
    PLAN_AFTER_READING
} maker_plan;

/* What a verb adds. */
struct maker {
    const options *o;
    int forced;         /* class from --type, or -1 */
    bool takes_heights; /* heights are no reason to refuse a file */
    bool of_objects;    /* pictures of objects: without --type only what is sure counts */
    bool any_order;     /* the verb treats x and y alike and need not know which is which */
    maker_plan plan;
    bool finds_green;  /* the facts of a measured file tell which way green points */
    int read_permille; /* how much of the work is reading, for the progress bar; 0: all of it */
    size_t state_size;
    const void *settings; /* the verb's */
    /* Before each pass: sets up the state, which is all zeros, and the shape of the output. */
    bool (*begin)(production *p, ntpio_write_options *shape, ntpio_error *error);
    /* When the facts are known, before rows are made (PLAN_AFTER_READING: before `finish`; PLAN_WHILE_READING: before
     * the output gets its name): is all
     * known that the verb needs?  If not, *why asks, and the file is refused.  May be NULL. */
    bool (*knows)(production *p, text *why);
    /* Rows were read into the view: makes the rows of the output and writes them
     * (production_write). */
    bool (*rows)(production *p, const ntp_rect *area, ntpio_error *error);
    /* After the last row of PLAN_WHILE_READING, when the facts are known: are the rows as they
     * should be, now that the facts are known?  Otherwise they are made again.  May be NULL: yes. */
    bool (*holds)(production *p);
    /* After the last row, when the facts are known: makes what needs all rows.  May be NULL. */
    bool (*finish)(production *p, ntpio_error *error);
    /* Adds what was done to the line or to the JSON object of the file.  Either may be NULL. */
    void (*describe)(const production *p, text *line, json_t *object);
    /* Adds what has to be known even with --quiet.  May be NULL: nothing. */
    void (*warn)(const production *p, text *line);
};

/* *error becomes one of usage: "NAME: what".  Returns false. */
bool wrong_use(const production *p, const char *what, ntpio_error *error);

/* Writes rows to the output, in order. */
bool production_write(production *p, const void *rows, ptrdiff_t stride, const ntp_rect *area,
                      ntpio_error *error);

/* For a further output: is the path neither an input nor the output of one? */
bool production_may_write(const production *p, const char *path, ntpio_error *error);
/* Starts a further output, or that of PLAN_AFTER_READING.  shape has its size, samples and
 * texts; the rest is set here, copy_from only if it is NULL. */
ntpio_writer *production_open(const production *p, const char *path, ntpio_write_options *shape,
                              ntpio_error *error);

/* Runs a writing verb over its inputs; returns the exit code. */
int produce(const maker *m);

#endif
