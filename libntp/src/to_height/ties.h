/* SPDX-License-Identifier: MIT */
/*
 * ties.h - texels of flat ground, whose heights refinement keeps equal
 */
#ifndef NTP_TIES_H
#define NTP_TIES_H

#include "to_height/round_trip.h"

/* Groups of texels.  A texel that is tied to no other has the group -1. */
typedef struct ntp__ties {
    bool any, sure; /* sure: only heights that have to be equal are tied */
    size_t texels;
    int32_t *group; /* the first texel of the group; packed */
    int32_t *count; /* of the group, at its first texel */
    double *sum;    /* likewise */
} ntp__ties;

/* Lays out its memory, or measures it where memory->base is NULL. */
void ntp__ties_init(ntp__ties *ties, const ntp__height_plan *plan, ntp__scratch *memory);

/* Finds the groups.  heights: packed; those of holes are NaN. */
void ntp__ties_find(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                    const double *heights);

/* Changes the groups after heights came to a halt: frees what is tied wrongly, and ties what makes
 * slopes 0 that should be flat and lie just beyond the edge.  Returns whether there was any of it. */
bool ntp__ties_change(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                      const double *heights);

/* Replaces the values of each group by their mean, in a packed plane. */
void ntp__ties_level(const ntp__ties *ties, double *plane);
void ntp__ties_level_floats(const ntp__ties *ties, float *plane);

#endif
