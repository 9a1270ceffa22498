/* SPDX-License-Identifier: MIT */
/*
 * png_pack.c - the rows of a picture, packed band by band
 *
 * A band is four megabytes of rows, or what is nearest if all are to have as many; below six, the
 * picture is one band.
 *
 * Matches reach back into the band before, but nothing else of it is known: bands are filtered and
 * packed side by side to the same bytes (png_band.c).  Only the end of the band before is waited
 * for, which is there once that is filtered, or at times packed.  The caller's thread copies rows;
 * others do the work, and so does the caller when it would have to wait.
 */
#include "png_pack.h"

#include <os/threads.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "png_band.h"
#include "png_filter.h"

enum {
    SMALL = 68 << 10, /* bytes: pictures that are packed with more care */
    CAREFUL = 10,     /* ... from this level on */
    CHUNK = 64 << 10, /* bytes: fewer of a file go with those of the next band */
    ENDING = 16 /* bytes at most: fill bits up to whole bytes before and after a band; checksum */
};

/* The last bytes of a filtered band, for the next one. */
typedef struct tail {
    uint8_t bytes[NTPIO__WINDOW];
    size_t size;
    uint32_t ready; /* 1 + the number of the band */
} tail;

struct ntpio__png_packer {
    ntpio__banding shared;
    uint32_t left, in_band; /* rows: not taken yet; taken of this band */
    uint8_t *before;        /* the last row of the band before */
    uint8_t *joined;        /* small bands, which together make a chunk of the file */
    size_t in_joined;       /* bits */
    uint32_t checksum;
    ntpio__band bands[NTPIO__PACKERS_MAX + 1]; /* a ring: band n is number n % slots */
    tail *tails; /* a ring of one more: when tail n goes, band n + 1 has been written */
    uint32_t slots;
    uint32_t filled, taken, delivered; /* bands: to be packed, begun, handed out */
    os_lock lock;                      /* of those, `done` and `stop` */
    os_condition changed;
    os_thread threads[NTPIO__PACKERS_MAX];
    int thread_count;
    bool stop;
};

void ntpio__png_packer_free(ntpio__png_packer *p)
{
    if (p == NULL)
        return;
    os_lock_take(&p->lock);
    p->stop = true;
    os_condition_wake_all(&p->changed);
    os_lock_release(&p->lock);
    for (int i = 0; i < p->thread_count; i++)
        os_thread_join(p->threads[i]);
    os_condition_destroy(&p->changed);
    os_lock_destroy(&p->lock);
    for (uint32_t i = 0; i < p->slots; i++)
        ntpio__band_free(&p->bands[i]);
    free(p->tails);
    free(p->before);
    free(p->joined);
    free(p);
}

/* Leaves the end of a band for the next one, if there is one, which may look back into it. */
static void leave_tail(ntpio__png_packer *p, uint32_t number, const uint8_t *end, size_t size)
{
    if (p->bands[number % p->slots].last)
        return;
    tail *t = &p->tails[number % (p->slots + 1)];
    t->size = size < NTPIO__WINDOW ? size : NTPIO__WINDOW;
    memcpy(t->bytes, end - t->size, t->size);
    os_lock_take(&p->lock);
    t->ready = number + 1;
    os_condition_wake_all(&p->changed);
    os_lock_release(&p->lock);
}

/* Puts the end of the band before in front of a band's bytes.  Returns its size. */
static size_t take_tail(ntpio__png_packer *p, uint32_t number, uint8_t *bytes)
{
    if (number == 0)
        return 0;
    const tail *t = &p->tails[(number - 1) % (p->slots + 1)];
    os_lock_take(&p->lock);
    while (t->ready != number)
        os_condition_wait(&p->changed, &p->lock);
    os_lock_release(&p->lock);
    memcpy(bytes - t->size, t->bytes, t->size);
    return t->size;
}

/* Filters and packs a band. */
static void make_band(ntpio__png_packer *p, uint32_t number)
{
    ntpio__band *b = &p->bands[number % p->slots];
    uint8_t *bytes = b->filtered + NTPIO__WINDOW;
    const size_t size = ntpio__band_size(&p->shared, b);
    b->first = number == 0;
    const bool settled = ntpio__band_filter(&p->shared, b);
    if (settled)
        leave_tail(p, number, bytes + size, size);
    ntpio__band_pack(&p->shared, b, take_tail(p, number, bytes));
    if (!settled)
        leave_tail(p, number, bytes + size, size);
}

