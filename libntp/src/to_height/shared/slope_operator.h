/* SPDX-License-Identifier: MIT */
/*
 * slope_operator.h - slopes of a heightfield as a linear operator, and its adjoint
 *
 * A slope is a sum of one or two products of an operator on rows with one on columns.  A line is
 * such an operator on one axis: taps in the interior, single entries near the ends, where the
 * border says what lies beyond.
 */
#ifndef NTP_SLOPE_OPERATOR_H
#define NTP_SLOPE_OPERATOR_H

#include "stencil/border.h"

/* Near the ends: up to 4 positions at each, 9 taps, of which each stands for up to 2 texels. */
enum { NTP__LINE_ENTRIES = 2 * NTP__MAX_RADIUS * NTP__MAX_TAPS * 2 };

typedef struct ntp__line_entry {
    int32_t row, at;
    double weight;
} ntp__line_entry;

typedef struct ntp__line {
    int32_t n, low, high; /* positions low..high - 1 have all their taps inside */
    bool identity;
    double tap[NTP__MAX_TAPS];
    int32_t count;
    ntp__line_entry entry[NTP__LINE_ENTRIES];
} ntp__line;

/* What a line multiplies element `at` with: one row or column of its matrix. */
typedef struct ntp__line_terms {
    int32_t count;
    int32_t at[NTP__MAX_TAPS + NTP__LINE_ENTRIES];
    double weight[NTP__MAX_TAPS + NTP__LINE_ENTRIES];
} ntp__line_terms;

typedef struct ntp__stencil {
    int32_t width, height, terms;
    /* The slope to the right is along_x of across_y, the one down across_x of along_y. */
    ntp__line along_x[2], across_x[2], along_y[2], across_y[2];
} ntp__stencil;

/* A packed plane of heights, one of the two; stride in elements. */
typedef struct ntp__plane {
    const double *d;
    const float *f;
    ptrdiff_t stride;
} ntp__plane;

/* absolute: with the magnitudes of all weights.  kernel is one of the table's. */
void ntp__stencil_init(ntp__stencil *s, ntp_kernel kernel, ntp_border border_x, ntp_border border_y,
                       int32_t width, int32_t height, bool absolute);

/* Slopes of row y; work: room for a row. */
void ntp__stencil_slopes(const ntp__stencil *s, double *right, double *down, double *work,
                         const ntp__plane *heights, int32_t y);

/* Which elements, with which weights, make element i of the line; and which ones i is part of. */
void ntp__line_row(ntp__line_terms *terms, const ntp__line *line, int32_t i);
void ntp__line_column(ntp__line_terms *terms, const ntp__line *line, int32_t i);

/* Adds the adjoint of a line of a row. */
void ntp__line_adjoint(const ntp__line *line, double *out, const double *in);

/* The square of the gain of slopes at frequencies along (cos, sin) of w, without the borders. */
typedef struct ntp__gains {
    double along[2], across[2];
} ntp__gains;

void ntp__stencil_gains(ntp__gains *gains, ntp_kernel kernel, int64_t k, int64_t n);

#endif
