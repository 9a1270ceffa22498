/* SPDX-License-Identifier: MIT */
/*
 * png_band.c - a band of rows, filtered and packed: which way is the smallest
 *
 * The rule of filters: each row of a band gets the filter with the least sum of distances from 0
 * (the usual guess, and libpng's), or all of them get the same one, whichever packs best.  From
 * SEARCHES on, that is tried with some of the rows, quickly; below, the guess is taken.  Normals
 * that were painted or scaled up need none, smooth ones Average, many a mixture.
 *
 * Costs foresee badly what a long way back repeats, so libpng's defaults can be smaller: the guess,
 * and the matches of zlib's level 6.  From SEARCHES on, two runs of rows are packed as they would do
 * it, too.  Where that is no larger, or hardly, the band is packed both ways, as all bands below
 * MODEST are, and the smaller one stays; of noise, where the runs are like the rest, only that way.
 * Where matches below eight bytes save nothing in these runs, the band is packed without them: that is
 * quicker.
 *
 * Small pictures are tried with several rules of filters, and as libpng would.
 *
 * If it is known how large a file of nearly this picture was, and a band takes more than its share
 * of that, the band is packed again at a higher level.  If it is the whole picture, that is done with
 * two rules of filters: those that are best when all rows are tried at the usual level.
 */
#include "png_band.h"

#include <os/memory.h>
#include <stdlib.h>
#include <string.h>

#include "png_filter.h"
#include "png_sums.h"

enum {
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
    TINY = 10 << 10,    /* bytes: of so small a picture all kinds are tried */
    RUN = 64 << 10,     /* bytes of each of two runs, ... */
    RUNS_OF = 16,       /* ... or this share of the band */
    RUN_MIN = 8 << 10,  /* ... but so many */
    MODEST = 128 << 10, /* bytes: of smaller bands, runs tell too little */
    CLEARLY = 256,      /* runs that are larger by less may be the smaller ones as a whole */
    ALIKE = 32,   /* runs that differ by less tell which way is the smaller one as a whole ... */
    NOISE = 8,    /* ... if they pack to more than this share of themselves */
    HARDLY = 256, /* where short matches save less than this share, a band does without, ... */
    MUCH = 32,    /* ... but not where they save more than this, ... */
    FLAT = 64,    /* ... or where the runs pack to less than this share of themselves */
    ROUNDS = 2,   /* rules of filters that are tried again */
    NEARLY = 50   /* a file that is larger than its rival by this share is small enough */
};

static size_t most_packed(const ntpio__banding *p)
{
    return NTPIO__ZLIB_HEADER + ntpio__deflate_bound(p->rows * (p->row_size + 1)) +
           NTPIO__ZLIB_CHECKSUM;
}

/* The texel before each row is zeros. */
static uint8_t *new_rows(const ntpio__banding *p)
{
    const size_t rows = p->at_once ? 2 : p->rows + (size_t) 1;
    uint8_t *raw = malloc(rows * p->pitch);
    os_large_pages(raw, rows * p->pitch);
    for (size_t y = 0; raw != NULL && y < rows; y++)
        memset(raw + y * p->pitch, 0, NTPIO__TEXEL_MAX);
    return raw;
}

bool ntpio__band_init(const ntpio__banding *p, ntpio__band *b)
{
    const size_t size = p->rows * (p->row_size + 1);
    ntpio__band_free(b);
    b->deflater = ntpio__deflater_new(p->rival != 0 ? NTPIO__LEVEL_MAX : p->level);
    b->raw = new_rows(p);
    b->filtered = os_alloc_large(NTPIO__WINDOW + size + NTPIO__SLACK);
    b->out = malloc(most_packed(p));
    const bool tries = p->level >= SEARCHES || p->rival != 0;
    b->again = tries ? malloc(most_packed(p)) : NULL;
    return b->deflater != NULL && b->raw != NULL && b->filtered != NULL && b->out != NULL &&
           (b->again != NULL || !tries);
}

