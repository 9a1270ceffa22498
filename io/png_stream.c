/* SPDX-License-Identifier: MIT */
/*
 * png_stream.c - the rows of a PNG in little memory
 *
 * Data of IDAT chunks go into `packed`, and are unpacked into `room`: the window of deflate, then
 * rows that were not taken.  Rows are copied to the caller before their filters are undone, since
 * the window holds filtered bytes.  The last row is delivered only if the stream ends well: with
 * its checksum, where the chunks end, and with what follows them.
 */
#include "png_stream.h"

#include <stdlib.h>

#include "inflate.h"
#include "png_filter.h"
#include "png_sums.h"
#include "png_whole.h"

enum {
    HEAD_MAX = 1 << 16, /* before the first IDAT chunk */
    TAIL_MAX = 1 << 16, /* after the last one */
    ROW_MAX = 1 << 20,
    PACKED_SIZE = 1 << 15,
    ROOM_SIZE = 1 << 16, /* at least, besides the window */
    CHUNK_HEAD = 8,
    CHECKSUM = 4,
    SIGNATURE = 8
};

struct ntpio__png_stream {
    ntpio__source *source;
    ntpio__png_shape shape;
    uint8_t *shell;
    size_t shell_size;
    bool packed_hard, faulty;
    uint64_t left;             /* bytes that are not unpacked */
    uint32_t row, chunk_left;  /* the next one; bytes left of this chunk */
    uint32_t chunk_sum, sum;   /* of this chunk so far; of all that was unpacked */
    uint8_t after[CHUNK_HEAD]; /* the first bytes after the chunks */
    size_t after_size;
    uint8_t *room, *from, *to, *room_end; /* from: the first row that is not taken; to: its end */
    uint8_t *above;                       /* the row before `row` */
    ntpio__inflate inflate;
    uint8_t packed[PACKED_SIZE + NTPIO__IN_SLACK];
};

/* -------------------------------------------------------------------------- chunks */

/* The checksum of one chunk, and the head of the next one.  False: a fault. */
static bool next_chunk(ntpio__png_stream *s)
{
    uint8_t sum[CHECKSUM];
    if (ntpio__read(s->source, sum, CHECKSUM) != CHECKSUM || ntpio__png_number(sum) != s->chunk_sum)
        return false;
    s->after_size = ntpio__read(s->source, s->after, CHUNK_HEAD);
    s->inflate.no_more = s->after_size < CHUNK_HEAD || !ntpio__png_is(s->after, "IDAT");
    s->chunk_left = ntpio__png_number(s->after);
    s->chunk_sum = ntpio__crc32(0, s->after + 4, 4);
    return s->inflate.no_more || s->chunk_left <= INT32_MAX;
}

/* Fills `packed` with what comes.  False: a fault. */
static bool fill(ntpio__png_stream *s)
{
    ntpio__inflate *in = &s->inflate;
    size_t used = (size_t) (in->in_end - in->in);
    memmove(s->packed, in->in, used);
    while (used < PACKED_SIZE && !in->no_more) {
        size_t some = PACKED_SIZE - used;
        some = some < s->chunk_left ? some : s->chunk_left;
        if (ntpio__read(s->source, s->packed + used, some) != some)
            return false;
        s->chunk_sum = ntpio__crc32(s->chunk_sum, s->packed + used, some);
        s->chunk_left -= (uint32_t) some;
        used += some;
        if (s->chunk_left == 0 && !next_chunk(s))
            return false;
    }
    in->in = s->packed;
    in->in_end = s->packed + used;
    memset(s->packed + used, 0, NTPIO__IN_SLACK);
    return true;
}

/* ------------------------------------------------------------------------- pixels */

/* Makes room: the window stays, and what was not taken. */
static void compact(ntpio__png_stream *s)
{
    uint8_t *keep = s->to - s->room > NTPIO__WINDOW ? s->to - NTPIO__WINDOW : s->room;
    keep = keep < s->from ? keep : s->from;
    const size_t gone = (size_t) (keep - s->room);
    memmove(s->room, keep, (size_t) (s->to - keep));
    s->from -= gone;
    s->to -= gone;
}

