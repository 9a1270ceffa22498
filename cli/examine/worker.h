/* SPDX-License-Identifier: MIT */
/*
 * worker.h - the memory of a thread, used again from file to file
 */
#ifndef NTP_CLI_WORKER_H
#define NTP_CLI_WORKER_H

#include <libntp.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Memory that grows.  What it held is lost when it does. */
typedef struct buffer {
    unsigned char *data;
    size_t size;
} buffer;

unsigned char *buffer_reserve(buffer *b, size_t size);

enum {
    ASIDE_ROWS = 64,
    HISTOGRAM_SIZE = 65536 * sizeof(uint64_t) /* bytes; of 8 bit, a page of them is used */
};

typedef struct worker {
    ntp_tally *tally;
    buffer rows;  /* the ring of rows that a view looks at */
    buffer raw;   /* rows as the file has them, where their channels are rearranged */
    buffer kept;  /* all rows as the file has them, where they are read again */
    buffer extra; /* the verb's own */
    buffer extra2, extra3;
    ntp_diff *diff;      /* NULL: none was needed */
    uint64_t *histogram; /* NTP levels 0..65535 */
    ntp_orientation *orientation;
    buffer band;  /* rows around the one whose orientation is measured */
    buffer aside; /* such rows that may not be needed */
    size_t aside_rows;
    int32_t aside_row[ASIDE_ROWS]; /* which ones are measured of these */
    uint32_t aside_touch;          /* the unused texels that count */
    buffer middle;                 /* what middle_and_lines.c keeps: the middle, rows, columns */
    buffer across;
    buffer down;
    int threads;           /* that this worker may keep busy, itself included */
    _Atomic int permille;  /* of the file at work, for the progress bar */
    _Atomic uint64_t left; /* texels that --refine has not brought back yet; 0: it does not run */
} worker;

worker *worker_new(void);

/* An empty ntp_diff in the worker's memory. */
ntp_diff *worker_diff(worker *w);

void worker_free(worker *w);

#endif
