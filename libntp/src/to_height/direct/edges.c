/* SPDX-License-Identifier: MIT */
/*
 * edges.c - the edges of central slopes with extrapolated borders, fitted with full weight
 *
 * In the direct solution slopes at these edges count a quarter, because then cosines are
 * eigenvectors.  This does harm at the edges only.  So the two outermost lines of texels on each
 * such side are fitted again: all slopes count alike, and the other heights stay.  Let a and b be
 * the changes of the two lines.  The slopes inward change by b - a, -a/2 and -b/2, and their
 * squares do not mix a + b with a - b.  Each of these is a system of its own along the edge:
 * central differences and a number on the diagonal.  Both are solved exactly.  The sum of squares
 * is then within some hundredths of a percent of the least possible.
 */
#include "to_height/direct/direct.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    DEEP = NTP__EDGE_LINES,
    LINES = DEEP - 1,   /* lines that are fitted */
    LEAST = DEEP + 1,   /* texels across, so that none of these lines is at the other edge */
    ARRAYS = 2 + 3 + 2, /* the right-hand sides, the factors, a row of slopes */
    SIDES = 2,          /* of an axis */
    STRIPS = 64         /* of heights, for threads */
};

/* The squares of slopes inward add up to these factors times (a + b)^2/2 and (a - b)^2/2. */
static const double SUM_WEIGHT = 0.25, DIFFERENCE_WEIGHT = 2.25;

typedef struct edge {
    const ntp_image *dst;
    const ntp__slopes *slopes;
    const ntp__grid_axis *along; /* the edge */
    bool is_column;
    bool far;       /* right or bottom */
    double weight;  /* of slopes inward; those along the edge have 1 */
    double step_in; /* spacing of texels inward */
    double step;    /* spacing along the edge */
    double *sum;    /* right-hand sides, then solutions: of a + b and a - b */
    double *difference;
    double *diagonal, *next, *second; /* factors */
    double *right, *down;             /* slopes of a row */
} edge;

static bool wanted(const ntp__grid_axis *axis)
{
    return axis->kind == NTP__AXIS_CENTRAL && axis->border == NTP_BORDER_EXTRAPOLATE &&
           axis->n >= LEAST;
}

static int32_t longest(const ntp__problem *p)
{
    return p->along.n > p->down.n ? p->along.n : p->down.n;
}

/* ------------------------------------------------------------------------ right-hand sides */

/* The height `depth` lines in, at place i of the edge. */
static float *height_at(const edge *e, int32_t depth, int32_t i)
{
    if (e->is_column)
        return (float *) ntp__at_mut(e->dst, 0, i) + (e->far ? e->dst->width - 1 - depth : depth);
    return (float *) ntp__at_mut(e->dst, 0, e->far ? e->dst->height - 1 - depth : depth) + i;
}

static double height(const edge *e, int32_t depth, int32_t i)
{
    return (double) *height_at(e, depth, i);
}

/* A slope at the end of an axis is this share of the difference of the last two texels. */
static double end_share(const ntp__grid_axis *axis)
{
    return axis->border == NTP_BORDER_EXTRAPOLATE ? 1 : axis->border == NTP_BORDER_CLAMP ? 0.5 : 0;
}

/* A slope along the edge as a difference of two heights and a factor. */
static double between(const ntp__grid_axis *axis, int32_t i, int32_t *before, int32_t *after)
{
    int32_t last = axis->n - 1;
    bool end = !axis->wrap && (i == 0 || i == last);
    *before = i > 0 ? i - 1 : axis->wrap ? last : 0;
    *after = i < last ? i + 1 : axis->wrap ? 0 : last;
    return end ? end_share(axis) : 0.5;
}

/* Adds what a slope inward, `depth` lines in, leaves unexplained to the equation of both lines. */
static void add_inward(edge *e, int32_t depth, int32_t i, double slope)
{
    int32_t outer = depth > 0 ? depth - 1 : 0;
    double share = depth > 0 ? 0.5 : 1;
    double rest = share * (height(e, depth + 1, i) - height(e, outer, i)) - e->step_in * slope;
    /* The slope changes by b - a, -a/2 or -b/2. */
    static const double of_sum[DEEP] = { 0, 0.5, 0.5 }, of_difference[DEEP] = { 2, 0.5, -0.5 };
    e->sum[i] += e->weight * of_sum[depth] * rest;
    e->difference[i] += e->weight * of_difference[depth] * rest;
}

