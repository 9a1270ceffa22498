/* SPDX-License-Identifier: MIT */
/*
 * source.h - where the bytes of an image come from: a file, standard input, memory
 */
#ifndef NTPIO_SOURCE_H
#define NTPIO_SOURCE_H

#include <stdio.h>

#include "ntpio.h"

enum { NTPIO__PEEK = 4096 }; /* bytes that can be looked at before they are read */

typedef struct ntpio__source {
    const uint8_t *bytes; /* [at, end) are unread */
    size_t at, end;
    FILE *file; /* NULL: the bytes are all there is */
    uint8_t *buffer;
    int64_t start; /* of the image in a file that can seek, else -1 */
    int problem;   /* errno of a failed read */
    ntpio_stamp stamp;
} ntpio__source;

bool ntpio__source_open(ntpio__source *source, const char *path, bool regular_only,
                        ntpio_error *error);
void ntpio__source_memory(ntpio__source *source, const void *bytes, size_t size);
void ntpio__source_close(ntpio__source *source);

/* Fills the buffer up to at least `size` unread bytes, at most NTPIO__PEEK.  Returns how many there
 * are. */
size_t ntpio__peek(ntpio__source *source, size_t size);

/* Reads all that is left, at most `most` bytes, into memory: then the source can seek.  False if there
 * is more, or no memory: `*too_long` says which. */
bool ntpio__source_hold(ntpio__source *source, uint64_t most, bool *too_long);

/* Reads up to `size` bytes; returns how many there were. */
size_t ntpio__read(ntpio__source *source, void *dst, size_t size);

/* Can the source seek?  Offsets count from the first byte of the image. */
bool ntpio__can_seek(const ntpio__source *source);
bool ntpio__seek(ntpio__source *source, uint64_t offset);
bool ntpio__size(ntpio__source *source, uint64_t *size);

#endif
