/* SPDX-License-Identifier: MIT */
/*
 * png_whole.c - all pixels of a PNG at once
 *
 * Who reads rows twice gets them from memory the second time.  libpng still reads everything else:
 * it gets a copy of the file whose pixels are an empty stream.  A file counts as faultless only if
 * libpng would take it without an error or a warning about pixels: checksums are right, the stream
 * ends where the chunks and the last row end, and it reaches no further back than its header says.
 *
 * libdeflate would be up to a tenth faster where few codes are literals, but reads codes that RFC
 * 1951 forbids and zlib refuses: lengths 286 and 287, the free half of a code of one word, more than
 * 286 and 30 codes.  Its checksums are taken.
 */
#include "png_whole.h"

#include <stdlib.h>
#include <string.h>

#include "inflate.h"
#include "os/memory.h"
#include "png_filter.h"
#include "png_sums.h"

const uint8_t ntpio__no_pixels[NTPIO__NO_PIXELS_SIZE] = { 0,   0,    0,    8,    'I',  'D', 'A',
                                                          'T', 0x78, 0x9c, 0x03, 0x00, 0,   0,
                                                          0,   1,    0x48, 0x06, 0x89, 0xd2 };

enum {
    SIGNATURE = 8,
    CHUNK_HEAD = 8,
    CHUNK = 12, /* length, name, checksum */
    HEADER = 13,
    ZLIB_HEADER = 2,
    CHECKSUM = 4,
    PART = 1 << 17,
    DENSEST = 1032 /* deflate makes at most so many bytes of one */
};

typedef struct parts {
    const uint8_t *file;
    size_t size, pixels_from, pixels_to; /* the IDAT chunks, whole */
    size_t packed;                       /* bytes in them */
    ntpio__png_shape shape;
} parts;

typedef struct unpacking {
    uint8_t *rows, *out, *end;
    uint32_t sum;
    bool ends; /* the stream, well or not */
    ntpio__inflate inflate;
    uint8_t last[2 * NTPIO__IN_SLACK]; /* bytes of the stream */
} unpacking;

/* Is a whole chunk at `at`?  *size: with its 12 bytes around the data. */
static bool chunk_at(const parts *p, size_t at, size_t *size)
{
    if (p->size - at < CHUNK)
        return false;
    *size = (size_t) ntpio__png_number(p->file + at) + CHUNK;
    return *size <= p->size - at;
}

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
    const parts p = { .file = chunks, .size = size };
    size_t at = 0, whole;
    while (chunk_at(&p, at, &whole) && !ntpio__png_is(chunks + at, "IDAT"))
        at += whole;
    return size - at >= CHUNK_HEAD && ntpio__png_is(chunks + at, "IDAT");
}

/* Finds the IDAT chunks: one after the other, each with the right checksum, and no other. */
static bool find_pixels(parts *p)
{
    size_t at = SIGNATURE, size;
    for (; chunk_at(p, at, &size) && !ntpio__png_is(p->file + at, "IDAT"); at += size) {
        if (ntpio__png_is(p->file + at, "tRNS"))
            return false;
    }
    p->pixels_from = at;
    for (; chunk_at(p, at, &size) && ntpio__png_is(p->file + at, "IDAT"); at += size) {
        if (!checksum_is_right(p->file + at, size))
            return false;
        p->packed += size - CHUNK;
    }
    p->pixels_to = at;
    return p->packed > ZLIB_HEADER + CHECKSUM && !ntpio__png_has_pixels(p->file + at, p->size - at);
}

bool ntpio__png_zlib_header(const uint8_t *packed, uint64_t size)
{
    enum { DEFLATE = 8, WINDOW_MOST = 7, DICTIONARY = 0x20 };
    const unsigned kind = packed[0] & 15, window = packed[0] >> 4;
    return kind == DEFLATE && window <= WINDOW_MOST && (packed[0] * 256 + packed[1]) % 31 == 0 &&
           (packed[1] & DICTIONARY) == 0 &&
           (window == WINDOW_MOST || size <= (uint64_t) 256 << window);
}

static uint64_t size_of(const ntpio__png_shape *shape)
{
    return ((uint64_t) shape->row_size + 1) * shape->height;
}

