/* SPDX-License-Identifier: MIT */
/*
 * fuzz_write.c - writes any picture as PNG, and reads it back with libpng alone
 *
 * The first bytes say what picture: its size, samples, level, threads, texts, and how its texels follow
 * from the other bytes.  The file goes to memory: the functions of output.h are here.  libpng
 * must read the same samples and texts without a warning, and our reader the same samples, at once
 * and row by row.  With one thread and with several the bytes are the same.  Where bands and rows are
 * made small when this is built (NTPIO_PNG_BAND, NTPIO_PNG_ROW_MAX), small pictures have several bands,
 * and longer rows are libpng's.  Small tables take less time to clear.
 */
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ntpio.h"
#include "output.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum {
    HEAD = 8,
    SIDE_MAX = 32, /* small, for speed */
    LEVELS = 12,
    THREADS = 4,
    TEXT_MAX = 40
};

typedef struct picture {
    ntpio_write_options options;
    ntpio_text text;
    ntpio_info rival;
    char value[TEXT_MAX + 1];
    size_t row; /* bytes */
    uint8_t *samples;
} picture;

static void require(bool condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "fuzz_write: %s\n", what);
        abort();
    }
}

/* ------------------------------------------------------------------ the file in memory */

struct ntpio__output {
    size_t size, capacity;
    uint8_t *bytes;
};

static struct ntpio__output written;

ntpio__output *ntpio__output_open(const char *path, const ntpio_write_options *options,
                                  ntpio_error *error)
{
    (void) path, (void) options, (void) error;
    written.size = 0;
    return &written;
}

bool ntpio__output_write(ntpio__output *output, const void *bytes, size_t size, ntpio_error *error)
{
    (void) error;
    if (size > output->capacity - output->size) {
        output->capacity = 2 * (output->size + size);
        output->bytes = realloc(output->bytes, output->capacity);
        require(output->bytes != NULL, "memory");
    }
    memcpy(output->bytes + output->size, bytes, size);
    output->size += size;
    return true;
}

bool ntpio__output_can_seek(const ntpio__output *output)
{
    (void) output;
    return false;
}

bool ntpio__output_write_at(ntpio__output *output, uint64_t offset, const void *bytes, size_t size,
                            ntpio_error *error)
{
    require(offset == output->size, "an output that cannot seek");
    return ntpio__output_write(output, bytes, size, error);
}

bool ntpio__output_commit(ntpio__output *output, ntpio_error *error)
{
    (void) output, (void) error;
    return true;
}

void ntpio__output_abort(ntpio__output *output)
{
    (void) output;
}

/* ------------------------------------------------------------------------- pictures */

/* Bytes as they are, again and again; smooth; of few values; noise. */
static void fill(picture *p, unsigned kind, const uint8_t *data, size_t size)
{
    static const uint8_t none = 0;
    const size_t whole = p->row * p->options.height;
    uint32_t state = (uint32_t) size;
    if (size == 0) {
        data = &none;
        size = 1;
    }
    for (size_t i = 0; i < whole; i++) {
        const uint8_t given = data[i % size];
        state = state * 1664525u + 1013904223u + given;
        p->samples[i] = kind == 0   ? given
                        : kind == 1 ? (uint8_t) (data[0] * (i % p->row) + i / p->row + given % 4)
                        : kind == 2 ? data[(state >> 24) % (size < 5 ? size : 5)]
                                    : (uint8_t) (state >> 24);
    }
}

/* False: too few bytes. */
static bool take(picture *p, const uint8_t *data, size_t size)
{
    if (size < HEAD)
        return false;
    memset(p, 0, sizeof *p);
    p->options = (ntpio_write_options) { .format = NTPIO_PNG,
                                         .channels = 1 + data[0] % 4,
                                         .sample_bytes = 1 + data[0] / 4 % 2,
                                         .level = data[1] % (LEVELS + 1),
                                         .threads = 1 + data[2] % THREADS,
                                         .width = 1 + data[3] % SIDE_MAX,
                                         .height = 1 + data[4] % SIDE_MAX };
    if (p->options.level == 0) { /* it is packed again if it is larger than a file of few bytes */
        p->options.level = -1;
        p->options.as_it_came = &p->rival;
        p->rival = (ntpio_info) { .packed_hard = true,
                                  .width = p->options.width,
                                  .height = p->options.height,
                                  .channels = p->options.channels,
                                  .bit_depth = 8 * p->options.sample_bytes,
                                  .file_size = 1 + 4 * data[7] };
    }
    p->row = p->options.width * (size_t) (p->options.channels * p->options.sample_bytes);
    p->samples = malloc(p->row * p->options.height);
    require(p->samples != NULL, "memory");
    fill(p, data[5] % 4, data + HEAD, size - HEAD);
    static char key[] = "Comment";
    const size_t length = data[6] % TEXT_MAX;
    for (size_t i = 0; i < length; i++) /* of Latin-1, what shows */
        p->value[i] = (char) (' ' + data[i % size] % 95);
    p->text = (ntpio_text) { .key = key, .value = p->value, .compressed = data[7] % 2 != 0 };
    p->options.texts = &p->text;
    p->options.text_count = length != 0;
    return true;
}

