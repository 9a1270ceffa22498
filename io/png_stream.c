/* SPDX-License-Identifier: MIT */
/*
 * png_stream.c - the rows of a PNG, unpacked while they are read
 *
 * Data of IDAT chunks go into `packed`, and are unpacked into `room`: the window of deflate, then
 * rows that were not taken.  Rows are copied to the caller before their filters are undone, since
 * the window holds filtered bytes.  The last row is delivered only if the stream ends well: with
 * its checksum, where the chunks end, and with what follows them.
 *
 * If the picture is kept, the room is all of it.  Then filters are undone in place, as soon as the
 * window has left a row behind, and rows are copied as often as they are read.  Fresh memory for the
 * file as well would take as long as unpacking.  Another thread may unpack it meanwhile, or they take
 * turns: who unpacks has the file and what is behind the window to itself.
 */
#include "png_stream.h"

#include <stdlib.h>

#include "inflate.h"
#include "os/memory.h"
#include "os/threads.h"
#include "png_filter.h"
#include "png_plain.h"
#include "png_shell.h"
#include "png_sums.h"

enum {
    ROW_MAX = 1 << 20, /* unless the picture is kept */
    PACKED_SIZE = 1 << 15,
    PART = 1 << 16,  /* is unpacked at once: it stays in the cache until its checksum is made */
    DENSEST = 1032,  /* deflate makes at most so many bytes of one */
    SOON = 2 * PART, /* who waits for a row waits for so much more */
    PAGES = 2 << 20, /* are asked for at once */
    CHUNK_HEAD = 8,
    CHECKSUM = 4,
    SIGNATURE = 8,
    HEAD = SIGNATURE + CHUNK_HEAD + 13 + CHECKSUM /* the signature, and the chunk IHDR */
};

