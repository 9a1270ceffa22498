/* SPDX-License-Identifier: MIT */
/*
 * weighted_operator.c - the normal equations of weighted least squares, row by row
 *
 * A row of the result is a sum over the weighted slopes that read it, and the flows through its
 * pairs.  Each part keeps the rows of slopes it has made; where bands of two parts meet, both make
 * them.  So every row is made in one order, by whichever part.
 */
#include "weighted.h"

#include <string.h>

/* ------------------------------------------------------------------------ rows of slopes */

/* The place of row y; *found: it was there. */
static int32_t place_of(ntp__kept *kept, int32_t y, bool *found)
{
    int32_t oldest = 0, at = -1;
    for (int32_t k = 0; k < NTP__KEPT; k++) {
        at = kept->row[k] == y ? k : at;
        oldest = kept->used[k] < kept->used[oldest] ? k : oldest;
    }
    *found = at >= 0;
    at = *found ? at : oldest;
    kept->row[at] = y;
    kept->used[at] = ++kept->clock;
    return at;
}

static void forget(ntp__kept *kept)
{
    kept->clock = 0;
    for (int32_t k = 0; k < NTP__KEPT; k++) {
        kept->row[k] = -1;
        kept->used[k] = 0;
    }
}

/* Stored slopes of row y. */
static int32_t stored_row(const ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    bool found;
    int32_t k = place_of(&part->stored, y, &found);
    if (!found)
        ntp__weighted_stored(w, part->stored.right[k], part->stored.down[k], y);
    return k;
}

static void weigh(double *slope, const double *stored, const float *weight, int32_t n)
{
    for (int32_t x = 0; x < n; x++) {
        double v = stored != NULL ? stored[x] - slope[x] : slope[x];
        slope[x] = weight[x] > 0 ? (double) weight[x] * v : 0;
    }
}

static int32_t weighted_row(const ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    bool found;
    int32_t k = place_of(&part->weighted, y, &found);
    if (found)
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

/* out += adjoint of (x line of y line) at row y, of the slopes to the right or down. */
static void add_slopes(const ntp__weighted *w, ntp__weighted_part *part, double *out, int32_t y,
                       const ntp__line *along_rows, const ntp__line *along_columns, bool right)
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

static float magnitude(float v)
{
    return v < 0 ? -v : v;
}

/* Of a pair a, b and the texels before and after it: more where no slope near it counts. */
static double pair_weight(const ntp__weighted *w, float before, float a, float b, float after)
{
    float ma = magnitude(a), mb = magnitude(b), least = ma < mb ? ma : mb;
    bool alone = (before <= 0) & (a <= 0) & (b <= 0) & (after <= 0);
    return (double) least * (alone ? w->strength_alone : w->strength);
}

/* The stored difference of a pair: the integral of the slopes over it. */
static double pair_data(const ntp__weighted *w, const float weight[4], const double slope[4])
{
    if (!w->rows && weight[0] != 0 && weight[3] != 0)
        return (13 * (slope[1] + slope[2]) - (slope[0] + slope[3])) / 24;
    return (slope[1] + slope[2]) / 2;
}

/* Elements x - 1 .. x + 2; what is beyond a free end counts as a hole. */
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

static void add_pairs_of_row(const ntp__weighted *w, ntp__weighted_part *part, double *out,
                             int32_t y)
{
    int32_t n = w->width;
    bool wrap = w->how->border_x == NTP_BORDER_WRAP;
    const float *weights = w->right + ntp__weighted_at(w, y);
    const double *h = w->from + ntp__weighted_at(w, y), *slopes = NULL;
    if (w->residual)
        slopes = part->stored.right[stored_row(w, part, y)];
    for (int32_t x = 0; n > 1 && x < (wrap ? n : n - 1); x++) {
        int32_t next = x + 1 < n ? x + 1 : 0;
        float weight[4];
        double slope[4];
        neighborhood(weight, slope, weights, slopes, x, n, wrap);
        double data = w->residual ? pair_data(w, weight, slope) : 0;
        double flow = pair_weight(w, weight[0], weight[1], weight[2], weight[3]) *
                      (w->residual ? data - (h[next] - h[x]) : h[next] - h[x]);
        out[next] += flow;
        out[x] -= flow;
    }
}

/* out += sign * the flows through the pairs of rows y and y + 1. */
static void add_pairs_below(const ntp__weighted *w, ntp__weighted_part *part, double *out,
                            int32_t y, double sign)
{
    const float *weights[4];
    const double *slopes[4];
    int32_t n = w->height;
    bool wrap = w->how->border_y == NTP_BORDER_WRAP;
    if (n < 2 || (!wrap && (y < 0 || y + 1 >= n)))
        return;
    for (int32_t i = 0; i < 4; i++) {
        int32_t at = y - 1 + i;
        bool inside = wrap || (at >= 0 && at < n);
        at = (at + n) % n;
        weights[i] = inside ? w->down + ntp__weighted_at(w, at) : part->no_weights;
        slopes[i] = part->nothing;
        if (w->residual && inside)
            slopes[i] = part->stored.down[stored_row(w, part, at)];
    }
    const double *h = w->from + ntp__weighted_at(w, (y + n) % n);
    const double *next = w->from + ntp__weighted_at(w, (y + 1) % n);
    for (int32_t x = 0; x < w->width; x++) {
        float weight[4] = { weights[0][x], weights[1][x], weights[2][x], weights[3][x] };
        double flow = next[x] - h[x];
        if (w->residual) {
            double slope[4] = { slopes[0][x], slopes[1][x], slopes[2][x], slopes[3][x] };
            flow = pair_data(w, weight, slope) - flow;
        }
        out[x] += sign * pair_weight(w, weight[0], weight[1], weight[2], weight[3]) * flow;
    }
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
    if (w->strength > 0) {
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
    forget(&w->parts[part].weighted);
    forget(&w->parts[part].stored);
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++)
        apply_row(w, &w->parts[part], y);
}

void ntp__weighted_apply(ntp__weighted *w, double *to, const double *from, bool residual)
{
    w->from = from;
    w->to = to;
    w->residual = residual;
    ntp__crew_each(&w->crew, apply_band, w, ntp__bands(w));
}
