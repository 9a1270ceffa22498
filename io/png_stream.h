/* SPDX-License-Identifier: MIT */
/*
 * png_stream.h - the rows of a PNG, unpacked while they are read
 *
 * For the files of png_plain.h.  Chunks are read and unpacked part by part, and rows are taken from
 * the caches.  Who reads rows once needs little memory; for who reads them again, the stream keeps
 * the picture, if the limits allow it.  A fault shows only when rows before it have been delivered;
 * then the caller reads anew in another way, and leaves these out.
 */
#ifndef NTPIO_PNG_STREAM_H
#define NTPIO_PNG_STREAM_H

#include "reader.h"

typedef struct ntpio__png_stream ntpio__png_stream;

/* The stream of a file, or NULL, with the source at its start: none of those, or a fault. */
ntpio__png_stream *ntpio__png_stream_open(ntpio_reader *reader);

/* What libpng reads instead of the file: the same with an empty picture.  Until all rows were
 * delivered, it ends after that picture. */
const uint8_t *ntpio__png_stream_shell(const ntpio__png_stream *stream, size_t *size);

/* Did its maker try hardest? */
bool ntpio__png_stream_packed_hard(const ntpio__png_stream *stream);

/* The next rows; returns how many there are before the end or a fault.  swap: the two bytes of
 * samples. */
uint32_t ntpio__png_stream_rows(ntpio__png_stream *stream, uint8_t *dst, ptrdiff_t stride,
                                uint32_t count, bool swap);

/* As ntpio_unpack, of a picture that is kept. */
bool ntpio__png_stream_unpack(ntpio__png_stream *stream);

/* Back to the first row.  False: the picture is not kept. */
bool ntpio__png_stream_rewind(ntpio__png_stream *stream);

void ntpio__png_stream_close(ntpio__png_stream *stream);

#endif