static uint64_t raw_size(const parts *p)
{
    return size_of(&p->shape);
}

static uint64_t most_at_once(const ntpio_limits *limits)
{
    return limits->max_at_once < limits->max_memory ? limits->max_at_once : limits->max_memory;
}

static bool is_small(const parts *p, const ntpio_limits *limits)
{
    const ntpio__png_shape *shape = &p->shape;
    return shape->width <= limits->max_side && shape->height <= limits->max_side &&
           shape->width <= limits->max_texels / shape->height &&
           raw_size(p) <= most_at_once(limits) && raw_size(p) / DENSEST <= p->packed;
}

bool ntpio__png_is_large(ntpio_reader *reader)
{
    enum { HEAD = SIGNATURE + CHUNK + HEADER };
    ntpio__source *source = &reader->source;
    ntpio__png_shape shape;
    uint64_t size;
    const size_t peeked = ntpio__peek(source, HEAD);
    return ntpio__png_shape_of(&shape, source->bytes + source->at, peeked) &&
           ((ntpio__can_seek(source) && ntpio__size(source, &size) &&
             size > reader->limits.max_at_once) ||
            size_of(&shape) > most_at_once(&reader->limits));
}

/* The data of all IDAT chunks as one.  They move together if the file is a copy of ours. */
static const uint8_t *join(const parts *p, uint8_t *file, uint8_t **memory)
{
    if (p->pixels_to - p->pixels_from == p->packed + CHUNK)
        return p->file + p->pixels_from + 8;
    uint8_t *first = file != NULL ? file + p->pixels_from : malloc(p->packed), *out = first;
    *memory = file != NULL ? NULL : first;
    for (size_t at = p->pixels_from, size; first != NULL && at < p->pixels_to; at += size) {
        size = (size_t) ntpio__png_number(p->file + at) + CHUNK;
        memmove(out, p->file + at + 8, size - CHUNK);
        out += size - CHUNK;
    }
    return first;
}

/* Unpacks a part that stays in the cache until its checksum is made.  False: a fault or the end. */
static bool unpack_part(unpacking *u)
{
    ntpio__inflate *in = &u->inflate;
    const size_t left = (size_t) (u->end - u->out);
    const uint8_t *from = u->out, *most = u->out + (left < PART ? left : PART) + NTPIO__OUT_SLACK;
    ntpio__inflated now = ntpio__inflate_some(in, u->rows, &u->out, most);
    if (now == NTPIO__NEEDS_INPUT && !in->no_more) { /* the last bytes, with slack behind them */
        const size_t some = (size_t) (in->in_end - in->in);
        memcpy(u->last, in->in, some);
        in->in = u->last;
        in->in_end = u->last + some;
        in->no_more = true;
        now = ntpio__inflate_some(in, u->rows, &u->out, most);
    }
    u->ends = now == NTPIO__STREAM_ENDS;
    if (now == NTPIO__STREAM_BAD || u->out > u->end)
        return false;
    u->sum = ntpio__adler32(u->sum, from, (size_t) (u->out - from));
    return !u->ends;
}

static bool unpack_all(unpacking *u, const parts *p, const uint8_t *packed, uint8_t *rows)
{
    const size_t size = (size_t) raw_size(p);
    ntpio__inflate *in = &u->inflate;
    memset(in, 0, offsetof(ntpio__inflate, literals));
    memset(u->last, 0, sizeof u->last);
    in->in = packed + ZLIB_HEADER;
    in->in_end = packed + p->packed;
    u->rows = u->out = rows;
    u->end = rows + size;
    u->sum = 1;
    u->ends = false;
    while (unpack_part(u))
        continue;
    const uint8_t *sum = u->ends ? ntpio__inflate_end(in) : NULL;
    return sum != NULL && u->out == u->end && in->in_end - sum == CHECKSUM &&
           ntpio__png_number(sum) == u->sum;
}

static bool unpack(const parts *p, const uint8_t *packed, uint8_t *rows)
{
    unpacking *u = malloc(sizeof *u);
    const bool good =
        u != NULL && ntpio__png_zlib_header(packed, raw_size(p)) && unpack_all(u, p, packed, rows);
    free(u);
    for (uint32_t y = 0; good && y < p->shape.height; y++) {
        if (rows[y * (p->shape.row_size + 1)] >= NTPIO__FILTERS)
            return false;
    }
    return good;
}

