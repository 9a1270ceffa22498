/* SPDX-License-Identifier: MIT */
/*
 * png_pack.c - the rows of a picture, filtered and packed band by band
 *
 * A band is about four megabytes of rows.  The rule of filters: each row of a band gets the filter with
 * the least sum of distances from 0 (the usual guess), or all of them get the same one, whichever
 * packs best.  From SEARCHES on, that is tried with some of the rows, at level 1; below, the guess
 * is taken.  Normals that were painted or scaled up need none, smooth ones Average, many a mixture.
 *
 * If it is known how large a file of nearly this picture was, and a band takes more than its share
 * of that, the band is packed again at a higher level.  If it is the whole picture, that is done with
 * two rules of filters: those that are best when all rows are tried at the usual level.
 *
 * Matches reach back into the band before, but nothing else of it is known: bands are filtered and
 * packed side by side to the same bytes.  Only the end of the band before is waited for, which is
 * there once that is filtered.  The caller's thread copies rows; others do the work, and so does
 * the caller when it would have to wait.
 */
#include "png_pack.h"

#include <os/threads.h>
#include <stdlib.h>
#include <string.h>

#include "deflate.h"
#include "png_filter.h"
#include "png_sums.h"

#include <zlib.h>

enum {
    SMALL = 64 << 10,  /* bytes: pictures that are packed with more care */
    GROUP = 8,         /* rows that follow each other, and are tried together */
    SEARCHES = 5,      /* levels from here on try filters */
    SEARCHES_MORE = 7, /* ... with more rows */
    SEARCHES_ALL = 10, /* ... with all */
    FEW = 32,          /* one of so many groups is tried */
    SOME = 3,
    SAMPLE = 24 << 10, /* bytes: at least so many are tried */
    LITTLE = 2 << 10,  /* bytes: beside a rival, a sample that packs to less is tried again ... */
    CLOSER = 4,        /* ... with so many times as many rows */
    BARELY = 64,       /* a sample that is smaller by this share, or less, says nothing */
    GUESS = NTPIO__FILTERS,
    KINDS,
    ROUNDS = 2,       /* rules of filters that are tried again */
    NEARLY = 50,      /* a file that is larger than its rival by this share is small enough */
    CHUNK = 64 << 10, /* bytes: fewer of a file go with those of the next band */
    HEADER = 2,       /* of a zlib stream */
    CHECKSUM = 4      /* at its end */
};

/* A band that waits to be packed, or to be written. */
typedef struct band {
    ntpio__deflater *deflater;
    uint8_t *raw;        /* the row before the band, and the band's */
    uint8_t *guesses[2]; /* rows: the best so far, and another */
    uint8_t *filtered;   /* a window of older bytes, the band, the slack; before, what is tried */
    uint8_t *out;        /* packed */
    uint8_t *again;      /* ... with more care, or NULL: there is no rival */
    size_t size;         /* of out */
    uint32_t rows, checksum;
    bool first, last, done;
} band;

/* The last bytes of a filtered band, for the next one. */
typedef struct tail {
    uint8_t bytes[NTPIO__WINDOW];
    size_t size;
    uint32_t ready; /* 1 + the number of the band */
} tail;

struct ntpio__png_packer {
    int level;
    size_t row_size, texel, pitch;
    uint32_t left, rows, in_band; /* not taken yet; of a band; taken of this one */
    uint8_t *before;              /* the last row of the band before */
    uint8_t *joined;              /* small bands, which together make a chunk of the file */
    size_t in_joined;
    uint32_t checksum;
    band bands[NTPIO__PACKERS_MAX + 1]; /* a ring: band n is number n % slots */
    tail *tails; /* a ring of one more: when tail n goes, band n + 1 has been written */
    uint32_t slots;
    uint32_t filled, taken, delivered; /* bands: to be packed, begun, handed out */
    os_lock lock;                      /* of those, `done` and `stop` */
    os_condition changed;
    os_thread threads[NTPIO__PACKERS_MAX];
    int thread_count;
    uint64_t rival; /* bytes of a file with nearly this picture; 0: there is none */
    uint32_t height;
    bool stop;
};

