/* SPDX-License-Identifier: MIT */
/*
 * resize_columns.c - the sums of columns of ntp_resize where resize_strip.c does not serve
 *
 * The columns of a strip of the result are few enough that its rows are kept until no row of the result needs them,
 * so each is read about once.  A kept row has what is to be summed, as integers in doubles.
 */
#include "base/inlining.h"
#include "reshape/resize_strip.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

typedef ntp__resize_job job;

static ONE_COPY void widen(double *restrict to, const int32_t *restrict from, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        to[i] = from[i];
}

static ONE_COPY void multiply(double *restrict to, const double *restrict v,
                              const double *restrict by, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        to[i] = v[i] * by[i];
}

/* What n texels of row y add to the sums before the weight of the row: planes of those that j has, so far apart. */
static ONE_COPY void read_terms(const job *j, double *to, int32_t apart, int32_t x, int32_t y,
                                int32_t n)
{
    const uint32_t touch = j->plan->how.touch_unused;
    double *by = to + (ptrdiff_t) SUM_WEIGHT * apart, *more = by + apart;
    ntp__block block;
    ntp__vectors v;
    ntp__unpack(&block, j->src, x, y, n);
    ntp__block_vectors(&v, &block, n, j->m, j->src->encoding);
    if (j->sum[SUM_ALPHA] != NULL) {
        widen(more, block.c[3], n);
        more += apart;
    }
    for (int32_t i = 0; !j->weighted && i < n; i++)
        block.c[3][i] = 1; /* nothing is unused for its alpha */
    if (ntp__any_suspect(&block, n, j->m)) {
        for (int32_t i = 0; i < n; i++) {
            if (ntp__unused(block.c[0][i], block.c[1][i], block.c[2][i], 1, j->m, touch) ||
                (block.any_broken && block.broken[i]))
                block.c[3][i] = 0;
        }
    }
    widen(by, block.c[3], n);
    for (int32_t k = 0; k < 3; k++)
        multiply(to + (ptrdiff_t) k * apart, v.c[k], by, n);
    if (j->sum[SUM_NEGATIVE] != NULL) {
        const double *z = to + (ptrdiff_t) SUM_Z * apart;
        for (int32_t i = 0; i < n; i++)
            more[i] = z[i] < 0 ? -z[i] : 0;
        more += apart;
    }
    if (j->sum[SUM_EXTRA] != NULL) {
        widen(v.c[2], block.c[2], n);
        multiply(more, v.c[2], by, n);
    }
}

static ONE_COPY void add_whole(int64_t *restrict sum, const double *restrict terms, int32_t w,
                               int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += (int64_t) terms[i] * w;
}

static ONE_COPY void add_scaled(double *restrict sum, const double *restrict terms, double w,
                                int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += terms[i] * w;
}

/* Adds them, times w, to the sums from column x on. */
static void add_terms(const job *j, const double *terms, int32_t apart, int32_t x, int32_t n,
                      int32_t w)
{
    for (int32_t k = 0; k < SUMS; k++) {
        /* So that nothing cancels what is negative. */
        const int32_t by = k == SUM_NEGATIVE ? ntp__abs(w) : w;
        if (j->sum[k] == NULL)
            continue;
        if (j->quickly)
            add_scaled(j->quick[k] + x, terms, by, n);
        else
            add_whole(j->sum[k] + x, terms, by, n);
        terms += apart;
    }
}

static int32_t planes_of(const job *j)
{
    int32_t planes = 0;
    for (int32_t k = 0; k < SUMS; k++)
        planes += j->sum[k] != NULL;
    return planes;
}

void ntp__find_room(job *j, void *memory, size_t size)
{
    const size_t rows = (size_t) j->plan->y.stride, head = (rows * sizeof *j->held + 7) / 8 * 8;
    const size_t most = (size - head) / (rows * (size_t) planes_of(j) * sizeof *j->rows);
    j->room = most < NTP__BLOCK ? (int32_t) most : NTP__BLOCK;
    if (j->room > j->plan->x.src)
        j->room = j->plan->x.src; /* the sums have no more */
    if (j->room < j->plan->x.stride)
        return;
    j->held = memory;
    j->rows = (double *) (void *) ((char *) memory + head);
}

int32_t ntp__keep_rows(job *j, int32_t x0, int32_t x1)
{
    const ntp__span_of_taps *span = j->plan->x.span;
    int32_t x = x0;
    j->first = span[x0].first;
    for (; x < x1 && span[x].first + span[x].count - j->first <= j->room; x++)
        j->columns = span[x].first + span[x].count - j->first;
    for (int32_t i = 0; i < j->plan->y.stride; i++)
        j->held[i] = NOWHERE;
    return x;
}

/* Row i, which may lie outside. */
static const double *find_row(const job *j, int32_t i)
{
    const ntp__axis *axis = &j->plan->x;
    const int32_t rows = j->plan->y.stride, slot = (i % rows + rows) % rows;
    double *row = j->rows + (ptrdiff_t) slot * planes_of(j) * j->room;
    if (j->held[slot] == i)
        return row;
    j->held[slot] = i;
    for (int32_t c = 0, n = 0; c < j->columns; c += n) {
        const int32_t x = j->first + c, left = j->columns - c;
        n = x < 0 || x >= axis->src ? 1 : axis->src - x < left ? axis->src - x : left;
        read_terms(j, row + c, j->room, ntp__axis_map(axis, x), ntp__axis_map(&j->plan->y, i), n);
    }
    return row;
}

void ntp__sum_columns(const job *j, int32_t y, int32_t x0, int32_t x1)
{
    const ntp__axis *axis = &j->plan->y;
    double terms[SUMS * NTP__BLOCK];
    for (int32_t k = 0; k < SUMS; k++) {
        if (j->sum[k] != NULL)
            memset(j->sum[k] + x0, 0, (size_t) (x1 - x0) * sizeof *j->sum[k]); /* also 0.0 */
    }
    for (int32_t t = 0; t < axis->span[y].count; t++) {
        const int32_t w = axis->weight[(ptrdiff_t) y * axis->stride + t];
        const int32_t row = axis->span[y].first + t;
        if (w == 0)
            continue;
        if (j->rows != NULL) {
            add_terms(j, find_row(j, row), j->room, x0, x1 - x0, w);
            continue;
        }
        for (int32_t x = x0; x < x1; x += NTP__BLOCK) {
            const int32_t n = x1 - x < NTP__BLOCK ? x1 - x : NTP__BLOCK;
            read_terms(j, terms, NTP__BLOCK, x, ntp__axis_map(axis, row), n);
            add_terms(j, terms, NTP__BLOCK, x, n, w);
        }
    }
}
