/* SPDX-License-Identifier: MIT */
/*
 * graph.c - flexible conjugate gradients, and the cycle over ever coarser graphs before each step
 *
 * A cycle runs in floats: it only has to point the right way.  Sums that decide are in double.
 */
#include "to_depth/graph.h"

#include <math.h>
#include <string.h>

enum {
    SMALLEST = 24,    /* nodes of a level that gets no coarser one */
    LAST_SWEEPS = 12, /* of Gauss and Seidel, up and down, on the coarsest level */
    POOL = 72,        /* bytes a node: 44 on a full grid, more where springs are cut */
    ASIDE = 48,       /* bytes a node: 42 if no spring vanishes within a pair */
    SLACK = 4096      /* for alignment, and for graphs of a few nodes */
};
static const double ONE_STEP = 1.0 / 16; /* less left than this, in squares: no second step */
static const float STRONG = 0.25F;       /* of the stiffest spring: along those nodes are joined */

/* ------------------------------------------------------------------------- the levels */

void ntp__springs_init(ntp__springs *s, int32_t nodes, ntp__scratch *memory)
{
    size_t n = (size_t) nodes;
    ntp__graph *g = &s->level[0];
    g->nodes = nodes;
    g->first = ntp__take(memory, (n + 1) * sizeof *g->first);
    g->spring = ntp__take(memory, NTP__GRID_SPRINGS * n * sizeof *g->spring);
    s->residual = ntp__take(memory, n * sizeof *s->residual);
    s->direction = ntp__take(memory, n * sizeof *s->direction);
    s->image = ntp__take(memory, n * sizeof *s->image);
    s->pool_size = n * POOL + SLACK;
    s->pool = ntp__take(memory, s->pool_size);
    s->aside = ntp__take(memory, n * ASIDE + SLACK);
}

static void find_inverse(ntp__graph *g)
{
    for (int32_t i = 0; i < g->nodes; i++) {
        float sum = 0;
        for (int32_t e = g->first[i]; e < g->first[i + 1]; e++)
            sum += g->spring[e].stiffness;
        g->inverse[i] = sum > 0 ? 1 / sum : 0;
    }
}

/* Joins each node with the free neighbor to which its spring is stiffest.  Returns how many groups
 * there are. */
static int32_t pair_up(const ntp__graph *g, int32_t *group)
{
    int32_t groups = 0;
    for (int32_t i = 0; i < g->nodes; i++)
        group[i] = -1;
    for (int32_t i = 0; i < g->nodes; i++) {
        if (group[i] >= 0)
            continue;
        float best = 0, stiffest = 0;
        int32_t mate = i;
        for (int32_t e = g->first[i]; e < g->first[i + 1]; e++) {
            float stiffness = g->spring[e].stiffness;
            stiffest = stiffness > stiffest ? stiffness : stiffest;
            if (stiffness > best && group[g->spring[e].to] < 0) {
                best = stiffness;
                mate = g->spring[e].to;
            }
        }
        if (best < STRONG * stiffest)
            mate = i;
        group[i] = group[mate] = groups++;
    }
    return groups;
}

/* Adds the springs of node i of the fine graph to the group k, whose own begin at `start`.
 * place[to]: where the spring to that group is, if it is not below `start`. */
static int32_t add_springs(ntp__graph *coarse, const ntp__graph *fine, const int32_t *group,
                           int32_t i, int32_t start, int32_t count, int32_t *place)
{
    for (int32_t e = fine->first[i]; e < fine->first[i + 1]; e++) {
        int32_t to = group[fine->spring[e].to];
        if (to == group[i])
            continue;
        if (place[to] < start) {
            place[to] = count;
            coarse->spring[count++] = (ntp__spring) { to, 0 };
        }
        coarse->spring[place[to]].stiffness += fine->spring[e].stiffness;
    }
    return count;
}