static bool band_init(const ntpio__png_packer *p, band *b, size_t size)
{
    b->deflater = ntpio__deflater_new(p->level);
    b->raw = calloc(p->rows + (size_t) 1, p->pitch);
    b->guesses[0] = malloc(p->row_size);
    b->guesses[1] = malloc(p->row_size);
    b->filtered = malloc(NTPIO__WINDOW + size + NTPIO__SLACK);
    b->out = malloc(HEADER + ntpio__deflate_bound(size) + CHECKSUM);
    return b->deflater != NULL && b->raw != NULL && b->guesses[0] != NULL &&
           b->guesses[1] != NULL && b->filtered != NULL && b->out != NULL;
}

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
    for (uint32_t i = 0; i < p->slots; i++) {
        ntpio__deflater_free(p->bands[i].deflater);
        free(p->bands[i].raw);
        free(p->bands[i].guesses[0]);
        free(p->bands[i].guesses[1]);
        free(p->bands[i].filtered);
        free(p->bands[i].out);
        free(p->bands[i].again);
    }
    free(p->tails);
    free(p->before);
    free(p->joined);
    free(p);
}

/* ------------------------------------------------------------------------- filters */

/* Row y of a band; -1: the one before it. */
static uint8_t *raw_row(const ntpio__png_packer *p, const band *b, int64_t y)
{
    return b->raw + (size_t) (y + 1) * p->pitch + NTPIO__TEXEL_MAX;
}

/* The filter with the least sum; the first of equals. */
static void guess_row(const ntpio__png_packer *p, band *b, uint32_t y, uint8_t *out)
{
    uint64_t least = UINT64_MAX;
    for (int kind = 0; kind < NTPIO__FILTERS; kind++) {
        const uint64_t sum =
            ntpio__filter(b->guesses[1], raw_row(p, b, y), raw_row(p, b, (int64_t) y - 1),
                          p->row_size, p->texel, kind);
        if (sum < least) {
            uint8_t *best = b->guesses[1];
            b->guesses[1] = b->guesses[0];
            b->guesses[0] = best;
            least = sum;
            out[0] = (uint8_t) kind;
        }
        if (least == 0)
            break;
    }
    memcpy(out + 1, b->guesses[0], p->row_size);
}

static void filter_row(const ntpio__png_packer *p, band *b, uint32_t y, int kind, uint8_t *out)
{
    if (kind == GUESS) {
        guess_row(p, b, y, out);
        return;
    }
    out[0] = (uint8_t) kind;
    ntpio__filter(out + 1, raw_row(p, b, y), raw_row(p, b, (int64_t) y - 1), p->row_size, p->texel,
                  kind);
}

/* One of how many groups of rows is tried. */
static uint32_t stride_of_groups(const ntpio__png_packer *p, const band *b)
{
    const uint32_t wanted = p->level >= SEARCHES_ALL ? 1 : p->level >= SEARCHES_MORE ? SOME : FEW;
    const size_t size = b->rows * (p->row_size + 1), most = size / SAMPLE;
    return most < 1 ? 1 : most < wanted ? (uint32_t) most : wanted;
}

static size_t try_kind(const ntpio__png_packer *p, band *b, int kind, uint32_t stride, int level)
{
    const uint32_t step = GROUP * stride;
    size_t size = 0;
    for (uint32_t first = (step - GROUP) / 2; first < b->rows; first += step) {
        for (uint32_t y = first; y < first + GROUP && y < b->rows; y++) {
            filter_row(p, b, y, kind, b->filtered + size);
            size += p->row_size + 1;
        }
    }
    memset(b->filtered + size, 0, NTPIO__SLACK);
    uint8_t *out = b->again != NULL ? b->again : b->out; /* out may have the best so far */
    return size == 0 ? 0 : ntpio__deflate(b->deflater, level, b->filtered, 0, size, true, out);
}

static int choose_kind(const ntpio__png_packer *p, band *b)
{
    if (p->level < SEARCHES)
        return GUESS;
    uint32_t stride = stride_of_groups(p, b);
    size_t least = try_kind(p, b, GUESS, stride, 1);
    for (; p->rival != 0 && least < LITTLE && stride > 1; least = try_kind(p, b, GUESS, stride, 1))
        stride = stride < CLOSER ? 1 : stride / CLOSER;
    int best = GUESS;
    for (int kind = 0; kind < NTPIO__FILTERS; kind++) {
        const size_t size = try_kind(p, b, kind, stride, 1);
        if (size + size / BARELY < least) {
            least = size;
            best = kind;
        }
    }
    return best;
}

/* --------------------------------------------------------------------------- bands */