static void write_picture(const picture *p, int32_t threads, unsigned step)
{
    ntpio_error error;
    ntpio_write_options options = p->options;
    options.threads = threads;
    ntpio_writer *writer = ntpio_create("picture.png", &options, &error);
    require(writer != NULL, "not created");
    for (uint32_t y = 0; y < options.height; y += step) {
        const uint32_t count = options.height - y < step ? options.height - y : step;
        require(
            ntpio_write_rows(writer, p->samples + y * p->row, (ptrdiff_t) p->row, count, &error),
            "rows not written");
    }
    require(ntpio_commit(writer, &error), "not ended");
}

/* --------------------------------------------------------------------------- readers */

static void on_fault(png_structp png, png_const_charp message)
{
    (void) png;
    require(false, message);
    abort();
}

static void on_read(png_structp png, png_bytep to, size_t size)
{
    size_t *at = png_get_io_ptr(png);
    require(size <= written.size - *at, "truncated");
    memcpy(to, written.bytes + *at, size);
    *at += size;
}

static void check_text(const picture *p, png_structp png, png_infop info)
{
    png_textp texts;
    int count = 0;
    png_get_text(png, info, &texts, &count);
    require((size_t) count == p->options.text_count, "number of texts");
    require(count == 0 || strcmp(texts[0].text, p->value) == 0, "text");
}

static void read_with_libpng(const picture *p)
{
    static const int kinds[] = { PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA };
    static const uint16_t one = 1;
    const ntpio_write_options *o = &p->options;
    size_t at = 0;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, on_fault, on_fault);
    png_infop info = png_create_info_struct(png);
    png_set_read_fn(png, &at, on_read);
    png_read_info(png, info);
    require(png_get_image_width(png, info) == o->width, "width");
    require(png_get_image_height(png, info) == o->height, "height");
    require(png_get_bit_depth(png, info) == 8 * o->sample_bytes, "depth");
    require(png_get_color_type(png, info) == kinds[o->channels - 1], "kind of samples");
    if (o->sample_bytes == 2 && *(const uint8_t *) &one == 1)
        png_set_swap(png);
    png_read_update_info(png, info);
    uint8_t *row = malloc(p->row);
    require(row != NULL, "memory");
    for (uint32_t y = 0; y < o->height; y++) {
        png_read_row(png, row, NULL);
        require(memcmp(row, p->samples + y * p->row, p->row) == 0, "samples");
    }
    free(row);
    png_read_end(png, info);
    require(at == written.size, "bytes after the end");
    check_text(p, png, info);
    png_destroy_read_struct(&png, &info, NULL);
}

static void read_with_ours(const picture *p, uint64_t max_at_once)
{
    const ntpio_limits limits = { .max_at_once = max_at_once };
    ntpio_error error;
    ntpio_reader *reader =
        ntpio_open_memory(written.bytes, written.size, "picture.png", &limits, &error);
    require(reader != NULL, "not opened");
    uint8_t *rows = malloc(p->row * p->options.height);
    require(rows != NULL, "memory");
    require(ntpio_read_rows(reader, rows, (ptrdiff_t) p->row, p->options.height, &error) &&
                ntpio_read_end(reader, &error),
            "not read");
    require(memcmp(rows, p->samples, p->row * p->options.height) == 0, "samples of our reader");
    free(rows);
    ntpio_close(reader);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    picture p;
    if (!take(&p, data, size))
        return 0;
    write_picture(&p, 1, 1);
    read_with_libpng(&p);
    read_with_ours(&p, 0);
    read_with_ours(&p, 1);
    if (p.options.threads > 1) {
        const size_t alone_size = written.size;
        uint8_t *alone = malloc(alone_size);
        require(alone != NULL, "memory");
        memcpy(alone, written.bytes, alone_size);
        write_picture(&p, p.options.threads, 3);
        require(written.size == alone_size && memcmp(alone, written.bytes, alone_size) == 0,
                "threads change the bytes");
        free(alone);
    }
    free(p.samples);
    return 0;
}