struct ntpio__png_stream {
    ntpio__source *source;
    ntpio__png_shape shape;
    ntpio__png_shell shell;
    bool packed_hard, keeps, faulty;
    bool ended;                /* the stream, well or not */
    uint64_t left;             /* bytes that are not unpacked */
    uint32_t row;              /* the next one to deliver */
    uint32_t taken, undone;    /* rows that were found whole; of a picture that is kept: undone */
    uint32_t chunk_left;       /* bytes left of this chunk */
    uint32_t chunk_sum, sum;   /* of this chunk so far; of all that was unpacked */
    uint8_t after[CHUNK_HEAD]; /* the first bytes after the chunks */
    size_t after_size;
    uint8_t *room, *from, *to, *room_end; /* from: the first row that is not taken; to: its end */
    uint8_t *above;                       /* the row before `row` */
    os_lock lock;                         /* of a picture that is kept: of the six below */
    os_condition changed;
    bool unpacking, whole, stuck; /* somebody is at it; nothing is left; nothing more will come */
    size_t reached, wanted;       /* bytes that are unpacked, and that are waited for */
    size_t sure, present;         /* of these, the reader knows; pages that were asked for */
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

/* Unpacks a part more, which may be the last one.  False: a fault. */
static bool unpack(ntpio__png_stream *s)
{
    if (s->room_end - s->to < NTPIO__OUT_SLACK)
        compact(s);
    const bool some = s->room_end - s->to > PART + NTPIO__OUT_SLACK;
    uint8_t *out = s->to;
    const ntpio__inflated now = ntpio__inflate_some(
        &s->inflate, s->room, &out, some ? s->to + PART + NTPIO__OUT_SLACK : s->room_end);
    const size_t size = (size_t) (out - s->to);
    if (now == NTPIO__STREAM_BAD || size > s->left)
        return false;
    s->sum = ntpio__adler32(s->sum, s->to, size);
    s->left -= size;
    s->to = out;
    s->ended = now == NTPIO__STREAM_ENDS;
    return now != NTPIO__NEEDS_INPUT || fill(s);
}

/* Do the stream and its chunks end here, and as they should? */
static bool ends_well(ntpio__png_stream *s)
{
    ntpio__inflate *in = &s->inflate;
    while (!s->ended) {
        if (!unpack(s))
            return false;
    }
    in->in = ntpio__inflate_end(in);
    while (!in->no_more) {
        if (in->in_end - in->in > CHECKSUM || !fill(s))
            return false;
    }
    return s->left == 0 && in->in_end - in->in == CHECKSUM && ntpio__png_number(in->in) == s->sum;
}

/* ------------------------------------------------------------------------ the shell */

/* The file up to its pixels becomes the start of the shell.  False: there are none, or a tRNS
 * chunk. */
static bool take_head(ntpio__png_stream *s)
{
    if (!ntpio__png_shell_read(&s->shell, s->source, HEAD))
        return false;
    for (;;) {
        uint8_t head[CHUNK_HEAD];
        if (ntpio__read(s->source, head, CHUNK_HEAD) != CHUNK_HEAD)
            return false;
        s->chunk_left = ntpio__png_number(head);
        if (s->chunk_left > INT32_MAX || ntpio__png_is(head, "tRNS"))
            return false;
        if (ntpio__png_is(head, "IDAT")) {
            s->chunk_sum = ntpio__crc32(0, head + 4, 4);
            return ntpio__png_shell_add(&s->shell, ntpio__no_pixels, NTPIO__NO_PIXELS_SIZE);
        }
        if (!ntpio__png_shell_add(&s->shell, head, CHUNK_HEAD) ||
            !ntpio__png_shell_read(&s->shell, s->source, (size_t) s->chunk_left + CHECKSUM))
            return false;
    }
}

/* Adds what follows the pixels to the shell. */
static bool take_tail(ntpio__png_stream *s)
{
    const size_t begin = s->shell.size;
    return ntpio__png_shell_add(&s->shell, s->after, s->after_size) &&
           ntpio__png_shell_read_all(&s->shell, s->source) &&
           !ntpio__png_has_pixels(s->shell.bytes + begin, s->shell.size - begin);
}

/* -------------------------------------------------------------------------- turns */

/* Of a picture that is kept: unpacks a part more.  The lock is held before and after. */
static void unpack_in_turn(ntpio__png_stream *s)
{
    s->unpacking = true;
    os_lock_release(&s->lock);
    const bool good = !s->ended && unpack(s);
    os_lock_take(&s->lock);
    s->unpacking = false;
    s->stuck = s->stuck || !good;
    s->whole = s->left == 0;
    s->reached = (size_t) (s->to - s->room);
    if (s->whole || s->stuck || s->reached >= s->wanted)
        os_condition_wake_all(&s->changed);
}

/* Waits until so many bytes are unpacked, or as many as will be. */
static void wait_for(ntpio__png_stream *s, size_t wanted)
{
    s->wanted = wanted;
    os_condition_wait(&s->changed, &s->lock);
    s->wanted = SIZE_MAX;
}

/* Fresh memory comes from the system, which fills it with zeros: who has to wait lets that be done. */
static bool asks_for_pages(ntpio__png_stream *s)
{
    const size_t next = (s->reached + PAGES - 1) / PAGES * PAGES;
    const size_t first = s->present > next ? s->present : next;
    if (first + PAGES > (size_t) (s->room_end - s->room))
        return false;
    s->present = first + PAGES;
    os_lock_release(&s->lock);
    os_make_present(s->room + first, PAGES);
    os_lock_take(&s->lock);
    return true;
}

/* Unpacks so many bytes, or waits for who does.  False: they do not come. */
static bool reaches(ntpio__png_stream *s, size_t size)
{
    if (size <= s->sure)
        return true;
    os_lock_take(&s->lock);
    while (s->reached < size && !s->whole && !s->stuck) {
        if (!s->unpacking)
            unpack_in_turn(s);
        else if (!asks_for_pages(s))
            wait_for(s, size + SOON);
    }
    s->sure = s->whole && !s->stuck ? SIZE_MAX : s->reached;
    os_lock_release(&s->lock);
    return size <= s->sure;
}

bool ntpio__png_stream_unpack(ntpio__png_stream *s)
{
    if (!s->keeps)
        return false;
    os_lock_take(&s->lock);
    while (s->unpacking)
        wait_for(s, 0);
    const bool more = !s->whole && !s->stuck;
    if (more)
        unpack_in_turn(s);
    os_lock_release(&s->lock);
    return more;
}

/* The file is read in another way from now on. */
static void stop_unpacking(ntpio__png_stream *s)
{
    os_lock_take(&s->lock);
    s->stuck = true;
    while (s->unpacking)
        wait_for(s, 0);
    os_lock_release(&s->lock);
}

/* --------------------------------------------------------------------------- rows */

/*
 * Is the next row whole?  The last one is, if all is well after it.  A picture that is kept has to
 * reach further by the window, in which filters must not be undone.
 */
static bool has_row(ntpio__png_stream *s)
{
    const size_t size = s->shape.row_size + 1;
    if (s->keeps)
        s->faulty = s->faulty || !reaches(s, (size_t) (s->from - s->room) + size + NTPIO__WINDOW);
    while (!s->keeps && !s->faulty && s->left > 0 && (size_t) (s->to - s->from) < size)
        s->faulty = s->ended || !unpack(s);
    s->faulty = s->faulty || *s->from >= NTPIO__FILTERS ||
                (s->taken + 1 == s->shape.height && !(ends_well(s) && take_tail(s)));
    if (s->keeps && s->faulty)
        stop_unpacking(s);
    return !s->faulty;
}

/* Copies the next row, and says how it is filtered. */
static int take_row(ntpio__png_stream *s, uint8_t *dst)
{
    const int kind = *s->from;
    memcpy(dst, s->from + 1, s->shape.row_size);
    s->from += s->shape.row_size + 1;
    s->taken++;
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

static uint32_t pass_rows(ntpio__png_stream *s, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                          bool swap)
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

/* Undoes the filters of one row more, or of those that can be undone with it.  False: a fault. */
static bool undo_rows(ntpio__png_stream *s)
{
    const size_t size = s->shape.row_size;
    while (s->taken < s->undone + NTPIO__ROWS_TOGETHER && s->taken < s->shape.height &&
           has_row(s)) {
        s->from += size + 1;
        s->taken++;
    }
    const uint32_t count = s->taken - s->undone;
    if (count == 0)
        return false;
    uint8_t *kind = s->room + s->undone * (size + 1), *row = kind + 1;
    int kinds[NTPIO__ROWS_TOGETHER];
    for (uint32_t k = 0; k < count; k++)
        kinds[k] = kind[k * (size + 1)];
    s->undone +=
        ntpio__unfilter_rows(row, (ptrdiff_t) size + 1, count,
                             s->undone > 0 ? row - (size + 1) : NULL, size, s->shape.texel, kinds);
    return true;
}

static void copy_row(uint8_t *dst, const uint8_t *row, size_t size, bool swap)
{
    if (!swap)
        memcpy(dst, row, size);
    for (size_t i = 0; swap && i < size; i += 2) {
        dst[i] = row[i + 1];
        dst[i + 1] = row[i];
    }
}

static uint32_t copy_rows(ntpio__png_stream *s, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                          bool swap)
{
    const size_t size = s->shape.row_size;
    uint32_t done = 0;
    for (; done < count && (s->row + done < s->undone || undo_rows(s)); done++)
        copy_row(dst + (ptrdiff_t) done * stride, s->room + (s->row + done) * (size + 1) + 1, size,
                 swap);
    return done;
}

uint32_t ntpio__png_stream_rows(ntpio__png_stream *s, uint8_t *dst, ptrdiff_t stride,
                                uint32_t count, bool swap)
{
    const uint32_t done =
        s->keeps ? copy_rows(s, dst, stride, count, swap) : pass_rows(s, dst, stride, count, swap);
    s->row += done;
    return done;
}

bool ntpio__png_stream_rewind(ntpio__png_stream *s)
{
    if (s->keeps)
        s->row = 0;
    return s->keeps;
}

/* --------------------------------------------------------------------------- files */

static bool is_plain(ntpio__png_shape *shape, ntpio_reader *reader)
{
    ntpio__source *source = &reader->source;
    const ntpio_limits *limits = &reader->limits;
    const size_t size = ntpio__can_seek(source) ? ntpio__peek(source, HEAD) : 0;
    return ntpio__png_shape_of(shape, source->bytes + source->at, size) &&
           shape->width <= limits->max_side && shape->height <= limits->max_side &&
           shape->width <= limits->max_texels / shape->height;
}

/* The bytes of all rows, each with the number of its filter. */
static uint64_t size_of(const ntpio__png_shape *shape)
{
    return ((uint64_t) shape->row_size + 1) * shape->height;
}

/* May the picture be kept, and can so much be in the file? */
static bool may_keep(const ntpio__png_shape *shape, ntpio_reader *reader)
{
    const ntpio_limits *limits = &reader->limits;
    const uint64_t size = size_of(shape);
    uint64_t packed;
    return ntpio__size(&reader->source, &packed) && packed <= limits->max_at_once &&
           size <= limits->max_at_once && size <= limits->max_memory && size / DENSEST <= packed;
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

static bool find_room(ntpio__png_stream *s)
{
    const size_t row = s->shape.row_size + 1;
    size_t room = NTPIO__WINDOW + (row < PART / 2 ? PART : 2 * row) + NTPIO__OUT_SLACK;
    if (s->keeps) {
        room = (size_t) s->left + NTPIO__OUT_SLACK;
        s->room = os_alloc_large(room);
    } else {
        s->room = malloc(room);
        s->above = malloc(row);
    }
    s->from = s->to = s->room;
    s->room_end = s->room + room;
    return s->room != NULL && (s->keeps || s->above != NULL);
}

ntpio__png_stream *ntpio__png_stream_open(ntpio_reader *reader)
{
    ntpio__source *source = &reader->source;
    ntpio__png_shape shape;
    if (!is_plain(&shape, reader))
        return NULL;
    const bool wide = shape.row_size >= ROW_MAX;
    const bool keeps = (!reader->limits.one_pass || wide) && may_keep(&shape, reader);
    ntpio__png_stream *s = keeps || !wide ? malloc(sizeof *s) : NULL;
    if (s == NULL)
        return NULL;
    memset(s, 0, offsetof(ntpio__png_stream, inflate) + offsetof(ntpio__inflate, literals));
    s->source = source;
    s->shape = shape;
    s->keeps = keeps;
    s->left = size_of(&shape);
    s->sum = 1;
    s->wanted = SIZE_MAX;
    os_lock_init(&s->lock);
    os_condition_init(&s->changed);
    if (find_room(s) && take_head(s) && take_zlib_header(s))
        return s;
    ntpio__png_stream_close(s);
    source->problem = 0;
    ntpio__seek(source, 0);
    return NULL;
}

const uint8_t *ntpio__png_stream_shell(const ntpio__png_stream *s, size_t *size)
{
    *size = s->shell.size;
    return s->shell.bytes;
}

bool ntpio__png_stream_packed_hard(const ntpio__png_stream *s)
{
    return s->packed_hard;
}

void ntpio__png_stream_close(ntpio__png_stream *s)
{
    if (s == NULL)
        return;
    os_condition_destroy(&s->changed);
    os_lock_destroy(&s->lock);
    free(s->shell.bytes);
    free(s->room);
    free(s->above);
    free(s);
}
