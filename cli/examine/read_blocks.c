/* SPDX-License-Identifier: MIT */
/*
 * read_blocks.c - a file as blocks of rows in a ring
 *
 * Rows go through a small ring, so memory does not grow with the image.  If a processor is idle, a
 * second thread decodes the next block while the caller works on this one; the ring then holds two
 * blocks.  Who knows that a file is read twice has its rows kept, unless they are many; if the reader
 * keeps them itself, the second thread unpacks all that it can, and the caller does the rest.
 *
 * Rows that are packed take all threads: reading ahead gets one of them only if there are three or
 * more, and if it is decoding.  What was decoded before is only copied.
 */
#include "examine/read_blocks.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "examine/samples.h"
#include "os/files.h"
#include "os/threads.h"

enum {
    BLOCK_BYTES = 256 * 1024, /* a block stays in the second-level cache */
    BLOCK_ROWS = 64,
    KEPT_BYTES = 64 << 20,   /* 4096 x 4096 in RGB; memory must not grow with any image */
    AHEAD_TEXELS = 512 * 512 /* a smaller image is read before a thread has started */
};

bool file_error(ntpio_error *error, ntpio_status status, const char *name, const char *what)
{
    text shown = { 0 };
    text_name(&shown, name);
    error->status = status;
    snprintf(error->message, sizeof error->message, "%.380s: %s", text_string(&shown), what);
    text_free(&shown);
    return false;
}

bool library_error(const source *s, ntp_status status, ntpio_error *error)
{
    return file_error(error, NTPIO_ERR_USAGE, s->in->path, ntp_status_string(status));
}

/* Standard input and pipes can be read only once: all of it. */
static bool read_all(source *s, FILE *file, ntpio_error *error)
{
    const uint64_t most = 4ULL << 30;
    size_t capacity = 0;
    for (;;) {
        if (s->size == capacity) {
            capacity = capacity == 0 ? 1 << 20 : capacity * 2;
            unsigned char *grown = capacity <= most ? realloc(s->bytes, capacity) : NULL;
            if (grown == NULL)
                return file_error(error, NTPIO_ERR_MEMORY, s->in->path,
                                  "too large to be held in memory");
            s->bytes = grown;
        }
        const size_t got = fread(s->bytes + s->size, 1, capacity - s->size, file);
        s->size += got;
        if (got == 0)
            break;
    }
    return ferror(file) ? file_error(error, NTPIO_ERR_OPEN, s->in->path, strerror(errno)) : true;
}

static bool hold(source *s, ntpio_error *error)
{
    os_file found;
    if (strcmp(s->in->path, "-") == 0)
        return read_all(s, stdin, error);
    if (!os_look(s->in->path, &found) || found.kind == OS_REGULAR || found.kind == OS_DIRECTORY ||
        s->limits->regular_only)
        return true;
    if (found.kind == OS_DEVICE) /* it may have no end */
        return file_error(error, NTPIO_ERR_OPEN, s->in->path, "a device, not a file");
    FILE *file = os_open_to_read(s->in->path, false);
    if (file == NULL)
        return file_error(error, NTPIO_ERR_OPEN, s->in->path, strerror(errno));
    const bool ok = read_all(s, file, error);
    fclose(file);
    return ok;
}

static bool start(source *s, ntpio_error *error)
{
    const char *name = strcmp(s->in->path, "-") == 0 ? "standard input" : s->in->path;
    s->next = 0;
    s->keeps = s->kept = s->ended = false;
    s->reader = s->bytes != NULL ? ntpio_open_memory(s->bytes, s->size, name, s->limits, error)
                                 : ntpio_open(s->in->path, s->limits, error);
    if (s->reader == NULL)
        return false;
    s->info = ntpio_reader_info(s->reader);
    return true;
}

bool source_open(source *s, worker *w, const input *in, const ntpio_limits *limits,
                 ntpio_error *error)
{
    *s = (source) { .in = in, .w = w, .limits = limits };
    if (in->problem != NULL)
        return file_error(error, NTPIO_ERR_OPEN, in->path, in->problem);
    if (hold(s, error) && start(s, error))
        return true;
    source_close(s);
    return false;
}

static bool changed(const source *s, ntpio_error *error)
{
    return file_error(error, NTPIO_ERR_OPEN, s->in->path, "changed meanwhile");
}

static bool is_same_stamp(const ntpio_stamp *a, const ntpio_stamp *b)
{
    return a->known == b->known && a->device == b->device && a->node == b->node &&
           a->size == b->size && a->seconds == b->seconds && a->nanoseconds == b->nanoseconds;
}

static void stop_ahead(source *s);

