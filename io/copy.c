/* SPDX-License-Identifier: MIT */
/*
 * copy.c - a file as an output that is equal to its input, byte for byte
 */
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "output.h"
#include "source.h"

enum { PIECE = 1 << 16 };

static bool copy_all(ntpio__source *source, ntpio__output *output, const char *name,
                     ntpio_error *error)
{
    uint8_t *piece = malloc(PIECE);
    if (piece == NULL)
        return ntpio__fail_memory(error, name);
    bool done = true;
    for (size_t got; done && (got = ntpio__read(source, piece, PIECE)) != 0;)
        done = ntpio__output_write(output, piece, got, error);
    free(piece);
    if (done && source->problem != 0)
        return ntpio__fail(error, NTPIO_ERR_OPEN, name, "cannot be read: %s",
                           strerror(source->problem));
    return done;
}

bool ntpio_copy(const char *path, const void *bytes, size_t size,
                const ntpio_write_options *options, ntpio_error *error)
{
    ntpio__source source;
    if (bytes != NULL)
        ntpio__source_memory(&source, bytes, size);
    else if (!ntpio__source_open(&source, options->read_path, false, error))
        return false;
    ntpio__output *output = ntpio__output_open(path, options, error);
    bool done = output != NULL && copy_all(&source, output, options->read_path, error);
    if (done)
        done = ntpio__output_commit(output, error);
    else if (output != NULL)
        ntpio__output_abort(output);
    ntpio__source_close(&source);
    return done;
}
