/* SPDX-License-Identifier: MIT */
/*
 * test_png_pack.c - what is packed is unpacked by zlib and libpng, and has libpng's chunks
 *
 * Streams: bytes of many kinds, at every level, in parts.  Files: every kind of samples, sides that
 * are 1 or odd, several bands, rows too long for bands.
 */
#define ZLIB_CONST
#include <png.h>
#include <zlib.h>

#include "../system.h"
#include "chance.h"
#include "deflate.h"
#include "deflate_block.h"
#include "made.h"
#include "ntpio.h"

enum { SIZE_MAX_TRIED = 200000, GUARD = 64, FILE_MAX = 1 << 23 };

/* ------------------------------------------------------------------------- streams */

/* Noise, steps, runs, repeated pieces, one value. */
static void fill(uint8_t *b, size_t size, uint32_t kind)
{
    for (size_t i = 0; i < size;) {
        const uint32_t back = 1 + chance(40000), length = 1 + chance(kind == 3 ? 400 : 20);
        const uint8_t value = (uint8_t) (kind == 4 ? 9 : chance(kind == 0 ? 256 : 6));
        for (uint32_t k = 0; k < length && i < size; k++, i++)
            b[i] = kind == 3 && back <= i ? b[i - back]
                   : kind == 2            ? value
                   : kind == 4            ? 9
                                          : (uint8_t) (kind == 0 ? chance(256) : chance(6) * value);
    }
}

static void unpacks(const uint8_t *packed, size_t packed_size, const uint8_t *bytes, size_t size)
{
    static uint8_t out[SIZE_MAX_TRIED + 1];
    z_stream z = { 0 };
    CHECK(inflateInit2(&z, -MAX_WBITS) == Z_OK);
    z.next_in = packed;
    z.avail_in = (uInt) packed_size;
    z.next_out = out;
    z.avail_out = sizeof out;
    CHECK(inflate(&z, Z_FINISH) == Z_STREAM_END && z.avail_in == 0 && z.total_out == size);
    CHECK(memcmp(out, bytes, size) == 0);
    inflateEnd(&z);
}

/* In parts, of which each may look back into the one before.  Nothing is written past the bound. */
static size_t pack_parts(ntpio__deflater *d, int level, uint8_t *bytes, size_t size, size_t part,
                         uint8_t *out)
{
    size_t packed = 0;
    for (size_t from = 0, to; from < size; from = to) {
        uint8_t kept[NTPIO__SLACK];
        to = size - from < part ? size : from + part;
        memcpy(kept, bytes + to, sizeof kept);
        memset(bytes + to, 0, sizeof kept);
        const size_t bound = ntpio__deflate_bound(to - from);
        memset(out + packed + bound, 0x5a, GUARD);
        packed += ntpio__deflate(d, level, bytes, from, to, to == size, out + packed);
        for (size_t i = 0; i < GUARD && to == size; i++)
            CHECK(size > part || out[bound + i] == 0x5a);
        memcpy(bytes + to, kept, sizeof kept);
    }
    return packed;
}

static void test_streams(void)
{
    static uint8_t bytes[SIZE_MAX_TRIED + NTPIO__SLACK];
    static uint8_t out[2 * SIZE_MAX_TRIED], again[2 * SIZE_MAX_TRIED];
    for (int level = NTPIO__LEVEL_ZLIB; level <= NTPIO__LEVEL_TRIAL; level++) {
        ntpio__deflater *d = ntpio__deflater_new(level);
        CHECK(d != NULL);
        for (uint32_t n = 0; n < 40; n++) {
            const size_t size = 1 + chance(n < 20 ? 300 : n < 38 ? 60000 : SIZE_MAX_TRIED);
            const size_t part = n % 3 == 0 ? size : 1 + chance((uint32_t) size) / (1 + n % 2);
            const size_t least = part < size / 8 ? size / 8 + 1 : part;
            fill(bytes, size, n % 5);
            const size_t packed = pack_parts(d, level, bytes, size, least, out);
            unpacks(out, packed, bytes, size);
            CHECK(pack_parts(d, level, bytes, size, least, again) == packed);
            CHECK(memcmp(out, again, packed) == 0); /* what was packed before leaves no trace */
        }
        ntpio__deflater_free(d);
    }
}

