/* SPDX-License-Identifier: MIT */
/*
 * jobs.h - many files at once, with results in the order of the inputs
 *
 * The room of threads.
 *   jobs.c         a batch: workers take inputs, one thread prints
 *   thread_crew.c  threads for the parts of one large piece of work
 */
#ifndef NTP_CLI_JOBS_H
#define NTP_CLI_JOBS_H

#include <stdbool.h>

#include "examine/worker.h"
#include "files/paths.h"
#include "text/text.h"

/* What became of one input. */
typedef struct result {
    text out;     /* for standard output */
    text err;     /* for standard error: whole lines */
    unsigned ran; /* RAN_* */
    void *data;   /* the verb's own, made in work, freed in deliver */
} result;

typedef struct batch {
    const input_list *inputs;
    int jobs;           /* 0: one for each processor */
    bool show_progress; /* where standard error is a terminal */
    bool reads_only;    /* stop when results cannot be printed: nothing else is made */
    void *context;
    /* Runs in a thread of its own, where the context is read only. */
    void (*work)(void *context, worker *w, const input *in, result *r);
    /* Runs in the main thread, in order; then the batch prints out and err. */
    void (*deliver)(void *context, const input *in, result *r);
} batch;

/* Returns the RAN_* of all. */
unsigned batch_run(const batch *b);

/* May a bar be drawn?  Standard error is a terminal, and --no-progress was not given. */
bool progress_wanted(const options *o);

#endif
