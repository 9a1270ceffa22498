/* SPDX-License-Identifier: MIT */
/*
 * png_plain.h - PNG files whose pixels are read without libpng
 *
 * Plain files without any fault: 8 or 16 bit, gray to RGBA, not interlaced, no tRNS.  What is not
 * plain, and whatever is wrong, is left to libpng, which has a message for it.
 */
#ifndef NTPIO_PNG_PLAIN_H
#define NTPIO_PNG_PLAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct ntpio__png_shape {
    uint32_t width, height;
    size_t row_size, texel; /* bytes */
} ntpio__png_shape;

/* A complete IDAT chunk: a zlib stream of no bytes. */
enum { NTPIO__NO_PIXELS_SIZE = 20 };
extern const uint8_t ntpio__no_pixels[NTPIO__NO_PIXELS_SIZE];

/* The number that four bytes of a PNG are. */
static inline uint32_t ntpio__png_number(const uint8_t *b)
{
    return (uint32_t) b[0] << 24 | (uint32_t) b[1] << 16 | (uint32_t) b[2] << 8 | b[3];
}

/* The second byte of a zlib stream: its two top bits say how hard its maker tried, and 3 is
 * hardest. */
static inline bool ntpio__png_packed_hard(uint8_t second)
{
    return second >> 6 == 3;
}

/* Is a chunk of type `name` at `chunk`? */
static inline bool ntpio__png_is(const uint8_t *chunk, const char *name)
{
    return memcmp(chunk + 4, name, 4) == 0;
}

/* Looks at the first `size` bytes of a file.  False: no such picture, or a header with a fault. */
bool ntpio__png_shape_of(ntpio__png_shape *shape, const uint8_t *file, size_t size);

/* Do chunks hold pixels, whole or not?  After those that were read, libpng counts what is in them,
 * and stops at too much. */
bool ntpio__png_has_pixels(const uint8_t *chunks, size_t size);

/* Is it the header of a zlib stream that zlib takes?  `size`: of what is unpacked; zlib minds the
 * window that the header names. */
bool ntpio__png_zlib_header(const uint8_t *packed, uint64_t size);

#endif
