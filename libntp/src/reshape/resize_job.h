/* SPDX-License-Identifier: MIT */
/*
 * resize_job.h - what resize.c and resize_strip.c share
 */
#ifndef NTP_RESIZE_JOB_H
#define NTP_RESIZE_JOB_H

#include "reshape/resize.h"
#include "texel/direction.h"

struct ntp_resize_plan {
    ntp_resize_options how;
    ntp__axis x, y;
};

static inline size_t ntp__align16(size_t n)
{
    return (n + 15) / 16 * 16;
}

/* What is summed up. */
enum {
    SUM_X,
    SUM_Y,
    SUM_Z,
    SUM_WEIGHT, /* alpha of used texels, or 1 */
    SUM_ALPHA,
    SUM_NEGATIVE, /* not 0: texels with z < 0; only Lanczos has it */
    SUM_EXTRA,    /* third sample of NTP_ENCODING_XY, weighted */
    SUMS
};

typedef struct ntp__strip ntp__strip;

enum { NTP__LINE = 64 /* bytes of the cache; strips are aligned to it */ };

typedef struct ntp__resize_job {
    const ntp_image *dst;
    const ntp_const_image *src;
    const ntp_resize_plan *plan;
    int64_t *sum[SUMS]; /* one for each column of src; NULL: not needed */
    double *quick[SUMS];
    ntp__strip *strip; /* NULL: the texture or the filter is not for strips */
    double most;       /* the greatest sum of |weight| of a texel, with alpha */
    int32_t m;
    double *rows;           /* those that resize_columns.c keeps; NULL: none */
    int32_t *held;          /* which these are */
    int32_t room;           /* columns that a row may have */
    int32_t first, columns; /* that it has; they may lie outside */
    bool weighted;          /* with alpha */
    bool quickly;           /* the columns are in quick */
} ntp__resize_job;

/* Finds j->rows in memory that is aligned; leaves it NULL if a texel has too many columns. */
void ntp__find_room(ntp__resize_job *j, void *memory, size_t size);

/* Begins to keep rows for columns x0.. of the result; returns the end of those that there is room for, at most x1. */
int32_t ntp__keep_rows(ntp__resize_job *j, int32_t x0, int32_t x1);

/* The sums of columns x0..x1 - 1 for row y of the result; of kept rows, counted from j->first on. */
void ntp__sum_columns(const ntp__resize_job *j, int32_t y, int32_t x0, int32_t x1);

/* The bytes of a strip, and of what aligns it; 0 if the filter of the plan is too wide. */
size_t ntp__strip_size(const ntp_resize_plan *plan);

/* Makes j->strip ready for columns x0.. of the result; returns the end of those that it has room
 * for, at most x1. */
int32_t ntp__strip_begin(const ntp__resize_job *j, int32_t x0, int32_t x1);

/* The vectors of row y, whose signs and zeros are right; inexact[i]: not 0 where they are not good enough.  Returns
 * how many. */
int32_t ntp__strip_vectors(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact, int32_t y);

/* After that, or after ntp__strip_packed, where sums are beyond 2^53: vector k, that of texel i of the strip, as it is
 * exactly. */
void ntp__strip_exactly(const ntp__resize_job *j, ntp__i128 sum[3], const ntp__vectors *v,
                        int32_t k, int32_t i);

/* Row y as packed pixels.  Returns how many of them are not decided, texels at[0].. of the
 * strip, with their vectors; below 0: no pixel is, and ntp__strip_vectors is the other way. */
int32_t ntp__strip_packed(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact, int32_t *at,
                          int32_t y);

#endif
