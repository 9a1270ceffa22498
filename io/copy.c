/* SPDX-License-Identifier: MIT */
/*
 * copy.c - a file as an output that is equal to its input, byte for byte, or but for chunks of a PNG
 */
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "output.h"
#include "source.h"

enum {
    PIECE = 1 << 16,
    SIGNATURE = 8,
    CHUNK_START = 8, /* length and name */
    CHUNK_END = 4    /* checksum */
};

typedef struct copying {
    ntpio__source *source;
    ntpio__output *output;
    ntpio_error *error;
    uint8_t *piece;
} copying;

/* Takes `size` bytes, or as many as there are; drops them, or writes them. */
static bool pass(const copying *c, uint64_t size, bool drop)
{
    while (size > 0) {
        const size_t want = size < PIECE ? (size_t) size : PIECE;
        const size_t got = ntpio__read(c->source, c->piece, want);
        if (!drop && !ntpio__output_write(c->output, c->piece, got, c->error))
            return false;
        size = got < want ? 0 : size - got;
    }
    return true;
}

static bool is_color(const uint8_t *name)
{
    static const char *const names[] = { "gAMA", "sRGB", "iCCP", "cHRM", "cICP" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (memcmp(name, names[i], 4) == 0)
            return true;
    }
    return false;
}

/* Passes the chunks of a PNG.  It was read before: so IEND ends them, or the file does. */
static bool pass_chunks(const copying *c)
{
    if (!pass(c, SIGNATURE, false))
        return false;
    while (ntpio__peek(c->source, CHUNK_START) >= CHUNK_START) {
        const uint8_t *b = c->source->bytes + c->source->at;
        const uint64_t length =
            (uint64_t) b[0] << 24 | (uint64_t) b[1] << 16 | (uint64_t) b[2] << 8 | b[3];
        const bool last = memcmp(b + 4, "IEND", 4) == 0;
        if (!pass(c, CHUNK_START + length + CHUNK_END, is_color(b + 4)))
            return false;
        if (last)
            break;
    }
    return true;
}

static bool copy_all(ntpio__source *source, ntpio__output *output, bool without_color,
                     const char *name, ntpio_error *error)
{
    const copying c = { source, output, error, malloc(PIECE) };
    if (c.piece == NULL)
        return ntpio__fail_memory(error, name);
    const bool done = (!without_color || pass_chunks(&c)) && pass(&c, UINT64_MAX, false);
    free(c.piece);
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
    bool done = output != NULL &&
                copy_all(&source, output, options->without_color, options->read_path, error);
    if (done)
        done = ntpio__output_commit(output, error);
    else if (output != NULL)
        ntpio__output_abort(output);
    ntpio__source_close(&source);
    return done;
}
