/* SPDX-License-Identifier: MIT */
/*
 * png_band.h - a band of rows, filtered and packed: which way is the smallest
 */
#ifndef NTPIO_PNG_BAND_H
#define NTPIO_PNG_BAND_H

#include "deflate.h"

enum {
    NTPIO__ZLIB_HEADER = 2,  /* bytes of a stream before its blocks */
    NTPIO__ZLIB_CHECKSUM = 4 /* at its end */
};

/* What all bands of a picture share. */
typedef struct ntpio__banding {
    int level;
    bool small;   /* the picture, which is one band; several ways are tried */
    bool at_once; /* rows are filtered as they come, and only the last two are kept */
    size_t row_size, texel, pitch;
    uint32_t height, rows; /* rows of a band, but for the last one */
    uint64_t rival;        /* bytes of a file with nearly this picture; 0: there is none */
} ntpio__banding;

/* A band that waits to be packed, or to be written. */
typedef struct ntpio__band {
    ntpio__deflater *deflater;
    uint8_t *raw;      /* the row before the band, and the band's; or the last two of these */
    uint8_t *filtered; /* a window of older bytes, the band, the slack; before, what is tried */
    uint8_t *out;      /* packed */
    uint8_t *again;    /* ... another way; before, what is tried; NULL where nothing is */
    size_t size, bits; /* of out; without what fills it up to a whole byte */
    int kind, level;   /* of the filters, and of packing: what is chosen */
    uint32_t rows, checksum;
    bool first, last, done;
    bool close;  /* packing as libpng does is to be tried as well */
    bool shifts; /* `out` may begin within a byte */
} ntpio__band;

/* Of a band that fits `p`.  False: no memory. */
bool ntpio__band_init(const ntpio__banding *p, ntpio__band *b);
void ntpio__band_free(ntpio__band *b);

/* Are no other ways to filter tried than row by row at this level? */
bool ntpio__band_takes_guess(int level);

/* Filters row y, where rows are filtered as they come. */
void ntpio__band_filter_row(const ntpio__banding *p, const ntpio__band *b, uint32_t y);

/* Row y of a band; -1: the one before it. */
uint8_t *ntpio__band_row(const ntpio__banding *p, const ntpio__band *b, int64_t y);

/* Filters its rows.  True: these filters stay.  False: packing decides. */
bool ntpio__band_filter(const ntpio__banding *p, ntpio__band *b);

/* Packs what was filtered, which follows the `known` bytes before it. */
void ntpio__band_pack(const ntpio__banding *p, ntpio__band *b, size_t known);

/* The filtered bytes of the band. */
static inline size_t ntpio__band_size(const ntpio__banding *p, const ntpio__band *b)
{
    return b->rows * (p->row_size + 1);
}

#endif