/* A block of literals by itself. */
static void pack_literals(uint8_t *bytes, uint32_t size)
{
    static uint8_t out[SIZE_MAX_TRIED];
    const ntpio__step step = { size, 0 };
    ntpio__counts counts = { { 0 }, { 0 } };
    ntpio__bits bits = { .out = out };
    for (uint32_t i = 0; i < size; i++)
        counts.words[bytes[i]]++;
    ntpio__put_block(&bits, &step, 1, &counts, bytes, size, true);
    ntpio__end_byte(&bits);
    unpacks(out, bits.size, bytes, size);
}

/* One that occurs more than 2^16 times; and many words in a row that are as long as they may be, from
 * any bit on. */
static void test_literals(void)
{
    enum { MANY = 70000, VALUES = 21 };
    static uint8_t bytes[SIZE_MAX_TRIED];
    bytes[MANY - 1] = 1;
    pack_literals(bytes, MANY);
    for (uint32_t shift = 0; shift < 8; shift++) {
        uint32_t size = shift, before = 0, next = 1;
        memset(bytes, VALUES - 1, shift); /* of one bit */
        for (uint32_t value = 0; value < VALUES; value++) {
            memset(bytes + size, (int) value, next);
            size += next;
            next += before + 1;
            before = next - before - 1;
        }
        pack_literals(bytes, size);
    }
}

/* --------------------------------------------------------------------------- files */

static ntpio_error error;
static uint8_t file[FILE_MAX], other[FILE_MAX];

static size_t row_bytes(const ntpio_write_options *o)
{
    return o->width * (size_t) (o->channels * o->sample_bytes);
}

static uint8_t *make_rows(const ntpio_write_options *o, uint32_t kind)
{
    const size_t size = row_bytes(o) * o->height;
    uint8_t *rows = malloc(size);
    CHECK(rows != NULL);
    fill(rows, size, kind);
    return rows;
}

static void write_rows(const char *path, const ntpio_write_options *o, const uint8_t *rows,
                       uint32_t step)
{
    ntpio_writer *w = ntpio_create(path, o, &error);
    CHECK(w != NULL);
    for (uint32_t y = 0; y < o->height; y += step) {
        const uint32_t count = o->height - y < step ? o->height - y : step;
        CHECK(
            ntpio_write_rows(w, rows + y * row_bytes(o), (ptrdiff_t) row_bytes(o), count, &error));
    }
    CHECK(ntpio_commit(w, &error));
}

/* max_at_once 1: libpng reads the pixels. */
static void reads(const char *path, const ntpio_write_options *o, const uint8_t *rows,
                  uint64_t max_at_once)
{
    const ntpio_limits limits = { .max_side = 1 << 20, .max_at_once = max_at_once };
    uint8_t *row = malloc(row_bytes(o));
    ntpio_reader *r = ntpio_open(path, &limits, &error);
    CHECK(row != NULL && r != NULL);
    const ntpio_info *info = ntpio_reader_info(r);
    CHECK(info->width == o->width && info->height == o->height && info->channels == o->channels &&
          info->sample_bytes == o->sample_bytes);
    for (uint32_t y = 0; y < o->height; y++) {
        CHECK(ntpio_read_rows(r, row, 0, 1, &error));
        CHECK(memcmp(row, rows + y * row_bytes(o), row_bytes(o)) == 0);
    }
    CHECK(ntpio_read_end(r, &error));
    ntpio_close(r);
    free(row);
}