/* Puts the springs to nodes before k first. */
static void sort_springs(ntp__spring *spring, int32_t count, int32_t k)
{
    int32_t before = 0;
    for (int32_t e = 0; e < count; e++) {
        if (spring[e].to < k) {
            ntp__spring moved = spring[e];
            spring[e] = spring[before];
            spring[before++] = moved;
        }
    }
}

/* coarse = the groups of fine, of one or two nodes each, with the sums of the springs between
 * them.  members and place are working memory: 2 and 1 numbers a group. */
static void contract(ntp__graph *coarse, const ntp__graph *fine, const int32_t *group,
                     int32_t groups, int32_t *members, int32_t *place)
{
    coarse->nodes = groups;
    for (int32_t k = 0; k < groups; k++)
        members[2 * k] = members[2 * k + 1] = place[k] = -1;
    for (int32_t i = 0; i < fine->nodes; i++)
        members[2 * group[i] + (members[2 * group[i]] >= 0)] = i;
    int32_t count = 0;
    for (int32_t k = 0; k < groups; k++) {
        int32_t start = count;
        coarse->first[k] = start;
        for (int32_t m = 2 * k; m < 2 * k + 2 && members[m] >= 0; m++)
            count = add_springs(coarse, fine, group, members[m], start, count, place);
        sort_springs(coarse->spring + start, count - start, k);
    }
    coarse->first[groups] = count;
}

static void take_graph(ntp__graph *g, int32_t nodes, int32_t springs, ntp__scratch *memory)
{
    g->first = ntp__take(memory, ((size_t) nodes + 1) * sizeof *g->first);
    g->spring = ntp__take(memory, (size_t) springs * sizeof *g->spring);
}

/* What a level needs beside its springs: 16 bytes a node. */
static void take_work(ntp__springs *s, int32_t l, ntp__scratch *memory)
{
    ntp__graph *g = &s->level[l];
    size_t n = (size_t) g->nodes;
    g->inverse = ntp__take(memory, n * sizeof *g->inverse);
    g->group = ntp__take(memory, n * sizeof *g->group);
    s->force[l] = ntp__take(memory, n * sizeof *s->force[l]);
    s->move[l] = ntp__take(memory, n * sizeof *s->move[l]);
    find_inverse(g);
}

static bool has_room(const ntp__springs *s, const ntp__scratch *memory, int32_t nodes,
                     int32_t springs)
{
    size_t bytes = 20 * (size_t) nodes + (size_t) springs * sizeof(ntp__spring);
    return memory->used + bytes + (size_t) 8 * NTP__ALIGNMENT <= s->pool_size;
}

/* Makes the level after l, of pairs of pairs of its nodes.  False: there is none. */
static bool add_level(ntp__springs *s, int32_t l, ntp__scratch *memory)
{
    ntp__graph *fine = &s->level[l], *coarse = &s->level[l + 1], half;
    int32_t n = fine->nodes, pairs = pair_up(fine, fine->group);
    ntp__scratch aside = { s->aside, 0 };
    take_graph(&half, pairs, fine->first[n], &aside);
    int32_t *members = ntp__take(&aside, 2 * (size_t) pairs * sizeof *members);
    int32_t *place = ntp__take(&aside, (size_t) pairs * sizeof *place);
    int32_t *again = ntp__take(&aside, (size_t) pairs * sizeof *again);
    if (aside.used > (size_t) s->level[0].nodes * ASIDE + SLACK)
        return false;
    contract(&half, fine, fine->group, pairs, members, place);
    int32_t quads = pair_up(&half, again);
    if (quads > n - n / 4 || !has_room(s, memory, quads, half.first[pairs]))
        return false;
    take_graph(coarse, quads, half.first[pairs], memory);
    contract(coarse, &half, again, quads, members, place);
    for (int32_t i = 0; i < n; i++)
        fine->group[i] = again[fine->group[i]];
    take_work(s, l + 1, memory);
    return true;
}

