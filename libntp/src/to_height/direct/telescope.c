/* SPDX-License-Identifier: MIT */
/*
 * telescope.c - Eberly's reconstruction: sums of slopes from texels whose height is given
 *
 * David Eberly, "Reconstructing a Height Field from a Normal Map", sections 3.1 (one-sided) and
 * 3.2 (centered).  The sums are doubles.  A first walk finds the mean and a second one writes, so
 * each height is rounded once.  There are more equations than heights.  Those that the sums do not
 * use are compared with the heights (his conditions of consistency).
 */
#include "to_height/direct/direct.h"

#include <math.h>
#include <string.h>

typedef struct telescope {
    const ntp__slopes *slopes;
    const ntp_image *dst;
    int32_t width;
    bool central, wrap_x, wrap_y;
    double dx, dy;
    double seeds[4];
    double *right, *down, *down_above; /* slopes of a row; slopes down of the row before */
    double *above[2];                  /* heights of the rows before */
    double *top[2];                    /* heights of the first rows */
    double squares, most;              /* of the errors in the equations that are not used */
    uint64_t equations;
    double sum[4];   /* of the heights by parity of column and row */
    double shift[4]; /* added to them */
    uint64_t count[4];
    bool write;
} telescope;

/* Fills one of the first rows from its seeds, along the slopes to the right. */
static void along_row(const telescope *t, double *h, double first, double second)
{
    h[0] = first;
    if (!t->central) {
        for (int32_t x = 1; x < t->width; x++)
            h[x] = h[x - 1] + t->dx * t->right[x - 1];
        return;
    }
    if (t->width > 1)
        h[1] = second;
    for (int32_t x = 2; x < t->width; x++)
        h[x] = h[x - 2] + 2 * t->dx * t->right[x - 1];
}

static void put_row(telescope *t, const double *h, int32_t y)
{
    float *row = ntp__at_mut(t->dst, 0, y);
    for (int32_t x = 0; x < t->width; x++) {
        int32_t parity = (x & 1) + 2 * (y & 1);
        if (t->write) {
            row[x] = (float) (h[x] + t->shift[parity]);
        } else {
            t->sum[parity] += h[x];
            t->count[parity]++;
        }
    }
}

/* ---------------------------------------------------------------------- consistency */

/* Compares one equation: a slope tells the difference of two heights. */
static void compare(telescope *t, double difference, double spacing, double slope)
{
    double off = difference / spacing - slope;
    off = off < 0 ? -off : off;
    t->squares += off * off;
    t->most = off > t->most ? off : t->most;
    t->equations++;
}

/* Compares the slopes to the right of row y, except those that its heights are made of. */
static void compare_row(telescope *t, const double *h, int32_t y)
{
    int32_t n = t->width, reach = t->central ? 1 : 0, rows = t->central ? 2 : 1;
    double spacing = (1 + reach) * t->dx;
    for (int32_t x = reach; y >= rows && x < n - 1; x++)
        compare(t, h[x + 1] - h[x - reach], spacing, t->right[x]);
    if (!t->wrap_x || n < 2)
        return;
    compare(t, h[0] - h[n - 1 - reach], spacing, t->right[n - 1]);
    if (t->central)
        compare(t, h[1] - h[n - 1], spacing, t->right[0]);
}

/* Compares the slopes down across the lower edge; those of the last row are in down_above. */
static void compare_edge(telescope *t)
{
    int32_t height = t->dst->height;
    const double *last = t->above[t->central ? (height - 1) & 1 : 0];
    const double *before = t->above[height & 1];
    if (!t->wrap_y || height < 2)
        return;
    for (int32_t x = 0; x < t->width; x++) {
        if (t->central)
            compare(t, t->top[0][x] - before[x], 2 * t->dy, t->down_above[x]);
        else
            compare(t, t->top[0][x] - last[x], t->dy, t->down_above[x]);
    }
    if (!t->central)
        return;
    ntp__slopes_row(t->slopes, t->right, t->down, 0, NULL);
    for (int32_t x = 0; x < t->width; x++)
        compare(t, t->top[1][x] - last[x], 2 * t->dy, t->down[x]);
}

