/* SPDX-License-Identifier: MIT */
/*
 * right_hand_side.c - right-hand sides: the adjoint of the stencils, applied to rows of slopes
 *
 * Slopes are read row by row through the cache of the part that makes the right-hand side.
 */
#include "stencil/taps.h"
#include "to_height/direct/direct.h"

#include <string.h>

enum {
    PAD = NTP__MAX_RADIUS,
    ENDS = 4 /* places at the ends of a row whose terms are not those of the middle */
};

static size_t real_size(const ntp__problem *p)
{
    return p->single ? sizeof(float) : sizeof(double);
}

void ntp__source_init(ntp__source *source, ntp__scratch *memory, const ntp__problem *p,
                      const ntp__slopes *slopes)
{
    const ntp__solver_kernels *kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    size_t width = (size_t) p->along.n;
    /* The rows of one right-hand side with its own, and one more. */
    int32_t kept = 2 * ntp__reach(&p->down) + 2;
    memset(source, 0, sizeof *source);
    source->problem = p;
    source->slopes = slopes;
    source->loops = p->single ? &kernels->rows_single : &kernels->rows_double;
    ntp__row_cache_init(&source->rows, memory, kept < NTP__MOST_CACHED ? kept : NTP__MOST_CACHED,
                        width * real_size(p));
    source->line = ntp__take(memory, (width + 2 * PAD) * real_size(p));
}

/* The place of row y of slopes. */
static int32_t get_row(ntp__source *source, int32_t y)
{
    int32_t k;
    if (ntp__row_cache_find(&source->rows, y, &k))
        return k;
    ntp__slope_counts *counts = &source->row_counts[k];
    memset(counts, 0, sizeof *counts);
    if (source->window != NULL) {
        y -= source->window->first;
        y += y < 0 ? source->window->height : 0;
    }
    void *right = source->rows.right[k], *down = source->rows.down[k];
    if (source->problem->single)
        ntp__slopes_row_single(source->slopes, right, down, y, counts);
    else
        ntp__slopes_row(source->slopes, right, down, y, counts);
    return k;
}

static const void *right_row(ntp__source *source, int32_t y)
{
    return source->rows.right[get_row(source, y)];
}

static const void *down_row(ntp__source *source, int32_t y)
{
    return source->rows.down[get_row(source, y)];
}

/* ------------------------------------------------------------------------ sums over rows */

/* A sum of runs of numbers, taken two at a time. */
typedef struct run_sum {
    const ntp__row_loops *loops;
    void *f;
    int32_t n;
    bool begun; /* f holds a sum; else what it holds is replaced */
    const void *waiting;
    double weight;
} run_sum;

static void put_pair(run_sum *s, const void *a, double wa, const void *b, double wb)
{
    (s->begun ? s->loops->add_pair : s->loops->set_pair)(s->f, a, wa, b, wb, s->n);
    s->begun = true;
}

static void put_run(run_sum *s, const void *run, double weight)
{
    if (weight == 0 || s->n < 1)
        return;
    if (s->waiting == NULL) {
        s->waiting = run;
        s->weight = weight;
        return;
    }
    put_pair(s, s->waiting, s->weight, run, weight);
    s->waiting = NULL;
}

static void finish(run_sum *s)
{
    if (s->waiting != NULL)
        put_pair(s, s->waiting, s->weight, s->waiting, 0);
    s->waiting = NULL;
}

static char *place(const ntp__problem *p, const void *line, int32_t i)
{
    return (char *) (uintptr_t) line + (ptrdiff_t) i * (ptrdiff_t) real_size(p);
}

static double value(const ntp__problem *p, const void *line, int32_t i)
{
    return p->single ? (double) ((const float *) line)[i] : ((const double *) line)[i];
}

static void set_value(const ntp__problem *p, void *line, int32_t i, double v)
{
    if (p->single)
        ((float *) line)[i] = (float) v;
    else
        ((double *) line)[i] = v;
}

/* -------------------------------------------------------------- one-dimensional stencils */

static void add_end(const ntp__problem *p, void *f, const void *right, int32_t x)
{
    ntp__terms terms;
    double sum = value(p, f, x);
    ntp__adjoint(&terms, &p->along, x);
    for (int32_t k = 0; k < terms.count; k++)
        sum += p->right_weight * terms.weight[k] * value(p, right, terms.at[k]);
    set_value(p, f, x, sum);
}

