/* SPDX-License-Identifier: MIT */
/*
 * writer.h - what an encoder is
 */
#ifndef NTPIO_WRITER_H
#define NTPIO_WRITER_H

#include "message.h"
#include "output.h"

typedef struct ntpio__encoder {
    bool (*open)(ntpio_writer *writer, ntpio_error *error);
    bool (*rows)(ntpio_writer *writer, const uint8_t *src, ptrdiff_t stride, uint32_t count,
                 ntpio_error *error);
    bool (*end)(ntpio_writer *writer, ntpio_error *error);
    void (*close)(ntpio_writer *writer);
} ntpio__encoder;

struct ntpio_writer {
    const ntpio__encoder *encoder;
    void *state; /* of the encoder */
    ntpio__output *output;
    ntpio_write_options options;
    char *name;
    uint32_t row; /* the next one expected */
    bool failed;
};

#endif
