/* SPDX-License-Identifier: MIT */
/*
 * weights.c - the weights of weighted least squares, and its holes
 *
 * An error of one level in x or y makes an error of the slope that grows with the slope.  Let
 * n = (x, y, z) have errors of the same variance in each.  Then x/z has (z^2 + x^2)/z^4 times that
 * variance if z is stored, and ((z^2 + x^2)^2 + (x y)^2)/z^6 times if z is derived from x and y.
 */
#include "to_height/weighted/weighted.h"

#include "to_height/shared/holes.h"

/* Lower weights would make the steepest texels almost holes, and the iteration slow. */
static const double least_weight = 0.01;

/* The weight of slope p; q is the other slope of the texel.  A flat texel has weight 1. */
static double weight_of(const ntp__weighted *w, double p, double q)
{
    double p2 = p * p, q2 = q * q, z2 = 1 / (1 + p2 + q2);
    double weight = w->slopes->derived ? z2 / ((1 + p2) * (1 + p2) + p2 * q2) : z2 / (1 + p2);
    return weight > least_weight ? weight : least_weight;
}

/* Sets hole to 1 in the holes of a row and to 0 elsewhere, and counts them. */
static void mark_holes(const ntp__weighted *w, ntp__weighted_part *part, double *hole, int32_t y)
{
    for (int32_t x = 0; x < w->width; x += NTP__BLOCK) {
        ntp__block block;
        bool found[NTP__BLOCK];
        int32_t n = w->width - x < NTP__BLOCK ? w->width - x : NTP__BLOCK;
        ntp__unpack(&block, w->slopes->src, x, y, n);
        ntp__find_holes(found, w->slopes, w->mask, &block, x, y, n);
        for (int32_t i = 0; i < n; i++) {
            hole[x + i] = found[i];
            part->holes += found[i];
            part->not_finite += block.any_broken && block.broken[i];
        }
    }
}

/* Sets the weights of a row, and where its holes are. */
static void set_row(ntp__weighted *w, ntp__weighted_part *part, int32_t y)
{
    double *p = part->spare[0], *q = part->spare[1], energy = 0;
    float *right = w->right + ntp__weighted_at(w, y), *down = w->down + ntp__weighted_at(w, y);
    double *hole = w->d + ntp__weighted_at(w, y);
    ntp__slopes_row(w->slopes, p, q, y, NULL);
    mark_holes(w, part, hole, y);
    for (int32_t x = 0; x < w->width; x++) {
        double a = weight_of(w, p[x], q[x]) * w->inverse.share_x;
        double b = weight_of(w, q[x], p[x]) * w->inverse.share_y;
        right[x] = hole[x] != 0 ? 0 : (float) a;
        down[x] = hole[x] != 0 ? 0 : (float) b;
        p[x] *= w->dx;
        q[x] *= w->dy;
        energy += (double) right[x] * p[x] * p[x] + (double) down[x] * q[x] * q[x];
    }
    w->sum[y] = energy;
}

static void set_band(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++)
        set_row(w, &w->parts[part], y);
}

/* Marks the slopes whose stencil reads a hole.  w->stencil has the magnitudes of its weights
 * now. */
static void mark_band(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    ntp__plane holes = { w->d, NULL, w->width };
    double **spare = w->parts[part].spare;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++) {
        float *right = w->right + ntp__weighted_at(w, y), *down = w->down + ntp__weighted_at(w, y);
        ntp__stencil_slopes(w->stencil, spare[0], spare[1], spare[2], &holes, y);
        for (int32_t x = 0; x < w->width; x++) {
            right[x] = spare[0][x] > 0 ? ntp__not_counting(right[x]) : right[x];
            down[x] = spare[1][x] > 0 ? ntp__not_counting(down[x]) : down[x];
        }
    }
}

void ntp__weighted_stored(const ntp__weighted *w, double *right, double *down, int32_t y)
{
    ntp__slopes_row(w->slopes, right, down, y, NULL);
    if (w->dx == 1 && w->dy == 1)
        return;
    for (int32_t x = 0; x < w->width; x++) {
        right[x] *= w->dx;
        down[x] *= w->dy;
    }
}

void ntp__weighted_setup(ntp__weighted *w)
{
    const ntp__height_plan *plan = w->plan;
    ntp_kernel kernel = w->rows ? plan->kernel : NTP_KERNEL_FORWARD;
    ntp__crew_each(&w->crew, set_band, w, ntp__bands(w));
    for (int32_t i = 0; i < w->crew.parts; i++)
        w->holes = w->holes || w->parts[i].holes > 0;
    if (w->holes && w->rows) {
        ntp__stencil_init(w->stencil, kernel, plan->border_x, plan->border_y, w->width, w->height,
                          true);
        ntp__crew_each(&w->crew, mark_band, w, ntp__bands(w));
    }
    ntp__stencil_init(w->stencil, kernel, plan->border_x, plan->border_y, w->width, w->height,
                      false);
}
