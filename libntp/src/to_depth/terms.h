/* SPDX-License-Identifier: MIT */
/*
 * terms.h - what normals say about depth: two one-sided equations an axis at each texel
 *
 * Used texels are nodes, in the order of rows.  At node i the normals ask for view (z[j] - z[i]) =
 * rise for the neighbor j after it, and for view (z[i] - z[j]) = rise for j before it.  z is the
 * depth, or with a camera its logarithm.  Of the two, the share says how far the one after it
 * counts; the other counts the rest.  So at a cliff a texel can go with one side alone.  Beside that
 * the two equations of a pair of neighbors have a trust: the less their normals agree, and the
 * further depth is off both of their slopes, the less they count.
 *
 * Least squares solves these equations as they are.  All else takes the mean slope of a pair in both of
 * its equations, which is right at a fold, too; view says only how much they weigh.
 */
#ifndef NTP_TO_DEPTH_TERMS_H
#define NTP_TO_DEPTH_TERMS_H

#include "base/view.h"
#include "to_depth/graph.h"

/* Along one axis. */
typedef struct ntp__axis_terms {
    int32_t *after, *before; /* the neighbors of a node; -1: none */
    float *view, *rise;
    float *share; /* of the equation with the node after it; the other has the rest */
    float *even;  /* trust in the pair of a node and the one after it, by their normals alone */
    float *trust; /* the same, also by depth */
    float *stiff; /* of the spring to the node after it */
    float *pull;  /* the force by which that spring pushes the two apart */
    double focal; /* texels; 1 without a camera */
} ntp__axis_terms;

typedef struct ntp__terms {
    int32_t nodes;
    ntp__axis_terms axis[2]; /* to the right, down */
    double *z, *force;
    bool own; /* each equation has the slope of its node; else both of a pair have the mean slope */
} ntp__terms;

/* Takes memory for so many nodes. */
void ntp__terms_init(ntp__terms *t, int32_t nodes, ntp__scratch *memory);

/* Counts of texels. */
typedef struct ntp__term_counts {
    uint64_t holes, not_finite, turned_away;
} ntp__term_counts;

/* Reads the normals.  node: of each texel, -1 in holes. */
void ntp__terms_read(ntp__terms *t, int32_t *node, const ntp_const_image *src,
                     const ntp_depth_options *how, ntp__term_counts *counts);

/* All shares 1/2, all trust 1: least squares. */
void ntp__terms_even(ntp__terms *t);

/* Sets the shares by the depth so far: 1 / (1 + exp(-k (b^2 - a^2))), a and b the products of view
 * and the difference to the node after and before it. */
void ntp__terms_share(ntp__terms *t, double k);

/* Sets the trust.  `far`: how many texels off both slopes, times the square of the cosine between
 * normal and view, halve it; 0: only the normals count. */
void ntp__terms_trust(ntp__terms *t, double far);

/* From now on bends half as large tell a cliff. */
void ntp__terms_sharpen(ntp__terms *t);

/* Springs and forces of all equations by shares and trust. */
void ntp__terms_springs(ntp__terms *t, ntp__graph *graph);

/* The sum of the squares of what is left of all equations, by their shares, with mean slopes. */
double ntp__terms_energy(const ntp__terms *t);

/* Forces as large as what is left of the equations, with signs by chance. */
void ntp__terms_doubt(const ntp__terms *t, double *force, uint64_t *chance);

#endif
