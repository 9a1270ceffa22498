/* SPDX-License-Identifier: MIT */
/*
 * fuzz_io.c - reads any bytes as an image
 *
 * Rows go into buffers of their exact size, so that a byte too many is caught.  Reading in steps of
 * several rows must give the same as reading row by row, and each error must be one line of plain
 * text with a status.  Formats are recognized by content; because of the name, everything else is
 * read as TGA.
 */
#include "ntpio.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Small, for speed: a few MB at most, whatever a header says. */
static const ntpio_limits LIMITS = {
    .max_side = 4096,
    .max_texels = 1 << 18,
    .max_memory = 1 << 22,
};

static void require(bool condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "fuzz_io: %s\n", what);
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

/* Reads the whole image in steps of `step` rows; *hash and the row count are the result. */
static bool read_all(const uint8_t *data, size_t size, uint32_t step, uint64_t *hash)
{
    ntpio_error error = { NTPIO_OK, "" };
    ntpio_reader *reader = ntpio_open_memory(data, size, "fuzz.tga", &LIMITS, &error);
    *hash = 14695981039346656037u; /* FNV-1a */
    if (reader == NULL) {
        check_error(&error);
        return false;
    }
    const ntpio_info *info = ntpio_reader_info(reader);
    check_info(info);
    size_t row = (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
    uint8_t *rows = malloc(row * step);
    require(rows != NULL, "memory");
    bool good = true;
    for (uint32_t y = 0; good && y < info->height; y += step) {
        uint32_t count = info->height - y < step ? info->height - y : step;
        good = ntpio_read_rows(reader, rows, (ptrdiff_t) row, count, &error);
        for (size_t i = 0; good && i < row * count; i++)
            *hash = (*hash ^ rows[i]) * 1099511628211u;
    }
    good = good && ntpio_read_end(reader, &error);
    if (good)
        check_info(info);
    else
        check_error(&error);
    free(rows);
    ntpio_close(reader);
    return good;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t by_one, by_seven;
    bool good = read_all(data, size, 1, &by_one);
    require(read_all(data, size, 7, &by_seven) == good, "rows decide whether a file is good");
    require(!good || by_one == by_seven, "steps change what is read");
    return 0;
}