void ntpio__band_free(ntpio__band *b)
{
    ntpio__deflater_free(b->deflater);
    free(b->raw);
    free(b->filtered);
    free(b->out);
    free(b->again);
    *b = (ntpio__band) { 0 };
}

/* ------------------------------------------------------------------------- filters */

uint8_t *ntpio__band_row(const ntpio__banding *p, const ntpio__band *b, int64_t y)
{
    const size_t row = (size_t) (y + 1);
    return b->raw + (p->at_once ? row % 2 : row) * p->pitch + NTPIO__TEXEL_MAX;
}

/* The filter with the least sum; the first of equals.  As in libpng, not Average in a single column
 * or row, where the others are None or one of the neighbors. */
static int guess_kind(const ntpio__banding *p, const ntpio__band *b, uint32_t y)
{
    uint64_t sums[NTPIO__FILTERS];
    int best = 0;
    ntpio__filter_sums(ntpio__band_row(p, b, y), ntpio__band_row(p, b, (int64_t) y - 1),
                       p->row_size, p->texel, sums);
    if (p->row_size == p->texel || p->height == 1)
        sums[NTPIO__AVERAGE] = UINT64_MAX;
    for (int kind = 1; kind < NTPIO__FILTERS; kind++)
        best = sums[kind] < sums[best] ? kind : best;
    return best;
}

/* Filters `count` rows from `first` on, and returns their size. */
static size_t filter_rows(const ntpio__banding *p, const ntpio__band *b, uint32_t first,
                          uint32_t count, int kind, uint8_t *out)
{
    const uint8_t *start = out;
    for (uint32_t y = first; y < first + count; y++) {
        out[0] = (uint8_t) (kind == GUESS ? guess_kind(p, b, y) : kind);
        ntpio__filter(out + 1, ntpio__band_row(p, b, y), ntpio__band_row(p, b, (int64_t) y - 1),
                      p->row_size, p->texel, out[0]);
        out += p->row_size + 1;
    }
    return (size_t) (out - start);
}

bool ntpio__band_takes_guess(int level)
{
    return level < SEARCHES;
}

void ntpio__band_filter_row(const ntpio__banding *p, const ntpio__band *b, uint32_t y)
{
    filter_rows(p, b, y, 1, GUESS, b->filtered + NTPIO__WINDOW + y * (p->row_size + 1));
}

/* One of how many groups of rows is tried. */
static uint32_t stride_of_groups(const ntpio__banding *p, const ntpio__band *b)
{
    const uint32_t wanted = p->level >= SEARCHES_ALL ? 1 : p->level >= SEARCHES_MORE ? SOME : FEW;
    const size_t most = ntpio__band_size(p, b) / SAMPLE;
    return most < 1 ? 1 : most < wanted ? (uint32_t) most : wanted;
}

static size_t try_kind(const ntpio__banding *p, ntpio__band *b, int kind, uint32_t stride,
                       int level)
{
    const uint32_t step = GROUP * stride;
    size_t size = 0;
    for (uint32_t y = (step - GROUP) / 2; y < b->rows; y += step) {
        const uint32_t count = b->rows - y < GROUP ? b->rows - y : GROUP;
        size += filter_rows(p, b, y, count, kind, b->filtered + size);
    }
    memset(b->filtered + size, 0, NTPIO__SLACK);
    return size == 0 ? 0 : ntpio__deflate(b->deflater, level, b->filtered, 0, size, true, b->again);
}