void ntp__springs_coarsen(ntp__springs *s)
{
    ntp__scratch memory = { s->pool, 0 };
    s->levels = 1;
    take_work(s, 0, &memory);
    while (s->levels < NTP__GRAPH_LEVELS && s->level[s->levels - 1].nodes > SMALLEST &&
           add_level(s, s->levels - 1, &memory))
        s->levels++;
    /* Free again, and enough: 8 bytes for each coarser node, of which there are at most 3 n. */
    ntp__scratch aside = { s->aside, 0 };
    for (int32_t l = 1; l < s->levels; l++) {
        size_t n = (size_t) s->level[l].nodes;
        s->first[l] = ntp__take(&aside, n * sizeof *s->first[l]);
        s->held[l] = ntp__take(&aside, n * sizeof *s->held[l]);
    }
}

void ntp__springs_keep_levels(ntp__springs *s)
{
    find_inverse(&s->level[0]);
}

/* -------------------------------------------------------------------------- the cycle */

/* A sweep of Gauss and Seidel up the nodes, all of which are at 0. */
static void sweep_up_from_0(const ntp__graph *g, float *restrict x, const float *restrict force)
{
    for (int32_t i = 0; i < g->nodes; i++) {
        float sum = force[i];
        for (int32_t e = g->first[i]; e < g->first[i + 1] && g->spring[e].to < i; e++)
            sum += g->spring[e].stiffness * x[g->spring[e].to];
        x[i] = sum * g->inverse[i];
    }
}

/* What that sweep leaves of the force on node i: each node after it has moved since. */
static float left_over(const ntp__graph *g, const float *x, int32_t i)
{
    float sum = 0;
    for (int32_t e = g->first[i + 1] - 1; e >= g->first[i] && g->spring[e].to > i; e--)
        sum += g->spring[e].stiffness * x[g->spring[e].to];
    return sum;
}

/* The same sweep up or down, wherever nodes are. */
static void sweep(const ntp__graph *g, float *restrict x, const float *restrict force, bool up)
{
    for (int32_t k = 0; k < g->nodes; k++) {
        int32_t i = up ? k : g->nodes - 1 - k;
        float sum = force[i];
        for (int32_t e = g->first[i]; e < g->first[i + 1]; e++)
            sum += g->spring[e].stiffness * x[g->spring[e].to];
        x[i] = sum * g->inverse[i];
    }
}

/* The force that holds node i, the nodes being at x. */
static float hold(const ntp__graph *g, const float *x, int32_t i)
{
    float sum = 0;
    for (int32_t e = g->first[i]; e < g->first[i + 1]; e++)
        sum += g->spring[e].stiffness * (x[i] - x[g->spring[e].to]);
    return sum;
}

static void cycle(ntp__springs *s, int32_t l);

static double product(const float *a, const float *b, int32_t n)
{
    double sum = 0;
    for (int32_t i = 0; i < n; i++)
        sum += (double) a[i] * (double) b[i];
    return sum;
}

/* A coarser level, by one or two conjugate steps, each after a cycle (the K-cycle of Notay and
 * Vassilevski, 2008).  Groups move as a whole, which makes the springs between them too stiff; the
 * steps make up for that.  With one step alone iterations grow with every level. */
static void solve_coarse(ntp__springs *s, int32_t l)
{
    const ntp__graph *g = &s->level[l];
    int32_t n = g->nodes;
    float *x = s->move[l], *force = s->force[l], *first = s->first[l], *held = s->held[l];
    cycle(s, l);
    for (int32_t i = 0; i < n; i++)
        held[i] = hold(g, x, i);
    double against = product(x, held, n), before = product(force, force, n);
    double step = against > 0 ? product(x, force, n) / against : 1;
    for (int32_t i = 0; i < n; i++) {
        first[i] = x[i];
        force[i] -= (float) step * held[i];
    }
    double along = 0, back = step;
    if (against > 0 && product(force, force, n) > ONE_STEP * before) {
        cycle(s, l);
        double across = product(x, held, n);
        for (int32_t i = 0; i < n; i++)
            held[i] = hold(g, x, i);
        double second = product(x, held, n), rest = second - across * across / against;
        along = rest > 0x1p-16 * second ? product(x, force, n) / rest : 0;
        back -= along * across / against;
    }
    for (int32_t i = 0; i < n; i++)
        x[i] = (float) back * first[i] + (float) along * x[i];
}