/* The same for a slope along the edge. */
static void add_along(edge *e, int32_t depth, int32_t i, double slope)
{
    int32_t before, after;
    double share = between(e->along, i, &before, &after), sign = depth == 0 ? 1 : -1;
    double rest = share * (height(e, depth, after) - height(e, depth, before)) - e->step * slope;
    e->sum[after] -= share * rest;
    e->sum[before] += share * rest;
    e->difference[after] -= sign * share * rest;
    e->difference[before] += sign * share * rest;
}

static void add_texel(edge *e, int32_t depth, int32_t i, double right, double down)
{
    double inward = e->is_column ? right : down;
    add_inward(e, depth, i, e->far ? -inward : inward);
    if (depth < LINES)
        add_along(e, depth, i, e->is_column ? down : right);
}

/* Columns are read as rows of the turned texture, a stretch at a time. */
static void add_column(edge *e)
{
    int32_t left = e->far ? e->dst->width - DEEP : 0;
    double right[DEEP][NTP__BLOCK], down[DEEP][NTP__BLOCK];
    ntp__slopes part = *e->slopes;
    ntp_const_image columns = ntp__transposed(e->slopes->src);
    const ntp_const_image turned = columns;
    part.src = &columns;
    for (int32_t y = 0; y < e->along->n; y += NTP__BLOCK) {
        columns.data = ntp__at(&turned, y, left);
        columns.width = e->along->n - y < NTP__BLOCK ? e->along->n - y : NTP__BLOCK;
        for (int32_t i = 0; i < DEEP; i++)
            ntp__slopes_row(&part, right[i], down[i], i, NULL);
        for (int32_t k = 0; k < columns.width; k++) {
            for (int32_t i = 0; i < DEEP; i++)
                add_texel(e, e->far ? DEEP - 1 - i : i, y + k, right[i][k], down[i][k]);
        }
    }
}

static void add_rows(edge *e)
{
    for (int32_t depth = 0; depth < DEEP; depth++) {
        int32_t y = e->far ? e->dst->height - 1 - depth : depth;
        ntp__slopes_row(e->slopes, e->right, e->down, y, NULL);
        for (int32_t x = 0; x < e->along->n; x++)
            add_texel(e, depth, x, e->right[x], e->down[x]);
    }
}

/* ------------------------------------------------------------------------------ solutions */

/* An edge that wraps.  Differences of texels two apart give a quarter of -1, 2 + mu, -1, which
 * factors as in columns.c.  v becomes the solution. */
static void solve_round(double *v, int32_t n, double number)
{
    double mu = 4 * number, r = 1 / (1 + mu / 2 + sqrt(mu + mu * mu / 4));
    int32_t rings = n % 2 == 0 ? 2 : 1, length = n / rings;
    for (int32_t ring = 0; ring < rings; ring++) {
        for (int32_t step = 2; step >= -2; step -= 4) { /* down, then up */
            int32_t at = ring;
            double state = 0, power = 1;
            for (int32_t i = 0; i < length; i++) {
                state = v[at] + r * state;
                power *= r;
                at = (at + step + n) % n;
            }
            state /= 1 - power; /* the rounds before have left this behind */
            at = ring;
            for (int32_t i = 0; i < length; i++) {
                v[at] += r * state;
                state = v[at];
                at = (at + step + n) % n;
            }
        }
    }
    for (int32_t i = 0; i < n; i++)
        v[i] *= 4 * r;
}

/* The square of the central differences plus a number: five diagonals. */
static void five_diagonals(edge *e, double number)
{
    int32_t n = e->along->n;
    for (int32_t i = 0; i < n; i++) {
        e->diagonal[i] = number;
        e->next[i] = e->second[i] = 0;
    }
    for (int32_t i = 0; i < n; i++) {
        int32_t before, after;
        double share = between(e->along, i, &before, &after), square = share * share;
        if (before == after)
            continue;
        e->diagonal[before] += square;
        e->diagonal[after] += square;
        if (after - before == 2)
            e->second[before] -= square;
        else
            e->next[before] -= square;
    }
}

/* An edge with ends.  v becomes the solution; L D L^T takes the place of the diagonals. */
static void solve_ends(edge *e, double *v, double number)
{
    int32_t n = e->along->n;
    double *d = e->diagonal, *a = e->next, *b = e->second;
    five_diagonals(e, number);
    for (int32_t i = 0; i < n; i++) {
        double first = a[i] / d[i], second = b[i] / d[i];
        if (i + 1 < n) {
            d[i + 1] -= first * a[i];
            a[i + 1] -= first * b[i];
            v[i + 1] -= first * v[i];
        }
        if (i + 2 < n) {
            d[i + 2] -= second * b[i];
            v[i + 2] -= second * v[i];
        }
        v[i] /= d[i];
        a[i] = first;
        b[i] = second;
    }
    for (int32_t i = n - 1; i >= 0; i--) {
        v[i] -= i + 1 < n ? a[i] * v[i + 1] : 0;
        v[i] -= i + 2 < n ? b[i] * v[i + 2] : 0;
    }
}

