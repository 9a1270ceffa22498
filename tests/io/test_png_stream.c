/* SPDX-License-Identifier: MIT */
/*
 * test_png_stream.c - PNG that is kept, in parts and row by row: the same samples, texts and
 * messages
 *
 * While rows are read, another thread may unpack what is kept.
 *
 * libpng and zlib are the witnesses.  Files of every kind are made, then most are damaged: filters
 * that do not exist, rows too many or too few, windows that are too small, chunks out of order or
 * longer than the file, bytes changed with and without their checksums mended.
 */
#include <zlib.h>

#include "chance.h"
#include "made.h"
#include "png_filter.h"
#include "png_plain.h"
#include "png_stream.h"
#include "os/threads.h"

enum { SIDE = 40, TALL = 7 * SIDE, RAW_MAX = 1 << 17, SURPLUS = 20000, STEP_MAX = 5, FILES = 6000 };

/* ------------------------------------------------------------------------- chance */

static bool plain; /* the file that is made has no fault */

static bool spoiled_once_in(uint32_t n)
{
    return !plain && once_in(n);
}

/* -------------------------------------------------------------------------- files */

static made file, packed;
static uint8_t raw[RAW_MAX];
static size_t raw_size;

static size_t make_rows(uint32_t width, uint32_t height, size_t texel)
{
    const bool one_filter = once_in(2), smooth = once_in(2);
    const uint32_t filters = NTPIO__FILTERS + spoiled_once_in(20);
    const uint8_t filter = (uint8_t) chance(filters);
    size_t size = 0;
    for (uint32_t y = 0; y < height; y++) {
        raw[size++] = one_filter ? filter : (uint8_t) chance(filters);
        for (size_t i = 0; i < width * texel; i++)
            raw[size++] = (uint8_t) chance(smooth ? 3 : 256);
    }
    if (spoiled_once_in(12))
        size += chance(4);
    if (spoiled_once_in(12))
        size -= chance(2);
    return size;
}

static void mend_header(void)
{
    packed.bytes[1] &= 0xe0;
    packed.bytes[1] |= (uint8_t) (31 - (packed.bytes[0] * 256 + packed.bytes[1]) % 31);
}

static void pack(size_t size)
{
    z_stream z = { 0 };
    const int window = plain || once_in(2) ? MAX_WBITS : 9 + (int) chance(7);
    CHECK(deflateInit2(&z, (int) chance(10), Z_DEFLATED, window, 1 + (int) chance(9),
                       (int) chance(5)) == Z_OK);
    z.next_in = raw;
    z.avail_in = (uInt) size;
    z.next_out = packed.bytes;
    z.avail_out = sizeof packed.bytes;
    CHECK(deflate(&z, Z_FINISH) == Z_STREAM_END);
    packed.size = z.total_out;
    deflateEnd(&z);
}

/* Makes the last four bytes the checksum of what zlib unpacks, so that only the stream is wrong. */
static void mend_checksum(void)
{
    static uint8_t out[2 * RAW_MAX];
    z_stream z = { 0 };
    CHECK(inflateInit2(&z, -MAX_WBITS) == Z_OK);
    z.next_in = packed.bytes + 2;
    z.avail_in = (uInt) packed.size - 2;
    z.next_out = out;
    z.avail_out = sizeof out;
    if (inflate(&z, Z_FINISH) == Z_STREAM_END && z.avail_in >= 4) {
        const uint32_t sum = (uint32_t) adler32(1, out, (uInt) z.total_out);
        for (uint32_t i = 0; i < 4; i++)
            packed.bytes[packed.size - z.avail_in + i] = (uint8_t) (sum >> (24 - 8 * i));
    }
    inflateEnd(&z);
}

