/* SPDX-License-Identifier: MIT */
/*
 * slope_operator.c - slopes of a heightfield as a linear operator, and its adjoint
 *
 * The lines follow ntp_normals_from_height: the same taps, and the same heights beyond each border.
 * The operator and its adjoint read one table, so they are adjoint up to rounding.
 */
#include "to_height/shared/slope_operator.h"

#include "to_height/shared/fft.h"

#include <math.h>
#include <string.h>

enum { RADIUS = NTP__MAX_RADIUS, POINTS = NTP__MAX_TAPS };

static double magnitude(double v)
{
    return v < 0 ? -v : v;
}

/* Entries for the same element are one: at a mirrored end slopes are exactly 0 then, as their normals
 * are. */
static void add_entry(ntp__line *line, int32_t row, int32_t at, double weight)
{
    for (int32_t j = 0; j < line->count; j++) {
        if (line->entry[j].row == row && line->entry[j].at == at) {
            line->entry[j].weight += weight;
            return;
        }
    }
    line->entry[line->count++] = (ntp__line_entry) { row, at, weight };
}

static void init_line(ntp__line *line, const int32_t taps[NTP__MAX_TAPS], double denominator,
                      ntp_border border, ntp__span span, int32_t n, bool absolute)
{
    memset(line, 0, sizeof *line);
    line->n = n;
    line->identity = true;
    int32_t first = 0, last = 0;
    for (int32_t k = -RADIUS; k <= RADIUS; k++) {
        double tap = taps[k + RADIUS] / denominator;
        line->tap[k + RADIUS] = absolute ? magnitude(tap) : tap;
        line->identity = line->identity && tap == (k == 0 ? 1 : 0);
        first = tap != 0 && k < first ? k : first;
        last = tap != 0 && k > last ? k : last;
    }
    line->low = -first > span.first ? -first : span.first;
    line->high = n - last < span.last + 1 ? n - last : span.last + 1;
    if (line->low >= line->high)
        line->low = line->high = 0;
    for (int32_t i = 0; i < n; i++) {
        if (i == line->low && line->high > line->low)
            i = line->high;
        if (i >= n)
            break;
        int32_t position = ntp__clamp(i, span);
        for (int32_t k = first; k <= last; k++) {
            ntp__mapped m = ntp__border_map(ntp__border_beyond(border), position + k, n);
            for (int32_t j = 0; j < m.count && line->tap[k + RADIUS] != 0; j++) {
                double weight = line->tap[k + RADIUS] * m.weight[j];
                add_entry(line, i, m.index[j], absolute ? magnitude(weight) : weight);
            }
        }
    }
}

/* Near an end: the slope at i of the polynomial through the nearest heights, as Lagrange wrote it. */
static void add_polynomial(ntp__line *line, int32_t i, int32_t n)
{
    int32_t count = n < POINTS ? n : POINTS, most = n - count;
    int32_t first = i - POINTS / 2 > 0 ? i - POINTS / 2 : 0;
    first = first < most ? first : most;
    double own = 0;
    for (int32_t j = first; j < first + count; j++) {
        double weight = 1.0 / (j - i);
        if (j == i)
            continue;
        own -= weight;
        for (int32_t k = first; k < first + count; k++)
            weight *= k != i && k != j ? (double) (i - k) / (j - k) : 1;
        add_entry(line, i, j, weight);
    }
    add_entry(line, i, i, own);
}

/* The slopes of a surface whose heights are known at the texels. */
static void init_baked_line(ntp__line *line, ntp_border border, int32_t n)
{
    static const int32_t taps[NTP__MAX_TAPS] = { 3, -32, 168, -672, 0, 672, -168, 32, -3 };
    init_line(line, taps, 840, NTP_BORDER_WRAP, (ntp__span) { 0, n - 1 }, n, false);
    if (border == NTP_BORDER_WRAP)
        return;
    line->count = 0;
    for (int32_t i = 0; i < n; i++) {
        if (i < line->low || i >= line->high)
            add_polynomial(line, i, n);
    }
}

static void init_baked(ntp__stencil *s, ntp_border border_x, ntp_border border_y)
{
    static const int32_t one[NTP__MAX_TAPS] = { [RADIUS] = 1 };
    s->terms = 1;
    init_baked_line(&s->along_x[0], border_x, s->width);
    init_baked_line(&s->along_y[0], border_y, s->height);
    init_line(&s->across_x[0], one, 1, border_x, (ntp__span) { 0, s->width - 1 }, s->width, false);
    init_line(&s->across_y[0], one, 1, border_y, (ntp__span) { 0, s->height - 1 }, s->height,
              false);
}

void ntp__stencil_init(ntp__stencil *s, ntp_kernel kernel, ntp_border border_x, ntp_border border_y,
                       int32_t width, int32_t height, bool absolute)
{
    const ntp__kernel *k = &ntp__kernel_table[kernel];
    s->width = width;
    s->height = height;
    if (kernel == NTP_KERNEL_BAKED) {
        init_baked(s, border_x, border_y);
        return;
    }
    s->terms = k->terms;
    for (int32_t t = 0; t < k->terms; t++) {
        const ntp__taps *taps = &k->term[t];
        double whole = k->denominator;
        init_line(&s->along_x[t], taps->along, whole, border_x,
                  ntp__stencil_span(k, true, border_x, width), width, absolute);
        init_line(&s->across_x[t], taps->across, 1, border_x,
                  ntp__stencil_span(k, false, border_x, width), width, absolute);
        init_line(&s->along_y[t], taps->along, whole, border_y,
                  ntp__stencil_span(k, true, border_y, height), height, absolute);
        init_line(&s->across_y[t], taps->across, 1, border_y,
                  ntp__stencil_span(k, false, border_y, height), height, absolute);
    }
}