/* Returns the size of the file. */
static size_t trip(const ntpio_write_options *o, uint32_t kind)
{
    uint8_t *rows = make_rows(o, kind);
    write_rows("packed.png", o, rows, o->height);
    reads("packed.png", o, rows, 1);
    reads("packed.png", o, rows, 0);
    const size_t size = load_file("packed.png", other, FILE_MAX);
    free(rows);
    unlink("packed.png");
    return size;
}

static void test_kinds(void)
{
    static const uint32_t sides[][2] = { { 1, 1 }, { 1, 37 }, { 37, 1 }, { 33, 19 } };
    for (int32_t level = -1; level <= NTPIO__LEVEL_MAX; level += level < 0 ? 2 : 1) {
        for (uint32_t n = 0; n < 32; n++) {
            const ntpio_write_options o = { .format = NTPIO_PNG,
                                            .width = sides[n / 8][0],
                                            .height = sides[n / 8][1],
                                            .channels = 1 + (int32_t) n % 4,
                                            .sample_bytes = 1 + (int32_t) n / 4 % 2,
                                            .level = level };
            trip(&o, (uint32_t) (n + (uint32_t) level) % 5);
        }
    }
}

/* Several bands; then rows that are too long for them, which libpng packs. */
static void test_large(void)
{
    const ntpio_write_options bands = {
        .width = 250001, .height = 11, .channels = 4, .sample_bytes = 1, .level = 1
    };
    const ntpio_write_options long_rows = {
        .width = 350001, .height = 2, .channels = 3, .sample_bytes = 1, .level = 12
    };
    trip(&bands, 3);
    trip(&long_rows, 2);
}

/* Beside a file that was smaller: never larger than without, and at least as small as at the highest
 * level where there is one band.  Noise gets no smaller. */
static void beside_rival(ntpio_write_options o, uint32_t kind)
{
    ntpio_info rival = { .packed_hard = true,
                         .file_size = 1,
                         .width = o.width,
                         .height = o.height,
                         .channels = o.channels,
                         .bit_depth = 8 * o.sample_bytes };
    const uint64_t start = state;
    const size_t usual = trip(&o, kind);
    state = start;
    o.as_it_came = &rival;
    const size_t again = trip(&o, kind);
    memcpy(file, other, again);
    CHECK(again <= usual && (again < usual || kind == 0));
    state = start;
    o.threads = 3;
    CHECK(trip(&o, kind) == again && memcmp(file, other, again) == 0);
    state = start;
    rival.packed_hard = false; /* nothing is packed again */
    CHECK(trip(&o, kind) == usual);
    o.level = NTPIO__LEVEL_MAX;
    state = start;
    CHECK(row_bytes(&o) * o.height > 4 << 20 || again <= trip(&o, kind));
}

static void test_rivals(void)
{
    ntpio_write_options o = { .format = NTPIO_PNG, .channels = 3, .level = -1 };
    for (uint32_t n = 0; n < 8; n++) {
        o.width = 290 + 7 * n;
        o.height = n % 2 == 0 ? 20 : 90;
        o.sample_bytes = 1 + (int32_t) n / 4;
        beside_rival(o, n % 4);
    }
    o.width = 1000;
    o.height = 1100; /* two bands of 3.3 MB */
    for (uint32_t kind = 1; kind < 4; kind += 2)
        beside_rival(o, kind);
}

/* A band that packs small ends within a byte, and an empty block fills that up in front of the band of
 * noise after it, whatever stood there in memory. */
static void test_joins(void)
{
    ntpio_write_options o = {
        .format = NTPIO_PNG, .width = 2000, .channels = 3, .sample_bytes = 1
    };
    for (uint32_t n = 0; n < 8; n++) {
        o.level = 1 + (int32_t) n % 6;
        o.height = 2000; /* three bands */
        uint8_t *rows = make_rows(&o, 4);
        const size_t third = row_bytes(&o) * o.height / 3;
        for (uint32_t i = 0; i < n; i++)
            rows[chance((uint32_t) third)] = (uint8_t) chance(256);
        for (size_t i = third * (1 + n % 2); i < 3 * third; i++)
            rows[i] = (uint8_t) chance(256);
        write_rows("packed.png", &o, rows, o.height);
        reads("packed.png", &o, rows, 1);
        free(rows);
    }
    unlink("packed.png");
}