static void damage_stream(void)
{
    if (once_in(10)) { /* another window than that of the stream */
        packed.bytes[0] = (uint8_t) (chance(9) << 4 | 8);
        mend_header();
    }
    if (once_in(24)) { /* a dictionary */
        packed.bytes[1] |= 0x20;
        mend_header();
    }
    for (uint32_t n = chance(3); n > 0; n--)
        packed.bytes[2 + chance((uint32_t) packed.size - 2)] ^= (uint8_t) (1u << chance(8));
    if (!once_in(4))
        mend_checksum();
    if (once_in(16)) {
        static const uint8_t surplus[SURPLUS];
        put(&packed, surplus, chance(SURPLUS));
    }
    if (once_in(16))
        packed.size -= chance(5);
}

static void put_pixels(void)
{
    const size_t step = once_in(2) ? packed.size : 1 + chance((uint32_t) packed.size + 1);
    for (size_t at = 0; at < packed.size; at += step) {
        chunk(&file, "IDAT", packed.bytes + at, packed.size - at < step ? packed.size - at : step);
        if (once_in(30))
            chunk(&file, "IDAT", "", 0);
        if (spoiled_once_in(60))
            chunk(&file, "tEXt", "between\0pixels", 14);
    }
}

/* More pixels than one picture has, in a chunk by itself.  It may say that it is longer than the
 * file. */
static void put_stray_pixels(void)
{
    static const uint8_t surplus[SURPLUS];
    const size_t at = file.size;
    chunk(&file, "IDAT", surplus, chance(SURPLUS));
    if (once_in(2))
        file.bytes[at] = (uint8_t) chance(256);
}

static void damage_file(void)
{
    if (once_in(10))
        file.bytes[chance((uint32_t) file.size)] ^= (uint8_t) (1u << chance(8));
    if (once_in(20))
        file.size -= chance((uint32_t) file.size);
}

static void make_file(void)
{
    static const uint8_t kinds[] = { 0, 2, 4, 6, 3 }, channels[] = { 1, 3, 2, 4, 1 };
    const uint32_t kind = chance(plain ? 4 : 5), depth = kind < 4 && once_in(2) ? 16 : 8;
    const uint32_t width = 1 + chance(SIDE), height = 1 + chance(once_in(8) ? TALL : SIDE);
    uint8_t head[13] = { 0 };
    head[3] = (uint8_t) width;
    head[6] = (uint8_t) (height >> 8);
    head[7] = (uint8_t) height;
    head[8] = (uint8_t) depth;
    head[9] = kinds[kind];
    head[12] = spoiled_once_in(30); /* interlaced */
    file.size = 0;
    put(&file, "\x89PNG\r\n\x1a\n", 8);
    chunk(&file, "IHDR", head, sizeof head);
    if (kind == 4)
        chunk(&file, "PLTE", "abcdefghijklmnopqrstuvwx", 24);
    if (once_in(3))
        chunk(&file, "gAMA", "\0\0\xb1\x8f", 4);
    if (once_in(3))
        chunk(&file, "tEXt", "before\0pixels", 13);
    if (spoiled_once_in(20))
        chunk(&file, "tRNS", "\0\1\0\2\0\3", kind == 0 ? 2 : 6);
    raw_size = make_rows(width, height, channels[kind] * depth / 8);
    pack(raw_size);
    if (spoiled_once_in(2))
        damage_stream();
    put_pixels();
    if (spoiled_once_in(20))
        put_stray_pixels();
    if (once_in(3))
        chunk(&file, "tEXt", "after\0pixels", 12);
    if (spoiled_once_in(20))
        put_stray_pixels();
    chunk(&file, "IEND", "", 0);
    if (!plain)
        damage_file();
}

/* ------------------------------------------------------------------------ readers */

typedef struct seen {
    bool good;
    ntpio_error error;
    ntpio_info info;
    uint32_t rows;
    uint64_t samples, texts; /* sums */
} seen;

static uint64_t sum_of(uint64_t sum, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        sum = (sum ^ ((const uint8_t *) data)[i]) * 1099511628211u;
    return sum;
}

