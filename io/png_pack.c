/* SPDX-License-Identifier: MIT */
/*
 * png_pack.c - the rows of a picture, filtered and packed band by band
 *
 * A band is about four megabytes of rows.  The rule of filters: each row of a band gets the filter with
 * the least sum of distances from 0 (the usual guess), or all of them get the same one, whichever
 * packs best.  From SEARCHES on, that is tried with some of the rows, at level 1; below, the guess
 * is taken.  Normals that were painted or scaled up need none, smooth ones Average, many a mixture.
 *
 * Bands are packed one by one.  Matches reach back into the band before, but nothing else of it is
 * known, so that bands could be packed side by side to the same bytes.
 */
#include "png_pack.h"

#include <stdlib.h>
#include <string.h>

#include "deflate.h"
#include "png_filter.h"

#ifdef NTPIO_HAVE_LIBDEFLATE
#  include <libdeflate.h>
#else
#  include <zlib.h>
#endif

enum {
    BAND = 4 << 20,    /* bytes */
    SMALL = 64 << 10,  /* bytes: pictures that are packed with more care */
    GROUP = 8,         /* rows that follow each other, and are tried together */
    SEARCHES = 5,      /* levels from here on try filters */
    SEARCHES_MORE = 7, /* ... with more rows */
    SEARCHES_ALL = 10, /* ... with all */
    FEW = 32,          /* one of so many groups is tried */
    SOME = 3,
    SAMPLE = 24 << 10, /* bytes: at least so many are tried */
    BARELY = 64,       /* a sample that is smaller by this share, or less, says nothing */
    GUESS = NTPIO__FILTERS,
    CHUNK = 64 << 10, /* bytes: fewer of a file go with those of the next band */
    HEADER = 2,       /* of a zlib stream */
    CHECKSUM = 4      /* at its end */
};

struct ntpio__png_packer {
    ntpio__deflater *deflater;
    int level;
    size_t row_size, texel, pitch;
    uint32_t left, rows, in_band; /* not taken yet; of a band; taken of this one */
    uint8_t *raw;                 /* the row before the band, and the band's */
    uint8_t *filtered;            /* a window of older bytes, the band, the slack */
    size_t known;                 /* bytes of the window */
    uint8_t *guesses[2];          /* rows: the best so far, and another */
    uint8_t *sample, *out;
    size_t waiting; /* bytes in out, too few for a chunk of the file */
    uint32_t checksum;
    bool begun;
};

void ntpio__png_packer_free(ntpio__png_packer *p)
{
    if (p == NULL)
        return;
    ntpio__deflater_free(p->deflater);
    free(p->raw);
    free(p->filtered);
    free(p->guesses[0]);
    free(p->guesses[1]);
    free(p->sample);
    free(p->out);
    free(p);
}

ntpio__png_packer *ntpio__png_packer_new(size_t row_size, uint32_t height, size_t texel, int level)
{
    ntpio__png_packer *p = calloc(1, sizeof *p);
    if (p == NULL)
        return NULL;
    const size_t fit = row_size + 1 < BAND ? BAND / (row_size + 1) : 1;
    const bool small =
        level >= NTPIO__LEVEL_USUAL && level < SEARCHES_ALL && height <= SMALL / (row_size + 1);
    level = small ? SEARCHES_ALL : level; /* that takes no time to speak of */
    p->level = level;
    p->row_size = row_size;
    p->texel = texel;
    p->pitch = NTPIO__TEXEL_MAX + row_size;
    p->left = height;
    p->rows = fit < height ? (uint32_t) fit : height;
    p->checksum = 1;
    const size_t band = p->rows * (row_size + 1);
    p->deflater = ntpio__deflater_new(level);
    p->raw = calloc(p->rows + (size_t) 1, p->pitch);
    p->filtered = malloc(NTPIO__WINDOW + band + NTPIO__SLACK);
    p->guesses[0] = malloc(row_size);
    p->guesses[1] = malloc(row_size);
    p->sample = malloc(band + NTPIO__SLACK);
    p->out = malloc(CHUNK + HEADER + ntpio__deflate_bound(band) + CHECKSUM);
    if (p->deflater != NULL && p->raw != NULL && p->filtered != NULL && p->guesses[0] != NULL &&
        p->guesses[1] != NULL && p->sample != NULL && p->out != NULL)
        return p;
    ntpio__png_packer_free(p);
    return NULL;
}

/* ------------------------------------------------------------------------- filters */

/* Row y of the band; -1: the one before it. */
static uint8_t *raw_row(const ntpio__png_packer *p, int64_t y)
{
    return p->raw + (size_t) (y + 1) * p->pitch + NTPIO__TEXEL_MAX;
}

