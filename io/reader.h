/* SPDX-License-Identifier: MIT */
/*
 * reader.h - what a decoder is, and what decoders share
 *
 * A decoder delivers rows from the top.  If its file cannot do that, the decoder fills `held`, an
 * image in memory, and open.c delivers the rows.
 */
#ifndef NTPIO_READER_H
#define NTPIO_READER_H

#include "message.h"
#include "source.h"

typedef struct ntpio__decoder {
    bool (*open)(ntpio_reader *reader, ntpio_error *error);
    bool (*rows)(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                 ntpio_error *error);
    bool (*end)(ntpio_reader *reader, ntpio_error *error); /* or NULL */
    void (*close)(ntpio_reader *reader);
    bool (*rewind)(ntpio_reader *reader); /* as ntpio_rewind, or NULL: false */
    bool (*unpack)(ntpio_reader *reader); /* as ntpio_unpack, or NULL: false */
} ntpio__decoder;

struct ntpio_reader {
    const ntpio__decoder *decoder;
    void *state; /* of the decoder */
    ntpio__source source;
    ntpio_info info;
    ntpio_limits limits; /* without zeros */
    char *name;
    uint32_t row;  /* the next one to deliver */
    uint8_t *held; /* the whole image, when it does not stream */
};

/* Refuses a size of zero or above the limits.  Call it before memory is allocated. */
bool ntpio__check_size(const ntpio_reader *reader, uint64_t width, uint64_t height,
                       ntpio_error *error);

/* Allocates `held` for the image that info describes; refuses what is above the limits. */
bool ntpio__hold(ntpio_reader *reader, ntpio_error *error);

/* Refuses what takes more memory than the limits allow. */
bool ntpio__check_memory(const ntpio_reader *reader, uint64_t bytes, ntpio_error *error);

/* The bytes of a row that is delivered. */
size_t ntpio__row_bytes(const ntpio_info *info);

/* Reads `size` bytes, or reports that the file is truncated or cannot be read. */
bool ntpio__read_all(ntpio_reader *reader, void *dst, size_t size, ntpio_error *error);

/* Reads the rest of the source into memory, where it can seek; refuses what is above the limits. */
bool ntpio__hold_source(ntpio_reader *reader, ntpio_error *error);

/* Reports why the source gave less than was asked for.  Returns false. */
bool ntpio__fail_ended(const ntpio_reader *reader, ntpio_error *error);

#endif
