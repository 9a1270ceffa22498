/* SPDX-License-Identifier: MIT */
/*
 * png_plain.c - PNG files whose pixels are read without libpng
 */
#include "png_plain.h"

#include "png_sums.h"

const uint8_t ntpio__no_pixels[NTPIO__NO_PIXELS_SIZE] = { 0,   0,    0,    8,    'I',  'D', 'A',
                                                          'T', 0x78, 0x9c, 0x03, 0x00, 0,   0,
                                                          0,   1,    0x48, 0x06, 0x89, 0xd2 };

enum {
    SIGNATURE = 8,
    CHUNK_HEAD = 8,
    CHUNK = 12, /* length, name, checksum */
    HEADER = 13
};

static bool checksum_is_right(const uint8_t *chunk, size_t size)
{
    return ntpio__crc32(0, chunk + 4, size - 8) == ntpio__png_number(chunk + size - 4);
}

bool ntpio__png_shape_of(ntpio__png_shape *shape, const uint8_t *file, size_t size)
{
    static const size_t channels[] = { 1, 0, 3, 0, 2, 0, 4 };
    const uint8_t *chunk = file + SIGNATURE, *b = chunk + 8;
    if (size < SIGNATURE + CHUNK + HEADER || ntpio__png_number(chunk) != HEADER ||
        !ntpio__png_is(chunk, "IHDR") || !checksum_is_right(chunk, HEADER + CHUNK))
        return false;
    const int depth = b[8], kind = b[9];
    shape->width = ntpio__png_number(b);
    shape->height = ntpio__png_number(b + 4);
    if ((depth != 8 && depth != 16) || kind > 6 || channels[kind] == 0 || b[10] != 0 ||
        b[11] != 0 || b[12] != 0)
        return false;
    shape->texel = channels[kind] * (size_t) depth / 8;
    shape->row_size = shape->width * shape->texel;
    return shape->width != 0 && shape->height != 0 && shape->width <= INT32_MAX &&
           shape->height <= INT32_MAX;
}

bool ntpio__png_has_pixels(const uint8_t *chunks, size_t size)
{
    size_t at = 0;
    while (size - at >= CHUNK && !ntpio__png_is(chunks + at, "IDAT")) {
        const size_t length = ntpio__png_number(chunks + at);
        if (length > size - at - CHUNK)
            break;
        at += length + CHUNK;
    }
    return size - at >= CHUNK_HEAD && ntpio__png_is(chunks + at, "IDAT");
}

bool ntpio__png_zlib_header(const uint8_t *packed, uint64_t size)
{
    enum { DEFLATE = 8, WINDOW_MOST = 7, DICTIONARY = 0x20 };
    const unsigned kind = packed[0] & 15, window = packed[0] >> 4;
    return kind == DEFLATE && window <= WINDOW_MOST && (packed[0] * 256 + packed[1]) % 31 == 0 &&
           (packed[1] & DICTIONARY) == 0 &&
           (window == WINDOW_MOST || size <= (uint64_t) 256 << window);
}