static ntpio_reader *open_made(uint64_t at_once, bool one_pass, ntpio_error *error)
{
    const ntpio_limits limits = {
        .max_side = 512, .max_memory = 1 << 22, .max_at_once = at_once, .one_pass = one_pass
    };
    return ntpio_open_memory(file.bytes, file.size, "made", &limits, error);
}

/* Reads all rows, `step` at a time. */
static void look_at_rows(seen *s, ntpio_reader *reader, uint32_t step)
{
    static uint8_t rows[STEP_MAX][512 * 8];
    const ntpio_info *i = ntpio_reader_info(reader);
    while (s->good && s->rows < i->height) {
        const uint32_t left = i->height - s->rows, count = left < step ? left : step;
        s->good = ntpio_read_rows(reader, rows, sizeof *rows, count, &s->error);
        for (uint32_t y = 0; y < count; y++)
            s->samples =
                sum_of(s->samples, rows[y], i->width * (size_t) (i->channels * i->sample_bytes));
        s->rows += s->good ? count : 0;
    }
}

static void *unpack_all(void *reader)
{
    while (ntpio_unpack(reader))
        continue;
    return NULL;
}

/* How many parts are unpacked before any row is read; AHEAD: another thread unpacks them meanwhile. */
enum { AHEAD = -1 };

static void look_at_unpacked_rows(seen *s, ntpio_reader *reader, uint32_t step, int parts)
{
    os_thread thread;
    const bool ahead = parts == AHEAD && os_thread_start(&thread, unpack_all, reader) == 0;
    for (int n = 0; n < parts; n++)
        ntpio_unpack(reader);
    look_at_rows(s, reader, step);
    if (ahead)
        os_thread_join(thread);
    CHECK(!ntpio_unpack(reader) || !s->good); /* nothing is left */
}

static seen look_unpacked(uint64_t at_once, bool one_pass, uint32_t step, int parts)
{
    seen s = { 0 };
    ntpio_reader *reader = open_made(at_once, one_pass, &s.error);
    s.good = reader != NULL;
    if (s.good)
        look_at_unpacked_rows(&s, reader, step, parts);
    s.good = s.good && ntpio_read_end(reader, &s.error);
    if (reader != NULL) {
        s.info = *ntpio_reader_info(reader);
        for (size_t i = 0; i < s.info.text_count; i++) {
            const ntpio_text *t = &s.info.texts[i];
            s.texts = sum_of(sum_of(s.texts, t->key, strlen(t->key)), t->value, strlen(t->value));
        }
        s.info.texts = NULL;
    }
    ntpio_close(reader);
    return s;
}

static seen look_so(uint64_t at_once, bool one_pass, uint32_t step)
{
    return look_unpacked(at_once, one_pass, step, 0);
}

/* Reads rows and goes back, as often as the reader can; then all of them, twice. */
static void look_again_and_again(const seen *rows)
{
    static uint8_t some[TALL][SIDE * 8];
    ntpio_error error = { 0 };
    ntpio_reader *reader = open_made(1 << 22, false, &error);
    bool can = reader != NULL && ntpio_rewind(reader);
    const uint32_t height = reader != NULL ? ntpio_reader_info(reader)->height : 0;
    CHECK(!plain || can);
    for (uint32_t n = chance(4); can && n > 0; n--) {
        const bool read = ntpio_read_rows(reader, some, sizeof *some, chance(height + 1), &error);
        CHECK(read || !rows->good);
        can = ntpio_rewind(reader);
        CHECK(can || !plain);
    }
    for (int n = 0; can && n < 2; n++) {
        seen s = { .good = true };
        look_at_rows(&s, reader, 1);
        CHECK(!rows->good || (s.rows == rows->rows && s.samples == rows->samples));
        CHECK(s.good || strcmp(s.error.message, rows->error.message) == 0);
        CHECK(n > 0 || ntpio_read_end(reader, &error) == rows->good || !s.good);
        can = s.good && ntpio_rewind(reader);
        CHECK(can || !plain);
    }
    ntpio_close(reader);
}