/* The filter with the least sum; the first of equals. */
static void guess_row(ntpio__png_packer *p, uint32_t y, uint8_t *out)
{
    uint64_t least = UINT64_MAX;
    for (int kind = 0; kind < NTPIO__FILTERS; kind++) {
        const uint64_t sum = ntpio__filter(
            p->guesses[1], raw_row(p, y), raw_row(p, (int64_t) y - 1), p->row_size, p->texel, kind);
        if (sum < least) {
            uint8_t *best = p->guesses[1];
            p->guesses[1] = p->guesses[0];
            p->guesses[0] = best;
            least = sum;
            out[0] = (uint8_t) kind;
        }
        if (least == 0)
            break;
    }
    memcpy(out + 1, p->guesses[0], p->row_size);
}

static void filter_row(ntpio__png_packer *p, uint32_t y, int kind, uint8_t *out)
{
    if (kind == GUESS) {
        guess_row(p, y, out);
        return;
    }
    out[0] = (uint8_t) kind;
    ntpio__filter(out + 1, raw_row(p, y), raw_row(p, (int64_t) y - 1), p->row_size, p->texel, kind);
}

/* One of how many groups of rows is tried. */
static uint32_t stride_of_groups(const ntpio__png_packer *p)
{
    const uint32_t wanted = p->level >= SEARCHES_ALL ? 1 : p->level >= SEARCHES_MORE ? SOME : FEW;
    const size_t size = p->in_band * (p->row_size + 1), most = size / SAMPLE;
    return most < 1 ? 1 : most < wanted ? (uint32_t) most : wanted;
}

static size_t try_kind(ntpio__png_packer *p, int kind)
{
    const uint32_t step = GROUP * stride_of_groups(p);
    size_t size = 0;
    for (uint32_t first = (step - GROUP) / 2; first < p->in_band; first += step) {
        for (uint32_t y = first; y < first + GROUP && y < p->in_band; y++) {
            filter_row(p, y, kind, p->sample + size);
            size += p->row_size + 1;
        }
    }
    memset(p->sample + size, 0, NTPIO__SLACK);
    return size == 0
               ? 0
               : ntpio__deflate(p->deflater, 1, p->sample, 0, size, true, p->out + p->waiting);
}

static int choose_kind(ntpio__png_packer *p)
{
    if (p->level < SEARCHES)
        return GUESS;
    size_t least = try_kind(p, GUESS);
    int best = GUESS;
    for (int kind = 0; kind < NTPIO__FILTERS; kind++) {
        const size_t size = try_kind(p, kind);
        if (size + size / BARELY < least) {
            least = size;
            best = kind;
        }
    }
    return best;
}

/* --------------------------------------------------------------------------- bands */

static uint32_t sum_bytes(uint32_t sum, const uint8_t *bytes, size_t size)
{
#ifdef NTPIO_HAVE_LIBDEFLATE
    return libdeflate_adler32(sum, bytes, size);
#else
    return (uint32_t) adler32(sum, bytes, (uInt) size);
#endif
}

/* The last bytes and the last row stay for the next band. */
static void keep_end(ntpio__png_packer *p, size_t end)
{
    p->known = end < NTPIO__WINDOW ? end : NTPIO__WINDOW;
    memmove(p->filtered, p->filtered + end - p->known, p->known);
    memcpy(raw_row(p, -1), raw_row(p, (int64_t) p->in_band - 1), p->row_size);
    p->in_band = 0;
}

static size_t pack_band(ntpio__png_packer *p)
{
    const size_t from = p->known, to = from + p->in_band * (p->row_size + 1);
    const int kind = choose_kind(p);
    for (uint32_t y = 0; y < p->in_band; y++)
        filter_row(p, y, kind, p->filtered + from + y * (p->row_size + 1));
    memset(p->filtered + to, 0, NTPIO__SLACK);
    p->checksum = sum_bytes(p->checksum, p->filtered + from, to - from);
    size_t size = p->waiting;
    if (!p->begun) { /* a window of 32 KiB, and the usual level */
        p->out[size++] = 0x78;
        p->out[size++] = 0x9c;
    }
    p->begun = true;
    size +=
        ntpio__deflate(p->deflater, p->level, p->filtered, from, to, p->left == 0, p->out + size);
    for (int i = 3; p->left == 0 && i >= 0; i--)
        p->out[size++] = (uint8_t) (p->checksum >> 8 * i);
    keep_end(p, to);
    p->waiting = size < CHUNK && p->left > 0 ? size : 0;
    return p->waiting == 0 ? size : 0;
}

size_t ntpio__png_pack_row(ntpio__png_packer *p, const uint8_t *row, bool swap,
                           const uint8_t **packed)
{
    uint8_t *to = raw_row(p, p->in_band++);
    p->left--;
    if (!swap)
        memcpy(to, row, p->row_size);
    for (size_t i = 0; swap && i < p->row_size; i += 2) {
        to[i] = row[i + 1];
        to[i + 1] = row[i];
    }
    *packed = p->out;
    return p->in_band == p->rows || p->left == 0 ? pack_band(p) : 0;
}
