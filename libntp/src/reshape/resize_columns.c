/* SPDX-License-Identifier: MIT */
/*
 * resize_columns.c - the sums of columns of ntp_resize where resize_strip.c does not serve
 *
 * The columns of a strip of the result are few enough that its rows are kept until no row of the result needs them,
 * so each is read about once.  A kept row has what is to be summed, as integers in doubles.
 */
#include "reshape/resize_strip.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <math.h>
#include <string.h>

typedef ntp__resize_job job;

/* What n texels of row y add to each sum, before the weight of the row. */
static void read_terms(const job *j, double *const to[SUMS], int32_t x, int32_t y, int32_t n)
{
    const uint32_t touch = j->plan->how.touch_unused;
    ntp__block block;
    ntp__vectors v;
    double by[NTP__BLOCK];
    ntp__unpack(&block, j->src, x, y, n);
    ntp__block_vectors(&v, &block, n, j->m, j->src->encoding);
    for (int32_t i = 0; i < n; i++)
        by[i] = j->weighted ? block.c[3][i] : 1;
    if (ntp__any_suspect(&block, n, j->m)) {
        for (int32_t i = 0; i < n; i++) {
            if (ntp__unused(block.c[0][i], block.c[1][i], block.c[2][i], block.c[3][i], j->m,
                            touch) ||
                (block.any_broken && block.broken[i]))
                by[i] = 0;
        }
    }
    memcpy(to[SUM_WEIGHT], by, (size_t) n * sizeof by[0]);
    for (int32_t k = 0; k < 3; k++) {
        for (int32_t i = 0; i < n; i++)
            to[k][i] = v.c[k][i] * by[i];
    }
    for (int32_t i = 0; to[SUM_NEGATIVE] != NULL && i < n; i++)
        to[SUM_NEGATIVE][i] = v.c[2][i] < 0 ? by[i] : 0;
    for (int32_t i = 0; to[SUM_ALPHA] != NULL && i < n; i++)
        to[SUM_ALPHA][i] = block.c[3][i];
    for (int32_t i = 0; to[SUM_EXTRA] != NULL && i < n; i++)
        to[SUM_EXTRA][i] = block.c[2][i] * by[i];
}

static void add_whole(int64_t *restrict sum, const double *restrict terms, int32_t w, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += (int64_t) terms[i] * w;
}

static void add_scaled(double *restrict sum, const double *restrict terms, double w, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += terms[i] * w;
}

/* Adds them, times w, to the sums from column x on. */
static void add_terms(const job *j, double *const terms[SUMS], int32_t x, int32_t n, int32_t w)
{
    for (int32_t k = 0; k < SUMS; k++) {
        const int32_t by =
            k == SUM_NEGATIVE ? ntp__abs(w) : w; /* so that nothing cancels what is counted */
        if (j->sum[k] == NULL)
            continue;
        if (j->quickly)
            add_scaled(j->quick[k] + x, terms[k], by, n);
        else
            add_whole(j->sum[k] + x, terms[k], by, n);
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
static void find_row(const job *j, double *terms[SUMS], int32_t i)
{
    const ntp__axis *axis = &j->plan->x;
    const int32_t rows = j->plan->y.stride, slot = (i % rows + rows) % rows;
    double *row = j->rows + (ptrdiff_t) slot * planes_of(j) * j->room;
    for (int32_t k = 0; k < SUMS; k++) {
        terms[k] = j->sum[k] != NULL ? row : NULL;
        row += j->sum[k] != NULL ? j->room : 0;
    }
    if (j->held[slot] == i)
        return;
    j->held[slot] = i;
    for (int32_t c = 0, n = 0; c < j->columns; c += n) {
        const int32_t x = j->first + c, left = j->columns - c;
        double *to[SUMS];
        n = x < 0 || x >= axis->src ? 1 : axis->src - x < left ? axis->src - x : left;
        for (int32_t k = 0; k < SUMS; k++)
            to[k] = terms[k] != NULL ? terms[k] + c : NULL;
        read_terms(j, to, ntp__axis_map(axis, x), ntp__axis_map(&j->plan->y, i), n);
    }
}

void ntp__sum_columns(const job *j, int32_t y, int32_t x0, int32_t x1)
{
    const ntp__axis *axis = &j->plan->y;
    double room[SUMS][NTP__BLOCK], *terms[SUMS];
    for (int32_t k = 0; k < SUMS; k++) {
        terms[k] = j->sum[k] != NULL ? room[k] : NULL;
        if (j->sum[k] != NULL)
            memset(j->sum[k] + x0, 0, (size_t) (x1 - x0) * sizeof *j->sum[k]); /* also 0.0 */
    }
    for (int32_t t = 0; t < axis->span[y].count; t++) {
        const int32_t w = axis->weight[(ptrdiff_t) y * axis->stride + t],
                      row = axis->span[y].first + t;
        for (int32_t x = x0, n = 0; w != 0 && x < x1; x += n) {
            n = x1 - x < NTP__BLOCK ? x1 - x : NTP__BLOCK;
            if (j->rows != NULL)
                find_row(j, terms, row);
            else
                read_terms(j, terms, x, ntp__axis_map(axis, row), n);
            add_terms(j, terms, x, n, w);
        }
    }
}