static int choose_kind(const ntpio__banding *p, ntpio__band *b)
{
    if (p->level < SEARCHES)
        return GUESS;
    uint32_t stride = stride_of_groups(p, b);
    size_t least = try_kind(p, b, GUESS, stride, NTPIO__LEVEL_TRIAL);
    for (; p->rival != 0 && least < LITTLE && stride > 1;
         least = try_kind(p, b, GUESS, stride, NTPIO__LEVEL_TRIAL))
        stride = stride < CLOSER ? 1 : stride / CLOSER;
    int best = GUESS;
    for (int kind = 0; kind < NTPIO__FILTERS; kind++) {
        const size_t size = try_kind(p, b, kind, stride, NTPIO__LEVEL_TRIAL);
        if (size + size / BARELY < least) {
            least = size;
            best = kind;
        }
    }
    return best;
}

/* What two runs of rows take, and what of that matches below eight bytes have saved. */
typedef struct trial {
    size_t filtered, packed, saved_by_short;
} trial;

/* At a quarter of the band and at three quarters, packed with what is before them. */
static trial try_runs(const ntpio__banding *p, ntpio__band *b, int kind, int level)
{
    const size_t line = p->row_size + 1, share = ntpio__band_size(p, b) / RUNS_OF;
    const size_t run = share > RUN ? RUN : share < RUN_MIN ? RUN_MIN : share;
    const uint32_t rows = (uint32_t) ((run + line - 1) / line), before = NTPIO__WINDOW / line;
    trial t = { 0, 0, 0 };
    for (uint32_t part = 1; part < 4; part += 2) {
        const uint32_t first = (uint32_t) ((uint64_t) b->rows * part / 4);
        const uint32_t count = b->rows - first < rows ? b->rows - first : rows;
        const uint32_t back = first < before ? first : before;
        const size_t to = filter_rows(p, b, first - back, back + count, kind, b->filtered);
        memset(b->filtered + to, 0, NTPIO__SLACK);
        t.packed +=
            ntpio__deflate(b->deflater, level, b->filtered, back * line, to, true, b->again);
        t.saved_by_short += ntpio__deflate_saved_by_short(b->deflater);
        t.filtered += count * line;
    }
    return t;
}

/* Is the band no larger, or hardly, without short matches?  Of nearly flat ones, runs tell too little. */
static bool does_without_short(const ntpio__banding *p, ntpio__band *b, const trial *ours)
{
    if (p->level > NTPIO__LEVEL_USUAL || ours->packed < ours->filtered / FLAT ||
        ours->saved_by_short > ours->packed / MUCH)
        return false;
    return ours->saved_by_short < ours->packed / HARDLY ||
           try_runs(p, b, b->kind, NTPIO__LEVEL_FAR).packed <= ours->packed;
}

/* Chooses the filters, and the level that packs them; or two ways that are to be compared. */
static void choose_way(const ntpio__banding *p, ntpio__band *b)
{
    b->kind = choose_kind(p, b);
    b->level = p->level;
    b->close = p->level >= SEARCHES && ntpio__band_size(p, b) < MODEST;
    if (p->level < SEARCHES || b->close)
        return;
    const trial run = try_runs(p, b, b->kind, p->level);
    const size_t ours = run.packed, theirs = try_runs(p, b, GUESS, NTPIO__LEVEL_ZLIB).packed;
    if (theirs > ours + ours / CLEARLY) {
        if (does_without_short(p, b, &run))
            b->level = NTPIO__LEVEL_FAR;
        return;
    }
    if (theirs > ours - ours / ALIKE && theirs > run.filtered / NOISE) {
        b->kind = GUESS;
        b->level = NTPIO__LEVEL_ZLIB;
    } else {
        b->close = true;
    }
}

/* --------------------------------------------------------------------------- bands */

static void filter_band(const ntpio__banding *p, ntpio__band *b, int kind)
{
    uint8_t *bytes = b->filtered + NTPIO__WINDOW;
    if (!p->at_once)
        filter_rows(p, b, 0, b->rows, kind, bytes);
    memset(bytes + ntpio__band_size(p, b), 0, NTPIO__SLACK);
}

