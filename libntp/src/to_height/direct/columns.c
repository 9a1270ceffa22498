/* SPDX-License-Identifier: MIT */
/*
 * columns.c - the recursion along columns
 *
 * Once rows are transformed, each column is a system of its own: lambda h plus second differences
 * of h.  Forward slopes couple neighbors.  Central ones couple rows two apart, so the even rows are
 * one segment and the odd ones another.  Along a segment the system is -1, 2 + mu, -1.  With
 * r + 1/r = 2 + mu it factors into u[i] = f[i] + r u[i-1], downwards, and h[i] = r (u[i] + h[i+1]),
 * upwards.  Waves enter a segment at its ends and decay as r^i.  They come from the end that the
 * border joins to this one: of the same segment, or of the other.  Their sizes follow from two sums
 * on the way down.  All state is in double; rows are floats.
 */
#include "to_height/direct/direct.h"

#include <math.h>
#include <string.h>

/* Powers of r below this no longer show in a float. */
static const double tiny = 0x1p-80;

/* -------------------------------------------------------------------------------- set-up */

/* r^e with the greatest e <= limit for which it is not tiny. */
static double greatest_power(double r, int32_t limit, int32_t *e)
{
    double square[17], product = 1;
    int32_t last = 0;
    square[0] = r;
    for (; last < 16 && 2 << last <= limit; last++)
        square[last + 1] = square[last] * square[last];
    *e = 0;
    for (int32_t b = last; b >= 0; b--) {
        if (*e + (1 << b) <= limit && product * square[b] >= tiny) {
            product *= square[b];
            *e += 1 << b;
        }
    }
    return product;
}

static int32_t groups_of(const ntp__columns *c)
{
    return (c->width + NTP__COLUMNS - 1) / NTP__COLUMNS;
}

static void init_segment(ntp__segment *s, ntp__scratch *memory, int32_t first, int32_t step,
                         int32_t rows, int32_t width)
{
    s->first = first;
    s->step = step;
    s->length = (rows - first + step - 1) / step;
    double **arrays[] = { &s->state, &s->sum, &s->power, &s->entry, &s->start, &s->begin };
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        *arrays[i] = ntp__take(memory, (size_t) width * sizeof(double));
}

static void lay_out(ntp__columns *c, ntp__scratch *memory, const ntp__problem *p)
{
    size_t row = (size_t) c->width * sizeof(double), column = (size_t) p->down.n * sizeof(double);
    c->r = ntp__take(memory, row);
    c->inverse = ntp__take(memory, row);
    for (int32_t i = 0; i < c->segments; i++)
        init_segment(&c->segment[i], memory, i, c->segments, p->down.n, c->width);
    for (int32_t i = 0; i < NTP__MAX_NULLS; i++)
        c->null[i] = ntp__take(memory, column);
    c->live = ntp__take(memory, (size_t) groups_of(c) * sizeof *c->live);
}

/* Sets the state before the first row. */
static void clear(ntp__columns *c)
{
    memset(c->live, 0, (size_t) groups_of(c) * sizeof *c->live);
    for (int32_t i = 0; i < c->segments; i++) {
        ntp__segment *s = &c->segment[i];
        for (int32_t k = 0; k < c->width; k++) {
            s->state[k] = s->sum[k] = s->entry[k] = s->start[k] = s->begin[k] = 0;
            s->power[k] = 1;
        }
    }
}

static void set_column(ntp__columns *c, const ntp__problem *p, int32_t k)
{
    ntp__symbol symbol;
    int32_t e, *live = &c->live[k / NTP__COLUMNS], other = c->width - k;
    if (p->along.wrap && k > other) { /* the same frequency */
        c->r[k] = c->r[other];
        c->inverse[k] = c->inverse[other];
    } else {
        ntp__symbol_at(&symbol, &p->along, k);
        double mu = c->scale * p->ratio * symbol.along[0] * symbol.along[0];
        double half = mu / 2, root = sqrt(mu + half * half);
        c->r[k] = mu > 0 ? 1 / (1 + half + root) : 0;
        c->inverse[k] = mu > 0 ? 1 + half + root : 0;
    }
    greatest_power(c->r[k], p->down.n, &e);
    *live = e > *live ? e : *live;
    if (!(c->inverse[k] > 0) && c->nulls < NTP__MAX_NULLS)
        c->null_at[c->nulls++] = k;
}