static void add_term(ntp__line_terms *terms, int32_t at, double weight)
{
    terms->at[terms->count] = at;
    terms->weight[terms->count] = weight;
    terms->count++;
}

void ntp__line_row(ntp__line_terms *terms, const ntp__line *line, int32_t i)
{
    terms->count = 0;
    if (i >= line->low && i < line->high) {
        for (int32_t k = -RADIUS; k <= RADIUS; k++) {
            if (line->tap[k + RADIUS] != 0)
                add_term(terms, i + k, line->tap[k + RADIUS]);
        }
        return;
    }
    for (int32_t j = 0; j < line->count; j++) {
        if (line->entry[j].row == i)
            add_term(terms, line->entry[j].at, line->entry[j].weight);
    }
}

void ntp__line_column(ntp__line_terms *terms, const ntp__line *line, int32_t i)
{
    terms->count = 0;
    for (int32_t k = RADIUS; k >= -RADIUS; k--) {
        if (line->tap[k + RADIUS] != 0 && i - k >= line->low && i - k < line->high)
            add_term(terms, i - k, line->tap[k + RADIUS]);
    }
    for (int32_t j = 0; j < line->count; j++) {
        if (line->entry[j].at == i)
            add_term(terms, line->entry[j].row, line->entry[j].weight);
    }
}

/* out += line of in */
static void add_line(const ntp__line *line, double *restrict out, const double *restrict in)
{
    for (int32_t k = -RADIUS; k <= RADIUS; k++) {
        double tap = line->tap[k + RADIUS];
        if (tap == 0)
            continue;
        for (int32_t i = line->low; i < line->high; i++)
            out[i] += tap * in[i + k];
    }
    for (int32_t j = 0; j < line->count; j++)
        out[line->entry[j].row] += line->entry[j].weight * in[line->entry[j].at];
}

void ntp__line_adjoint(const ntp__line *line, double *restrict out, const double *restrict in)
{
    for (int32_t k = -RADIUS; k <= RADIUS; k++) {
        double tap = line->tap[k + RADIUS];
        if (tap == 0)
            continue;
        for (int32_t i = line->low; i < line->high; i++)
            out[i + k] += tap * in[i];
    }
    for (int32_t j = 0; j < line->count; j++)
        out[line->entry[j].at] += line->entry[j].weight * in[line->entry[j].row];
}

/* Row y of a line along columns: a weighted sum of rows. */
static void mix_rows(const ntp__line *line, double *out, const ntp__plane *heights, int32_t y,
                     int32_t width)
{
    ntp__line_terms terms;
    ntp__line_row(&terms, line, y);
    memset(out, 0, (size_t) width * sizeof *out);
    for (int32_t j = 0; j < terms.count; j++) {
        double weight = terms.weight[j];
        ptrdiff_t start = (ptrdiff_t) terms.at[j] * heights->stride;
        if (heights->d != NULL) {
            const double *row = heights->d + start;
            for (int32_t x = 0; x < width; x++)
                out[x] += weight * row[x];
        } else {
            const float *row = heights->f + start;
            for (int32_t x = 0; x < width; x++)
                out[x] += weight * (double) row[x];
        }
    }
}

void ntp__stencil_slopes(const ntp__stencil *s, double *right, double *down, double *work,
                         const ntp__plane *heights, int32_t y)
{
    size_t row = (size_t) s->width * sizeof(double);
    memset(right, 0, row);
    memset(down, 0, row);
    for (int32_t t = 0; t < s->terms; t++) {
        mix_rows(&s->across_y[t], work, heights, y, s->width);
        add_line(&s->along_x[t], right, work);
        mix_rows(&s->along_y[t], work, heights, y, s->width);
        add_line(&s->across_x[t], down, work);
    }
}

/* Taps across are even.  Taps along are odd, but for those of `forward`: their gain has a phase,
 * which is left out, as there is no other term that it would be added to. */
void ntp__stencil_gains(ntp__gains *gains, ntp_kernel kernel, int64_t k, int64_t n)
{
    const ntp__kernel *table = &ntp__kernel_table[kernel];
    memset(gains, 0, sizeof *gains);
    for (int32_t t = 0; t < table->terms; t++) {
        double even = 0, odd = 0;
        for (int32_t i = -RADIUS; i <= RADIUS; i++) {
            double c, s, along = (double) table->term[t].along[i + RADIUS] / table->denominator;
            int64_t turn = k * i % n;
            ntp__turn(&c, &s, turn < 0 ? turn + n : turn, n);
            gains->across[t] += table->term[t].across[i + RADIUS] * c;
            even += along * c;
            odd += along * s;
        }
        bool forward = kernel == NTP_KERNEL_FORWARD;
        gains->along[t] = forward ? sqrt(even * even + odd * odd) : odd;
    }
}
