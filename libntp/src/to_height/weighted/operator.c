/* SPDX-License-Identifier: MIT */
/*
 * operator.c - the normal equations of weighted least squares, row by row
 *
 * A row of the result is a sum over the weighted slopes that read it, plus the flows through its
 * pairs.  A flow is the weight of a pair times its difference.  Each part keeps the rows of slopes
 * it has made.  Where two bands meet, the rows are made for both.  So every row is made in the same
 * order, whichever part makes it.
 */
#include "to_height/weighted/weighted.h"

#include "base/inlining.h"

#include <string.h>

enum { NO_FLOWS = -2 };

/* ------------------------------------------------------------------------ rows of slopes */

/* The place of the stored slopes of row y. */
static int32_t stored_row(const ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    int32_t k;
    if (!ntp__row_cache_find(&part->stored, y, &k))
        ntp__weighted_stored(w, part->stored.right[k], part->stored.down[k], y);
    return k;
}

ONE_COPY static void weigh(double *slope, const double *stored, const float *weight, int32_t n)
{
    for (int32_t x = 0; x < n; x++) {
        double v = stored != NULL ? stored[x] - slope[x] : slope[x];
        slope[x] = ntp__counts(weight[x]) ? (double) weight[x] * v : 0;
    }
}

static int32_t weighted_row(const ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    int32_t k;
    if (ntp__row_cache_find(&part->weighted, y, &k))
        return k;
    double *right = part->weighted.right[k], *down = part->weighted.down[k];
    ntp__plane from = { w->from, NULL, w->width };
    ntp__stencil_slopes(w->stencil, right, down, part->spare[0], &from, y);
    const double *stored_right = NULL, *stored_down = NULL;
    if (w->residual) {
        int32_t s = stored_row(w, part, y);
        stored_right = part->stored.right[s];
        stored_down = part->stored.down[s];
    }
    weigh(right, stored_right, w->right + ntp__weighted_at(w, y), w->width);
    weigh(down, stored_down, w->down + ntp__weighted_at(w, y), w->width);
    return k;
}

/* out += row y of the adjoint of (x line of y line), applied to the slopes to the right or down. */
ONE_COPY static void add_slopes(const ntp__weighted *w, ntp__weighted_part *part, double *out,
                                int32_t y, const ntp__line *along_rows,
                                const ntp__line *along_columns, bool right)
{
    ntp__line_terms terms;
    double *mixed = along_rows->identity ? out : part->spare[1];
    ntp__line_column(&terms, along_columns, y);
    if (mixed != out)
        memset(mixed, 0, (size_t) w->width * sizeof *mixed);
    for (int32_t j = 0; j < terms.count; j++) {
        int32_t k = weighted_row(w, part, terms.at[j]);
        const double *row = right ? part->weighted.right[k] : part->weighted.down[k];
        double weight = terms.weight[j];
        for (int32_t x = 0; x < w->width; x++)
            mixed[x] += weight * row[x];
    }
    if (mixed != out)
        ntp__line_adjoint(along_rows, out, mixed);
}

/* -------------------------------------------------------------------------------- pairs */

/* The weight of a pair a, b with the texels before and after it: more if no slope near it
 * counts. */
static double pair_weight(const ntp__weighted *w, float before, float a, float b, float after)
{
    float ma = ntp__weight_size(a), mb = ntp__weight_size(b), least = ma < mb ? ma : mb;
    bool counted = ntp__any_counts(before, a, b, after);
    return (double) least * (counted ? w->strength : w->strength_alone);
}

/* The stored difference of a pair: the integral of the slopes over it. */
static double pair_data(const ntp__weighted *w, const float weight[4], const double slope[4])
{
    if (!w->rows && !ntp__in_hole(weight[0]) && !ntp__in_hole(weight[3]))
        return (13 * (slope[1] + slope[2]) - (slope[0] + slope[3])) / 24;
    return (slope[1] + slope[2]) / 2;
}

/* Elements x - 1 .. x + 2.  Texels beyond a free end count as holes. */
static void neighborhood(float weight[4], double slope[4], const float *weights,
                         const double *slopes, int32_t x, int32_t n, bool wrap)
{
    for (int32_t i = 0; i < 4; i++) {
        int32_t at = x - 1 + i;
        bool inside = at >= 0 && at < n;
        at = inside ? at : (at + n) % n;
        weight[i] = inside || wrap ? weights[at] : 0;
        slope[i] = slopes != NULL && (inside || wrap) ? slopes[at] : 0;
    }
}