/* Unpacks more bytes; *ends: there are no more.  False: a fault. */
static bool unpack(ntpio__png_stream *s, bool *ends)
{
    if (s->room_end - s->to < NTPIO__OUT_SLACK)
        compact(s);
    uint8_t *out = s->to;
    const ntpio__inflated now = ntpio__inflate_some(&s->inflate, s->room, &out, s->room_end);
    const size_t size = (size_t) (out - s->to);
    if (now == NTPIO__STREAM_BAD || size > s->left)
        return false;
    s->sum = ntpio__adler32(s->sum, s->to, size);
    s->left -= size;
    s->to = out;
    *ends = now == NTPIO__STREAM_ENDS;
    return now != NTPIO__NEEDS_INPUT || fill(s);
}

/* Do the stream and its chunks end here, and as they should? */
static bool ends_well(ntpio__png_stream *s)
{
    ntpio__inflate *in = &s->inflate;
    bool ends = false;
    while (!ends) {
        if (!unpack(s, &ends))
            return false;
    }
    in->in = ntpio__inflate_end(in);
    while (!in->no_more) {
        if (in->in_end - in->in > CHECKSUM || !fill(s))
            return false;
    }
    return s->left == 0 && in->in_end - in->in == CHECKSUM && ntpio__png_number(in->in) == s->sum;
}

/* Adds what follows the pixels to the shell. */
static bool take_tail(ntpio__png_stream *s)
{
    uint8_t *grown = realloc(s->shell, s->shell_size + s->after_size + TAIL_MAX);
    if (grown == NULL)
        return false;
    s->shell = grown;
    uint8_t *tail = s->shell + s->shell_size;
    memcpy(tail, s->after, s->after_size);
    const size_t size = ntpio__read(s->source, tail + s->after_size, TAIL_MAX);
    s->shell_size += s->after_size + size;
    return size < TAIL_MAX && s->source->problem == 0 &&
           !ntpio__png_has_pixels(tail, s->after_size + size);
}

/* Is a whole row there?  The last one is, if all is well after it. */
static bool has_row(ntpio__png_stream *s)
{
    const size_t size = s->shape.row_size + 1;
    bool ends = false;
    while (!s->faulty && (size_t) (s->to - s->from) < size)
        s->faulty = ends || !unpack(s, &ends);
    s->faulty = s->faulty || *s->from >= NTPIO__FILTERS ||
                (s->row + 1 == s->shape.height && !(ends_well(s) && take_tail(s)));
    return !s->faulty;
}

/* Copies the next row, and says how it is filtered. */
static int take_row(ntpio__png_stream *s, uint8_t *dst)
{
    const int kind = *s->from;
    memcpy(dst, s->from + 1, s->shape.row_size);
    s->from += s->shape.row_size + 1;
    s->row++;
    return kind;
}

static void swap_bytes(uint8_t *row, size_t size)
{
    for (size_t i = 0; i < size; i += 2) {
        uint16_t sample;
        memcpy(&sample, row + i, sizeof sample);
        sample = (uint16_t) (sample << 8 | sample >> 8);
        memcpy(row + i, &sample, sizeof sample);
    }
}

uint32_t ntpio__png_stream_rows(ntpio__png_stream *s, uint8_t *dst, ptrdiff_t stride,
                                uint32_t count, bool swap)
{
    const size_t size = s->shape.row_size;
    const uint8_t *above = s->row > 0 ? s->above : NULL;
    uint32_t taken = 0, undone = 0;
    int kinds[NTPIO__ROWS_TOGETHER];
    while (undone < count) {
        for (; taken < count && taken < undone + NTPIO__ROWS_TOGETHER && has_row(s); taken++)
            kinds[taken - undone] = take_row(s, dst + (ptrdiff_t) taken * stride);
        if (taken == undone)
            break;
        const uint32_t done =
            ntpio__unfilter_rows(dst + (ptrdiff_t) undone * stride, stride, taken - undone, above,
                                 size, s->shape.texel, kinds);
        undone += done;
        memmove(kinds, kinds + done, (NTPIO__ROWS_TOGETHER - done) * sizeof *kinds);
        above = dst + (ptrdiff_t) (undone - 1) * stride;
    }
    if (undone > 0)
        memcpy(s->above, above, size);
    for (uint32_t y = 0; swap && y < undone; y++)
        swap_bytes(dst + (ptrdiff_t) y * stride, size);
    return undone;
}

/* --------------------------------------------------------------------------- files */