static void solve(edge *e, double *v, double number)
{
    if (e->along->wrap)
        solve_round(v, e->along->n, number);
    else
        solve_ends(e, v, number);
}

/* Fits the edge; returns the sum of all changes. */
static double fit(edge *e)
{
    double total = 0;
    int32_t n = e->along->n;
    memset(e->sum, 0, (size_t) n * sizeof(double));
    memset(e->difference, 0, (size_t) n * sizeof(double));
    if (e->is_column)
        add_column(e);
    else
        add_rows(e);
    solve(e, e->sum, SUM_WEIGHT * e->weight);
    solve(e, e->difference, DIFFERENCE_WEIGHT * e->weight);
    for (int32_t i = 0; i < n; i++) {
        float *outer = height_at(e, 0, i), *inner = height_at(e, 1, i);
        float before[LINES] = { *outer, *inner };
        *outer = (float) ((double) *outer + (e->sum[i] + e->difference[i]) / 2);
        *inner = (float) ((double) *inner + (e->sum[i] - e->difference[i]) / 2);
        total += (double) *outer - (double) before[0] + ((double) *inner - (double) before[1]);
    }
    return total;
}

/* ---------------------------------------------------------------------------------- whole */

/* Subtracts the mean, and finds the range. */
typedef struct settling {
    const ntp_image *dst;
    float mean;
    int32_t rows; /* of a strip */
    float range[STRIPS][2];
} settling;

static void settle_strip(void *job, int32_t part, int32_t strip)
{
    const ntp__solver_kernels *kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    settling *s = job;
    const int32_t first = strip * s->rows, rest = s->dst->height - first;
    float *range = s->range[strip];
    (void) part;
    range[0] = FLT_MAX;
    range[1] = -FLT_MAX;
    for (int32_t y = 0; y < s->rows && y < rest; y++) {
        float *row = ntp__at_mut(s->dst, 0, first + y);
        for (int32_t x = 0; x < s->dst->width; x++)
            row[x] -= s->mean;
        kernels->range(range, row, s->dst->width);
    }
}

static void settle(const ntp_image *dst, float mean, const ntp__crew *crew, float range[2])
{
    settling s = { .dst = dst, .mean = mean, .rows = (dst->height + STRIPS - 1) / STRIPS };
    ntp__crew_each(crew, settle_strip, &s, STRIPS);
    range[0] = FLT_MAX;
    range[1] = -FLT_MAX;
    for (int32_t i = 0; i < STRIPS; i++) {
        range[0] = s.range[i][0] < range[0] ? s.range[i][0] : range[0];
        range[1] = s.range[i][1] > range[1] ? s.range[i][1] : range[1];
    }
}

void ntp__edges_fit(const ntp_image *dst, const ntp__slopes *slopes, const ntp__problem *p,
                    ntp__scratch *memory, const ntp__crew *crew, float range[2])
{
    double *arrays[ARRAYS], change = 0;
    if (!wanted(&p->along) && !wanted(&p->down))
        return;
    for (int32_t i = 0; i < ARRAYS; i++)
        arrays[i] = ntp__take(memory, (size_t) longest(p) * sizeof(double));
    if (memory->base == NULL)
        return;
    for (int32_t i = 0; i < 2 * SIDES; i++) {
        bool is_column = i < SIDES;
        const ntp__grid_axis *inward = is_column ? &p->along : &p->down;
        double step_x = p->right_weight / p->ratio, step_y = p->down_weight;
        edge e = { .dst = dst,
                   .slopes = slopes,
                   .along = is_column ? &p->down : &p->along,
                   .is_column = is_column,
                   .far = i % SIDES == 1,
                   .weight = is_column ? p->ratio : 1 / p->ratio,
                   .step_in = is_column ? step_x : step_y,
                   .step = is_column ? step_y : step_x,
                   .sum = arrays[0],
                   .difference = arrays[1],
                   .diagonal = arrays[2],
                   .next = arrays[3],
                   .second = arrays[4],
                   .right = arrays[5],
                   .down = arrays[6] };
        if (wanted(inward))
            change += fit(&e);
    }
    settle(dst, (float) (change / ((double) dst->width * dst->height)), crew, range);
}
