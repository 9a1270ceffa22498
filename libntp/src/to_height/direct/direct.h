/* SPDX-License-Identifier: MIT */
/*
 * direct.h - what the files of the direct solver share
 *
 * This room solves least squares without iteration, where all texels count alike.  Rows are
 * transformed, and then each column is a small system of its own.
 *   solve.c            walks over the picture, in parts, in memory or row by row
 *   axis.c             stencils and borders: which are known, their adjoints, their symbols
 *   right_hand_side.c  the adjoint of the stencils, applied to rows of slopes
 *   columns.c          solves columns by recursion
 *   filter.c           solves columns by transforms, for kernels that recursion cannot do
 *   edges.c            fits the edges of central slopes again
 *   telescope.c        Eberly's sums of slopes, which need none of the files above
 */
#ifndef NTP_DIRECT_H
#define NTP_DIRECT_H

#include "base/parts.h"
#include "base/scratch.h"
#include "to_height/shared/row_cache.h"
#include "to_height/shared/slopes.h"
#include "to_height/shared/solver_kernels.h"

/* ---------------------------------------------------------------------------------- axes */

typedef enum ntp__axis_kind {
    NTP__AXIS_FORWARD,
    NTP__AXIS_CENTRAL,
    NTP__AXIS_BAKED,
    NTP__AXIS_TAPS /* of the table in stencil/taps.h */
} ntp__axis_kind;

/* One axis of the image, with the stencil of the slopes along it. */
typedef struct ntp__grid_axis {
    int32_t n;
    ntp_kernel kernel;
    ntp__axis_kind kind;
    ntp_border border;
    bool wrap;
    double last; /* forward, not wrap: share of the last slope in the last edge, with its sign */
    double edge; /* central, not wrap: weight of the slopes at both ends */
} ntp__grid_axis;

enum { NTP__MAX_TERMS = 10 };

/* A weighted sum of slopes. */
typedef struct ntp__terms {
    int32_t count;
    int32_t at[NTP__MAX_TERMS];
    double weight[NTP__MAX_TERMS];
} ntp__terms;

/* The adjoint of a one-dimensional stencil at i: the slopes that the height at i is part of. */
void ntp__adjoint(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i);

/* How many texels on each side of i have slopes that count in the adjoint at i. */
int32_t ntp__reach(const ntp__grid_axis *axis);

/* The index of the slope that stands at i, which may lie outside, and its sign.  Slopes along the
 * axis are odd: they change sign where the axis is mirrored.  Slopes across it are even. */
int32_t ntp__reflected(const ntp__grid_axis *axis, int32_t i, bool odd, double *sign);

/* Which transform makes the stencil diagonal. */
ntp__fft_kind ntp__axis_transform(const ntp__grid_axis *axis);

enum { NTP__AXIS_TERMS = 2 };

/* What the stencil multiplies frequency j by: for each term of a kernel the slopes along the axis
 * and the means across it, and the roughness 4 sin^2(w/2). */
typedef struct ntp__symbol {
    double along[NTP__AXIS_TERMS], across[NTP__AXIS_TERMS];
    double roughness;
} ntp__symbol;

void ntp__symbol_at(ntp__symbol *symbol, const ntp__grid_axis *axis, int32_t j);

/* Those of all frequencies. */
void ntp__symbols(ntp__symbol *symbol, const ntp__grid_axis *axis);

/* ------------------------------------------------------------------------------- problem */

/* Rows of normals, and where heights go: whole images, or callbacks. */
typedef struct ntp__problem {
    ntp__grid_axis along, down;
    double right_weight, down_weight; /* of the slopes in the right-hand side */
    double ratio;                     /* of dy and dx, squared */
    double sigma;                     /* of the rounding of slopes; 0: no prior */
    bool single;                      /* arithmetic of rows in float */
    bool filter;                      /* columns are solved by transforms, not by recursion */
} ntp__problem;

/* For a plan that ntp__direct_check takes and that is not one of telescoping. */
void ntp__problem_init(ntp__problem *p, const ntp__height_plan *plan, ntp_type type);

/* The functions below that take a scratch lay out their arrays in it.  With base NULL they only
 * measure: `used` counts. */

/* ---------------------------------------------------------------------------------- rows */

/* The row of a picture of `height` rows that a view of a few rows begins with.  The view may go
 * on at the top. */
typedef struct ntp__window {
    int32_t first, height;
} ntp__window;

