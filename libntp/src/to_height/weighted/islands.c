/* SPDX-License-Identifier: MIT */
/*
 * islands.c - the connected areas of a masked heightfield, and their means
 *
 * Normals do not tell how high one island is above another, so each gets mean 0.  Texels are joined
 * to their neighbors to the right and below, also across a border that wraps.  The first texel of
 * an island names it.
 */
#include "to_height/weighted/weighted.h"

#include <string.h>

typedef struct islands {
    ntp__weighted *w;
    uint32_t *root;      /* an earlier texel of the same island, or the texel itself */
    double *count, *sum; /* by root */
} islands;

static uint32_t find(uint32_t *root, uint32_t i)
{
    while (root[i] != i) {
        root[i] = root[root[i]];
        i = root[i];
    }
    return i;
}

static void join(uint32_t *root, uint32_t a, uint32_t b)
{
    a = find(root, a);
    b = find(root, b);
    if (a < b)
        root[b] = a;
    else
        root[a] = b;
}

static void label(islands *s)
{
    const ntp__weighted *w = s->w;
    uint32_t width = (uint32_t) w->width, height = (uint32_t) w->height;
    bool wrap_x = w->plan->wrap_x, wrap_y = w->plan->wrap_y;
    for (uint32_t i = 0; i < width * height; i++)
        s->root[i] = i;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            uint32_t i = y * width + x;
            uint32_t right = x + 1 < width ? i + 1 : y * width,
                     down = y + 1 < height ? i + width : x;
            if (ntp__in_hole(w->right[i]))
                continue;
            if ((x + 1 < width || wrap_x) && !ntp__in_hole(w->right[right]))
                join(s->root, i, right);
            if ((y + 1 < height || wrap_y) && !ntp__in_hole(w->right[down]))
                join(s->root, i, down);
        }
    }
    for (uint32_t i = 0; i < width * height; i++)
        s->root[i] = find(s->root, i);
}

/* The values that are averaged over islands: x (the column), y (the row), or the height. */
typedef enum quantity { COLUMN, ROW, HEIGHT } quantity;

static double value(const islands *s, quantity what, int32_t x, int32_t y)
{
    return what == COLUMN ? x : what == ROW ? y : s->w->x[ntp__weighted_at(s->w, y) + (size_t) x];
}

/* sum[root] = the mean over the island. */
static void find_means(islands *s, quantity what)
{
    const ntp__weighted *w = s->w;
    size_t texels = (size_t) w->width * (size_t) w->height, i = 0;
    memset(s->sum, 0, texels * sizeof *s->sum);
    for (int32_t y = 0; y < w->height; y++) {
        for (int32_t x = 0; x < w->width; x++, i++) {
            if (!ntp__in_hole(w->right[i]))
                s->sum[s->root[i]] += value(s, what, x, y);
        }
    }
    for (i = 0; i < texels; i++)
        s->sum[i] = s->count[i] > 0 ? s->sum[i] / s->count[i] : 0;
}

/* The sum of a (b - its mean over the island).  The means are in sum. */
static double moment(const islands *s, quantity a, quantity b)
{
    const ntp__weighted *w = s->w;
    double all = 0;
    size_t i = 0;
    for (int32_t y = 0; y < w->height; y++) {
        double row = 0;
        for (int32_t x = 0; x < w->width; x++, i++) {
            if (!ntp__in_hole(w->right[i]))
                row += value(s, a, x, y) * (value(s, b, x, y) - s->sum[s->root[i]]);
        }
        all += row;
    }
    return all;
}

/* The plane that fits all islands best, where each island has a constant of its own. */
static void find_trend(islands *s, double trend[2])
{
    bool free_x = !s->w->plan->wrap_x;
    bool free_y = !s->w->plan->wrap_y;
    find_means(s, COLUMN);
    double xx = moment(s, COLUMN, COLUMN), xy = moment(s, ROW, COLUMN);
    double xh = moment(s, HEIGHT, COLUMN);
    find_means(s, ROW);
    double yy = moment(s, ROW, ROW), yh = moment(s, HEIGHT, ROW);
    double det = xx * yy - xy * xy;
    trend[0] = trend[1] = 0;
    if (free_x && free_y && det > 0) {
        trend[0] = (xh * yy - yh * xy) / det;
        trend[1] = (yh * xx - xh * xy) / det;
    } else if (free_x && xx > 0) {
        trend[0] = xh / xx;
    } else if (free_y && yy > 0) {
        trend[1] = yh / yy;
    }
}

uint64_t ntp__islands_level(ntp__weighted *w, double trend[2])
{
    size_t texels = (size_t) w->width * (size_t) w->height, i = 0;
    ntp__scratch memory = { (char *) w->r, 0 };
    islands s = { w, ntp__take(&memory, texels * sizeof *s.root), w->d, w->a };
    uint64_t count = 0;
    label(&s);
    memset(s.count, 0, texels * sizeof *s.count);
    for (i = 0; i < texels; i++) {
        s.count[s.root[i]] += !ntp__in_hole(w->right[i]);
        count += !ntp__in_hole(w->right[i]) && s.root[i] == i;
    }
    if (trend != NULL) {
        find_trend(&s, trend);
        i = 0;
        for (int32_t y = 0; y < w->height; y++) {
            for (int32_t x = 0; x < w->width; x++, i++)
                w->x[i] -= trend[0] * x + trend[1] * y;
        }
    }
    find_means(&s, HEIGHT);
    for (i = 0; i < texels; i++)
        w->x[i] = !ntp__in_hole(w->right[i]) ? w->x[i] - s.sum[s.root[i]] : 0;
    return count;
}
