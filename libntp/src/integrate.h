/* SPDX-License-Identifier: MIT */
/*
 * integrate.h - what the files of "normals -> heightfield" share
 */
#ifndef NTP_INTEGRATE_H
#define NTP_INTEGRATE_H

#include "fft.h"
#include "slopes.h"

/* One axis of the image, with the stencil of the slopes along it. */
typedef struct ntp__grid_axis {
    int32_t n;
    bool central, wrap;
    double last; /* forward, not wrap: share of the last slope in the last edge, with its sign */
    double edge; /* central, not wrap: weight of the slopes at both ends */
} ntp__grid_axis;

/* The direct solver and telescoping: does it take this, its working memory, and the work, which adds
 * to counts.  parts: at least 1.  Of `how` the fields up to `equalize` count, but not decode and
 * z, which the slopes have in them. */
ntp_status ntp__integrate_check(const ntp_height_options *how, int32_t width, int32_t height);
size_t ntp__integrate_scratch(const ntp_height_options *how, int32_t width, int32_t height,
                              int32_t parts);
ntp_status ntp__integrate(const ntp_image *dst, const ntp__slopes *slopes,
                          const ntp_height_options *how, void *scratch, const ntp_hooks *hooks,
                          ntp__slope_counts *counts);

enum { NTP__MAX_TERMS = 4 };

/* A weighted sum of slopes. */
typedef struct ntp__terms {
    int32_t count;
    int32_t at[NTP__MAX_TERMS];
    double weight[NTP__MAX_TERMS];
} ntp__terms;

ntp_status ntp__grid_axis_init(ntp__grid_axis *axis, int32_t n, ntp_kernel kernel,
                               ntp_border border);

/* The adjoint of the stencil: what the slopes say about the height at i. */
void ntp__adjoint(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i);

/* Eigenvalue of the stencil followed by its adjoint, for element j of a transformed row. */
double ntp__eigenvalue(const ntp__grid_axis *axis, int32_t j);

/*
 * Solves (A + lambda) h = f down columns x0..x1 - 1 of a packed float image in place, A being
 * (adjoint)(stencil) of the axis and lambda the eigenvalue of each column on the other axis.
 * Where lambda is 0 the solution has mean 0 on each chain of rows that A couples.  sums: f of
 * column 0, more exactly; column: room for axis->n doubles.
 */
void ntp__solve_columns(const ntp_image *dst, const ntp__grid_axis *along,
                        const ntp__grid_axis *down, const double *sums, double *column, int32_t x0,
                        int32_t x1);

enum { NTP__COLUMNS = 256 /* at most, of a call */ };

/* Eberly's sums.  rows: room for 5 rows of doubles. */
void ntp__telescope(const ntp_image *dst, const ntp__slopes *slopes, const ntp_height_options *how,
                    double *rows, ntp__slope_counts *counts);

#endif