void ntp__columns_init(ntp__columns *c, ntp__scratch *memory, const ntp__problem *p)
{
    bool central = p->down.kind == NTP__AXIS_CENTRAL && p->down.n > 1;
    memset(c, 0, sizeof *c);
    c->loops = &ntp__solver_kernels_for(NTP__CPU_ALL)->columns;
    c->down = &p->down;
    c->width = p->along.n;
    /* Central slopes give a quarter of -1, 2, -1. */
    c->scale = central ? 4 : 1;
    c->segments = central ? 2 : 1;
    lay_out(c, memory, p);
    if (memory->base == NULL)
        return;
    clear(c);
    for (int32_t k = 0; k < c->width; k++)
        set_column(c, p, k);
}

/* ------------------------------------------------------------------------------ recursion */

static const ntp__segment *segment_of(const ntp__columns *c, int32_t y)
{
    return &c->segment[y % c->segments];
}

void ntp__columns_down(ntp__columns *c, float *row, int32_t y, int32_t x0, int32_t x1)
{
    const ntp__segment *s = segment_of(c, y);
    int32_t at_row = y / c->segments;
    for (int32_t i = 0; i < c->nulls; i++) {
        int32_t at = c->null_at[i];
        if (at > 0 && at >= x0 && at < x1)
            c->null[i][y] = (double) row[at];
    }
    for (int32_t x = x0; x < x1; x += NTP__COLUMNS) {
        int32_t n = x1 - x < NTP__COLUMNS ? x1 - x : NTP__COLUMNS;
        if (at_row <= c->live[x / NTP__COLUMNS])
            c->loops->down_live(s->state + x, row + x, c->r + x, c->scale, s->sum + x, s->power + x,
                                tiny, n);
        else
            c->loops->down(s->state + x, row + x, c->r + x, c->scale, n);
    }
}

void ntp__columns_up(ntp__columns *c, float *row, int32_t y, int32_t x0, int32_t x1)
{
    const ntp__segment *s = segment_of(c, y);
    int32_t at_row = y / c->segments;
    for (int32_t x = x0; x < x1; x += NTP__COLUMNS) {
        int32_t n = x1 - x < NTP__COLUMNS ? x1 - x : NTP__COLUMNS;
        if (at_row <= c->live[x / NTP__COLUMNS])
            c->loops->up_live(s->state + x, row + x, c->r + x, c->inverse + x, s->entry + x,
                              s->start + x, s->begin + x, at_row, n);
        else
            c->loops->up(s->state + x, row + x, c->r + x, n);
    }
    for (int32_t i = 0; i < c->nulls; i++) {
        if (c->null_at[i] >= x0 && c->null_at[i] < x1)
            row[c->null_at[i]] = (float) c->null[i][y];
    }
}

/* ---------------------------------------------------------------------------------- turn */

/* r^length, or 0 if it is tiny. */
static double whole_power(double r, int32_t length)
{
    int32_t e;
    double power = greatest_power(r, length, &e);
    return e == length ? power : 0;
}

/* The waves that enter the two segments at their upper ends, and at their lower ends. */
typedef struct waves {
    double upper[2], lower[2];
} waves;

/*
 * The waves, in units of the response to one source.  A wave that leaves a segment comes from the
 * sources inside (u: the last state; v: the sum of r^i f[i]), and from the wave that entered at the
 * other end, times q = r^length.  With one segment, a border that wraps joins its ends, and a free
 * one mirrors.  With two segments, wrap joins each to itself, or to the other one if the number of
 * rows is odd; free ends join the two.
 */
