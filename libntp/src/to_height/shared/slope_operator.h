/* SPDX-License-Identifier: MIT */
/*
 * slope_operator.h - slopes of a heightfield as a linear operator, and its adjoint
 *
 * A slope is a sum of one or two products of an operator on rows and one on columns.  A line is
 * such an operator on one axis.  It has taps in the interior, and single entries near the ends,
 * where the border says what lies beyond.
 */
#ifndef NTP_SLOPE_OPERATOR_H
#define NTP_SLOPE_OPERATOR_H

#include "stencil/border.h"

/* Each end has up to 4 positions near it, with 9 taps, each of which stands for up to 2 texels. */
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

/* Elements `at` and what a line multiplies them by: one row or one column of its matrix. */
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

/* A plane of heights, as double or as float; the stride is in elements. */
typedef struct ntp__plane {
    const double *d;
    const float *f;
    ptrdiff_t stride;
} ntp__plane;

/* absolute: weights are replaced by their magnitudes (not those of NTP_KERNEL_BAKED).  For
 * NTP_KERNEL_BAKED, which has no taps in the table, slopes are those of a polynomial through the
 * nine nearest heights in a line. */
void ntp__stencil_init(ntp__stencil *s, ntp_kernel kernel, ntp_border border_x, ntp_border border_y,
                       int32_t width, int32_t height, bool absolute);

/* Slopes of row y; `work` has room for a row. */
void ntp__stencil_slopes(const ntp__stencil *s, double *right, double *down, double *work,
                         const ntp__plane *heights, int32_t y);

/* Which elements make element i of the line, with which weights; and of which ones i is a part. */
void ntp__line_row(ntp__line_terms *terms, const ntp__line *line, int32_t i);
void ntp__line_column(ntp__line_terms *terms, const ntp__line *line, int32_t i);

/* out += the adjoint of a line, applied to a row. */
void ntp__line_adjoint(const ntp__line *line, double *out, const double *in);

/* The gains of the stencil along an axis at the frequency of k turns in n, without the borders. */
typedef struct ntp__gains {
    double along[2], across[2];
} ntp__gains;

void ntp__stencil_gains(ntp__gains *gains, ntp_kernel kernel, int64_t k, int64_t n);

#endif
