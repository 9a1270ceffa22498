/* SPDX-License-Identifier: MIT */
/*
 * weighted.h - what the files of weighted least squares share
 *
 * This room solves least squares where texels count differently, or not at all: masks, holes, steep
 * textures.
 *   solve.c         conjugate gradients
 *   weights.c       the weights, and the holes
 *   operator.c      the normal equations, row by row
 *   first_guess.c   where the iteration begins in mazes
 *   islands.c       the connected areas, and their means
 *
 * The heights h are those for which this sum is least:
 *   weight (slope of h - stored slope)^2           over the texels, right and down, plus
 *   strength weight (difference of h - mean of the two stored slopes)^2     over pairs of neighbors, plus
 *   prior (Laplacian of h)^2                                over the texels
 * The weights are about 1/variance.  A slope counts if its stencil reads no hole.  The prior is that
 * of the direct solver.  The pairs tie together texels that a stencil leaves apart, as central slopes
 * do with even and odd ones on an island.  But slopes of two texels do not have the difference of
 * heights as their mean, so pairs make heights less exact.  So they count in the first of two
 * solutions, where there are holes or ends that the preconditioner does not know.  The second one
 * begins with it, and has weak pairs with holes, else none.  For baked normals there are only pairs.
 */
#ifndef NTP_WEIGHTED_H
#define NTP_WEIGHTED_H

#include "base/parts.h"
#include "base/scratch.h"
#include "to_height/shared/inverse.h"
#include "to_height/shared/row_cache.h"
#include "to_height/shared/slope_operator.h"
#include "to_height/shared/slopes.h"

enum {
    NTP__BAND = 32, /* rows of an item of work */
    NTP__KEPT = 12, /* rows of slopes that a part keeps: enough for a wide stencil */
    NTP__SPARE = 3  /* further rows of working memory */
};

typedef struct ntp__weighted_part {
    ntp__row_cache weighted, stored;
    double *spare[NTP__SPARE];
    int32_t flows_of;  /* the row of pairs whose flows lie in the last spare row */
    double *nothing;   /* a row of zeros */
    float *no_weights; /* a row of zeros */
    uint64_t holes, not_finite;
} ntp__weighted_part;

typedef struct ntp__weighted {
    const ntp_image *dst; /* until the end, the transforms work in it */
    const ntp__slopes *slopes;
    const ntp_const_image *mask;
    const ntp__height_plan *plan;
    ntp__crew crew;
    ntp__weighted_part *parts;
    ntp__stencil *stencil;
    int32_t width, height;
    double dx, dy;         /* spacing */
    bool rows;             /* slopes count; false: only pairs do (baked) */
    double strength;       /* of pairs */
    double strength_alone; /* of pairs near which no slope counts, because of holes */
    double prior;          /* of the squared Laplacian of the heights */
    double rounding;       /* what it makes of the sum of weighted squares; set with the prior */
    bool holes;
    double *laplacian;      /* of the heights that the operator is applied to */
    double *x, *r, *d, *a;  /* of conjugate gradients: heights, residual, direction, its image */
    float *right, *down;    /* weights: see ntp__in_hole */
    double *sum, *sum_also; /* sums of each row */
    ntp__inverse inverse;   /* the preconditioner: all but weights, holes and ends */
    double alpha, beta;     /* of the running pass */
    const double *from;     /* the running pass applies the operator to this */
    double *to;
    bool residual; /* the pass takes stored slopes less those of `from`, not slopes of `from` */
} ntp__weighted;

/* Working memory for a number of parts, and the solution.  dst gets heights of mean 0 over each
 * island.  hooks may be NULL.  In result only the
 * fields of NTP_HEIGHT_WEIGHTED and the trend are set. */
size_t ntp__weighted_scratch(const ntp__height_plan *plan, int32_t parts);
ntp_status ntp__weighted_solve(const ntp_image *dst, const ntp__slopes *slopes,
                               const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                               ntp_height_result *result);

/* Stored slopes of row y, as differences from one texel to the next. */
void ntp__weighted_stored(const ntp__weighted *w, double *right, double *down, int32_t y);

/* Sets the weights and finds the holes (weights.c).  w->sum gets the sums of weight slope^2 of
 * rows; the parts get the counts. */
void ntp__weighted_setup(ntp__weighted *w);

/* to = the operator applied to `from`, or the residual of `from` (operator.c). */
void ntp__weighted_apply(ntp__weighted *w, double *to, const double *from, bool residual);

/* In a maze, x gets heights that nearly fit (first_guess.c); false: it is no maze, and x is as it
 * was.  Works in r, d, a.  a has room for ntp__walk_bytes, and after a walk it holds zeros. */
bool ntp__weighted_start(ntp__weighted *w);
size_t ntp__walk_bytes(const ntp__height_plan *plan);

/* Subtracts its mean from each island of x, and before that the best plane if trend is not NULL
 * (islands.c).  An island is a set of 4-connected texels that are no holes.  Returns the number of
 * islands.  Works in r, d, a. */
uint64_t ntp__islands_level(ntp__weighted *w, double trend[2]);

/* Each pass reads the weights of all texels, so one float tells three cases apart.  0: a hole.
 * Above 0: the slope counts.  Below 0: its stencil reads a hole, and only pairs use the size. */
static inline bool ntp__in_hole(float weight)
{
    return weight == 0;
}

static inline bool ntp__counts(float weight)
{
    return weight > 0;
}

/* Does any of four count?  There are no branches, as a pass asks this for every pair. */
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
