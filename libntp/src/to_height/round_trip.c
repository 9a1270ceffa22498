/* SPDX-License-Identifier: MIT */
/*
 * round_trip.c - compares the normals of a reconstructed heightfield with the stored normals
 *
 * A stored level stands for a box: all values that round to it.  The heights give the texture again
 * if x and y of each texel lie in their boxes.  What lies beyond them is the excess.
 */
#include "to_height/round_trip.h"

#include "base/finite.h"
#include "to_height/direct/direct.h"
#include "to_height/shared/holes.h"
#include "to_height/shared/solver_kernels.h"

#include <math.h>

enum { MOST_ROWS = 128 }; /* NTP_RESIDUAL_INSIDE looks at no more */

/* The least share of the box of a blue that has no excess.  On gentle ground the box is a ring of
 * slopes; a narrower one would make heights worse. */
static const double least_share_of_blue = 0.95;

/* Leaves out the texels whose slopes a line makes from heights beyond a border. */
static void hold_inside(int32_t *first, int32_t *end, const ntp__line *line)
{
    *first = line->low > *first ? line->low : *first;
    *end = line->high < *end ? line->high : *end;
}

/* Leaves out the lines at edges that the direct solver fits again: their border may be a guess. */
static void hold_off_edges(int32_t *first, int32_t *end, ntp_border border)
{
    if (border == NTP_BORDER_EXTRAPOLATE && *end - *first > 4 * NTP__EDGE_LINES) {
        *first += NTP__EDGE_LINES - 1;
        *end -= NTP__EDGE_LINES - 1;
    }
}

static void choose_seen(ntp__round_trip *r, const ntp__height_plan *plan)
{
    const ntp__stencil *s = r->stencil;
    bool only_inside = plan->residual_scope == NTP_RESIDUAL_INSIDE;
    bool inside_x = only_inside || plan->residual_scope == NTP_RESIDUAL_INSIDE_X;
    bool inside_y = only_inside || plan->residual_scope == NTP_RESIDUAL_INSIDE_Y;
    r->seen = (ntp_rect) { 0, 0, r->width, r->height };
    r->rows = only_inside ? MOST_ROWS : r->height;
    for (int32_t t = 0; inside_x && t < s->terms; t++) {
        hold_inside(&r->seen.x0, &r->seen.x1, &s->along_x[t]);
        hold_inside(&r->seen.x0, &r->seen.x1, &s->across_x[t]);
    }
    for (int32_t t = 0; inside_y && t < s->terms; t++) {
        hold_inside(&r->seen.y0, &r->seen.y1, &s->along_y[t]);
        hold_inside(&r->seen.y0, &r->seen.y1, &s->across_y[t]);
    }
    if (only_inside && plan->kernel == NTP_KERNEL_CENTRAL && plan->solver != NTP__SOLVER_WEIGHTED) {
        hold_off_edges(&r->seen.x0, &r->seen.x1, plan->border_x);
        hold_off_edges(&r->seen.y0, &r->seen.y1, plan->border_y);
    }
}

void ntp__round_trip_init(ntp__round_trip *r, const ntp__slopes *slopes,
                          const ntp__height_plan *plan, ntp__crew crew, ntp__scratch *memory)
{
    /* Baked normals come from no stencil; central differences are near to them.  Refinement needs
     * what is nearer. */
    bool baked = plan->kernel == NTP_KERNEL_BAKED && plan->refine == 0;
    size_t rows = (size_t) plan->height, row = (size_t) plan->width * sizeof(double);
    r->slopes = slopes;
    r->mask = plan->mask;
    r->width = plan->width;
    r->height = plan->height;
    r->dx = plan->dx;
    r->dy = plan->dy;
    r->crew = crew;
    r->stencil = ntp__take(memory, sizeof *r->stencil);
    r->parts = ntp__take(memory, (size_t) crew.parts * sizeof *r->parts);
    for (int32_t i = 0; i < crew.parts * NTP__ROUND_TRIP_ROWS; i++) {
        double *taken = ntp__take(memory, row);
        if (memory->base != NULL)
            r->parts[i / NTP__ROUND_TRIP_ROWS].row[i % NTP__ROUND_TRIP_ROWS] = taken;
    }
    r->sum = ntp__take(memory, rows * sizeof *r->sum);
    r->count = ntp__take(memory, rows * sizeof *r->count);
    if (memory->base != NULL) {
        ntp__stencil_init(r->stencil, baked ? NTP_KERNEL_CENTRAL : plan->kernel, plan->border_x,
                          plan->border_y, plan->width, plan->height, false);
        choose_seen(r, plan);
    }
}

static double not_a_number(void)
{
    double zero = 0;
    return zero / zero;
}

