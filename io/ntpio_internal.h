/* SPDX-License-Identifier: MIT */
/*
 * ntpio_internal.h - what the files of io/ share
 *
 * A source hands bytes to a decoder, an encoder hands bytes to an output; open.c and writer.c
 * choose the pair by format.  A decoder delivers rows from the top; where its file cannot, it
 * fills `held`, an image in memory, and open.c deals the rows out.
 */
#ifndef NTPIO_INTERNAL_H
#define NTPIO_INTERNAL_H

#include <stdio.h>

#include "ntpio.h"

#if defined(__GNUC__)
#  define NTPIO_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#  define NTPIO_PRINTF(text, values)
#endif

/* ---- messages (message.c) */

/* Fills *error with "NAME: text", control characters and invalid UTF-8 escaped; returns false. */
bool ntpio__fail(ntpio_error *error, ntpio_status status, const char *name, const char *format, ...)
    NTPIO_PRINTF(4, 5);

bool ntpio__fail_memory(ntpio_error *error, const char *name);

char *ntpio__copy_string(const char *string, size_t size);

/* Appends deep copies of the strings; NULL stays NULL. */
bool ntpio__add_text(ntpio_info *info, const ntpio_text *text);

void ntpio__free_texts(ntpio_info *info);

/* ---- sources (source.c) */

typedef struct ntpio__source {
    const uint8_t *bytes; /* [at, end) are unread */
    size_t at, end;
    FILE *file; /* NULL: the bytes are all there is */
    uint8_t *buffer;
    long start;  /* of the image in a file that can seek, else -1 */
    int problem; /* errno of a failed read */
} ntpio__source;

bool ntpio__source_open(ntpio__source *source, const char *path, ntpio_error *error);
void ntpio__source_memory(ntpio__source *source, const void *bytes, size_t size);
void ntpio__source_close(ntpio__source *source);

/* Makes at least `size` bytes (up to NTPIO__PEEK) unread in the buffer; returns how many are. */
size_t ntpio__peek(ntpio__source *source, size_t size);

/* Reads what there is, up to size. */
size_t ntpio__read(ntpio__source *source, void *dst, size_t size);

/* Whether ntpio__seek works; the size counts from the image's first byte. */
bool ntpio__can_seek(const ntpio__source *source);
bool ntpio__seek(ntpio__source *source, uint64_t offset);
bool ntpio__size(ntpio__source *source, uint64_t *size);

/* Reads all of size, or says that the file is truncated or cannot be read. */
bool ntpio__read_all(ntpio_reader *reader, void *dst, size_t size, ntpio_error *error);
bool ntpio__fail_ended(const ntpio_reader *reader, ntpio_error *error);

enum { NTPIO__PEEK = 4096 };

/* ---- readers (open.c) */

typedef struct ntpio__decoder {
    bool (*open)(ntpio_reader *reader, ntpio_error *error);
    bool (*rows)(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                 ntpio_error *error);
    bool (*end)(ntpio_reader *reader, ntpio_error *error); /* or NULL */
    void (*close)(ntpio_reader *reader);
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

extern const ntpio__decoder ntpio__png_decoder, ntpio__tga_decoder, ntpio__jpeg_decoder,
    ntpio__pfm_decoder;

/* Refuses a size of zero or above the limits; before anything is allocated for it. */
bool ntpio__check_size(const ntpio_reader *reader, uint64_t width, uint64_t height,
                       ntpio_error *error);

/* Allocates held for the image that info describes, or fails by the limits. */
bool ntpio__hold(ntpio_reader *reader, ntpio_error *error);
bool ntpio__check_memory(const ntpio_reader *reader, uint64_t bytes, ntpio_error *error);
size_t ntpio__row_bytes(const ntpio_info *info);

/* Whether bytes without a signature could start a TGA file. */
bool ntpio__tga_plausible(const uint8_t *bytes, size_t size);

/* ---- outputs (output.c): the only file that knows the operating system */

typedef struct ntpio__output ntpio__output;

ntpio__output *ntpio__output_open(const char *path, ntpio_error *error);
bool ntpio__output_write(ntpio__output *output, const void *bytes, size_t size, ntpio_error *error);

/* Whether ntpio__output_write_at works (not for a pipe). */
bool ntpio__output_can_seek(const ntpio__output *output);
bool ntpio__output_write_at(ntpio__output *output, uint64_t offset, const void *bytes, size_t size,
                            ntpio_error *error);
bool ntpio__output_commit(ntpio__output *output, ntpio_error *error);
void ntpio__output_abort(ntpio__output *output);

/* ---- writers (writer.c) */

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

extern const ntpio__encoder ntpio__png_encoder, ntpio__tga_encoder, ntpio__pfm_encoder;

bool ntpio__little_endian(void);

#endif