/* Where the first IDAT chunk begins; 0: not in these bytes, or there is a tRNS chunk. */
static size_t find_pixels(const uint8_t *file, size_t size)
{
    size_t at = SIGNATURE;
    while (size - at >= CHUNK_HEAD && !ntpio__png_is(file + at, "IDAT")) {
        const size_t whole = (size_t) ntpio__png_number(file + at) + CHUNK_HEAD + CHECKSUM;
        if (ntpio__png_is(file + at, "tRNS") || whole > size - at)
            return 0;
        at += whole;
    }
    return size - at >= CHUNK_HEAD ? at : 0;
}

static bool is_plain(ntpio__png_shape *shape, const uint8_t *file, size_t size,
                     const ntpio_limits *limits)
{
    return ntpio__png_shape_of(shape, file, size) && shape->width <= limits->max_side &&
           shape->height <= limits->max_side &&
           shape->width <= limits->max_texels / shape->height && shape->row_size < ROW_MAX;
}

/* The file up to its pixels becomes the start of the shell. */
static bool take_head(ntpio__png_stream *s, size_t size)
{
    uint8_t head[CHUNK_HEAD];
    s->shell = malloc(size + NTPIO__NO_PIXELS_SIZE);
    if (s->shell == NULL || ntpio__read(s->source, s->shell, size) != size ||
        ntpio__read(s->source, head, CHUNK_HEAD) != CHUNK_HEAD)
        return false;
    memcpy(s->shell + size, ntpio__no_pixels, NTPIO__NO_PIXELS_SIZE);
    s->shell_size = size + NTPIO__NO_PIXELS_SIZE;
    s->chunk_left = ntpio__png_number(head);
    s->chunk_sum = ntpio__crc32(0, head + 4, 4);
    return s->chunk_left <= INT32_MAX;
}

/* The header of zlib's format. */
static bool take_zlib_header(ntpio__png_stream *s)
{
    ntpio__inflate *in = &s->inflate;
    in->in = in->in_end = s->packed;
    if (!fill(s) || in->in_end - in->in < 2)
        return false;
    const uint8_t *b = in->in;
    in->in += 2;
    s->packed_hard = ntpio__png_packed_hard(b[1]);
    return ntpio__png_zlib_header(b, s->left);
}

static bool start(ntpio__png_stream *s, size_t head_size)
{
    const size_t row = s->shape.row_size + 1, some = row < ROOM_SIZE / 2 ? ROOM_SIZE : 2 * row;
    const size_t room = NTPIO__WINDOW + some + NTPIO__OUT_SLACK;
    s->left = (uint64_t) row * s->shape.height;
    s->sum = 1;
    s->room = malloc(room);
    s->above = malloc(row);
    if (s->room == NULL || s->above == NULL)
        return false;
    s->from = s->to = s->room;
    s->room_end = s->room + room;
    return take_head(s, head_size) && take_zlib_header(s);
}

ntpio__png_stream *ntpio__png_stream_open(ntpio_reader *reader)
{
    ntpio__source *source = &reader->source;
    ntpio__png_shape shape;
    if (!ntpio__can_seek(source))
        return NULL;
    size_t head_size = 0; /* most heads are short, and a large one is looked at as a whole */
    for (size_t most = NTPIO__PEEK; head_size == 0 && most <= HEAD_MAX;
         most *= HEAD_MAX / NTPIO__PEEK) {
        const size_t peeked = ntpio__peek(source, most),
                     size = peeked < HEAD_MAX ? peeked : HEAD_MAX;
        const uint8_t *file = source->bytes + source->at;
        if (!is_plain(&shape, file, size, &reader->limits))
            return NULL;
        head_size = find_pixels(file, size);
    }
    ntpio__png_stream *s = head_size != 0 ? malloc(sizeof *s) : NULL;
    if (s == NULL)
        return NULL;
    memset(s, 0, offsetof(ntpio__png_stream, inflate) + offsetof(ntpio__inflate, literals));
    s->source = source;
    s->shape = shape;
    if (start(s, head_size))
        return s;
    ntpio__png_stream_close(s);
    source->problem = 0;
    ntpio__seek(source, 0);
    return NULL;
}

const uint8_t *ntpio__png_stream_shell(const ntpio__png_stream *s, size_t *size)
{
    *size = s->shell_size;
    return s->shell;
}

bool ntpio__png_stream_packed_hard(const ntpio__png_stream *s)
{
    return s->packed_hard;
}

void ntpio__png_stream_close(ntpio__png_stream *s)
{
    if (s == NULL)
        return;
    free(s->shell);
    free(s->room);
    free(s->above);
    free(s);
}