/* Packs the next band that nobody has begun.  The lock is held before and after. */
static void pack_next(ntpio__png_packer *p)
{
    const uint32_t number = p->taken++;
    os_lock_release(&p->lock);
    make_band(p, number);
    os_lock_take(&p->lock);
    p->bands[number % p->slots].done = true;
    os_condition_wake_all(&p->changed);
}

static void *pack_bands(void *context)
{
    ntpio__png_packer *p = context;
    os_lock_take(&p->lock);
    while (!p->stop) {
        if (p->taken < p->filled)
            pack_next(p);
        else
            os_condition_wait(&p->changed, &p->lock);
    }
    os_lock_release(&p->lock);
    return NULL;
}

/* If the system refuses some, the others do the work. */
static void start_threads(ntpio__png_packer *p, int count)
{
    while (p->thread_count < count &&
           os_thread_start(&p->threads[p->thread_count], pack_bands, p) == 0)
        p->thread_count++;
}

/* Rows of a band.  Pictures of powers of two have no small rest, which would take codes of its own. */
static uint32_t rows_of_bands(size_t line, uint32_t height)
{
    const uint64_t near = ((uint64_t) height * line + NTPIO__PACKED_BAND / 2) / NTPIO__PACKED_BAND;
    const uint64_t bands = near < 1 ? 1 : near < height ? near : height;
    return (uint32_t) ((height + bands - 1) / bands);
}

ntpio__png_packer *ntpio__png_packer_new(size_t row_size, uint32_t height, size_t texel, int level,
                                         int threads)
{
    ntpio__png_packer *p = calloc(1, sizeof *p);
    if (p == NULL)
        return NULL;
    const uint32_t rows = rows_of_bands(row_size + 1, height);
    const bool small =
        level >= NTPIO__LEVEL_USUAL && height <= SMALL / (row_size + 1) && rows == height;
    os_lock_init(&p->lock);
    os_condition_init(&p->changed);
    p->shared = (ntpio__banding) {
        .level = small && level < CAREFUL ? CAREFUL : level, /* that takes no time to speak of */
        .small = small,
        /* One thread would only read the rows again; of several, those that pack filter as well. */
        .at_once = threads < 2 && ntpio__band_takes_guess(level),
        .row_size = row_size,
        .texel = texel,
        .pitch = NTPIO__TEXEL_MAX + row_size,
        .height = height,
        .rows = rows,
    };
    p->left = height;
    p->checksum = 1;
    const uint32_t bands = (height + p->shared.rows - 1) / p->shared.rows;
    const int most = threads < NTPIO__PACKERS_MAX ? threads : NTPIO__PACKERS_MAX;
    bool good = true;
    /* One more than the threads: the caller fills it meanwhile. */
    p->slots = most < 2 ? 1 : bands < (uint32_t) most + 1 ? bands : (uint32_t) most + 1;
    for (uint32_t i = 0; i < p->slots; i++)
        good = ntpio__band_init(&p->shared, &p->bands[i]) && good;
    p->tails = malloc((p->slots + (size_t) 1) * sizeof *p->tails);
    for (uint32_t i = 0; p->tails != NULL && i <= p->slots; i++)
        p->tails[i].ready = 0;
    p->before = calloc(1, row_size);
    p->joined = malloc(CHUNK + ENDING);
    if (!good || p->tails == NULL || p->before == NULL || p->joined == NULL) {
        ntpio__png_packer_free(p);
        return NULL;
    }
    start_threads(p, (int) p->slots < most ? (int) p->slots - 1 : most - 1);
    return p;
}

bool ntpio__png_packer_rival(ntpio__png_packer *p, uint64_t size)
{
    bool good = true;
    p->shared.rival = size;
    for (uint32_t i = 0; i < p->slots; i++)
        good = ntpio__band_init(&p->shared, &p->bands[i]) && good;
    return good;
}

/* Hands the rows that were taken to whoever packs. */
static void fill_band(ntpio__png_packer *p)
{
    ntpio__band *b = &p->bands[p->filled % p->slots];
    const uint8_t *end = ntpio__band_row(&p->shared, b, (int64_t) p->in_band - 1);
    os_lock_take(&p->lock);
    b->done = false;
    b->last = p->left == 0;
    b->rows = p->in_band;
    p->in_band = 0;
    p->filled++;
    os_condition_wake_all(&p->changed);
    os_lock_release(&p->lock);
    memcpy(p->before, end, p->shared.row_size); /* nobody changes rows */
}

/* Copies samples of two bytes, which change places. */
static void copy_swapped(uint8_t *restrict to, const uint8_t *restrict from, size_t size)
{
    for (size_t i = 0; i < size; i += 2) {
        uint16_t sample;
        memcpy(&sample, from + i, sizeof sample);
        sample = (uint16_t) (sample << 8 | sample >> 8);
        memcpy(to + i, &sample, sizeof sample);
    }
}