/* move[l] = about how far force[l] moves the nodes. */
static void cycle(ntp__springs *s, int32_t l)
{
    const ntp__graph *g = &s->level[l];
    float *x = s->move[l];
    const float *force = s->force[l];
    if (l + 1 == s->levels) {
        memset(x, 0, (size_t) g->nodes * sizeof *x);
        for (int32_t k = 0; k < LAST_SWEEPS; k++) {
            sweep(g, x, force, true);
            sweep(g, x, force, false);
        }
        return;
    }
    float *left = s->force[l + 1];
    sweep_up_from_0(g, x, force);
    memset(left, 0, (size_t) s->level[l + 1].nodes * sizeof *left);
    for (int32_t i = 0; i < g->nodes; i++)
        left[g->group[i]] += left_over(g, x, i);
    solve_coarse(s, l + 1);
    for (int32_t i = 0; i < g->nodes; i++)
        x[i] += s->move[l + 1][g->group[i]];
    sweep(g, x, force, false);
}

/* ----------------------------------------------------------------- conjugate gradients */

/* As `hold`, in double. */
static double hold_exactly(const ntp__graph *g, const double *x, int32_t i)
{
    double sum = 0;
    for (int32_t e = g->first[i]; e < g->first[i + 1]; e++)
        sum += (double) g->spring[e].stiffness * (x[i] - x[g->spring[e].to]);
    return sum;
}

/* move[0] = the cycle of the residual, whose square is `square`; floats hold it at any scale. */
static void precondition(ntp__springs *s, double square)
{
    double scale = 1 / sqrt(square);
    for (int32_t i = 0; i < s->level[0].nodes; i++)
        s->force[0][i] = (float) (s->residual[i] * scale);
    cycle(s, 0);
}

/* The next direction: move[0] made conjugate to the last one, for which `against` was found.
 * Returns the same of the new one, and the step along it. */
static double turn(ntp__springs *s, double against, double *step)
{
    const ntp__graph *g = &s->level[0];
    const float *move = s->move[0];
    double across = 0, along = 0, now = 0;
    if (against > 0) {
        for (int32_t i = 0; i < g->nodes; i++)
            across += s->image[i] * (double) move[i];
        across /= against;
        for (int32_t i = 0; i < g->nodes; i++)
            s->direction[i] = (double) move[i] - across * s->direction[i];
    } else {
        for (int32_t i = 0; i < g->nodes; i++)
            s->direction[i] = (double) move[i];
    }
    for (int32_t i = 0; i < g->nodes; i++) {
        s->image[i] = hold_exactly(g, s->direction, i);
        now += s->direction[i] * s->image[i];
        along += s->direction[i] * s->residual[i];
    }
    *step = now > 0 ? along / now : 0;
    return now;
}

int32_t ntp__springs_solve(ntp__springs *s, double *x, const double *force, double share,
                           int32_t most)
{
    const ntp__graph *g = &s->level[0];
    int32_t done = 0;
    double square = 0, against = 0, step = 0;
    for (int32_t i = 0; i < g->nodes; i++) {
        s->residual[i] = force[i] - hold_exactly(g, x, i);
        square += s->residual[i] * s->residual[i];
    }
    double enough = share * share * square;
    while (done < most && square > enough) {
        precondition(s, square);
        against = turn(s, against, &step);
        if (!(against > 0))
            break;
        square = 0;
        for (int32_t i = 0; i < g->nodes; i++) {
            x[i] += step * s->direction[i];
            s->residual[i] -= step * s->image[i];
            square += s->residual[i] * s->residual[i];
        }
        done++;
    }
    return done;
}