/* The slopes that a part makes right-hand sides of, floats or doubles. */
typedef struct ntp__source {
    const ntp__problem *problem;
    const ntp__slopes *slopes;
    const ntp__window *window; /* NULL, or where the texture of the slopes lies in the picture */
    const ntp__row_loops *loops;
    ntp__row_cache rows;
    void *line;                                     /* a row with NTP__MAX_RADIUS on both sides */
    ntp__slope_counts row_counts[NTP__MOST_CACHED]; /* of each row in the cache */
    ntp__slope_counts counts;
} ntp__source;

void ntp__source_init(ntp__source *source, ntp__scratch *memory, const ntp__problem *p,
                      const ntp__slopes *slopes);

/* Right-hand side f of row y.  *sum is the part of it that comes from slopes down, summed; *squares
 * is the sum of f squared. */
void ntp__right_hand_side(ntp__source *source, void *f, int32_t y, double *sum, double *squares);

/* ------------------------------------------------------------------------------- columns */

typedef struct ntp__columns ntp__columns;

enum { NTP__COLUMNS = 64 /* done at a time */, NTP__MAX_NULLS = 2 };

/* Rows in the order in which they are coupled: first, first + step, and so on. */
typedef struct ntp__segment {
    int32_t first, step, length;
    double *state, *sum, *power, *entry, *start, *begin; /* of each column */
} ntp__segment;

struct ntp__columns {
    const ntp__column_loops *loops;
    const ntp__grid_axis *down;
    int32_t width;
    double scale;
    int32_t segments;
    ntp__segment segment[2];
    double *r, *inverse; /* 0: a null column, which is done apart */
    int32_t *live;       /* of each NTP__COLUMNS: the last row of a segment where r^i shows */
    int32_t nulls, null_at[NTP__MAX_NULLS];
    double *null[NTP__MAX_NULLS]; /* the null columns, whole */
};

void ntp__columns_init(ntp__columns *c, ntp__scratch *memory, const ntp__problem *p);

/* Row y of columns x0..x1 - 1.  Call `down` for all rows from the top, then `turn`, then `up` for
 * all rows from the bottom. */
void ntp__columns_down(ntp__columns *c, float *row, int32_t y, int32_t x0, int32_t x1);
void ntp__columns_turn(ntp__columns *c);
void ntp__columns_up(ntp__columns *c, float *row, int32_t y, int32_t x0, int32_t x1);

/* Transforms down the columns and a division, for stencils that recursion cannot do. */
typedef struct ntp__filter {
    const ntp__problem *problem;
    ntp__fft fft;
    ntp__symbol *along, *down; /* of each frequency */
    double prior, precision;
} ntp__filter;

void ntp__filter_init(ntp__filter *f, ntp__scratch *memory, const ntp__problem *p, void *work);
/* mean_square is that of the right-hand side. */
void ntp__filter_set_prior(ntp__filter *f, double mean_square);
void ntp__filter_columns(const ntp__filter *f, const ntp_image *dst, int32_t x0, void *work);

/* --------------------------------------------------------------------------------- edges */

enum { NTP__EDGE_LINES = 3 }; /* lines whose slopes change */

/* Fits the outermost texels at central, extrapolated borders again, with full weights; then sets
 * the range.  In whole images only. */
void ntp__edges_fit(const ntp_image *dst, const ntp__slopes *slopes, const ntp__problem *p,
                    ntp__scratch *memory, const ntp__crew *crew, float range[2]);

/* --------------------------------------------------------------------------------- whole */

/* Does this room take the plan, which is not one of weighted least squares? */
ntp_status ntp__direct_check(const ntp__height_plan *plan);

/* Working memory for a number of parts, at least 1; and the solution, which adds to counts. */
size_t ntp__direct_scratch(const ntp__height_plan *plan, int32_t parts);
ntp_status ntp__direct_solve(const ntp_image *dst, const ntp__slopes *slopes,
                             const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                             ntp__slope_counts *counts);

/* The same with rows that are read and written.  0, or an error: columns would have to be
 * transformed.  The size and the format of normals are those of form; decode and z are not AUTO. */
size_t ntp__direct_rows_scratch(const ntp_const_image *form, const ntp__height_plan *plan,
                                int32_t parts);
ntp_status ntp__direct_rows(const ntp_const_image *form, const ntp_height_rows *rows,
                            const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                            ntp_height_result *result);

/* Eberly's sums, and their working memory. */
size_t ntp__telescope_scratch(const ntp__height_plan *plan);
void ntp__telescope(const ntp_image *dst, const ntp__slopes *slopes, const ntp__height_plan *plan,
                    void *scratch, ntp__slope_counts *counts);

#endif
