/* SPDX-License-Identifier: MIT */
/*
 * weighted.h - what the files of weighted least squares share
 *
 * This room solves least squares where texels count differently, or not at all: masks, holes, steep
 * textures.  It looks for the heights h that make the sum of
 *   weight (slope of h - stored slope)^2           over the texels, right and down, and
 *   strength weight (difference of h - mean of the two stored slopes)^2     over pairs of neighbors
 * least.  The weights are about 1/variance.  A slope counts where its stencil reads no hole.  The
 * pairs tie together what a stencil leaves apart: central slopes leave even and odd texels apart.
 * They decide where a stencil sees nothing, and they are all there is for baked normals.
 *   solve.c         conjugate gradients
 *   weights.c       the weights, and the holes
 *   operator.c      the normal equations, row by row
 *   precondition.c  the same equations without weights and holes, solved by transforms
 *   first_guess.c   where the iteration begins in mazes
 *   islands.c       the connected areas, and their means
 */
#ifndef NTP_WEIGHTED_H
#define NTP_WEIGHTED_H

#include "base/parts.h"
#include "base/scratch.h"
#include "to_height/shared/fft.h"
#include "to_height/shared/row_cache.h"
#include "to_height/shared/slope_operator.h"
#include "to_height/shared/slopes.h"

enum {
    NTP__BAND = 32, /* rows of an item of work */
    NTP__KEPT = 12, /* rows of slopes that a part remembers: those of a wide stencil */
    NTP__SPARE = 3  /* more rows to work in */
};

typedef struct ntp__weighted_part {
    ntp__row_cache weighted, stored;
    double *spare[NTP__SPARE];
    int32_t flows_of;  /* the row of pairs whose flows lie in the last of them */
    float *row;        /* stands for rows below the last one */
    double *nothing;   /* a row of zeros */
    float *no_weights; /* the same */
    void *fft_work;
    uint64_t holes, not_finite;
} ntp__weighted_part;

/* An axis of the transform that solves the same problem without weights, holes and ends. */
typedef struct ntp__spectrum {
    ntp__fft fft;
    ntp__gains *gains; /* of element i of a transformed row */
    double *edge;      /* of pairs */
} ntp__spectrum;

typedef struct ntp__weighted {
    const ntp_image *dst; /* between passes: what the transform works in */
    const ntp__slopes *slopes;
    bool even; /* all weights but those of holes are 1 */
    const ntp_const_image *mask;
    const ntp__height_plan *plan;
    ntp__crew crew;
    ntp__weighted_part *parts;
    ntp__stencil *stencil;
    int32_t width, height;
    double dx, dy;           /* spacing */
    double share_x, share_y; /* 1/dx^2 and 1/dy^2, the greater one 1 */
    bool rows;               /* the slopes count; else only pairs: baked */
    double strength;         /* of pairs */
    double strength_alone;   /* of those near which no slope counts, for holes */
    bool holes;
    double *x, *r, *d, *a;  /* of conjugate gradients: heights, residual, direction, its image */
    float *right, *down;    /* weights: see ntp__in_hole */
    double *sum, *sum_also; /* of each row */
    ntp__spectrum along, across;
    double alpha, beta; /* of the running pass */
    const double *from; /* what the running pass applies the operator to */
    double *to;
    bool residual; /* to = adjoint of weights (stored - slopes of from), not of slopes of from */
} ntp__weighted;

/* Working memory for a number of parts, and the solution: dst gets heights of mean 0 over each
 * island.  even: nothing but holes has weights of its own.  hooks may be NULL.  Of result the
 * fields of NTP_HEIGHT_WEIGHTED and the trend are set. */
size_t ntp__weighted_scratch(const ntp__height_plan *plan, int32_t parts);
ntp_status ntp__weighted_solve(const ntp_image *dst, const ntp__slopes *slopes, bool even,
                               const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                               ntp_height_result *result);

/* Stored slopes of row y, as differences from a texel to the next. */
void ntp__weighted_stored(const ntp__weighted *w, double *right, double *down, int32_t y);

/* Weights, and what is a hole; the sums of rows are those of weight slope^2 (weights.c).
 * Counts are left in the parts. */
void ntp__weighted_setup(ntp__weighted *w);

/* Rows to of the operator, or of the residual (operator.c). */
void ntp__weighted_apply(ntp__weighted *w, double *to, const double *from, bool residual);

/* dst = approximate solution for r (precondition.c). */
void ntp__weighted_precondition(ntp__weighted *w);
void ntp__spectrum_init(ntp__spectrum *s, ntp__scratch *memory, ntp_kernel kernel,
                        ntp_border border, int32_t n, void *fft_work);
size_t ntp__spectrum_work(ntp_border border, int32_t n);

/* In a maze: heights in x that nearly fit; false: it is none, x is as it was.  Works in r, d, a, and
 * leaves zeros in a, which has room for ntp__walk_bytes. */
bool ntp__weighted_start(ntp__weighted *w);
size_t ntp__walk_bytes(const ntp__height_plan *plan);

/* Subtracts its mean from each island of x, 4-connected texels that are no holes, and the best
 * plane where trend is not NULL; returns how many there are (islands.c).  Works in r, d, a. */
uint64_t ntp__islands_level(ntp__weighted *w, double trend[2]);

/* Each pass reads the weights of all texels, so one float says three things: 0 is a hole, above 0 the
 * slope counts, and below 0 its stencil reads a hole, so that only pairs use the size. */
static inline bool ntp__in_hole(float weight)
{
    return weight == 0;
}

static inline bool ntp__counts(float weight)
{
    return weight > 0;
}

/* Any of four, without branches: a pass asks this for every pair. */
static inline bool ntp__any_counts(float a, float b, float c, float d)
{
    return ((a > 0) | (b > 0) | (c > 0) | (d > 0)) != 0;
}

static inline float ntp__not_counting(float weight)
{
    return -weight;
}

static inline float ntp__weight_size(float weight)
{
    return weight < 0 ? -weight : weight;
}

static inline size_t ntp__weighted_at(const ntp__weighted *w, int32_t y)
{
    return (size_t) y * (size_t) w->width;
}

static inline int32_t ntp__bands(const ntp__weighted *w)
{
    return (w->height + NTP__BAND - 1) / NTP__BAND;
}

#endif
