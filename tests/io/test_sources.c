/* SPDX-License-Identifier: MIT */
/*
 * test_sources.c - the same image from memory, a file, a pipe and standard input; limits; texts
 * before and after the pixels; names that do not print; which version was read
 */
#include "../system.h"
#include "made.h"
#include "ntpio.h"

enum { SIDE = 24, BESIDE = 7, MARK = 0xa5 };

typedef struct result {
    bool good;
    ntpio_error error;
    ntpio_info info; /* without texts */
    uint8_t rows[SIDE * SIDE * 16];
} result;

static made file;
static result from_memory, from_other;

/* Reads in steps of `step` rows, each followed by bytes that must stay; a negative step reads
 * into rows that go up in memory. */
static void read_rows(ntpio_reader *reader, uint32_t step, bool upward, result *r)
{
    r->good = reader != NULL;
    if (!r->good)
        return;
    r->info = *ntpio_reader_info(reader);
    const size_t row = (size_t) r->info.width * (size_t) (r->info.channels * r->info.sample_bytes);
    const size_t stride = row + BESIDE;
    uint8_t *part = malloc(stride * step);
    CHECK(part != NULL && row * r->info.height <= sizeof r->rows);
    for (uint32_t y = 0; r->good && y < r->info.height; y += step) {
        const uint32_t count = r->info.height - y < step ? r->info.height - y : step;
        memset(part, MARK, stride * step);
        r->good = upward ? ntpio_read_rows(reader, part + (count - 1) * stride, -(ptrdiff_t) stride,
                                           count, &r->error)
                         : ntpio_read_rows(reader, part, (ptrdiff_t) stride, count, &r->error);
        for (uint32_t i = 0; r->good && i < count; i++) {
            const uint8_t *from = part + (upward ? count - 1 - i : i) * stride;
            memcpy(r->rows + (y + i) * row, from, row);
            for (size_t k = row; k < stride; k++)
                CHECK(from[k] == MARK);
        }
    }
    free(part);
    r->good = r->good && ntpio_read_end(reader, &r->error);
}

static void same(const char *what)
{
    const ntpio_info *a = &from_memory.info, *b = &from_other.info;
    if (!from_memory.good || !from_other.good || a->width != b->width || a->height != b->height ||
        a->channels != b->channels || a->sample_bytes != b->sample_bytes || a->alpha != b->alpha ||
        a->bit_depth != b->bit_depth ||
        memcmp(from_memory.rows, from_other.rows, sizeof from_memory.rows) != 0) {
        fprintf(stderr, "%s: %s%s\n", what, from_memory.error.message, from_other.error.message);
        exit(1);
    }
}

static void write_path(const char *path)
{
    FILE *out = fopen(path, "wb");
    CHECK(out != NULL && fwrite(file.bytes, 1, file.size, out) == file.size);
    CHECK(fclose(out) == 0);
}

/* A pipe that holds the file and has ended. */
static int full_pipe(void)
{
    int ends[2];
    CHECK(system_pipe(ends) && file.size < 60000);
    CHECK(write(ends[1], file.bytes, (unsigned) file.size) == (int) file.size);
    CHECK(close(ends[1]) == 0);
    return ends[0];
}

static ntpio_reader *open_at(const char *path)
{
    return ntpio_open(path, NULL, &from_other.error);
}

static void read_other(ntpio_reader *reader, uint32_t step, bool upward)
{
    memset(from_other.rows, 0, sizeof from_other.rows);
    read_rows(reader, step, upward, &from_other);
    ntpio_close(reader);
}

static void everywhere(const char *what)
{
    char name[40];
    ntpio_reader *reader =
        ntpio_open_memory(file.bytes, file.size, "x.tga", NULL, &from_memory.error);
    memset(from_memory.rows, 0, sizeof from_memory.rows);
    read_rows(reader, 1, false, &from_memory);
    ntpio_close(reader);
    for (uint32_t step = 2; step < 2 * SIDE; step += 3) {
        reader = ntpio_open_memory(file.bytes, file.size, "x.tga", NULL, &from_other.error);
        read_other(reader, step, step % 2 == 0);
        same(what);
    }
    write_path("x.tga");
    read_other(open_at("x.tga"), 5, false);
    same(what);
    CHECK(unlink("x.tga") == 0);
    if (!SYSTEM_NAMES_PIPES)
        return;
    int fd = full_pipe();
    snprintf(name, sizeof name, "/dev/fd/%d", fd);
    read_other(open_at(name), 5, false);
    same(what);
    close(fd);
}