/* Leaves the end of a band for the next one, which may look back into it. */
static void leave_tail(ntpio__png_packer *p, uint32_t number, const uint8_t *end, size_t size)
{
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

/* Filters the band's rows, and returns their size. */
static size_t filter_rows(const ntpio__png_packer *p, band *b, int kind)
{
    uint8_t *bytes = b->filtered + NTPIO__WINDOW;
    const size_t line = p->row_size + 1, size = b->rows * line;
    for (uint32_t y = 0; y < b->rows; y++)
        filter_row(p, b, y, kind, bytes + y * line);
    memset(bytes + size, 0, NTPIO__SLACK);
    return size;
}

/* Packs what was filtered, which follows the `known` bytes before it.  Returns its size in `out`. */
static size_t pack_rows(const ntpio__png_packer *p, const band *b, int level, size_t known,
                        uint8_t *out)
{
    const uint8_t *bytes = b->filtered + NTPIO__WINDOW - known;
    size_t size = 0;
    if (b->first) { /* a window of 32 KiB, and the usual level */
        out[size++] = 0x78;
        out[size++] = 0x9c;
    }
    return size + ntpio__deflate(b->deflater, level, bytes, known,
                                 known + b->rows * (p->row_size + 1), b->last, out + size);
}

/* Does it take more than its share of the rival, and a bit? */
static bool is_beaten(const ntpio__png_packer *p, const band *b)
{
    const uint64_t share = p->rival * b->rows / p->height;
    return b->size > share + share / NEARLY;
}

/* The smaller one counts. */
static void pack_again(const ntpio__png_packer *p, band *b, int level, size_t known)
{
    const size_t size = pack_rows(p, b, level, known, b->again);
    if (size < b->size) {
        uint8_t *better = b->again;
        b->again = b->out;
        b->out = better;
        b->size = size;
        b->checksum = ntpio__adler32(1, b->filtered + NTPIO__WINDOW, b->rows * (p->row_size + 1));
    }
}

/* The whole picture: other filters may be better where more matches are found. */
static void try_again(const ntpio__png_packer *p, band *b)
{
    size_t sizes[KINDS];
    for (int kind = 0; kind < KINDS; kind++)
        sizes[kind] = try_kind(p, b, kind, 1, NTPIO__LEVEL_USUAL);
    for (int round = 0; round < ROUNDS && is_beaten(p, b); round++) {
        int best = GUESS;
        for (int kind = 0; kind < KINDS; kind++)
            best = sizes[kind] < sizes[best] ? kind : best;
        sizes[best] = SIZE_MAX;
        filter_rows(p, b, best);
        if (round == 0)
            pack_again(p, b, SEARCHES_ALL, 0);
        if (is_beaten(p, b))
            pack_again(p, b, NTPIO__LEVEL_MAX, 0);
    }
}

/* Filters and packs a band. */
static void make_band(ntpio__png_packer *p, uint32_t number)
{
    band *b = &p->bands[number % p->slots];
    uint8_t *bytes = b->filtered + NTPIO__WINDOW;
    const size_t size = filter_rows(p, b, choose_kind(p, b));
    b->first = number == 0;
    leave_tail(p, number, bytes + size, size);
    b->checksum = ntpio__adler32(1, bytes, size);
    const size_t known = take_tail(p, number, bytes);
    b->size = pack_rows(p, b, p->level, known, b->out);
    if (p->rival == 0 || !is_beaten(p, b))
        return;
    if (b->rows == p->height)
        try_again(p, b);
    else
        pack_again(p, b, SEARCHES_ALL, known);
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

ntpio__png_packer *ntpio__png_packer_new(size_t row_size, uint32_t height, size_t texel, int level,
                                         int threads)
{
    ntpio__png_packer *p = calloc(1, sizeof *p);
    if (p == NULL)
        return NULL;
    const size_t fit = row_size + 1 < NTPIO__PACKED_BAND ? NTPIO__PACKED_BAND / (row_size + 1) : 1;
    const bool small =
        level >= NTPIO__LEVEL_USUAL && level < SEARCHES_ALL && height <= SMALL / (row_size + 1);
    os_lock_init(&p->lock);
    os_condition_init(&p->changed);
    p->level = small ? SEARCHES_ALL : level; /* that takes no time to speak of */
    p->row_size = row_size;
    p->texel = texel;
    p->pitch = NTPIO__TEXEL_MAX + row_size;
    p->left = p->height = height;
    p->rows = fit < height ? (uint32_t) fit : height;
    p->checksum = 1;
    const size_t size = p->rows * (row_size + 1);
    const uint32_t bands = (height + p->rows - 1) / p->rows;
    const int most = threads < NTPIO__PACKERS_MAX ? threads : NTPIO__PACKERS_MAX;
    bool good = true;
    /* One more than the threads: the caller fills it meanwhile. */
    p->slots = most < 2 ? 1 : bands < (uint32_t) most + 1 ? bands : (uint32_t) most + 1;
    for (uint32_t i = 0; i < p->slots; i++)
        good = band_init(p, &p->bands[i], size) && good;
    p->tails = calloc(p->slots + (size_t) 1, sizeof *p->tails);
    p->before = calloc(1, row_size);
    p->joined = malloc(CHUNK);
    if (!good || p->tails == NULL || p->before == NULL || p->joined == NULL) {
        ntpio__png_packer_free(p);
        return NULL;
    }
    start_threads(p, (int) p->slots < most ? (int) p->slots - 1 : most - 1);
    return p;
}

bool ntpio__png_packer_rival(ntpio__png_packer *p, uint64_t size)
{
    const size_t most = HEADER + ntpio__deflate_bound(p->rows * (p->row_size + 1)) + CHECKSUM;
    for (uint32_t i = 0; i < p->slots; i++) {
        band *b = &p->bands[i];
        ntpio__deflater_free(b->deflater);
        b->deflater = ntpio__deflater_new(NTPIO__LEVEL_MAX);
        b->again = malloc(most);
        if (b->deflater == NULL || b->again == NULL)
            return false;
    }
    p->rival = size;
    return true;
}

/* Hands the rows that were taken to whoever packs. */
static void fill_band(ntpio__png_packer *p)
{
    band *b = &p->bands[p->filled % p->slots];
    const uint8_t *end = raw_row(p, b, (int64_t) p->in_band - 1);
    os_lock_take(&p->lock);
    b->done = false;
    b->last = p->left == 0;
    b->rows = p->in_band;
    p->in_band = 0;
    p->filled++;
    os_condition_wake_all(&p->changed);
    os_lock_release(&p->lock);
    memcpy(p->before, end, p->row_size); /* nobody changes rows */
}

void ntpio__png_pack_row(ntpio__png_packer *p, const uint8_t *row, bool swap)
{
    const band *b = &p->bands[p->filled % p->slots];
    if (p->in_band == 0)
        memcpy(raw_row(p, b, -1), p->before, p->row_size);
    uint8_t *to = raw_row(p, b, p->in_band++);
    p->left--;
    if (!swap)
        memcpy(to, row, p->row_size);
    for (size_t i = 0; swap && i < p->row_size; i += 2) {
        to[i] = row[i + 1];
        to[i + 1] = row[i];
    }
    if (p->in_band == p->rows || p->left == 0)
        fill_band(p);
}

/* Is the oldest band packed?  If no other can be filled before it is, it is waited for. */
static bool oldest_is_done(ntpio__png_packer *p)
{
    const bool waits = p->left == 0 || p->filled - p->delivered == p->slots;
    const band *b = &p->bands[p->delivered % p->slots];
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

static size_t take_joined(ntpio__png_packer *p, const uint8_t **packed)
{
    const size_t size = p->in_joined;
    p->in_joined = 0;
    *packed = p->joined;
    return size;
}

size_t ntpio__png_packed(ntpio__png_packer *p, const uint8_t **packed)
{
    while (p->delivered < p->filled && oldest_is_done(p)) {
        band *b = &p->bands[p->delivered % p->slots];
        if (p->in_joined + b->size + CHECKSUM > CHUNK && p->in_joined > 0)
            return take_joined(p, packed);
        const size_t size = b->rows * (p->row_size + 1);
        p->checksum = (uint32_t) adler32_combine(p->checksum, b->checksum, (z_off_t) size);
        for (int i = 3; b->last && i >= 0; i--)
            b->out[b->size++] = (uint8_t) (p->checksum >> 8 * i);
        p->delivered++;
        *packed = b->out;
        if (b->size > CHUNK)
            return b->size;
        memcpy(p->joined + p->in_joined, b->out, b->size);
        p->in_joined += b->size;
    }
    return p->left == 0 ? take_joined(p, packed) : 0;
}
