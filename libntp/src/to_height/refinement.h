/* SPDX-License-Identifier: MIT */
/*
 * refinement.h - heights on their way to the texture: refine.c leads, refine_steps.c walks
 */
#ifndef NTP_REFINEMENT_H
#define NTP_REFINEMENT_H

#include "to_height/round_trip.h"
#include "to_height/shared/inverse.h"
#include "to_height/ties.h"

enum {
    NTP__MEMORY = 6, /* steps that are remembered; more take no fewer rounds */
    NTP__DOTS = 4    /* products of each remembered step, see `learn_row` */
};

typedef struct ntp__refinement {
    ntp__round_trip *trip;
    const ntp__height_plan *plan;
    ntp__crew crew;
    ntp__inverse inverse;
    ntp__ties ties;
    double *heights, *gradient; /* packed planes, as all below */
    float *trial;               /* the heights rounded */
    float *before;              /* the gradient before the step */
    float *right, *down;        /* derivatives by slopes */
    float *way;                 /* the direction */
    float *scale;               /* of the inverse */
    float *answer, *answer_before;
    float *step[NTP__MEMORY], *answered[NTP__MEMORY]; /* remembered */
    double *work;                                     /* two rows for each part */
    double *sums;                                     /* NTP__MEMORY * NTP__DOTS of each row */
    int32_t stage, remembered, newest;
    double with_change[NTP__MEMORY][NTP__MEMORY];   /* [i][j]: step i by the change of j */
    double answer_change[NTP__MEMORY][NTP__MEMORY]; /* answer i by the change of j */
    double with_gradient[NTP__MEMORY], answer_gradient[NTP__MEMORY];
    double length;   /* of the first guess of the inverse curvature */
    double rounding; /* of heights to floats, of half a level */
    double moved;    /* the part of `way` by which heights have moved */
    double of_step[NTP__MEMORY], of_answer[NTP__MEMORY]; /* what `way` is made of */
    double by;
} ntp__refinement;

/* Where row y of a packed plane starts, in texels. */
static inline size_t ntp__refinement_row(const ntp__refinement *f, int32_t y)
{
    return (size_t) y * (size_t) f->plan->width;
}

static inline double ntp__least_step(const ntp__height_plan *plan)
{
    return plan->dx < plan->dy ? plan->dx : plan->dy;
}

/* Sets the inverse by the stored slopes.  It overwrites the gradient, `before`, `right`, `down` and
 * `scale`. */
void ntp__refinement_set_metric(ntp__refinement *f);

/* Moves the heights to this length of the way, and returns the value there; *off: texels that
 * differ. */
double ntp__refinement_value(ntp__refinement *f, double length, uint64_t *off);

/* One round: a way, and a step along it to a lower *value.  stepped: the last round took a step,
 * which is learnt from.  false: nothing more helps, and the heights are where they were. */
bool ntp__refinement_advance(ntp__refinement *f, bool stepped, double *value, uint64_t *off);

#endif