/* -------------------------------------------------------------------------- chunks */

static void libpng_writes(const char *path, const ntpio_write_options *o, const uint8_t *rows,
                          png_text *texts, int before, int after)
{
    static const int kinds[] = { PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA };
    FILE *f = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    CHECK(f != NULL && png != NULL);
    png_infop info = png_create_info_struct(png), end = png_create_info_struct(png);
    CHECK(info != NULL && end != NULL);
    png_init_io(png, f);
    png_set_IHDR(png, info, o->width, o->height, 8 * o->sample_bytes, kinds[o->channels - 1], 0, 0,
                 0);
    png_set_pHYs(png, info, 11, 12, 1);
    png_set_text(png, info, texts, before);
    png_write_info(png, info);
    if (o->sample_bytes == 2)
        png_set_swap(png);
    for (uint32_t y = 0; y < o->height; y++)
        png_write_row(png, rows + y * row_bytes(o));
    png_set_text(png, end, texts + before, after);
    png_write_end(png, end);
    png_destroy_info_struct(png, &end);
    png_destroy_write_struct(&png, &info);
    fclose(f);
}

/* Drops the chunks of pixels but for one empty one. */
static size_t without_pixels(uint8_t *b, size_t size)
{
    size_t to = 8;
    bool seen = false;
    for (size_t at = 8, whole; at < size; at += whole) {
        whole = 12 + ((size_t) b[at] << 24 | (size_t) b[at + 1] << 16 | (size_t) b[at + 2] << 8 |
                      b[at + 3]);
        CHECK(at + whole <= size);
        const bool pixels = memcmp(b + at + 4, "IDAT", 4) == 0;
        const size_t kept = pixels ? (seen ? 0 : 12) : whole;
        CHECK(crc(b + at + 4, whole - 8) ==
              ((uint32_t) b[at + whole - 4] << 24 | (uint32_t) b[at + whole - 3] << 16 |
               (uint32_t) b[at + whole - 2] << 8 | b[at + whole - 1]));
        memmove(b + to, b + at, kept);
        if (pixels && !seen) {
            memset(b + to, 0, 4);
            memset(b + to + 8, 0, 4);
        }
        to += kept;
        seen = seen || pixels;
    }
    return to;
}

static void test_chunks(void)
{
    static char keys[][8] = { "Title", "Comment", "Author", "Late" };
    static char values[][40] = { "plain", "packed packed packed packed", "J\xc3\xb6rg", "after" };
    static char language[] = "de", autor[] = "Autor";
    static const int how[] = { PNG_TEXT_COMPRESSION_NONE, PNG_TEXT_COMPRESSION_zTXt,
                               PNG_ITXT_COMPRESSION_NONE, PNG_TEXT_COMPRESSION_zTXt };
    png_text theirs[4] = { { 0 } };
    ntpio_text ours[4] = { { 0 } };
    for (int i = 0; i < 4; i++) {
        const bool itxt = i == 2;
        theirs[i] = (png_text) { .compression = how[i],
                                 .key = keys[i],
                                 .text = values[i],
                                 .lang = itxt ? language : NULL,
                                 .lang_key = itxt ? autor : NULL };
        ours[i] = (ntpio_text) { .key = keys[i],
                                 .value = values[i],
                                 .itxt = itxt,
                                 .compressed = how[i] == PNG_TEXT_COMPRESSION_zTXt,
                                 .language = itxt ? language : NULL,
                                 .translated_key = itxt ? autor : NULL };
    }
    for (int n = 0; n < 8; n++) {
        ntpio_info info = { .has_phys = true,
                            .phys_x = 11,
                            .phys_y = 12,
                            .phys_unit = 1,
                            .texts = ours,
                            .text_count = 3 };
        const ntpio_write_options o = { .width = 30,
                                        .height = 20,
                                        .channels = 1 + n % 4,
                                        .sample_bytes = 1 + n / 4,
                                        .level = -1,
                                        .copy_from = &info };
        uint8_t *rows = make_rows(&o, 1);
        libpng_writes("theirs.png", &o, rows, theirs, 3, 1);
        ntpio_writer *w = ntpio_create("ours.png", &o, &error);
        CHECK(w != NULL && ntpio_write_rows(w, rows, (ptrdiff_t) row_bytes(&o), 20, &error));
        info.text_count = 4;
        CHECK(ntpio_commit(w, &error));
        const size_t size = without_pixels(file, load_file("ours.png", file, FILE_MAX));
        CHECK(size == without_pixels(other, load_file("theirs.png", other, FILE_MAX)));
        CHECK(memcmp(file, other, size) == 0);
        free(rows);
    }
    unlink("ours.png");
    unlink("theirs.png");
}