static seen look(uint64_t at_once)
{
    return look_so(at_once, false, 1);
}

/* Does a stream deliver all rows?  keeps: twice. */
static bool taken_by_stream(size_t most, bool keeps)
{
    ntpio_reader reader = { .limits = { .max_side = 512,
                                        .max_texels = 1 << 20,
                                        .max_memory = 1 << 22,
                                        .max_at_once = most,
                                        .one_pass = !keeps } };
    static uint8_t rows[TALL][SIDE * 8];
    ntpio__source_memory(&reader.source, file.bytes, file.size);
    ntpio__png_stream *stream = ntpio__png_stream_open(&reader);
    const uint32_t height = (uint32_t) (file.bytes[22] << 8 | file.bytes[23]);
    const bool taken = stream != NULL &&
                       ntpio__png_stream_rows(stream, *rows, sizeof *rows, height, false) == height;
    const bool rewound = taken && ntpio__png_stream_rewind(stream);
    ntpio__png_stream_close(stream);
    return taken && rewound == keeps;
}

static bool same_info(const ntpio_info *a, const ntpio_info *b)
{
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           a->sample_bytes == b->sample_bytes && a->bit_depth == b->bit_depth &&
           a->streams == b->streams && a->interlaced == b->interlaced && a->palette == b->palette &&
           a->alpha == b->alpha && a->has_gama == b->has_gama && a->gamma == b->gamma &&
           a->text_count == b->text_count;
}

/* Where a file ends badly, a row more or less may come before the message. */
static bool same(const seen *a, const seen *b)
{
    return a->good == b->good && a->error.status == b->error.status &&
           strcmp(a->error.message, b->error.message) == 0 &&
           ((a->rows == b->rows && a->samples == b->samples) || !a->good) && a->texts == b->texts &&
           same_info(&a->info, &b->info);
}

static void test_files(void)
{
    uint32_t good = 0, taken = 0;
    for (uint32_t n = 0; n < FILES; n++) {
        plain = n % 4 == 0;
        make_file();
        const seen rows = look(1), once = look(1 << 22), large = look(2);
        const seen parts = look_so(1 << 22, true, 1), fives = look_so(1 << 22, true, STEP_MAX);
        const seen ahead = look_unpacked(1 << 22, false, 1 + chance(STEP_MAX), AHEAD);
        CHECK(ahead.good == rows.good && strcmp(ahead.error.message, rows.error.message) == 0 &&
              (ahead.samples == rows.samples || !rows.good));
        const bool as_good =
            fives.good == rows.good && (fives.samples == rows.samples || !rows.good);
        if (!same(&rows, &once) || !same(&rows, &parts) || !same(&rows, &large) || !as_good) {
            fprintf(stderr, "file %u: \"%s\" row by row, \"%s\" kept, \"%s\" in parts\n", n,
                    rows.error.message, once.error.message, parts.error.message);
            FILE *out = fopen("different.png", "wb");
            CHECK(out != NULL && fwrite(file.bytes, 1, file.size, out) == file.size);
            fclose(out);
            exit(1);
        }
        look_again_and_again(&rows);
        const bool kept = taken_by_stream(1 << 22, true);
        CHECK(!plain || !taken_by_stream(raw_size - 1, true));
        CHECK(!plain || (rows.good && kept));
        CHECK(kept == taken_by_stream(1 << 22, false));
        good += rows.good;
        taken += kept;
    }
    CHECK(good > FILES / 2 && good < FILES * 3 / 4); /* many of each */
    CHECK(taken > FILES / 3);
}

/* Repetitions of what was as far before as they may reach, in a picture of many parts.  Files are cut
 * off; at last, a row has a filter that does not exist, which shows while parts are unpacked. */
