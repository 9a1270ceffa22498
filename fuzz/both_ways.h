/* SPDX-License-Identifier: MIT */
/*
 * both_ways.h - reads bytes as an image in several ways, which must agree
 *
 * Rows go into buffers of their exact size, so that a byte too many is caught.  Reading in steps of
 * several rows, and PNG unpacked at once or in parts, must give the same as reading row by row, and
 * each error must be one line of plain text with a status.
 */
#ifndef FUZZ_BOTH_WAYS_H
#define FUZZ_BOTH_WAYS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "ntpio.h"

/* Small, for speed: a few MB at most, whatever a header says. */
static const ntpio_limits LIMITS = {
    .max_side = 4096,
    .max_texels = 1 << 18,
    .max_memory = 1 << 22,
};
static const uint64_t NEVER_AT_ONCE = 1;

static void require(bool condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "fuzz: %s\n", what);
        abort();
    }
}

static void check_error(const ntpio_error *error)
{
    size_t length = strnlen(error->message, sizeof error->message);
    require(error->status > NTPIO_OK && error->status <= NTPIO_ERR_USAGE, "error without status");
    require(length > 0 && length < sizeof error->message, "error without message");
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char) error->message[i];
        require(c >= 0x20 && c < 0x7f, "control character in a message");
    }
}

static void check_info(const ntpio_info *info)
{
    require(info->width >= 1 && info->width <= LIMITS.max_side, "width");
    require(info->height >= 1 && info->height <= LIMITS.max_side, "height");
    require((uint64_t) info->width * info->height <= LIMITS.max_texels, "texels");
    require(info->channels >= 1 && info->channels <= 4, "channels");
    require(info->sample_bytes == 1 || info->sample_bytes == 2 || info->sample_bytes == 4,
            "sample_bytes");
    require(info->jpeg_quality >= 0 && info->jpeg_quality <= 100, "jpeg_quality");
    for (size_t i = 0; i < info->text_count; i++)
        require(info->texts[i].key != NULL && info->texts[i].value != NULL, "text");
}

typedef struct seen {
    bool good;
    uint64_t hash; /* of the samples, then of the texts */
    ntpio_error error;
} seen;

static uint64_t hash_of(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ ((const uint8_t *) bytes)[i]) * 1099511628211u;
    return hash;
}

static uint64_t hash_of_texts(uint64_t hash, const ntpio_info *info)
{
    for (size_t i = 0; i < info->text_count; i++) {
        hash = hash_of(hash, info->texts[i].key, strlen(info->texts[i].key) + 1);
        hash = hash_of(hash, info->texts[i].value, strlen(info->texts[i].value) + 1);
    }
    return hash;
}

/* Reads the whole image in steps of `step` rows. */
static seen read_all(const uint8_t *data, size_t size, uint32_t step, uint64_t max_at_once,
                     bool one_pass)
{
    seen s = { .hash = 14695981039346656037u }; /* FNV-1a */
    ntpio_limits limits = LIMITS;
    limits.max_at_once = max_at_once;
    limits.one_pass = one_pass;
    limits.mip = size % 5 == 4;
    limits.layer_and_one = size % 8 == 7 ? 2 : size % 4 != 0;
    limits.pairs_as_rgb = size % 2 == 0;
    ntpio_reader *reader = ntpio_open_memory(data, size, "fuzz.tga", &limits, &s.error);
    if (reader == NULL) {
        check_error(&s.error);
        return s;
    }
    const ntpio_info *info = ntpio_reader_info(reader);
    check_info(info);
    size_t row = (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
    uint8_t *rows = malloc(row * step);
    require(rows != NULL, "memory");
    s.good = true;
    for (uint32_t y = 0; s.good && y < info->height; y += step) {
        uint32_t count = info->height - y < step ? info->height - y : step;
        s.good = ntpio_read_rows(reader, rows, (ptrdiff_t) row, count, &s.error);
        s.hash = s.good ? hash_of(s.hash, rows, row * count) : s.hash;
    }
    s.good = s.good && ntpio_read_end(reader, &s.error);
    s.hash = hash_of_texts(s.hash, info);
    if (s.good)
        check_info(info);
    else
        check_error(&s.error);
    free(rows);
    ntpio_close(reader);
    return s;
}

static void require_same(const seen *a, const seen *b)
{
    require(a->good == b->good, "the way decides whether a file is good");
    require(!a->good || a->hash == b->hash, "the way changes what is read");
    require(a->good || strcmp(a->error.message, b->error.message) == 0,
            "the way changes the message");
}

static void read_both_ways(const uint8_t *data, size_t size)
{
    const seen by_one = read_all(data, size, 1, NEVER_AT_ONCE, false);
    const seen by_seven = read_all(data, size, 7, 0, false);
    const seen in_parts = read_all(data, size, 5, 0, true);
    require_same(&by_one, &by_seven);
    require_same(&by_one, &in_parts);
}

static uint32_t big_endian(const uint8_t *b)
{
    return (uint32_t) b[0] << 24 | (uint32_t) b[1] << 16 | (uint32_t) b[2] << 8 | b[3];
}

static void put_big_endian(uint8_t *b, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        b[i] = (uint8_t) (value >> (24 - 8 * i));
}

/* Puts the right checksum at each chunk of a PNG file. */
static void mend(uint8_t *file, size_t size)
{
    enum { SIGNATURE = 8, CHUNK = 12 };
    for (size_t at = SIGNATURE; size - at >= CHUNK;) {
        const size_t length = big_endian(file + at);
        if (length > size - at - CHUNK)
            break;
        put_big_endian(file + at + 8 + length,
                       (uint32_t) crc32(0, file + at + 4, (uInt) length + 4));
        at += CHUNK + length;
    }
}

#endif