/* Packs what was filtered.  The smaller one counts: then it is in `out`. */
static bool pack_way(const ntpio__banding *p, ntpio__band *b, int level, size_t known)
{
    uint8_t *out = b->size == SIZE_MAX ? b->out : b->again;
    const uint8_t *bytes = b->filtered + NTPIO__WINDOW - known;
    const size_t filtered = ntpio__band_size(p, b);
    size_t header = 0;
    if (b->first) { /* a window of 32 KiB, and the usual level */
        out[header++] = 0x78;
        out[header++] = 0x9c;
    }
    const size_t size = header + ntpio__deflate(b->deflater, level, bytes, known, known + filtered,
                                                b->last, out + header);
    if (size >= b->size)
        return false;
    if (out == b->again) {
        b->again = b->out;
        b->out = out;
    }
    b->size = size;
    b->bits = 8 * header + ntpio__deflated_bits(b->deflater);
    b->shifts = ntpio__deflated_shifts(b->deflater);
    b->checksum = ntpio__adler32(1, b->filtered + NTPIO__WINDOW, filtered);
    return true;
}

/* Does it take more than its share of the rival, and a bit? */
static bool is_beaten(const ntpio__banding *p, const ntpio__band *b)
{
    const uint64_t share = p->rival * b->rows / p->height;
    return p->rival != 0 && b->size > share + share / NEARLY;
}

static int take_least(size_t *sizes)
{
    int best = GUESS;
    for (int kind = 0; kind < KINDS; kind++)
        best = sizes[kind] < sizes[best] ? kind : best;
    sizes[best] = SIZE_MAX;
    return best;
}

/* The whole picture: other filters may be better where more matches are found. */
static void try_again(const ntpio__banding *p, ntpio__band *b)
{
    size_t sizes[KINDS];
    for (int kind = 0; kind < KINDS; kind++)
        sizes[kind] = try_kind(p, b, kind, 1, NTPIO__LEVEL_USUAL);
    for (int round = 0; round < ROUNDS && is_beaten(p, b); round++) {
        filter_band(p, b, take_least(sizes));
        if (round == 0)
            pack_way(p, b, SEARCHES_ALL, 0);
        if (is_beaten(p, b))
            pack_way(p, b, NTPIO__LEVEL_MAX, 0);
    }
}

/* The smaller the picture, the more rules of filters are tried; all are below TINY. */
static void pack_small(const ntpio__banding *p, ntpio__band *b)
{
    size_t sizes[KINDS];
    const size_t most = TINY * KINDS / ntpio__band_size(p, b);
    for (int kind = 0; kind < KINDS; kind++)
        sizes[kind] = try_kind(p, b, kind, 1, NTPIO__LEVEL_TRIAL);
    for (size_t i = 0; i < KINDS && (i == 0 || i < most); i++) {
        filter_band(p, b, take_least(sizes));
        pack_way(p, b, p->level, 0);
    }
    filter_band(p, b, GUESS);
    pack_way(p, b, NTPIO__LEVEL_ZLIB, 0);
}

bool ntpio__band_filter(const ntpio__banding *p, ntpio__band *b)
{
    b->size = SIZE_MAX;
    b->close = false;
    if (p->small)
        return false;
    choose_way(p, b);
    filter_band(p, b, b->kind);
    return !b->close || b->kind == GUESS;
}

void ntpio__band_pack(const ntpio__banding *p, ntpio__band *b, size_t known)
{
    if (p->small)
        pack_small(p, b);
    else
        pack_way(p, b, b->level, known);
    if (b->close) {
        if (b->kind != GUESS)
            filter_band(p, b, GUESS);
        if (!pack_way(p, b, NTPIO__LEVEL_ZLIB, known) && b->kind != GUESS)
            filter_band(p, b, b->kind);
    }
    if (is_beaten(p, b)) {
        if (b->rows == p->height)
            try_again(p, b);
        else
            pack_way(p, b, SEARCHES_ALL, known);
    }
}