static uint8_t *shell_of(const parts *p, size_t *size)
{
    const size_t before = p->pixels_from, after = p->size - p->pixels_to;
    *size = before + NTPIO__NO_PIXELS_SIZE + after;
    uint8_t *shell = malloc(*size);
    if (shell == NULL)
        return NULL;
    memcpy(shell, p->file, before);
    memcpy(shell + before, ntpio__no_pixels, NTPIO__NO_PIXELS_SIZE);
    memcpy(shell + before + NTPIO__NO_PIXELS_SIZE, p->file + p->pixels_to, after);
    return shell;
}

/* `file`: the same bytes, if they may be changed, or NULL. */
static bool take_file(ntpio__png_whole *whole, parts *p, uint8_t *file, const ntpio_limits *limits)
{
    uint8_t *memory = NULL;
    if (!ntpio__png_shape_of(&p->shape, p->file, p->size) || !find_pixels(p) ||
        !is_small(p, limits))
        return false;
    whole->texel = p->shape.texel;
    whole->height = p->shape.height;
    whole->row_size = p->shape.row_size;
    whole->rows = os_alloc_large((size_t) raw_size(p) + NTPIO__OUT_SLACK);
    const uint8_t *packed = whole->rows != NULL ? join(p, file, &memory) : NULL;
    whole->packed_hard = packed != NULL && ntpio__png_packed_hard(packed[1]);
    if (packed != NULL && unpack(p, packed, whole->rows))
        whole->shell = shell_of(p, &whole->shell_size);
    free(memory);
    return whole->shell != NULL;
}

static uint8_t *read_file(ntpio__source *source, size_t size)
{
    uint8_t *file = os_alloc_large(size);
    if (file != NULL && ntpio__read(source, file, size) == size)
        return file;
    free(file);
    return NULL;
}

static bool take(ntpio__png_whole *whole, ntpio_reader *reader, size_t size)
{
    ntpio__source *source = &reader->source;
    uint8_t *copy = source->file != NULL ? read_file(source, size) : NULL;
    parts p = { .file = source->file != NULL ? copy : source->bytes, .size = size };
    const bool taken = p.file != NULL && take_file(whole, &p, copy, &reader->limits);
    free(copy);
    return taken;
}

bool ntpio__png_take(ntpio__png_whole *whole, ntpio_reader *reader)
{
    ntpio__source *source = &reader->source;
    uint64_t size;
    memset(whole, 0, sizeof *whole);
    if (!ntpio__can_seek(source) || !ntpio__size(source, &size) ||
        size > reader->limits.max_at_once)
        return false;
    if (take(whole, reader, (size_t) size))
        return true;
    ntpio__png_drop(whole);
    source->problem = 0;
    ntpio__seek(source, 0);
    return false;
}

void ntpio__png_take_row(ntpio__png_whole *whole, uint8_t *dst, bool swap)
{
    const size_t size = whole->row_size;
    uint8_t *row = whole->rows + whole->row * (size + 1) + 1;
    const uint8_t *above = whole->row > 0 ? row - (size + 1) : NULL;
    if (whole->row == whole->undone) {
        const uint32_t left = whole->height - whole->undone;
        const uint32_t count = left < NTPIO__ROWS_TOGETHER ? left : NTPIO__ROWS_TOGETHER;
        int kinds[NTPIO__ROWS_TOGETHER];
        for (uint32_t k = 0; k < count; k++)
            kinds[k] = row[k * (size + 1) - 1];
        whole->undone += ntpio__unfilter_rows(row, (ptrdiff_t) size + 1, count, above, size,
                                              whole->texel, kinds);
    }
    whole->row++;
    if (!swap)
        memcpy(dst, row, size);
    for (size_t i = 0; swap && i < size; i += 2) {
        dst[i] = row[i + 1];
        dst[i + 1] = row[i];
    }
}

void ntpio__png_drop(ntpio__png_whole *whole)
{
    free(whole->rows);
    free(whole->shell);
    memset(whole, 0, sizeof *whole);
}