/* f += the adjoint of slopes to the right. */
static void add_along(const ntp__source *source, void *f, const void *right)
{
    const ntp__problem *p = source->problem;
    int32_t n = p->along.n;
    if (n > 2 * ENDS) {
        ntp__terms terms;
        run_sum sum = { source->loops, place(p, f, ENDS), n - 2 * ENDS, true, NULL, 0 };
        ntp__adjoint(&terms, &p->along, ENDS);
        for (int32_t k = 0; k < terms.count; k++)
            put_run(&sum, place(p, right, terms.at[k]), p->right_weight * terms.weight[k]);
        finish(&sum);
    }
    for (int32_t x = 0; x < n; x++) {
        if (x == ENDS && n > 2 * ENDS)
            x = n - ENDS;
        add_end(p, f, right, x);
    }
}

static void by_lines(ntp__source *source, void *f, int32_t y, double *from_down)
{
    const ntp__problem *p = source->problem;
    ntp__terms terms;
    run_sum sum = { source->loops, f, p->along.n, false, NULL, 0 };
    ntp__adjoint(&terms, &p->down, y);
    for (int32_t k = 0; k < terms.count; k++)
        put_run(&sum, down_row(source, terms.at[k]), p->down_weight * terms.weight[k]);
    finish(&sum);
    if (!sum.begun)
        memset(f, 0, (size_t) p->along.n * real_size(p));
    *from_down = source->loops->sum(f, p->along.n);
    if (ntp__axis_transform(&p->along) == NTP__FFT_MIRROR)
        *from_down = 2 * *from_down - value(p, f, 0) - value(p, f, p->along.n - 1);
    add_along(source, f, right_row(source, y));
}

/* -------------------------------------------------------------- two-dimensional stencils */

/* A tap of a term of the kernel, for the adjoint: slopes along an axis go into heights with the
 * other sign. */
static double tap(const ntp__kernel *kernel, int32_t t, bool along, int32_t i)
{
    int32_t at = i + NTP__MAX_RADIUS;
    return along ? -(double) kernel->term[t].along[at] / kernel->denominator
                 : kernel->term[t].across[at];
}

static void pad(const ntp__problem *p, void *line, bool odd)
{
    double sign;
    int32_t n = p->along.n;
    for (int32_t i = -PAD; i < n + PAD; i++) {
        int32_t at = ntp__reflected(&p->along, i, odd, &sign);
        if (i < 0 || i >= n || sign == 0)
            set_value(p, line, i, sign * value(p, line, at));
        if (i == 0 && n > 2)
            i = n - 2;
    }
}

/* Adds what slopes right (down: slopes down) contribute by one term of the kernel. */
static void add_term(ntp__source *source, run_sum *sum, int32_t y, int32_t t, bool down)
{
    const ntp__problem *p = source->problem;
    const ntp__kernel *kernel = &ntp__kernel_table[p->along.kernel];
    void *line = place(p, source->line, PAD);
    run_sum rows = { source->loops, line, p->along.n, false, NULL, 0 };
    for (int32_t j = -kernel->radius; j <= kernel->radius; j++) {
        double sign, weight = tap(kernel, t, down, j);
        int32_t at = ntp__reflected(&p->down, y + j, down, &sign);
        if (weight * sign != 0)
            put_run(&rows, down ? down_row(source, at) : right_row(source, at), weight * sign);
    }
    finish(&rows);
    if (!rows.begun)
        return;
    pad(p, line, !down);
    for (int32_t i = -kernel->radius; i <= kernel->radius; i++)
        put_run(sum, place(p, line, i),
                tap(kernel, t, !down, i) * (down ? p->down_weight : p->right_weight));
    finish(sum); /* before line is used again */
}

static void by_taps(ntp__source *source, void *f, int32_t y)
{
    const ntp__problem *p = source->problem;
    run_sum sum = { source->loops, f, p->along.n, false, NULL, 0 };
    for (int32_t t = 0; t < ntp__kernel_table[p->along.kernel].terms; t++) {
        add_term(source, &sum, y, t, false);
        add_term(source, &sum, y, t, true);
    }
    if (!sum.begun)
        memset(f, 0, (size_t) p->along.n * real_size(p));
}

void ntp__right_hand_side(ntp__source *source, void *f, int32_t y, double *sum, double *squares)
{
    const ntp__problem *p = source->problem;
    int32_t own = get_row(source, y);
    source->counts.unused += source->row_counts[own].unused;
    source->counts.not_finite += source->row_counts[own].not_finite;
    *sum = *squares = 0;
    if (p->along.kind == NTP__AXIS_TAPS)
        by_taps(source, f, y);
    else
        by_lines(source, f, y, sum);
    if (p->filter)
        *squares = source->loops->sum_squares(f, p->along.n);
}
