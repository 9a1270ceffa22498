/* SPDX-License-Identifier: MIT */
/*
 * resize_strip.h - what resize_strip.c and resize_read.c share: the rows of a strip
 */
#ifndef NTP_RESIZE_STRIP_H
#define NTP_RESIZE_STRIP_H

#include "reshape/resize_job.h"
#include "reshape/resize_kernels.h"

enum {
    MOST_TAPS = 32,
    WIDEST = NTP__MOST_COLUMNS,
    MORE = 16,                            /* columns than a block has, of packed pixels */
    PADDED = NTP__BLOCK + MOST_TAPS + 16, /* weights of 0 may follow the last column */
    NOWHERE = -(1 << 30)                  /* is no row */
};

/* Vectors of 32 bytes are read and written quicker if none is in two lines of the cache.  So the
 * strip is aligned, and the sizes of its large members are multiples of a line. */
struct ntp__strip {
    double weight[WIDEST * (MOST_TAPS + 2)];
    float weight_in_float[WIDEST * (MOST_TAPS + 2)];
    double sums[4 * PADDED];
    float sums_in_float[4 * PADDED];
    int32_t x0, n;          /* columns of the result */
    int32_t first, columns; /* of the source; they may lie outside */
    int32_t taps_x, rows;
    int32_t at[WIDEST];          /* where the columns of a texel begin */
    bool in_floats;              /* they are exact */
    bool wide;                   /* there is AVX-512 */
    bool packed;                 /* rows are made of floats, as packed pixels */
    bool whole;                  /* rows of the source are int16_t */
    bool placed;                 /* they are read as packed pixels, with AVX2 */
    bool halved;                 /* they are runs of NTP__RUN numbers (resize_kernels.h) */
    int32_t pause;               /* rows for which packed pixels are not tried */
    int32_t held[MOST_TAPS + 1]; /* rows, which may lie outside */
    bool negative[MOST_TAPS + 1];
    bool holes[MOST_TAPS + 1];       /* one of their texels is unused */
    _Alignas(NTP__LINE) float row[]; /* 4 PADDED numbers for each */
};

/* What a row of the strip has. */
typedef struct ntp__strip_row {
    bool negative; /* a z below 0 */
    bool holes;
} ntp__strip_row;

/* Forgets all rows. */
void ntp__strip_forget(ntp__strip *s);

/* The rows of row y of the result. */
ntp__strip_row ntp__strip_rows(const ntp__resize_job *j, const float **rows, int32_t y);

/* Does a texel that texel i of row y is made of have a negative z?  `rows` are those of row y. */
bool ntp__strip_any_negative(const ntp__resize_job *j, const float *const *rows, int32_t i,
                             int32_t y);

#endif
