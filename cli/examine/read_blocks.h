/* SPDX-License-Identifier: MIT */
/*
 * read_blocks.h - a file as blocks of rows in a ring
 */
#ifndef NTP_CLI_READ_BLOCKS_H
#define NTP_CLI_READ_BLOCKS_H

#include <libntp.h>
#include <ntpio.h>
#include <stdbool.h>

#include "examine/worker.h"
#include "files/paths.h"

/* Whether examine() measures which way green points. */
typedef enum orient { ORIENT_NOT, ORIENT_SAMPLED, ORIENT_EVERY_ROW } orient;

/* The greatest |2c - M| of red and of green in used texels, M that of the samples.  Beyond 1 of 8
 * bit and 257 of others they need not be exact. */
typedef struct steepest {
    int32_t x, y;
} steepest;

/* A file being read. */
typedef struct source {
    const input *in;
    const ntpio_limits *limits;
    worker *w;
    unsigned char *bytes; /* the whole file, if it cannot be read twice */
    size_t size;
    ntpio_reader *reader;
    const ntpio_info *info;
    ntp_image view; /* set by source_view */
    bool mapped;
    int8_t map[4];       /* of the view's channels, where mapped */
    int32_t block_rows;  /* rows that source_next delivers at once */
    struct ahead *ahead; /* the thread that reads ahead, or NULL */
    uint32_t next;       /* the next row */
    bool keeps;          /* this pass keeps its rows in w->kept */
    bool kept;           /* w->kept has them all, and no other pass reads the file */
    bool ended;          /* the end of the file was reached and checked */
    bool alone;          /* this pass reads nothing ahead */
    bool packs;          /* the rows of this pass are packed */
    int read_permille;   /* of the work that reading is; 0: all of it */
    orient orient;
    bool find_slopes; /* orient.c also finds `most` */
    steepest most;
    bool keep_middle; /* for middle_and_lines.c */
    /* Where set, with a map: puts right what is wrong with the rows of a block as it is read.  Then
     * the ring is one block, and w->raw has it as it is stored. */
    void (*alter)(void *context, void *rows, size_t texels);
    void *alter_context;
    double max_angle; /* beyond which texels count as visibly wrong, in degrees */
} source;

bool source_open(source *s, worker *w, const input *in, const ntpio_limits *limits,
                 ntpio_error *error);
/* Back to the first row; the view stays.  Fails if the file is not the same version any more. */
bool source_rewind(source *s, ntpio_error *error);
/* Called before the first row: keeps the rows of the next pass in memory, unless they are many, so
 * that those after it need not decode them again. */
void source_keep(source *s);
/* Called before the first row of a pass whose rows are packed: how many threads are left for that,
 * the caller's included. */
int source_leave_threads(source *s);
/* Is the file still the version that is read? */
bool source_is_current(const source *s, ntpio_error *error);
/* Lets go of the file when all is read, so that it can be replaced; what is known of it stays. */
void source_close_file(source *s);
void source_close(source *s);

/* Sets how the rows are seen.  map: NULL, or what each of `channels` is taken from. */
void source_view(source *s, ntp_encoding encoding, ntp_y y, const int8_t *map, int32_t channels);

/* The same of gray files: gray becomes red, green and blue; alpha stays. */
void source_view_as_rgb(source *s, ntp_encoding encoding);

/* Reads the next rows into the ring.  Returns 1 if *area has them, 0 if the end was reached and
 * checked, -1 with *error if reading failed. */
int source_next(source *s, ntp_rect *area, ntpio_error *error);

/* Where the rows of an area are that source_next delivered. */
unsigned char *source_rows(const source *s, const ntp_rect *area);

/* *error becomes "NAME: what".  Returns false. */
bool file_error(ntpio_error *error, ntpio_status status, const char *name, const char *what);

/* A status of libntp as an error about the file.  Correct arguments make none.  Returns false. */
bool library_error(const source *s, ntp_status status, ntpio_error *error);

#endif
