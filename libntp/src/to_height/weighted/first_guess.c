/* SPDX-License-Identifier: MIT */
/*
 * first_guess.c - where the iteration begins in mazes
 *
 * The preconditioner knows no walls.  In corridors one or two texels wide, the way from one place
 * to another may be thousands of texels long, and the iteration finds heights along it slowly.  But
 * in a corridor the sums of slopes from texel to texel are nearly a solution.  So if most texels
 * have at most two neighbors, the iteration begins with such sums, on each island from its first
 * texel on.  Where corridors make no loops, almost nothing is left to iterate.
 */
#include "to_height/weighted/weighted.h"

#include <string.h>

enum { FEW_NEIGHBORS = 2, SIDES = 4 };

/* The arrays lie in memory that the iteration does not use yet. */
typedef struct walk {
    ntp__weighted *w;
    double *p, *q;   /* slopes of all texels */
    uint32_t *queue; /* texels that have a height; their neighbors come next */
    uint8_t *seen;
    uint32_t end;
    bool wrap[2];
} walk;

/* The neighbor of texel (x, y) to the right, below, to the left or above; false: there is none, or
 * it is a hole. */
static bool neighbor(const walk *k, int32_t side, int32_t x, int32_t y, size_t *at)
{
    const ntp__weighted *w = k->w;
    int32_t sign = side < 2 ? 1 : -1;
    int32_t to_x = x + (side % 2 == 0 ? sign : 0), to_y = y + (side % 2 == 1 ? sign : 0);
    if (to_x < 0 || to_x >= w->width) {
        if (!k->wrap[0])
            return false;
        to_x -= sign * w->width;
    }
    if (to_y < 0 || to_y >= w->height) {
        if (!k->wrap[1])
            return false;
        to_y -= sign * w->height;
    }
    *at = ntp__weighted_at(w, to_y) + (size_t) to_x;
    return !ntp__in_hole(w->right[*at]);
}

/* Do most texels have few neighbors? */
static bool is_narrow(const walk *k)
{
    uint64_t texels = 0, narrow = 0;
    for (int32_t y = 0; y < k->w->height; y++) {
        for (int32_t x = 0; x < k->w->width; x++) {
            int32_t count = 0;
            size_t at;
            if (ntp__in_hole(k->w->right[ntp__weighted_at(k->w, y) + (size_t) x]))
                continue;
            for (int32_t side = 0; side < SIDES; side++)
                count += neighbor(k, side, x, y, &at);
            texels++;
            narrow += count <= FEW_NEIGHBORS;
        }
    }
    return 2 * narrow > texels;
}

/* The height of a neighbor less that of the texel, by their slopes. */
static double difference(const walk *k, int32_t side, size_t from, size_t to)
{
    const double *slope = side % 2 == 0 ? k->p : k->q;
    size_t first = side < 2 ? from : to;
    double mean = (slope[from] + slope[to]) / 2;
    double up = k->w->plan->kernel == NTP_KERNEL_FORWARD ? slope[first] : mean;
    return side < 2 ? up : -up;
}

/* The height of a neighbor.  A central slope belongs to the texels before and after its own, so the
 * texel before is used if it has a height. */
static double height_beyond(const walk *k, int32_t side, int32_t x, int32_t y, size_t from,
                            size_t to)
{
    const ntp__weighted *w = k->w;
    double slope = side % 2 == 0 ? k->p[from] : k->q[from];
    bool counts = ntp__counts(side % 2 == 0 ? w->right[from] : w->down[from]);
    size_t before;
    if (w->plan->kernel == NTP_KERNEL_CENTRAL && counts &&
        neighbor(k, (side + 2) % SIDES, x, y, &before) && k->seen[before])
        return w->x[before] + (side < 2 ? 2 * slope : -2 * slope);
    return w->x[from] + difference(k, side, from, to);
}

static void add(walk *k, size_t at, double height)
{
    k->w->x[at] = height;
    k->seen[at] = 1;
    k->queue[k->end++] = (uint32_t) at;
}

/* Sets all heights of the island of a texel. */
static void walk_from(walk *k, size_t first)
{
    uint32_t begin = k->end, width = (uint32_t) k->w->width;
    add(k, first, 0);
    for (; begin < k->end; begin++) {
        size_t from = k->queue[begin], to;
        int32_t x = (int32_t) (from % width), y = (int32_t) (from / width);
        for (int32_t side = 0; side < SIDES; side++) {
            if (neighbor(k, side, x, y, &to) && !k->seen[to])
                add(k, to, height_beyond(k, side, x, y, from, to));
        }
    }
}

static void lay_out(walk *k, ntp__scratch *memory, size_t texels)
{
    k->queue = ntp__take(memory, texels * sizeof *k->queue);
    k->seen = ntp__take(memory, texels * sizeof *k->seen);
}

size_t ntp__walk_bytes(const ntp__height_plan *plan)
{
    walk k;
    ntp__scratch memory = { NULL, 0 };
    lay_out(&k, &memory, (size_t) plan->width * (size_t) plan->height);
    return memory.used;
}

bool ntp__weighted_start(ntp__weighted *w)
{
    size_t texels = (size_t) w->width * (size_t) w->height;
    walk k = { .w = w, .p = w->r, .q = w->d, .wrap = { w->plan->wrap_x, w->plan->wrap_y } };
    ntp__scratch memory = { (char *) w->a, 0 };
    lay_out(&k, &memory, texels);
    if (!w->holes || !is_narrow(&k))
        return false;
    for (int32_t y = 0; y < w->height; y++)
        ntp__weighted_stored(w, w->r + ntp__weighted_at(w, y), w->d + ntp__weighted_at(w, y), y);
    memset(k.seen, 0, texels);
    for (size_t i = 0; i < texels; i++) {
        if (!ntp__in_hole(w->right[i]) && !k.seen[i])
            walk_from(&k, i);
    }
    memset(w->a, 0, texels * sizeof *w->a);
    return true;
}