/* Once: standard input ends for good. */
static void standard_input(void)
{
    int fd = full_pipe();
    CHECK(dup2(fd, STDIN_FILENO) >= 0 && close(fd) == 0 && system_binary_input());
    read_other(open_at("-"), 4, false);
    same("standard input");
    CHECK(open_at("-") == NULL);
    CHECK(strncmp(from_other.error.message, "standard input: ", 16) == 0);
}

static void make_png(uint32_t height, int depth, int kind, int lace)
{
    static const uint32_t passes[7][4] = { { 0, 0, 8, 8 }, { 4, 0, 8, 8 }, { 0, 4, 4, 8 },
                                           { 2, 0, 4, 4 }, { 0, 2, 2, 4 }, { 1, 0, 2, 2 },
                                           { 0, 1, 1, 2 } };
    static const uint32_t whole[4] = { 0, 0, 1, 1 };
    static const uint32_t channels[] = { 1, 0, 3, 1, 2, 0, 4 };
    static uint8_t raw[1 << 16];
    size_t size = 0;
    png_start(&file, SIDE - 1, height, depth, kind, lace);
    for (int pass = 0; pass < (lace ? 7 : 1); pass++)
        size += pass_rows(raw + size, SIDE - 1, height, depth, channels[kind],
                          lace ? passes[pass] : whole);
    pixels(&file, raw, size);
    chunk(&file, "IEND", "", 0);
}

/* Of `bits` of color, without alpha bits in the header; alpha: the byte of all texels. */
static void make_tga(uint8_t bits, uint8_t origin, bool rle, int alpha)
{
    uint8_t head[18] = { [2] = rle ? 10 : 2, [12] = SIDE, [14] = SIDE, [16] = bits, [17] = origin };
    const uint32_t bytes = bits / 8u;
    file.size = 0;
    put(&file, head, sizeof head);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint8_t texel[4];
        for (uint32_t c = 0; c < 4; c++)
            texel[c] = (uint8_t) sample(i, 2, c, 8);
        if (alpha >= 0)
            texel[3] = (uint8_t) (i + 1 == SIDE * SIDE ? alpha : 0);
        if (rle && i % 96 == 0) /* packets of four rows */
            put(&file, "\x5f", 1);
        put(&file, texel, bytes);
    }
}

static void sources(void)
{
    for (int lace = 0; lace < 2; lace++)
        for (int depth = 8; depth <= 16; depth += 8) {
            make_png(SIDE, depth, 2, lace);
            everywhere("RGB");
            make_png(1, depth, 6, lace);
            everywhere("RGBA of one row");
        }
    for (int origin = 0; origin < 0x40; origin += 0x10)
        for (int rle = 0; rle < 2; rle++) {
            make_tga(24, (uint8_t) origin, rle, -1);
            everywhere("TGA of 24 bits");
            make_tga(32, (uint8_t) origin, rle, 0); /* no alpha anywhere: there is none */
            everywhere("TGA of 32 bits without alpha");
            CHECK(from_memory.info.channels == 3 && !from_memory.info.alpha);
            make_tga(32, (uint8_t) origin, rle, 1); /* one texel has some: all have */
            everywhere("TGA of 32 bits with alpha");
            CHECK(from_memory.info.channels == 4 && from_memory.info.alpha);
        }
    file.size = 0;
    put(&file, "PF\n24 24\n-1.0\n", 14);
    for (uint32_t i = 0; i < SIDE * SIDE * 3; i++) {
        uint8_t bytes[4];
        for (uint32_t c = 0; c < 4; c++)
            bytes[c] = (uint8_t) sample(i, 3, c, 8);
        put(&file, bytes, 4);
    }
    everywhere("PFM");
    standard_input();
}

