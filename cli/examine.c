/* SPDX-License-Identifier: MIT */
/*
 * examine.c - reading a file row by row, and finding out what it is
 *
 * Rows stream through a small ring, so memory does not grow with the image.  A file is measured
 * as standard first; what the class changes (16-bit angles, whether alpha 0 means unused)
 * makes it be read a second time.
 */
#include "examine.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum {
    BLOCK_BYTES = 256 * 1024, /* rows read at once stay in the second-level cache */
    BLOCK_ROWS = 64
};

unsigned char *buffer_reserve(buffer *b, size_t size)
{
    if (b->size < size) {
        free(b->data);
        b->data = need(aligned_alloc(64, (size + 63) / 64 * 64));
        b->size = size;
    }
    return b->data;
}

worker *worker_new(void)
{
    worker *w = need(calloc(1, sizeof *w));
    w->tally = need(calloc(1, ntp_tally_size()));
    return w;
}

void worker_free(worker *w)
{
    free(w->tally);
    free(w->rows.data);
    free(w->raw.data);
    free(w->extra.data);
    free(w->extra2.data);
    free(w->diff.data);
    free(w->histogram);
    free(w);
}

ntpio_limits limits_from(const options *o)
{
    return (ntpio_limits) { .max_side = (uint32_t) option_integer(o, OPT_MAX_SIDE),
                            .max_texels = (uint64_t) option_integer(o, OPT_MAX_TEXELS) };
}

int forced_class(const options *o)
{
    return (int) option_integer(o, OPT_TYPE) - 1; /* the choices are in the order of ntp_class */
}

/* ------------------------------------------------------------------------- reading */

static bool fail(ntpio_error *error, ntpio_status status, const char *name, const char *what)
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
    return fail(error, NTPIO_ERR_USAGE, s->in->path, ntp_status_string(status));
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
                return fail(error, NTPIO_ERR_MEMORY, s->in->path, "too large to be held in memory");
            s->bytes = grown;
        }
        const size_t got = fread(s->bytes + s->size, 1, capacity - s->size, file);
        s->size += got;
        if (got == 0)
            break;
    }
    return ferror(file) ? fail(error, NTPIO_ERR_OPEN, s->in->path, strerror(errno)) : true;
}

static bool hold(source *s, ntpio_error *error)
{
    struct stat st;
    if (strcmp(s->in->path, "-") == 0)
        return read_all(s, stdin, error);
    if (stat(s->in->path, &st) != 0 || S_ISREG(st.st_mode) || S_ISDIR(st.st_mode))
        return true;
    FILE *file = fopen(s->in->path, "rb");
    if (file == NULL)
        return fail(error, NTPIO_ERR_OPEN, s->in->path, strerror(errno));
    const bool ok = read_all(s, file, error);
    fclose(file);
    return ok;
}

static bool start(source *s, ntpio_error *error)
{
    const char *name = strcmp(s->in->path, "-") == 0 ? "standard input" : s->in->path;
    s->next = 0;
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
        return fail(error, NTPIO_ERR_OPEN, in->path, in->problem);
    if (hold(s, error) && start(s, error))
        return true;
    source_close(s);
    return false;
}

bool source_rewind(source *s, ntpio_error *error)
{
    ntpio_close(s->reader);
    s->reader = NULL;
    return start(s, error);
}

void source_close(source *s)
{
    ntpio_close(s->reader);
    s->reader = NULL;
    free(s->bytes);
    s->bytes = NULL;
}

static ntp_type sample_type(const ntpio_info *info)
{
    return info->sample_bytes == 1 ? NTP_U8 : info->sample_bytes == 2 ? NTP_U16 : NTP_F32;
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
    unsigned char *data = buffer_reserve(&s->w->rows, rows * row);
    s->view = ntp_image_packed(data, (int32_t) info->width, (int32_t) info->height, channels,
                               sample_type(info));
    s->view.row_stride = (ptrdiff_t) row;
    s->view.ring_rows = (int32_t) rows;
    s->view.encoding = encoding;
    s->view.y = y;
}