/* The flows of pairs h[i], next[i].  There are no branches, as most of the time is spent here. */
ONE_COPY static void multiply_pairs(const ntp__weighted *w, double *restrict flow,
                                    const float *const near[4], const double *restrict h,
                                    const double *restrict next, int32_t n)
{
    double strength = w->strength, alone = w->strength_alone;
    const float *before = near[0], *a = near[1], *b = near[2], *after = near[3];
    for (int32_t i = 0; i < n; i++) {
        float ma = ntp__weight_size(a[i]), mb = ntp__weight_size(b[i]), least = ma < mb ? ma : mb;
        bool counted = ntp__any_counts(before[i], a[i], b[i], after[i]);
        flow[i] = (double) least * (counted ? strength : alone) * (next[i] - h[i]);
    }
}

SELDOM static double flow_at(const ntp__weighted *w, const float *weights, const double *slopes,
                             const double *h, int32_t x, bool wrap)
{
    float weight[4];
    double slope[4];
    neighborhood(weight, slope, weights, slopes, x, w->width, wrap);
    double difference = h[x + 1 < w->width ? x + 1 : 0] - h[x];
    if (w->residual)
        difference = pair_data(w, weight, slope) - difference;
    return pair_weight(w, weight[0], weight[1], weight[2], weight[3]) * difference;
}

static void add_pairs_of_row(const ntp__weighted *w, ntp__weighted_part *part, double *out,
                             int32_t y)
{
    int32_t n = w->width, inner = w->residual || n < 4 ? 0 : n - 3;
    bool wrap = w->plan->wrap_x;
    const float *weights = w->right + ntp__weighted_at(w, y);
    const double *h = w->from + ntp__weighted_at(w, y), *slopes = NULL;
    double *flow = part->spare[1];
    if (n == 1)
        return;
    if (w->residual)
        slopes = part->stored.right[stored_row(w, part, y)];
    if (inner > 0) {
        const float *near[4] = { weights, weights + 1, weights + 2, weights + 3 };
        multiply_pairs(w, flow + 1, near, h + 1, h + 2, inner);
    }
    for (int32_t x = 0; x < n; x++) {
        if (inner > 0 && x == 1)
            x += inner;
        flow[x] = x < n - 1 || wrap ? flow_at(w, weights, slopes, h, x, wrap) : 0;
    }
    for (int32_t x = 0; x < n; x++)
        out[x] -= flow[x];
    for (int32_t x = 1; x < n; x++)
        out[x] += flow[x - 1];
    out[0] += flow[n - 1];
}

/* The flows of the residual through the pairs of two rows. */
SELDOM static void make_residual_flows(const ntp__weighted *w, double *flow,
                                       const float *const near[4], const double *const slopes[4],
                                       const double *h, const double *next)
{
    for (int32_t x = 0; x < w->width; x++) {
        const float weight[4] = { near[0][x], near[1][x], near[2][x], near[3][x] };
        const double slope[4] = { slopes[0][x], slopes[1][x], slopes[2][x], slopes[3][x] };
        flow[x] = pair_weight(w, weight[0], weight[1], weight[2], weight[3]) *
                  (pair_data(w, weight, slope) - (next[x] - h[x]));
    }
}

/* Flows through the pairs of rows y and y + 1. */
static void make_flows_below(const ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    const float *near[4];
    const double *slopes[4];
    int32_t n = w->height;
    bool wrap = w->plan->wrap_y;
    for (int32_t i = 0; i < 4; i++) {
        int32_t at = y - 1 + i;
        bool inside = wrap || (at >= 0 && at < n);
        at = (at + n) % n;
        near[i] = inside ? w->down + ntp__weighted_at(w, at) : part->no_weights;
        slopes[i] = part->nothing;
        if (w->residual && inside)
            slopes[i] = part->stored.down[stored_row(w, part, at)];
    }
    const double *h = w->from + ntp__weighted_at(w, (y + n) % n);
    const double *next = w->from + ntp__weighted_at(w, (y + 1) % n);
    double *flow = part->spare[2];
    if (w->residual)
        make_residual_flows(w, flow, near, slopes, h, next);
    else
        multiply_pairs(w, flow, near, h, next, w->width);
}

/* out += sign * the flows through the pairs of rows y and y + 1.  The flows are kept for the next
 * row. */