static waves find_waves(const ntp__columns *c, const double u[2], const double v[2],
                        const double q[2])
{
    waves w = { { 0, 0 }, { 0, 0 } };
    double all = q[0] * q[1];
    if (c->segments == 1 && !c->down->wrap) {
        w.upper[0] = (v[0] + q[0] * u[0]) / (1 - q[0] * q[0]);
        w.lower[0] = (u[0] + q[0] * v[0]) / (1 - q[0] * q[0]);
    } else if (c->segments == 1 || (c->down->wrap && c->down->n % 2 == 0)) {
        for (int32_t i = 0; i < c->segments; i++) {
            w.upper[i] = u[i] / (1 - q[i]);
            w.lower[i] = v[i] / (1 - q[i]);
        }
    } else if (c->down->wrap) {
        w.upper[1] = (u[0] + q[0] * u[1]) / (1 - all);
        w.upper[0] = u[1] + q[1] * w.upper[1];
        w.lower[0] = (v[1] + q[1] * v[0]) / (1 - all);
        w.lower[1] = v[0] + q[0] * w.lower[0];
    } else {
        for (int32_t i = 0; i < 2; i++) {
            w.upper[i] = (v[1 - i] + q[1 - i] * u[i]) / (1 - all);
            w.lower[1 - i] = u[i] + q[i] * w.upper[i];
        }
    }
    return w;
}

static void turn_column(ntp__columns *c, int32_t k)
{
    double r = c->r[k], u[2] = { 0, 0 }, v[2] = { 0, 0 }, q[2] = { 1, 1 };
    for (int32_t i = 0; i < c->segments; i++) {
        u[i] = c->segment[i].state[k];
        v[i] = c->segment[i].sum[k];
        q[i] = whole_power(r, c->segment[i].length);
    }
    waves w = find_waves(c, u, v, q);
    double response = r / ((1 - r) * (1 + r));
    for (int32_t i = 0; i < c->segments; i++) {
        ntp__segment *s = &c->segment[i];
        int32_t e;
        double power = greatest_power(r, s->length - 1, &e);
        s->start[k] = w.upper[i] * r * power;
        s->begin[k] = e;
        s->state[k] = response * (r * u[i] + w.lower[i] + w.upper[i] * r * q[i]);
    }
}

/* In a null column second differences of h are -scale f, so two sums solve it.  They follow the
 * order in which rows are coupled.  For central slopes with free ends, or with an odd number of
 * rows that wrap, that is one round through both segments. */
typedef struct chain {
    int32_t n, length, first, step;
    bool ring, folded;
} chain;

static int32_t row_of(const chain *c, int32_t i)
{
    if (c->folded) {
        int32_t evens = (c->n + 1) / 2;
        return i < evens ? 2 * i : 2 * (c->n - 1 - i) + 1;
    }
    return (int32_t) ((c->first + (int64_t) c->step * i) % c->n);
}

static void subtract_mean(double *h, const chain *c)
{
    double sum = 0;
    for (int32_t i = 0; i < c->length; i++)
        sum += h[row_of(c, i)];
    double mean = sum / c->length;
    for (int32_t i = 0; i < c->length; i++)
        h[row_of(c, i)] -= mean;
}

/* On a ring the first sum comes back to 0, and its mean is made 0, as it is a slope of h. */
static void solve_null(double *h, const chain *c, double scale)
{
    double flow = 0, height = 0;
    subtract_mean(h, c);
    for (int32_t i = 0; i < c->length; i++) {
        flow += scale * h[row_of(c, i)];
        h[row_of(c, i)] = flow;
    }
    if (c->ring)
        subtract_mean(h, c);
    for (int32_t i = 0; i < c->length; i++) {
        double step = h[row_of(c, i)];
        h[row_of(c, i)] = height;
        height -= step;
    }
    subtract_mean(h, c);
}

void ntp__columns_turn(ntp__columns *c)
{
    int32_t n = c->down->n;
    bool central = c->segments == 2, apart = central && c->down->wrap && n % 2 == 0;
    for (int32_t k = 0; k < c->width; k++) {
        for (int32_t i = 0; i < c->segments; i++) {
            c->segment[i].state[k] = c->r[k] > 0 ? c->segment[i].state[k] : 0;
            c->segment[i].begin[k] = -1;
        }
        if (c->r[k] > 0)
            turn_column(c, k);
    }
    for (int32_t i = 0; i < c->nulls; i++) {
        for (int32_t first = 0; first < (apart ? 2 : 1); first++) {
            chain rows = { n,
                           apart ? n / 2 : n,
                           first,
                           central ? 2 : 1,
                           central || c->down->wrap,
                           central && !c->down->wrap };
            solve_null(c->null[i], &rows, c->scale);
        }
    }
}