/* ------------------------------------------------------------------------------- sums */

static void walk(telescope *t, ntp__slope_counts *counts)
{
    for (int32_t y = 0; y < t->dst->height; y++) {
        double *h = t->central ? t->above[y & 1] : t->above[0];
        ntp__slopes_row(t->slopes, t->right, t->down, y, counts);
        if (y == 0) {
            along_row(t, h, t->seeds[0], t->seeds[1]);
        } else if (t->central && y == 1) {
            along_row(t, h, t->seeds[2], t->seeds[3]);
        } else {
            /* h holds the row before; for central slopes, the one before that. */
            double step = t->central ? 2 * t->dy : t->dy;
            for (int32_t x = 0; x < t->width; x++)
                h[x] += step * t->down_above[x];
        }
        if (y < 2)
            memcpy(t->top[y], h, (size_t) t->width * sizeof *h);
        if (t->write)
            compare_row(t, h, y);
        put_row(t, h, y);
        double *swap = t->down;
        t->down = t->down_above;
        t->down_above = swap;
    }
}

/* Seeds that are means over the ways to them from the first texel. */
static void default_seeds(telescope *t)
{
    int32_t w = t->width, h = t->dst->height;
    double p10, q01;
    ntp__slopes_row(t->slopes, t->right, t->down, 0, NULL);
    p10 = w > 1 ? t->dx * t->right[1] : 0;
    if (w > 1)
        t->seeds[1] = p10;
    if (h < 2)
        return;
    ntp__slopes_row(t->slopes, t->right, t->down, 1, NULL);
    q01 = t->dy * t->down[0];
    t->seeds[2] = q01;
    if (w > 1)
        t->seeds[3] = (q01 + t->dx * t->right[1] + p10 + t->dy * t->down[1]) / 2;
}

static void set_shifts(telescope *t, bool equalize)
{
    double sum = 0, count = 0;
    for (int32_t i = 0; i < 4; i++) {
        sum += t->sum[i];
        count += (double) t->count[i];
    }
    for (int32_t i = 0; i < 4; i++) {
        bool own = equalize && t->count[i] > 0;
        t->shift[i] = own ? -t->sum[i] / (double) t->count[i] : -sum / count;
    }
}

static void lay_out(telescope *t, ntp__scratch *memory, const ntp__height_plan *plan)
{
    double **rows[] = { &t->right,    &t->down,   &t->down_above, &t->above[0],
                        &t->above[1], &t->top[0], &t->top[1] };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        *rows[i] = ntp__take(memory, (size_t) plan->width * sizeof(double));
}

size_t ntp__telescope_scratch(const ntp__height_plan *plan)
{
    telescope t;
    ntp__scratch memory = { NULL, 0 };
    lay_out(&t, &memory, plan);
    return memory.used;
}

void ntp__telescope(const ntp_image *dst, const ntp__slopes *slopes, const ntp__height_plan *plan,
                    void *scratch, ntp__slope_counts *counts)
{
    telescope t;
    ntp__scratch memory = { scratch, 0 };
    memset(&t, 0, sizeof t);
    lay_out(&t, &memory, plan);
    t.slopes = slopes;
    t.dst = dst;
    t.width = plan->width;
    t.central = plan->kernel == NTP_KERNEL_CENTRAL;
    t.dx = plan->dx;
    t.dy = plan->dy;
    t.wrap_x = plan->wrap_x;
    t.wrap_y = plan->wrap_y;
    bool equalize = plan->equalize && t.central;
    if (plan->use_seeds)
        memcpy(t.seeds, plan->seeds, sizeof t.seeds);
    else if (t.central)
        default_seeds(&t);
    if (!plan->use_seeds || equalize) {
        walk(&t, NULL);
        set_shifts(&t, equalize);
    }
    t.write = true;
    walk(&t, counts);
    compare_edge(&t);
    counts->consistency = t.equations > 0 ? sqrt(t.squares / (double) t.equations) : 0;
    counts->consistency_max = t.most;
}