/* -------------------------------------------------------------------- bytes and sizes */

/* The same bytes however the rows come; no larger than libpng's own, whatever is in the picture. */
static void test_sizes(void)
{
    for (uint32_t kind = 0; kind < 6; kind++) {
        const ntpio_write_options o = {
            .width = 200, .height = 150, .channels = 3, .sample_bytes = 1, .level = -1
        };
        uint8_t *rows = make_rows(&o, kind);
        for (size_t i = 0; kind == 5 && i < row_bytes(&o) * o.height; i++) /* a slope, and noise */
            rows[i] = (uint8_t) (i / 3 % 200 / 2 + i / 600 + chance(4));
        libpng_writes("theirs.png", &o, rows, NULL, 0, 0);
        write_rows("ours.png", &o, rows, 150);
        write_rows("steps.png", &o, rows, 7);
        const size_t size = load_file("ours.png", file, FILE_MAX);
        CHECK(load_file("steps.png", other, FILE_MAX) == size && memcmp(file, other, size) == 0);
        CHECK(size <= load_file("theirs.png", other, FILE_MAX));
        free(rows);
    }
    unlink("ours.png");
    unlink("steps.png");
    unlink("theirs.png");
}

/* The same bytes with any number of threads: more bands than slots, fewer, one that is small. */
static void test_threads(void)
{
    for (uint32_t height = 3; height <= 45; height += 21) {
        ntpio_write_options o = {
            .width = 50001, .height = height, .channels = 4, .sample_bytes = 1, .level = 2
        };
        uint8_t *rows = make_rows(&o, 2);
        write_rows("ours.png", &o, rows, height);
        const size_t size = load_file("ours.png", file, FILE_MAX);
        for (o.threads = 2; o.threads <= 40; o.threads += o.threads < 4 ? 1 : 36) {
            write_rows("threads.png", &o, rows, 5);
            CHECK(load_file("threads.png", other, FILE_MAX) == size &&
                  memcmp(file, other, size) == 0);
        }
        reads("ours.png", &o, rows, 0);
        free(rows);
    }
    unlink("ours.png");
    unlink("threads.png");
}

/* A writer that is dropped ends its threads. */
static void test_dropped(void)
{
    ntpio_write_options o = {
        .width = 50001, .height = 90, .channels = 4, .sample_bytes = 1, .level = 9, .threads = 3
    };
    uint8_t *rows = make_rows(&o, 0);
    ntpio_writer *writer = ntpio_create("dropped.png", &o, &error);
    CHECK(writer != NULL);
    CHECK(ntpio_write_rows(writer, rows, (ptrdiff_t) row_bytes(&o), 60, &error));
    ntpio_abort(writer);
    CHECK(access("dropped.png", F_OK) != 0);
    free(rows);
}

int main(void)
{
    CHECK(system_enter_folder());
    test_streams();
    test_literals();
    test_kinds();
    test_large();
    test_rivals();
    test_joins();
    test_chunks();
    test_sizes();
    test_threads();
    test_dropped();
    CHECK(system_leave_folder());
    return 0;
}
