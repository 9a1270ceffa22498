/* SPDX-License-Identifier: MIT */
/*
 * write_run.h - reading a texture and writing another: the part that the writing verbs share
 *
 * A file is taken for a standard texture (or what --type says), and its output is written
 * while it is measured.  Only when the measurement says otherwise, the output is dropped and
 * the file is read again with the right encoding; so one pass suffices for most.
 */
#ifndef NTP_CLI_WRITE_RUN_H
#define NTP_CLI_WRITE_RUN_H

#include <jansson.h>

#include "examine/examine.h"
#include "options/options.h"
#include "run/jobs.h"

typedef struct maker maker;

/* One output in the making. */
typedef struct production {
    const maker *m;
    const input *in;
    const input_list *inputs; /* all of the run */
    worker *w;
    source s;
    facts f;              /* complete when `finish` and `describe` are called */
    bool known;           /* the facts are known before the rows come */
    uint32_t touch;       /* unused texels to treat like others, for this encoding */
    ntpio_writer *writer; /* NULL: nothing is written in this pass */
    bool probing;         /* only to find out whether anything changes */
    bool changes;         /* set by the verb's rows as soon as a sample changes */
    void *state;          /* the verb's */
} production;

/* When the rows of an output are made, and what is known of the texels by then. */
typedef enum maker_plan {
    /* While the file is read, as of a standard texture (or what --type says).  Where the facts say
     * otherwise in the end, the output is dropped and made again. */
    PLAN_WHILE_READING,
    /* While the file is read once more: the rows need the facts. */
    PLAN_MEASURE_FIRST,
    /* While the file is read: the options say what the texels are, and named files are never refused.
     * With a forced class the facts may be those of the first row. */
    PLAN_AS_TOLD,
    /* In `finish`, which opens the writer: the verb keeps the rows until the last one was read. */
    PLAN_AFTER_READING
} maker_plan;

/* What a verb adds. */
struct maker {
    const options *o;
    int forced;     /* class from --type, or -1 */
    bool any_order; /* the verb does the same to x and y: it need not know which is which */
    maker_plan plan;
    int read_permille; /* share of the work that reading is, for the progress bar; 0: all of it */
    size_t state_size;
    const void *settings; /* the verb's */
    /* Before each pass: starts the state afresh; says what is written. */
    bool (*begin)(production *p, ntpio_write_options *shape, ntpio_error *error);
    /* Rows were read into the view: makes and writes (production_write) the output's rows. */
    bool (*rows)(production *p, const ntp_rect *area, ntpio_error *error);
    /* After the last row, with the facts known: makes what needs all rows; may be NULL. */
    bool (*finish)(production *p, ntpio_error *error);
    /* Adds what was done to the file's line or JSON object; either may be NULL. */
    void (*describe)(const production *p, text *line, json_t *object);
};

/* *error becomes one of usage: "NAME: what".  Returns false. */
bool wrong_use(const production *p, const char *what, ntpio_error *error);

/* Writes rows to the output, in order. */
bool production_write(production *p, const void *rows, ptrdiff_t stride, const ntp_rect *area,
                      ntpio_error *error);

/* For further outputs: is the path neither an input nor the output of one? */
bool production_may_write(const production *p, const char *path, ntpio_error *error);
/* Starts a further output, or the one of PLAN_AFTER_READING; shape says its size, its samples and its
 * texts, and the rest is set as for the first (copy_from only where it is NULL). */
ntpio_writer *production_open(const production *p, const char *path, ntpio_write_options *shape,
                              ntpio_error *error);

/* Runs a writing verb over its inputs; returns the exit code. */
int produce(const maker *m);

#endif