#define REARRANGE(TYPE, ONE)                                                                       \
    for (size_t i = 0; i < count; i++) {                                                           \
        const TYPE *from = (const TYPE *) raw + i * (size_t) channels;                             \
        TYPE *to = (TYPE *) rows + i * (size_t) s->view.channels;                                  \
        for (int32_t c = 0; c < s->view.channels; c++)                                             \
            to[c] = s->map[c] == FROM_ZERO  ? (TYPE) 0                                             \
                    : s->map[c] == FROM_ONE ? (TYPE) (ONE)                                         \
                                            : from[s->map[c]];                                     \
    }

static void rearrange(source *s, const void *raw, void *rows, size_t count)
{
    const int32_t channels = s->info->channels;
    if (s->view.type == NTP_U8) {
        REARRANGE(uint8_t, 255)
    } else if (s->view.type == NTP_U16) {
        REARRANGE(uint16_t, 65535)
    } else {
        REARRANGE(float, 1)
    }
}

int source_next(source *s, ntp_rect *area, ntpio_error *error)
{
    const uint32_t height = s->info->height;
    if (interrupted_by != 0) {
        fail(error, NTPIO_OK, s->in->path, "interrupted");
        return -1;
    }
    if (s->next == height)
        return ntpio_read_end(s->reader, error) ? 0 : -1;
    const uint32_t left = height - s->next;
    const uint32_t ring = (uint32_t) s->view.ring_rows;
    const uint32_t count = left < ring ? left : ring;
    unsigned char *rows = s->w->rows.data;
    if (s->mapped) {
        const size_t raw_row =
            (size_t) s->info->width * (size_t) s->info->channels * (size_t) s->info->sample_bytes;
        unsigned char *raw = buffer_reserve(&s->w->raw, raw_row * ring);
        if (!ntpio_read_rows(s->reader, raw, (ptrdiff_t) raw_row, count, error))
            return -1;
        rearrange(s, raw, rows, (size_t) s->info->width * count);
    } else if (!ntpio_read_rows(s->reader, rows, s->view.row_stride, count, error)) {
        return -1;
    }
    *area = (ntp_rect) { 0, (int32_t) s->next, s->view.width, (int32_t) (s->next + count) };
    s->next += count;
    atomic_store_explicit(&s->w->permille, (int) ((uint64_t) s->next * 1000 / height),
                          memory_order_relaxed);
    return 1;
}

/* ----------------------------------------------------------------------- the class */

ntp_encoding class_encoding(ntp_class type, int32_t channels)
{
    if (type == NTP_CLASS_HEIGHT || channels < 3)
        return NTP_HEIGHT;
    return type == NTP_CLASS_ZZERO ? NTP_ZZERO : type == NTP_CLASS_XY ? NTP_XY : NTP_STANDARD;
}

bool class_is_normals(ntp_class type)
{
    return type == NTP_CLASS_STANDARD || type == NTP_CLASS_ZZERO || type == NTP_CLASS_XY ||
           type == NTP_CLASS_OBJECT_SPACE;
}

const char *class_title(ntp_class type)
{
    switch (type) {
    case NTP_CLASS_STANDARD:
        return "standard";
    case NTP_CLASS_ZZERO:
        return "Z-zero";
    case NTP_CLASS_XY:
        return "XY-only";
    case NTP_CLASS_HEIGHT:
        return "height map";
    case NTP_CLASS_OBJECT_SPACE:
        return "object-space";
    case NTP_CLASS_ONE_COLOR:
        return "one color";
    default:
        return "no normals texture";
    }
}

/* LabPBR textures keep a height in alpha: there, alpha 0 is a depth, not a hole.  An alpha of
 * only 0 and M is a mask. */
uint32_t touch_for(const ntp_stats *stats, ntp_encoding encoding)
{
    const bool mask = stats->alpha_zero + stats->alpha_full == stats->texels;
    return encoding == NTP_XY && stats->channels == 4 && !mask ? NTP_UNUSED_TRANSPARENT : 0;
}

void facts_free(facts *f)
{
    free(f->levels);
    *f = (facts) { 0 };
}

