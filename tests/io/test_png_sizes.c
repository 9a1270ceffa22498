/* SPDX-License-Identifier: MIT */
/*
 * test_png_sizes.c - no file is larger than libpng's own of the same pixels, whatever they are
 *
 * Small pictures are tried in several ways, large ones by runs of rows.  Noise of pieces that
 * repeat far back is where costs foresee badly: zlib is the other witness.  Flat bands are joined
 * bit by bit, so files of several of them, and of noise between them, are read back.
 */
#define ZLIB_CONST
#include <png.h>
#include <stdbool.h>
#include <zlib.h>

#include "../system.h"
#include "chance.h"
#include "deflate.h"
#include "made.h"
#include "ntpio.h"

enum { CHUNK = 1 << 18, PIECES = 300000, FILE_MAX = 1 << 25 };

static ntpio_error error;
static uint8_t file[FILE_MAX], other[FILE_MAX];

/* A byte that is near 0 modulo 256. */
static uint8_t little(void)
{
    return (uint8_t) (chance(24) - 12);
}

static size_t row_bytes(const ntpio_write_options *o)
{
    return o->width * (size_t) (o->channels * o->sample_bytes);
}

/* Pieces of 6 to 9 bytes that stood up to 30,000 bytes before, and a few others. */
static void fill_pieces(uint8_t *b, size_t size)
{
    for (size_t i = 0; i < size;) {
        const size_t back = 1 + chance(30000);
        const uint32_t length = 6 + chance(4);
        const bool old = i > 30000 && chance(16) != 0;
        for (uint32_t k = 0; k < length && i < size; k++, i++)
            b[i] = old ? b[i - back] : little();
    }
}

/* One value, noise, few values, a slope with noise, pieces, waves. */
static void fill(uint8_t *b, const ntpio_write_options *o, uint32_t kind)
{
    const size_t line = row_bytes(o), size = line * o->height;
    if (kind == 4)
        fill_pieces(b, size);
    for (size_t i = 0; i < size && kind != 4; i++) {
        const uint32_t x = (uint32_t) (i % line), y = (uint32_t) (i / line);
        b[i] = (uint8_t) (kind == 0   ? 128
                          : kind == 1 ? chance(256)
                          : kind == 2 ? 40 * chance(3)
                          : kind == 3 ? x / 6 + y / 2 + chance(3)
                                      : (x / 12 * 17 ^ y / 5 * 29) & 240);
    }
}