/* Does the stencil of this texel read a hole? */
static bool reads_hole(double slope_right, double slope_down)
{
    return ntp__is_nan(slope_right) || ntp__is_nan(slope_down);
}

/* Slopes of the heights at row y, with the spacing of texels divided out. */
static void slopes_of_heights(const ntp__round_trip *r, double *right, double *down, double *work,
                              int32_t y)
{
    ntp__stencil_slopes(r->stencil, right, down, work, &r->heights, y);
    if (r->dx == 1 && r->dy == 1)
        return;
    for (int32_t x = 0; x < r->width; x++) {
        right[x] /= r->dx;
        down[x] /= r->dy;
    }
}

/* Unpacks n texels from (x, y) on, and finds the holes among them. */
static void look_at(const ntp__round_trip *r, ntp__block *block, bool hole[NTP__BLOCK], int32_t x,
                    int32_t y, int32_t n)
{
    ntp__unpack(block, r->slopes->src, x, y, n);
    ntp__find_holes(hole, r->slopes, r->mask, block, x, y, n);
}

void ntp__round_trip_mark_holes(const ntp__round_trip *r, double *heights, const ntp_image *dst)
{
    ntp__block block;
    bool hole[NTP__BLOCK];
    for (int32_t y = 0; y < r->height; y++) {
        double *d = heights != NULL ? heights + (size_t) y * (size_t) r->width : NULL;
        float *f = dst != NULL ? ntp__at_mut(dst, 0, y) : NULL;
        for (int32_t x = 0; x < r->width; x++) {
            int32_t i = x % NTP__BLOCK, left = r->width - x;
            if (i == 0)
                look_at(r, &block, hole, x, y, left < NTP__BLOCK ? left : NTP__BLOCK);
            if (!hole[i])
                continue;
            if (d != NULL)
                d[x] = not_a_number();
            if (f != NULL)
                f[x] = (float) not_a_number();
        }
    }
}

/* ----------------------------------------------------------------------------- residual */

/* Is this one of the rows that are looked at?  They are spread evenly. */
static bool is_sampled(const ntp__round_trip *r, int32_t y)
{
    int64_t rows = (int64_t) r->seen.y1 - r->seen.y0, at = (int64_t) y - r->seen.y0;
    return at >= 0 && at < rows && (rows <= r->rows || at * r->rows % rows < r->rows);
}

static void residual_row(void *job, int32_t part, int32_t y)
{
    const ntp__solver_kernels *kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    ntp__round_trip *r = job;
    double *const *row = r->parts[part].row, square[NTP__BLOCK], sum = 0;
    uint64_t count = 0;
    ntp__block block;
    bool hole[NTP__BLOCK];
    r->sum[y] = 0;
    r->count[y] = 0;
    if (!is_sampled(r, y))
        return;
    slopes_of_heights(r, row[0], row[1], row[2], y);
    ntp__slopes_row(r->slopes, row[2], row[3], y, NULL);
    for (int32_t x = r->seen.x0; x < r->seen.x1; x += NTP__BLOCK) {
        int32_t n = r->seen.x1 - x < NTP__BLOCK ? r->seen.x1 - x : NTP__BLOCK;
        look_at(r, &block, hole, x, y, n);
        kernels->squares_off(square, row, x, n);
        for (int32_t i = 0; i < n; i++) {
            if (hole[i] || reads_hole(row[0][x + i], row[1][x + i]))
                continue;
            sum += square[i];
            count++;
        }
    }
    r->sum[y] = sum;
    r->count[y] = count;
}

double ntp__round_trip_residual(ntp__round_trip *r, const ntp__plane *heights)
{
    double sum = 0, count = 0;
    r->heights = *heights;
    ntp__crew_each(&r->crew, residual_row, r, r->height);
    for (int32_t y = 0; y < r->height; y++) {
        sum += r->sum[y];
        count += (double) r->count[y];
    }
    /* A level is 2/range. */
    return count > 0 ? sqrt(sum / (2 * count)) * r->slopes->range / 2 : -1;
}

/* ------------------------------------------------------------------------------- excess */

/* How far v lies beyond the box of a level, in levels; *off: it rounds to another level.  zero and
 * range: v is (2 level - zero)/range in the middle of the box. */
static double beyond(double v, int32_t level, double zero, double range, double share, int32_t most,
                     bool *off)
{
    double at = (v * range + zero) / 2 - level, bound = share / 2;
    if (at <= bound && at >= -bound)
        return 0;
    /* The lowest and the highest level stand for all values beyond them too. */
    bool low = at < 0 && level > 0, high = at > 0 && level < most;
    *off = *off || (low && at < -0.5) || (high && at >= 0.5);
    if (low && at < -bound)
        return at + bound;
    return high && at > bound ? at - bound : 0;
}

/* Replaces the slopes right, down of a texel by the derivatives of half its squared excess, which is
 * added to *half.  Returns whether the normal rounds to others than the stored levels. */