static void test_far_repetitions(void)
{
    enum { CUT = 60, ALL = CUT + 20 };
    enum { WIDTH = 511, HEIGHT = 300, ROW = WIDTH * 6 + 1, DISTANCE = 32000, MOST = HEIGHT * ROW };
    static const uint8_t head[13] = { 0, 0,           WIDTH >> 8,   WIDTH & 255, 0,
                                      0, HEIGHT >> 8, HEIGHT & 255, 16,          2 };
    static uint8_t large[MOST];
    for (size_t i = 0; i < MOST; i++) {
        large[i] = i < DISTANCE || once_in(200) ? (uint8_t) chance(256) : large[i - DISTANCE];
        if (i % ROW == 0)
            large[i] = (uint8_t) chance(NTPIO__FILTERS);
    }
    for (size_t cut = 0; cut < ALL; cut++) {
        uLongf size = sizeof packed.bytes;
        if (cut == CUT)
            large[ROW * (HEIGHT / 4)] = NTPIO__FILTERS;
        if (cut == 0 || cut == CUT)
            CHECK(compress2(packed.bytes, &size, large, MOST, 6) == Z_OK);
        packed.size = cut == 0 || cut == CUT ? size : packed.size;
        file.size = 0;
        put(&file, "\x89PNG\r\n\x1a\n", 8);
        chunk(&file, "IHDR", head, sizeof head);
        plain = cut == 0;
        put_pixels();
        chunk(&file, "IEND", "", 0);
        file.size -= cut == 0 || cut >= CUT ? 0 : chance((uint32_t) file.size - 100);
        const seen rows = look_so(1, false, 1), kept = look_so(1 << 22, false, 1);
        const seen parts = look_so(1 << 22, true, STEP_MAX);
        CHECK(rows.good == plain && same(&rows, &kept));
        for (int unpacked = AHEAD; unpacked < 30; unpacked += 1 + (int) chance(12)) {
            const seen ahead = look_unpacked(1 << 22, false, 1, unpacked);
            CHECK(same(&rows, &ahead));
        }
        CHECK(parts.good == plain && (!plain || parts.samples == rows.samples));
        CHECK(plain || strcmp(parts.error.message, rows.error.message) == 0);
    }
}

/* One row of zeros: its filter, then a repetition of 258 bytes.  285 says so; 286, which zlib
 * refuses, says so to libdeflate. */
static void make_file_of_repetition(uint32_t code)
{
    static const uint8_t head[13] = { 0, 0, 1, 2, 0, 0, 0, 1, 8 };
    static const uint8_t sum[4] = { 1, 3, 0, 1 }; /* of 259 zeros */
    const uint32_t words[][2] = { { 1, 1 }, { 2, 2 }, { 0x30, 8 }, { 0xc0 + code - 280, 8 },
                                  { 0, 5 }, { 0, 7 } }; /* first bits first; 2, 2: fixed codes */
    uint8_t bits[8] = { 0 };
    size_t count = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        for (uint32_t k = words[i][1]; k-- > 0; count++)
            bits[count / 8] |= (uint8_t) ((words[i][0] >> k & 1) << count % 8);
    }
    packed.size = 0;
    put(&packed, "\x78\x01", 2);
    put(&packed, bits, (count + 7) / 8);
    put(&packed, sum, sizeof sum);
    file.size = 0;
    put(&file, "\x89PNG\r\n\x1a\n", 8);
    chunk(&file, "IHDR", head, sizeof head);
    chunk(&file, "IDAT", packed.bytes, packed.size);
    chunk(&file, "IEND", "", 0);
}

static void test_forbidden_code(void)
{
    for (uint32_t code = 285; code <= 287; code++) {
        make_file_of_repetition(code);
        const seen rows = look(1), once = look(1 << 22), parts = look_so(1 << 22, true, 1);
        CHECK(rows.good == (code == 285));
        CHECK(same(&rows, &once) && same(&rows, &parts));
    }
}

int main(void)
{
    test_files();
    test_far_repetitions();
    test_forbidden_code();
    return 0;
}
