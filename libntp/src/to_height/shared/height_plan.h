/* SPDX-License-Identifier: MIT */
/*
 * height_plan.h - what is to be solved: ntp_height_options, checked, with all defaults filled in
 *
 * to_height/make_plan.c makes it, and is the only file that checks options.  The solvers take it as
 * it is.
 */
#ifndef NTP_HEIGHT_PLAN_H
#define NTP_HEIGHT_PLAN_H

#include "libntp.h"

#include <stdbool.h>

typedef enum ntp__solver {
    NTP__SOLVER_DIRECT,      /* transforms along rows; recursion or transforms down columns */
    NTP__SOLVER_TELESCOPING, /* sums of slopes */
    NTP__SOLVER_WEIGHTED     /* iteration */
} ntp__solver;

typedef struct ntp__height_plan {
    int32_t width, height;
    ntp__solver solver;
    ntp_height_method method; /* the name that the result bears */
    ntp_kernel kernel;
    ntp_border border_x, border_y;
    bool wrap_x, wrap_y;
    double dx, dy; /* above 0 */
    ntp_prior prior;
    ntp_decode decode; /* may be AUTO until the texture has been looked at */
    int32_t neutral;   /* with NEUTRAL: levels up to so many halves from zero are 0 */
    double lean[2];    /* of nx and ny: what flat ground of a damaged texture adds to their means */
    ntp_z z;           /* the same */
    double least_z;    /* a stored z below this counts as this; 0: only the rule of half a level */
    bool mix_z;        /* the stored z is damaged as x and y are: all three tell it; see slopes.c */
    double error;      /* of x, y and z of a damaged texture, for the prior; 0: rounding alone */
    uint32_t touch_unused;
    const ntp_const_image *mask; /* for weighted; or NULL */
    double tolerance;            /* for weighted */
    int32_t max_iterations;
    bool use_seeds, equalize; /* for telescoping */
    double seeds[4];
    ntp_residual_scope residual_scope;
    bool detrend;
    int32_t refine;
} ntp__height_plan;

#endif