void source_keep(source *s)
{
    const ntpio_info *info = s->info;
    const uint64_t bytes = (uint64_t) info->width * info->height * (uint64_t) info->channels *
                           (uint64_t) info->sample_bytes;
    if (s->kept || ntpio_rewind(s->reader))
        return;
    s->keeps = bytes <= KEPT_BYTES;
    if (s->keeps)
        buffer_reserve(&s->w->kept, (size_t) bytes);
}

static bool may_read_ahead(const source *s)
{
    return s->view.ring_rows > s->block_rows;
}

int source_leave_threads(source *s)
{
    const bool decodes = !s->ended; /* after the end, it was rewound */
    s->alone = !may_read_ahead(s) || !decodes || s->w->threads < 3;
    s->packs = true;
    return s->alone ? s->w->threads : s->w->threads - 1;
}

bool source_rewind(source *s, ntpio_error *error)
{
    stop_ahead(s);
    s->alone = s->packs = false;
    s->kept = s->kept || (s->keeps && s->ended);
    if (s->kept || ntpio_rewind(s->reader)) {
        s->next = 0;
        return s->bytes != NULL || source_is_current(s, error);
    }
    const ntpio_stamp read = s->info->stamp;
    ntpio_close(s->reader);
    s->reader = NULL;
    return start(s, error) && (is_same_stamp(&read, &s->info->stamp) || changed(s, error));
}

bool source_is_current(const source *s, ntpio_error *error)
{
    return ntpio_is_current(s->in->path, &s->info->stamp) || changed(s, error);
}

void source_close_file(source *s)
{
    stop_ahead(s);
    ntpio_close_file(s->reader);
}

void source_close(source *s)
{
    stop_ahead(s);
    ntpio_close(s->reader);
    s->reader = NULL;
    free(s->bytes);
    s->bytes = NULL;
}

void source_view(source *s, ntp_encoding encoding, ntp_y y, const int8_t *map, int32_t channels)
{
    const ntpio_info *info = s->info;
    s->mapped = map != NULL;
    if (map != NULL)
        memcpy(s->map, map, (size_t) channels);
    else
        channels = info->channels;
    const size_t row = (size_t) info->width * (size_t) channels * (size_t) info->sample_bytes;
    size_t rows = BLOCK_BYTES / row;
    rows = rows < 1 ? 1 : rows > BLOCK_ROWS ? BLOCK_ROWS : rows;
    rows = rows > info->height ? info->height : rows;
    const bool large = (uint64_t) info->width * info->height >= AHEAD_TEXELS;
    const bool ahead = s->w->threads >= 2 && large && s->alter == NULL;
    const size_t blocks = ahead && info->height > 2 * rows ? 2 : 1;
    unsigned char *data = buffer_reserve(&s->w->rows, blocks * rows * row);
    s->view = ntp_image_packed(data, (int32_t) info->width, (int32_t) info->height, channels,
                               sample_type(info->sample_bytes));
    s->view.row_stride = (ptrdiff_t) row;
    s->view.ring_rows = (int32_t) (blocks * rows);
    s->block_rows = (int32_t) rows;
    s->view.encoding = encoding;
    s->view.y = y;
}

void source_view_as_rgb(source *s, ntp_encoding encoding)
{
    static const int8_t EXPAND[4] = { 0, 0, 0, 1 };
    source_view(s, encoding, NTP_Y_UP, EXPAND, s->info->channels + 2);
}

/* Reads the next rows as the file has them; kept ones lie one after the other. */
static bool read_raw(source *s, unsigned char *rows, uint32_t first, uint32_t count,
                     ntpio_error *error)
{
    const size_t row =
        (size_t) s->info->width * (size_t) s->info->channels * (size_t) s->info->sample_bytes;
    unsigned char *kept = s->keeps ? s->w->kept.data + first * row : NULL;
    if (s->kept) {
        memcpy(rows, kept, row * count);
        return true;
    }
    if (!ntpio_read_rows(s->reader, rows, (ptrdiff_t) row, count, error))
        return false;
    if (kept != NULL)
        memcpy(kept, rows, row * count);
    return true;
}

/* Reads block `index` into its place in the ring. */
static bool read_block(source *s, uint32_t index, ntpio_error *error)
{
    const uint32_t block = (uint32_t) s->block_rows, left = s->info->height - index * block;
    const uint32_t count = left < block ? left : block;
    const uint32_t slot = index * block % (uint32_t) s->view.ring_rows;
    unsigned char *rows = s->w->rows.data + (size_t) slot * (size_t) s->view.row_stride;
    if (!s->mapped)
        return read_raw(s, rows, index * block, count, error);
    const size_t raw_row =
        (size_t) s->info->width * (size_t) s->info->channels * (size_t) s->info->sample_bytes;
    unsigned char *raw = buffer_reserve(&s->w->raw, raw_row * block);
    if (!read_raw(s, raw, index * block, count, error))
        return false;
    const channel_order order = { s->view.type, s->view.channels, s->info->channels, s->map };
    reorder_channels(rows, raw, &order, (size_t) s->info->width * count);
    if (s->alter != NULL)
        s->alter(s->alter_context, rows, (size_t) s->info->width * count);
    return true;
}