static ntpio_status status_of(const ntpio_limits *limits)
{
    ntpio_error error = { NTPIO_OK, "" };
    ntpio_close(ntpio_open_memory(file.bytes, file.size, "x.tga", limits, &error));
    return error.status;
}

static void limits(void)
{
    const ntpio_limits fits = { .max_side = SIDE,
                                .max_texels = SIDE * SIDE,
                                .max_memory = SIDE * SIDE * 4 };
    const ntpio_limits side = { .max_side = SIDE - 2 },
                       texels = { .max_texels = (SIDE - 1) * SIDE - 1 };
    const ntpio_limits memory = { .max_memory = 1000 };
    for (int lace = 0; lace < 2; lace++) {
        make_png(SIDE, 8, 2, lace);
        CHECK(status_of(&fits) == NTPIO_OK);
        CHECK(status_of(&side) == NTPIO_ERR_LIMIT && status_of(&texels) == NTPIO_ERR_LIMIT);
        CHECK(status_of(&memory) == (lace ? NTPIO_ERR_LIMIT : NTPIO_OK)); /* held whole, or streamed
                                                                           * */
    }
    make_tga(24, 0, true, -1);
    CHECK(status_of(&fits) == NTPIO_OK && status_of(&memory) == NTPIO_ERR_LIMIT);
    CHECK(status_of(&side) == NTPIO_ERR_LIMIT && status_of(&texels) == NTPIO_ERR_LIMIT);
    /* Sizes that no memory holds are refused before anything is allocated for them. */
    png_start(&file, 0x7fffffff, 0x7fffffff, 16, 6, 1);
    chunk(&file, "IDAT", "", 0);
    CHECK(status_of(NULL) == NTPIO_ERR_LIMIT);
    static const char *const heads[] = { "PF 99999999999999999999 1 -1\n", "PF 65535 65535 1\n",
                                         "Pf 65536 1 1.0\n" };
    for (size_t i = 0; i < 3; i++) {
        file.size = 0;
        put(&file, heads[i], strlen(heads[i]));
        CHECK(status_of(NULL) == NTPIO_ERR_LIMIT || status_of(NULL) == NTPIO_ERR_CORRUPT);
    }
}

/* Zeros of a string belong to the body. */
#define BODY(kind, body) chunk(&file, kind, body, sizeof body - 1)

static void texts(void)
{
    static const uint8_t rows[] = { 0, 10, 20, 0, 30, 40 };
    png_start(&file, 2, 2, 8, 0, 0);
    BODY("gAMA", "\0\0\xb1\x8f");
    BODY("sRGB", "\0");
    BODY("iCCP", "x\0\0\x78\x9c\x03\0\0\0\0\x01"); /* an empty profile: it exists, nothing more */
    BODY("pHYs", "\0\0\x0b\x13\0\0\x0b\x14\1");
    BODY("tEXt", "Author\0\xc9mile");
    BODY("zTXt", "Comment\0\0\x78\x01\x01\x06\0\xf9\xffzipped\x09\x2d\x02\x8d"); /* stored */
    pixels(&file, rows, sizeof rows);
    BODY("iTXt", "Title\0\0\0fr\0Titre\0gr\xc3\xbc\xc3\x9f");
    chunk(&file, "IEND", "", 0);

    ntpio_error error = { NTPIO_OK, "" };
    uint8_t got[4];
    ntpio_reader *reader = ntpio_open_memory(file.bytes, file.size, "x.png", NULL, &error);
    CHECK(reader != NULL);
    const ntpio_info *info = ntpio_reader_info(reader);
    CHECK(info->text_count == 2);
    CHECK(ntpio_read_rows(reader, got, 2, 2, &error) && ntpio_read_end(reader, &error));
    CHECK(got[0] == 10 && got[1] == 20 && got[2] == 30 && got[3] == 40);
    CHECK(info->has_gama && info->gamma > 0.45454 && info->gamma < 0.45456);
    CHECK(info->has_srgb && info->has_iccp && !info->has_chrm);
    CHECK(info->has_phys && info->phys_x == 2835 && info->phys_y == 2836 && info->phys_unit == 1);
    CHECK(info->text_count == 3); /* the last one follows the pixels */
    const ntpio_text *t = info->texts;
    CHECK(strcmp(t[0].key, "Author") == 0 && strcmp(t[0].value, "\xc9mile") == 0);
    CHECK(!t[0].itxt && !t[0].compressed);
    CHECK(strcmp(t[1].key, "Comment") == 0 && strcmp(t[1].value, "zipped") == 0);
    CHECK(!t[1].itxt && t[1].compressed);
    CHECK(strcmp(t[2].key, "Title") == 0 && strcmp(t[2].value, "gr\xc3\xbc\xc3\x9f") == 0);
    CHECK(t[2].itxt && !t[2].compressed && strcmp(t[2].language, "fr") == 0);
    CHECK(strcmp(t[2].translated_key, "Titre") == 0);
    ntpio_close(reader);
}

