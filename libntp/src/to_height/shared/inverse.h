/* SPDX-License-Identifier: MIT */
/*
 * inverse.h - the inverse of the normal equations without weights, holes and ends
 *
 * It is the preconditioner of weighted least squares, and the metric of refinement.
 */
#ifndef NTP_INVERSE_H
#define NTP_INVERSE_H

#include "base/parts.h"
#include "base/scratch.h"
#include "to_height/shared/fft.h"
#include "to_height/shared/height_plan.h"
#include "to_height/shared/slope_operator.h"

/* One axis. */
typedef struct ntp__spectrum {
    ntp__fft fft;
    ntp__gains *gains; /* of the stencil, for each element of a transformed row */
    double *edge;      /* squared gains of pairs */
} ntp__spectrum;

typedef struct ntp__inverse {
    int32_t width, height;
    ntp__crew crew;
    double share_x, share_y; /* 1/dx^2 and 1/dy^2, scaled so that the greater one is 1 */
    bool rows;               /* slopes count; false: only pairs of neighbors do (baked) */
    double strength, prior;  /* of pairs, and of the squared Laplacian; set by the caller */
    ntp__spectrum along, across;
    const float *scale; /* see ntp__inverse_scale; NULL: there is none */
    void **work;        /* of each part */
    float *zeros;
    const double *from;
    const ntp_image *to;
} ntp__inverse;

/* Lays out its memory, or measures it where memory->base is NULL. */
void ntp__inverse_init(ntp__inverse *inverse, const ntp__height_plan *plan, ntp__crew crew,
                       ntp__scratch *memory);

/*
 * With slopes of weights w the normal equations are near to root(w) A root(w), if A has none and w is
 * smooth.  So the inverse is taken between two factors for each texel, 1/root(w).  `scale` holds the
 * weights, positive, and gets the factors: the weights are made smooth first, and the power is 3/8,
 * with which refinement took the fewest rounds.  Both planes are packed.
 */
void ntp__inverse_scale(ntp__inverse *inverse, float *scale, float *work);

/* to = the solution for the packed plane `from`, of mean 0 if there is no scale; `to` is packed as
 * well. */
void ntp__inverse_apply(ntp__inverse *inverse, const ntp_image *to, const double *from);

#endif