/* ------------------------------------------------------------------- reading ahead */

struct ahead {
    os_thread thread;
    os_lock lock;
    os_condition changed;
    uint32_t read;     /* blocks that are in the ring */
    uint32_t released; /* blocks that the caller is done with */
    bool unpacks;      /* ... and the caller makes blocks of that */
    bool stop, failed;
    ntpio_error error;
};

static void *read_ahead(void *context)
{
    source *s = context;
    struct ahead *a = s->ahead;
    const uint32_t block = (uint32_t) s->block_rows;
    const uint32_t blocks = (s->info->height + block - 1) / block;
    os_lock_take(&a->lock);
    while (!a->stop && !a->failed && a->read < blocks) {
        if (a->read >= a->released + 2) {
            os_condition_wait(&a->changed, &a->lock);
            continue;
        }
        const uint32_t index = a->read;
        os_lock_release(&a->lock);
        const bool ok = read_block(s, index, &a->error);
        os_lock_take(&a->lock);
        a->read += ok;
        a->failed = !ok;
        os_condition_wake_one(&a->changed);
    }
    os_lock_release(&a->lock);
    return NULL;
}

static bool may_go_on(struct ahead *a)
{
    os_lock_take(&a->lock);
    const bool goes_on = !a->stop;
    os_lock_release(&a->lock);
    return goes_on;
}

static void *unpack_ahead(void *context)
{
    const source *s = context;
    struct ahead *a = s->ahead;
    while (may_go_on(a) && ntpio_unpack(s->reader))
        continue;
    return NULL;
}

static void stop_ahead(source *s)
{
    struct ahead *a = s->ahead;
    if (a == NULL)
        return;
    os_lock_take(&a->lock);
    a->stop = true;
    os_condition_wake_one(&a->changed);
    os_lock_release(&a->lock);
    os_thread_join(a->thread);
    os_condition_destroy(&a->changed);
    os_lock_destroy(&a->lock);
    free(a);
    s->ahead = NULL;
}

static void start_ahead(source *s)
{
    s->ahead = need(calloc(1, sizeof *s->ahead));
    os_lock_init(&s->ahead->lock);
    os_condition_init(&s->ahead->changed);
    s->ahead->unpacks = !s->packs && ntpio_unpack(s->reader);
    void *(*const run)(void *) = s->ahead->unpacks ? unpack_ahead : read_ahead;
    if (os_thread_start(&s->ahead->thread, run, s) == 0)
        return;
    free(s->ahead); /* without a thread the rows are read when they are asked for */
    s->ahead = NULL;
}

static bool take_block(source *s, uint32_t index, ntpio_error *error)
{
    struct ahead *a = s->ahead;
    if (a == NULL || a->unpacks)
        return read_block(s, index, error);
    os_lock_take(&a->lock);
    a->released = index;
    os_condition_wake_one(&a->changed);
    while (a->read <= index && !a->failed)
        os_condition_wait(&a->changed, &a->lock);
    const bool ok = a->read > index;
    if (!ok)
        *error = a->error;
    os_lock_release(&a->lock);
    return ok;
}

unsigned char *source_rows(const source *s, const ntp_rect *area)
{
    return s->w->rows.data + (size_t) (area->y0 % s->view.ring_rows) * (size_t) s->view.row_stride;
}

int source_next(source *s, ntp_rect *area, ntpio_error *error)
{
    const uint32_t height = s->info->height, block = (uint32_t) s->block_rows;
    if (interrupted_by != 0) {
        file_error(error, NTPIO_OK, s->in->path, "interrupted");
        return -1;
    }
    if (s->next == height) {
        stop_ahead(s);
        s->ended = s->ended || ntpio_read_end(s->reader, error);
        return s->ended ? 0 : -1;
    }
    if (s->next == 0 && may_read_ahead(s) && !s->alone)
        start_ahead(s);
    if (!take_block(s, s->next / block, error))
        return -1;
    const uint32_t left = height - s->next, count = left < block ? left : block;
    *area = (ntp_rect) { 0, (int32_t) s->next, s->view.width, (int32_t) (s->next + count) };
    s->next += count;
    const uint64_t whole = s->read_permille > 0 ? (uint64_t) s->read_permille : 1000;
    atomic_store_explicit(&s->w->permille, (int) ((uint64_t) s->next * whole / height),
                          memory_order_relaxed);
    return 1;
}