static void keep_levels(facts *f, source *s)
{
    worker *w = s->w;
    if (w->histogram == NULL)
        w->histogram = need(calloc(65536, sizeof *w->histogram));
    if (ntp_levels_off(w->histogram, 65536, w->tally, f->encoding) != NTP_OK)
        return;
    size_t count = 0;
    for (uint32_t i = 0; i <= f->stats.max; i++)
        count += w->histogram[i] != 0;
    free(f->levels);
    f->levels = need(calloc(count + 1, sizeof *f->levels));
    f->level_count = 0;
    for (uint32_t i = 0; i <= f->stats.max; i++) {
        if (w->histogram[i] != 0)
            f->levels[f->level_count++] = (level_count) { i, w->histogram[i] };
    }
}

bool facts_from_tally(facts *f, source *s, int forced, ntpio_error *error)
{
    f->in = s->in;
    f->info = *s->info;
    f->info.texts = NULL;
    f->info.text_count = 0;
    f->forced = forced >= 0;
    /* heights have no reading of their own: their counts are those of any other */
    const ntp_encoding read_as = s->view.encoding == NTP_HEIGHT ? NTP_STANDARD : s->view.encoding;
    ntp_status status = ntp_summarize(&f->stats, s->w->tally, read_as);
    if (status == NTP_OK)
        status = ntp_classify(&f->type, &f->stats);
    if (status != NTP_OK)
        return library_error(s, status, error);
    if (forced >= 0) {
        f->type.type = (ntp_class) forced;
        f->type.confidence = 1;
    }
    f->encoding = class_encoding(f->type.type, s->view.channels);
    if (s->view.type == NTP_U8 && f->encoding != s->view.encoding && f->encoding != NTP_HEIGHT &&
        s->view.encoding != NTP_HEIGHT)
        status = ntp_summarize(&f->stats, s->w->tally, f->encoding);
    if (status != NTP_OK)
        return library_error(s, status, error);
    f->counts = s->in->named || s->in->hinted || class_is_normals(f->type.type);
    if (f->encoding == NTP_STANDARD || f->encoding == NTP_ZZERO)
        keep_levels(f, s);
    return true;
}

void first_view(source *s, int forced)
{
    static const int8_t EXPAND[4] = { 0, 0, 0, 1 };
    const bool gray = s->info->channels < 3;
    if (forced >= 0 && forced != NTP_CLASS_HEIGHT && gray)
        source_view(s, class_encoding((ntp_class) forced, 3), NTP_Y_UP, EXPAND,
                    s->info->channels + 2);
    else if (forced >= 0)
        source_view(s, class_encoding((ntp_class) forced, s->info->channels), NTP_Y_UP, NULL, 0);
    else
        source_view(s, gray ? NTP_HEIGHT : NTP_STANDARD, NTP_Y_UP, NULL, 0);
}

static bool measure(source *s, uint32_t touch, ntpio_error *error)
{
    ntp_tally_clear(s->w->tally);
    const ntp_const_image view = ntp_image_as_const(&s->view);
    ntp_rect area;
    int more;
    while ((more = source_next(s, &area, error)) > 0) {
        const ntp_status status = ntp_measure(s->w->tally, &view, touch, &area);
        if (status != NTP_OK)
            return library_error(s, status, error);
    }
    return more == 0;
}

bool examine(source *s, int forced, facts *f, ntpio_error *error)
{
    first_view(s, forced);
    if (!measure(s, 0, error) || !facts_from_tally(f, s, forced, error))
        return false;
    const uint32_t touch = touch_for(&f->stats, f->encoding);
    const bool angles_differ = f->encoding != s->view.encoding && s->view.type != NTP_U8;
    const bool alpha_differs = touch != 0 && f->stats.transparent > 0;
    s->view.encoding = f->encoding;
    if (!angles_differ && !alpha_differs)
        return true;
    const ntp_classification type = f->type; /* settled by the first reading */
    const bool counts = f->counts;
    if (!source_rewind(s, error) || !measure(s, touch, error) ||
        !facts_from_tally(f, s, (int) type.type, error))
        return false;
    f->type = type;
    f->forced = forced >= 0;
    f->counts = counts;
    return true;
}