static void add_pairs_below(const ntp__weighted *w, ntp__weighted_part *part, double *out,
                            int32_t y, double sign)
{
    bool wrap = w->plan->wrap_y;
    if (w->height < 2 || (!wrap && (y < 0 || y + 1 >= w->height)))
        return;
    if (part->flows_of != y)
        make_flows_below(w, part, y);
    part->flows_of = y;
    for (int32_t x = 0; x < w->width; x++)
        out[x] += sign * part->spare[2][x];
}

/* -------------------------------------------------------------------------------- prior */

/* Row y of the Laplacian of a plane; holes and what lies beyond free ends have no part in it. */
static void laplace(const ntp__weighted *w, double *out, const double *plane, int32_t y)
{
    int32_t last = w->width - 1, above = y > 0 ? y - 1 : w->height - 1;
    int32_t below = y + 1 < w->height ? y + 1 : 0;
    const float *weights = w->right;
    size_t row = ntp__weighted_at(w, y), up = ntp__weighted_at(w, above);
    size_t down = ntp__weighted_at(w, below);
    bool has_up = y > 0 || w->plan->wrap_y, has_down = y + 1 < w->height || w->plan->wrap_y;
    for (int32_t x = 0; x <= last; x++) {
        size_t at = row + (size_t) x;
        size_t left = x > 0 ? at - 1 : row + (size_t) last, right = x < last ? at + 1 : row;
        bool has_left = x > 0 || w->plan->wrap_x, has_right = x < last || w->plan->wrap_x;
        double h = plane[at], across = 0, along = 0;
        across += has_left && !ntp__in_hole(weights[left]) ? h - plane[left] : 0;
        across += has_right && !ntp__in_hole(weights[right]) ? h - plane[right] : 0;
        along += has_up && !ntp__in_hole(weights[up + (size_t) x]) ? h - plane[up + (size_t) x] : 0;
        along += has_down && !ntp__in_hole(weights[down + (size_t) x])
                     ? h - plane[down + (size_t) x]
                     : 0;
        double sum = w->inverse.share_x * across + w->inverse.share_y * along;
        out[x] = ntp__in_hole(weights[at]) ? 0 : sum;
    }
}

static void laplace_band(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    (void) part;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++)
        laplace(w, w->laplacian + ntp__weighted_at(w, y), w->from, y);
}

static void add_prior(const ntp__weighted *w, ntp__weighted_part *part, double *out, int32_t y)
{
    double factor = w->residual ? -w->prior : w->prior, *twice = part->spare[0];
    laplace(w, twice, w->laplacian, y);
    for (int32_t x = 0; x < w->width; x++)
        out[x] += factor * twice[x];
}

/* --------------------------------------------------------------------------- the passes */

static void apply_row(ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    const ntp__stencil *s = w->stencil;
    double *out = w->to + ntp__weighted_at(w, y);
    memset(out, 0, (size_t) w->width * sizeof *out);
    for (int32_t t = 0; w->rows && t < s->terms; t++) {
        add_slopes(w, part, out, y, &s->along_x[t], &s->across_y[t], true);
        add_slopes(w, part, out, y, &s->across_x[t], &s->along_y[t], false);
    }
    if (w->prior > 0)
        add_prior(w, part, out, y);
    if (w->strength > 0 || (w->strength_alone > 0 && w->holes)) {
        add_pairs_of_row(w, part, out, y);
        add_pairs_below(w, part, out, y - 1, 1);
        add_pairs_below(w, part, out, y, -1);
    }
    const double *from = w->from + ntp__weighted_at(w, y);
    double sum = 0;
    for (int32_t x = 0; x < w->width; x++)
        sum += from[x] * out[x];
    w->sum[y] = sum;
}

static void apply_band(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    ntp__row_cache_forget(&w->parts[part].weighted);
    ntp__row_cache_forget(&w->parts[part].stored);
    w->parts[part].flows_of = NO_FLOWS;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++)
        apply_row(w, &w->parts[part], y);
}

void ntp__weighted_apply(ntp__weighted *w, double *to, const double *from, bool residual)
{
    w->from = from;
    w->to = to;
    w->residual = residual;
    if (w->prior > 0)
        ntp__crew_each(&w->crew, laplace_band, w, ntp__bands(w));
    ntp__crew_each(&w->crew, apply_band, w, ntp__bands(w));
}