/* With its defaults, but long chunks, which take less. */
static size_t libpng_size(const ntpio_write_options *o, const uint8_t *rows)
{
    static const int kinds[] = { PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA };
    FILE *f = fopen("theirs.png", "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    CHECK(f != NULL && png != NULL);
    png_infop info = png_create_info_struct(png);
    CHECK(info != NULL);
    png_init_io(png, f);
    png_set_compression_buffer_size(png, CHUNK);
    png_set_IHDR(png, info, o->width, o->height, 8 * o->sample_bytes, kinds[o->channels - 1], 0, 0,
                 0);
    png_write_info(png, info);
    if (o->sample_bytes == 2)
        png_set_swap(png);
    for (uint32_t y = 0; y < o->height; y++)
        png_write_row(png, rows + y * row_bytes(o));
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    fclose(f);
    return load_file("theirs.png", other, FILE_MAX);
}

static size_t our_size(const ntpio_write_options *o, const uint8_t *rows, uint8_t *to)
{
    ntpio_writer *w = ntpio_create("ours.png", o, &error);
    CHECK(w != NULL);
    CHECK(ntpio_write_rows(w, rows, (ptrdiff_t) row_bytes(o), o->height, &error));
    CHECK(ntpio_commit(w, &error));
    return load_file("ours.png", to, FILE_MAX);
}

static void reads(const ntpio_write_options *o, const uint8_t *rows, uint64_t max_at_once)
{
    const ntpio_limits limits = { .max_side = 1 << 20, .max_at_once = max_at_once };
    uint8_t *row = malloc(row_bytes(o));
    ntpio_reader *r = ntpio_open("ours.png", &limits, &error);
    CHECK(row != NULL && r != NULL);
    for (uint32_t y = 0; y < o->height; y++) {
        CHECK(ntpio_read_rows(r, row, 0, 1, &error));
        CHECK(memcmp(row, rows + y * row_bytes(o), row_bytes(o)) == 0);
    }
    CHECK(ntpio_read_end(r, &error));
    ntpio_close(r);
    free(row);
}

/* The same file with 1, 2 and 3 threads, which is read back by both readers. */
static size_t trip(ntpio_write_options o, const uint8_t *rows)
{
    const size_t size = our_size(&o, rows, file);
    reads(&o, rows, 0);
    reads(&o, rows, 1);
    for (o.threads = 2; o.threads <= 3; o.threads++)
        CHECK(our_size(&o, rows, other) == size && memcmp(file, other, size) == 0);
    return size;
}

static void test_small(void)
{
    for (uint32_t n = 0; n < 8 * 6 * 9; n++) {
        static const uint32_t sides[] = { 1, 2, 5, 16, 17, 31, 64, 100, 128 };
        const ntpio_write_options o = { .format = NTPIO_PNG,
                                        .width = sides[n / 48],
                                        .height = sides[(n / 48 + n / 8) % 9],
                                        .channels = 1 + (int32_t) n % 4,
                                        .sample_bytes = 1 + (int32_t) n / 4 % 2,
                                        .level = -1 };
        uint8_t *rows = malloc(row_bytes(&o) * o.height);
        CHECK(rows != NULL);
        fill(rows, &o, n / 8 % 6);
        /* Above 16,383 symbols, zlib may end a block at a better place; of noise of some dozen bytes
         * it may take a repetition that happens to save a byte. */
        const bool one = (row_bytes(&o) + 1) * o.height < 1 << 14;
        const size_t ours = our_size(&o, rows, file), theirs = libpng_size(&o, rows);
        CHECK(ours <= theirs + (one ? 1 : theirs / 256));
        reads(&o, rows, 0);
        free(rows);
    }
}

/* Larger ones, of one band and of two. */
static void test_large(void)
{
    for (uint32_t n = 0; n < 12; n++) {
        const ntpio_write_options o = { .format = NTPIO_PNG,
                                        .width = n < 6 ? 600 : 2000,
                                        .height = n < 6 ? 301 : 1101,
                                        .channels = 3,
                                        .sample_bytes = 1,
                                        .level = n == 5 ? 9 : -1 };
        uint8_t *rows = malloc(row_bytes(&o) * o.height);
        CHECK(rows != NULL);
        fill(rows, &o, n % 6);
        CHECK(trip(o, rows) <= libpng_size(&o, rows));
        free(rows);
    }
}

/* Six bands: flat ones are joined, in the midst of noise or around it, or by themselves. */
static void test_joined(void)
{
    const ntpio_write_options o = { .format = NTPIO_PNG,
                                    .width = 2048,
                                    .height = 3072,
                                    .channels = 4,
                                    .sample_bytes = 1,
                                    .level = 1 };
    const size_t size = row_bytes(&o) * o.height, band = size / 6;
    uint8_t *rows = malloc(size);
    CHECK(rows != NULL);
    for (uint32_t noisy = 0; noisy < 64; noisy += noisy < 3 ? 1 : 20) {
        memset(rows, 77, size);
        for (uint32_t k = 0; k < 6; k++) {
            for (size_t i = 0; noisy >> k & 1 && i < band; i++)
                rows[k * band + i] = (uint8_t) chance(256);
        }
        trip(o, rows);
    }
    memset(rows, 77, size);
    CHECK(trip(o, rows) <= libpng_size(&o, rows));
    /* In every other band some noise, a part of which is stored as it is.  That begins at a whole byte,
     * also after the odd bits of the band before. */
    for (uint32_t k = 1; k < 6; k += 2) {
        uint8_t *at = rows + k * band + band / 3 + 3000;
        for (size_t i = 0; i < 60000; i++)
            at[i] = (uint8_t) chance(i < 40000 ? 256 : 3);
    }
    trip(o, rows);
    free(rows);
}

/* The matches of zlib at its level 6: what they take is no more. */
static void test_as_zlib(void)
{
    static uint8_t bytes[PIECES + NTPIO__SLACK], out[2 * PIECES], theirs[2 * PIECES];
    ntpio__deflater *d = ntpio__deflater_new(NTPIO__LEVEL_ZLIB);
    CHECK(d != NULL);
    for (uint32_t kind = 0; kind < 6; kind++) {
        const ntpio_write_options o = {
            .width = 1000, .height = PIECES / 1000, .channels = 1, .sample_bytes = 1
        };
        z_stream z = { 0 };
        fill(bytes, &o, kind);
        CHECK(deflateInit2(&z, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_FILTERED) == Z_OK);
        z.next_in = bytes;
        z.avail_in = PIECES;
        z.next_out = theirs;
        z.avail_out = sizeof theirs;
        CHECK(deflate(&z, Z_FINISH) == Z_STREAM_END);
        const size_t size = ntpio__deflate(d, NTPIO__LEVEL_ZLIB, bytes, 0, PIECES, true, out);
        CHECK(size <= z.total_out);
        CHECK((ntpio__deflated_bits(d) + 7) / 8 == size);
        deflateEnd(&z);
    }
    ntpio__deflater_free(d);
}

int main(void)
{
    CHECK(system_enter_folder());
    test_as_zlib();
    test_small();
    test_large();
    test_joined();
    unlink("ours.png");
    unlink("theirs.png");
    CHECK(system_leave_folder());
    return 0;
}
