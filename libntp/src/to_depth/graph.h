/* SPDX-License-Identifier: MIT */
/*
 * graph.h - solves the equations of a graph of springs, by conjugate gradients and multigrid
 *
 * Nodes hang together by springs of any stiffness, also of almost none.  The equations say how far
 * each node moves under forces: sum of stiffness (x[i] - x[j]) = force[i].  Multigrid is the
 * preconditioner.  A coarser level joins nodes in groups of up to four, along their stiffest
 * springs (pairs of pairs).  So groups do not reach across a cliff, where springs are weak, however
 * ragged it is.  One thread does all, so that its sums always have one order.
 */
#ifndef NTP_TO_DEPTH_GRAPH_H
#define NTP_TO_DEPTH_GRAPH_H

#include "base/scratch.h"

#include <stdbool.h>
#include <stdint.h>

enum { NTP__GRAPH_LEVELS = 40, NTP__GRID_SPRINGS = 4 /* at most, of a node of a grid */ };

typedef struct ntp__spring {
    int32_t to;
    float stiffness;
} ntp__spring;

/* The springs of node i are those from first[i] to first[i + 1] - 1, first those to nodes before it.
 * Each stands at both ends. */
typedef struct ntp__graph {
    int32_t nodes;
    int32_t *first;
    ntp__spring *spring;
    float *inverse; /* 1 / the sum of the stiffness at the node; 0 where it has no spring */
    int32_t *group; /* of each node: its node on the next level */
} ntp__graph;

typedef struct ntp__springs {
    int32_t levels;
    ntp__graph level[NTP__GRAPH_LEVELS]; /* the caller fills in `first` and `spring` of level 0 */
    float *force[NTP__GRAPH_LEVELS], *move[NTP__GRAPH_LEVELS]; /* of the cycle */
    float *first[NTP__GRAPH_LEVELS], *held[NTP__GRAPH_LEVELS]; /* of a step on coarser levels */
    double *residual, *direction, *image;
    void *pool, *aside; /* for the levels, and to make them; then for first and held */
    size_t pool_size;
} ntp__springs;

/* Takes memory for `nodes` nodes of a grid. */
void ntp__springs_init(ntp__springs *s, int32_t nodes, ntp__scratch *memory);

/* Makes the coarser levels for the springs of level 0. */
void ntp__springs_coarsen(ntp__springs *s);

/* Keeps the coarser levels although the springs of level 0 have changed a little. */
void ntp__springs_keep_levels(ntp__springs *s);

/* Improves x until the norm of the residual is below `share` of what it was at the start, or for so
 * many iterations.  Returns their number. */
int32_t ntp__springs_solve(ntp__springs *s, double *x, const double *force, double share,
                           int32_t most);

#endif