void ntpio__png_pack_row(ntpio__png_packer *p, const uint8_t *row, bool swap)
{
    const ntpio__band *b = &p->bands[p->filled % p->slots];
    if (p->in_band == 0)
        memcpy(ntpio__band_row(&p->shared, b, -1), p->before, p->shared.row_size);
    uint8_t *to = ntpio__band_row(&p->shared, b, p->in_band);
    p->left--;
    if (swap)
        copy_swapped(to, row, p->shared.row_size);
    else
        memcpy(to, row, p->shared.row_size);
    if (p->shared.at_once)
        ntpio__band_filter_row(&p->shared, b, p->in_band);
    p->in_band++;
    if (p->in_band == p->shared.rows || p->left == 0)
        fill_band(p);
}

/* Is the oldest band packed?  If no other can be filled before it is, it is waited for. */
static bool oldest_is_done(ntpio__png_packer *p)
{
    const bool waits = p->left == 0 || p->filled - p->delivered == p->slots;
    const ntpio__band *b = &p->bands[p->delivered % p->slots];
    os_lock_take(&p->lock);
    while (waits && !b->done) {
        if (p->taken < p->filled)
            pack_next(p);
        else
            os_condition_wait(&p->changed, &p->lock);
    }
    const bool done = b->done;
    os_lock_release(&p->lock);
    return done;
}

/* Up to a whole byte, by an empty block that is stored.  Zeros stand after what was joined. */
static void fill_up(ntpio__png_packer *p)
{
    static const uint8_t empty[] = { 0, 0, 0xff, 0xff }; /* its length, and that inverted */
    const size_t size = (p->in_joined + 3 + 7) / 8;
    memcpy(p->joined + size, empty, sizeof empty);
    p->in_joined = 8 * (size + sizeof empty);
}

static size_t take_joined(ntpio__png_packer *p, bool ends, const uint8_t **packed)
{
    if (!ends)
        fill_up(p);
    const size_t size = (p->in_joined + 7) / 8;
    p->in_joined = 0;
    *packed = p->joined;
    return size;
}

/* Adds the bits of a band, and zeros: an empty block begins with three. */
static void join(ntpio__png_packer *p, const ntpio__band *b)
{
    const size_t size = (b->bits + 7) / 8;
    if (!b->shifts && p->in_joined % 8 != 0)
        fill_up(p);
    const unsigned shift = (unsigned) (p->in_joined % 8);
    uint8_t *to = p->joined + p->in_joined / 8;
    uint32_t carried = shift != 0 ? *to : 0;
    for (size_t i = 0; i < size; i++) {
        carried |= (uint32_t) b->out[i] << shift;
        to[i] = (uint8_t) carried;
        carried >>= 8;
    }
    to[size] = (uint8_t) carried;
    to[size + 1] = 0;
    p->in_joined += b->bits;
}

/* The stream's checksum follows its last band. */
static uint8_t *put_checksum(const ntpio__png_packer *p, uint8_t *to)
{
    for (int i = 3; i >= 0; i--)
        *to++ = (uint8_t) (p->checksum >> 8 * i);
    return to;
}

static size_t take_band(const ntpio__png_packer *p, const ntpio__band *b, const uint8_t **packed)
{
    const uint8_t *end = b->out + b->size;
    if (b->last)
        end = put_checksum(p, b->out + b->size);
    *packed = b->out;
    return (size_t) (end - b->out);
}

size_t ntpio__png_packed(ntpio__png_packer *p, const uint8_t **packed)
{
    while (p->delivered < p->filled && oldest_is_done(p)) {
        const ntpio__band *b = &p->bands[p->delivered % p->slots];
        const size_t size = ntpio__band_size(&p->shared, b);
        if (p->in_joined > 0 && p->in_joined + b->bits + (size_t) 8 * ENDING > (size_t) 8 * CHUNK)
            return take_joined(p, false, packed);
        p->checksum = (uint32_t) adler32_combine(p->checksum, b->checksum, (z_off_t) size);
        p->delivered++;
        if (b->size > CHUNK)
            return take_band(p, b, packed);
        join(p, b);
        if (b->last) {
            const size_t used = (p->in_joined + 7) / 8;
            p->in_joined = 8 * (size_t) (put_checksum(p, p->joined + used) - p->joined);
        }
    }
    return p->left == 0 ? take_joined(p, true, packed) : 0;
}