static void names(void)
{
    char path[5000];
    ntpio_error error;
    memset(path, 'x', sizeof path);
    memcpy(path, "a\x1b[31m\n\xff\xc0\x80\xed\xa0\x80\xc2\x9b\x7f", 17);
    for (size_t size = 17; size < sizeof path; size += 311) {
        path[size] = 0;
        CHECK(ntpio_open(path, NULL, &error) == NULL && error.status == NTPIO_ERR_OPEN);
        CHECK(strlen(error.message) < sizeof error.message);
        for (const char *s = error.message; *s != 0; s++)
            CHECK(*s >= 0x20 && *s < 0x7f);
        path[size] = 'x';
    }
    CHECK(ntpio_open("gr\xc3\xbc\xc3\x9f.png", NULL, &error) == NULL);
    CHECK(strncmp(error.message, "gr\xc3\xbc\xc3\x9f.png: ", 12) == 0);
    CHECK(ntpio_open(".", NULL, &error) == NULL && error.status == NTPIO_ERR_OPEN);
}

static void append(const char *path, const void *bytes, size_t size)
{
    FILE *out = fopen(path, "ab");
    CHECK(out != NULL && fwrite(bytes, 1, size, out) == size && fclose(out) == 0);
}

static void stamps(void)
{
    const ntpio_limits regular = { .regular_only = true };
    const ntpio_stamp none = { .known = false };
    ntpio_error error;
    make_png(SIDE, 8, 2, 0);
    append("a.png", file.bytes, file.size);
    ntpio_reader *reader = ntpio_open("a.png", &regular, &error);
    CHECK(reader != NULL);
    const ntpio_stamp stamp = ntpio_reader_info(reader)->stamp;
    CHECK(stamp.known && stamp.size == file.size && ntpio_is_current("a.png", &stamp));
    CHECK(ntpio_is_current("none", &none) && !ntpio_is_current("none", &stamp));
    append("b.png", file.bytes, file.size);
    CHECK(!ntpio_is_current("b.png", &stamp));
    append("a.png", "x", 1);
    CHECK(!ntpio_is_current("a.png", &stamp));
    ntpio_close(reader);
    reader = ntpio_open_memory(file.bytes, file.size, "a.png", NULL, &error);
    CHECK(reader != NULL && !ntpio_reader_info(reader)->stamp.known);
    ntpio_close(reader);
    CHECK(unlink("a.png") == 0 && unlink("b.png") == 0);
    if (!SYSTEM_NAMES_PIPES)
        return;
    CHECK(system_make_pipe("pipe.png")); /* nobody writes into it */
    CHECK(ntpio_open("pipe.png", &regular, &error) == NULL && error.status == NTPIO_ERR_OPEN);
    CHECK(unlink("pipe.png") == 0);
}

int main(void)
{
    CHECK(system_enter_folder());
    sources();
    limits();
    texts();
    names();
    stamps();
    CHECK(system_leave_folder());
    return 0;
}