static bool differentiate(const ntp__round_trip *r, const ntp__block *block, int32_t i,
                          double *right, double *down, double *half)
{
    const ntp__slopes *s = r->slopes;
    double p = *right, d = *down, square = 1 + p * p + d * d, z = 1 / sqrt(square);
    double sign = s->src->y == NTP_Y_UP ? 1 : -1, zero = s->zero, range = s->range;
    int32_t most = ntp__max(s->src->type);
    double share_z = r->inside > least_share_of_blue ? r->inside : least_share_of_blue;
    bool off = false;
    double ex = beyond(-p * z, block->c[0][i], zero, range, r->inside, most, &off);
    double ey = beyond(sign * d * z, block->c[1][i], zero, range, r->inside, most, &off), ez = 0;
    if (r->blue && s->src->encoding == NTP_ENCODING_ZZERO)
        ez = 2 * beyond(z, block->c[2][i], 0, 2.0 * most, share_z, most, &off);
    else if (r->blue)
        ez = beyond(z, block->c[2][i], zero, range, share_z, most, &off);
    if (ex == 0 && ey == 0 && ez == 0) {
        *right = *down = 0;
        return off;
    }
    *half += (ex * ex + ey * ey + ez * ez) / 2;
    double factor = range * z / (2 * square);
    *right = factor * (-(1 + d * d) * ex - sign * p * d * ey - p * ez);
    *down = factor * (p * d * ex + sign * (1 + p * p) * ey - d * ez);
    return off;
}

static void excess_row(void *job, int32_t part, int32_t y)
{
    ntp__round_trip *r = job;
    double *const *row = r->parts[part].row, sum = 0;
    size_t start = (size_t) y * (size_t) r->width;
    uint64_t count = 0;
    ntp__block block;
    bool hole[NTP__BLOCK];
    slopes_of_heights(r, row[0], row[1], row[2], y);
    for (int32_t x = 0; x < r->width; x++) {
        int32_t i = x % NTP__BLOCK, left = r->width - x;
        if (i == 0)
            look_at(r, &block, hole, x, y, left < NTP__BLOCK ? left : NTP__BLOCK);
        if (hole[i] || reads_hole(row[0][x], row[1][x]))
            row[0][x] = row[1][x] = 0;
        else
            count += differentiate(r, &block, i, &row[0][x], &row[1][x], &sum);
        if (r->right != NULL) {
            r->right[start + (size_t) x] = (float) (row[0][x] / r->dx);
            r->down[start + (size_t) x] = (float) (row[1][x] / r->dy);
        }
    }
    r->sum[y] = sum;
    r->count[y] = count;
}

double ntp__round_trip_excess(ntp__round_trip *r, const ntp__plane *heights, float *right,
                              float *down, uint64_t *off)
{
    double sum = 0;
    r->heights = *heights;
    r->right = right;
    r->down = down;
    *off = 0;
    ntp__crew_each(&r->crew, excess_row, r, r->height);
    for (int32_t y = 0; y < r->height; y++) {
        sum += r->sum[y];
        *off += r->count[y];
    }
    return sum;
}

/* --------------------------------------------------------------------------------- blue */

/* Was this blue rounded with red and green from one vector? */
static bool rounded_with(const ntp__slopes *s, const ntp__block *block, int32_t i)
{
    double least = 0, most = 0, square = s->range * s->range;
    for (int32_t c = 0; c < 3; c++) {
        bool zzero = c == 2 && s->src->encoding == NTP_ENCODING_ZZERO;
        double v = zzero ? block->c[c][i] * s->z_scale : 2 * block->c[c][i] - s->zero;
        double half = zzero ? s->z_scale / 2 : 1, size = v < 0 ? -v : v;
        least += size > half ? (size - half) * (size - half) : 0;
        most += (size + half) * (size + half);
        if (c == 2 && v < -half)
            return false;
    }
    return least <= square && most >= square;
}

void ntp__round_trip_see_blue(ntp__round_trip *r)
{
    const ntp_const_image *src = r->slopes->src;
    ntp__block block;
    bool hole[NTP__BLOCK];
    r->blue = !r->slopes->derived &&
              (src->encoding == NTP_ENCODING_STANDARD || src->encoding == NTP_ENCODING_ZZERO);
    for (int32_t y = 0; y < r->height && r->blue; y++) {
        for (int32_t x = 0; x < r->width && r->blue; x += NTP__BLOCK) {
            int32_t n = r->width - x < NTP__BLOCK ? r->width - x : NTP__BLOCK;
            look_at(r, &block, hole, x, y, n);
            for (int32_t i = 0; i < n; i++)
                r->blue = r->blue && (hole[i] || rounded_with(r->slopes, &block, i));
        }
    }
}
