/* SPDX-License-Identifier: MIT */
/*
 * round_trip.c - compares the normals of a reconstructed heightfield with the stored normals
 *
 * A stored level stands for a box: all values that round to it.  The heights give the texture again
 * if x and y of each texel lie in their boxes.  The projection moves texels outside to the nearest
 * place inside, each texel by itself.
 */
#include "to_height/round_trip.h"

#include "base/finite.h"
#include "to_height/direct/direct.h"
#include "to_height/shared/holes.h"

#include <math.h>

/* The share of half a box that is used; the rest is for the rounding of heights to float. */
static const double inside = 0.98;

enum { MOST_ROWS = 128 }; /* NTP_RESIDUAL_INSIDE looks at no more */

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
    r->seen = (ntp_rect) { 0, 0, r->width, r->height };
    r->rows = only_inside ? MOST_ROWS : r->height;
    for (int32_t t = 0; only_inside && t < s->terms; t++) {
        hold_inside(&r->seen.x0, &r->seen.x1, &s->along_x[t]);
        hold_inside(&r->seen.x0, &r->seen.x1, &s->across_x[t]);
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
    /* Baked normals come from no stencil; central differences are near to them. */
    bool baked = plan->kernel == NTP_KERNEL_BAKED;
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

/* For n texels, the squared distance between the (x, y) of two normals, both given as slopes. */
static void squares_off(double *out, double *const *row, int32_t x, int32_t n)
{
    const double *right = row[0] + x, *down = row[1] + x, *p = row[2] + x, *q = row[3] + x;
    for (int32_t i = 0; i < n; i++) {
        double a = right[i], b = down[i], c = p[i], d = q[i];
        double ours = sqrt(1 + a * a + b * b), theirs = sqrt(1 + c * c + d * d);
        double ex = a / ours - c / theirs, ey = b / ours - d / theirs;
        out[i] = ex * ex + ey * ey;
    }
}

static void residual_row(void *job, int32_t part, int32_t y)
{
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
        squares_off(square, row, x, n);
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

/* --------------------------------------------------------------------------- projection */

/* v moved to within `half` of the value of a level; *off: it rounds to another level. */
static double to_box(const ntp__slopes *s, double v, int32_t level, bool *off)
{
    double middle = (2 * level - s->zero) / s->range, half = 1 / s->range;
    /* The lowest and the highest level stand for all values beyond them too. */
    bool at_low = level == 0, at_high = level == ntp__max(s->src->type);
    *off = *off || (v < middle - half && !at_low) || (v >= middle + half && !at_high);
    half *= inside;
    if (v < middle - half && !at_low)
        return middle - half;
    return v > middle + half && !at_high ? middle + half : v;
}

/* Slopes p to the right and d down, and x, y of their normal as they are stored. */
typedef struct slope_pair {
    double p, d, x, y;
} slope_pair;

static void set_normal(slope_pair *s, double sign)
{
    double length = sqrt(1 + s->p * s->p + s->d * s->d);
    s->x = -s->p / length;
    s->y = sign * s->d / length;
}

static void set_slopes(slope_pair *s, double x, double y, double sign, double least)
{
    double z2 = 1 - x * x - y * y, z = z2 > least * least ? sqrt(z2) : least;
    s->p = -x / z;
    s->d = sign * y / z;
    s->x = x;
    s->y = y;
}

static double distance(const slope_pair *a, const slope_pair *b)
{
    return (a->p - b->p) * (a->p - b->p) + (a->d - b->d) * (a->d - b->d);
}

/* Moves `at` to the place nearest to `from` where x (or y) is `bound`.  Each step solves for the
 * tangent of that curve.  So near to it a few steps are enough. */
static void to_bound(slope_pair *at, const slope_pair *from, bool of_x, double bound, double sign)
{
    enum { STEPS = 4 };
    for (int32_t i = 0; i < STEPS; i++) {
        double p = at->p, d = at->d, length2 = 1 + p * p + d * d, cube = length2 * sqrt(length2);
        double gp = of_x ? -(1 + d * d) / cube : -sign * p * d / cube;
        double gd = of_x ? p * d / cube : sign * (1 + p * p) / cube;
        double off = (of_x ? at->x : at->y) - bound + gp * (from->p - p) + gd * (from->d - d);
        double factor = off / (gp * gp + gd * gd);
        at->p = from->p - factor * gp;
        at->d = from->d - factor * gd;
        set_normal(at, sign);
    }
}

/* Replaces the slopes right, down by the shortest way from them into the boxes; true: they were
 * outside. */
static bool project_texel(const ntp__slopes *s, const ntp__block *block, int32_t i, double *right,
                          double *down)
{
    double sign = s->src->y == NTP_Y_UP ? 1 : -1, least = 1 / s->range;
    slope_pair from = { *right, *down, 0, 0 };
    bool off = false, unused = false;
    set_normal(&from, sign);
    slope_pair to = from;
    double x = to_box(s, from.x, block->c[0][i], &off), y = to_box(s, from.y, block->c[1][i], &off);
    bool move_x = x != from.x, move_y = y != from.y;
    if (move_x != move_y) {
        slope_pair corner;
        to_bound(&to, &from, move_x, move_x ? x : y, sign);
        set_slopes(&corner, x, y, sign, least);
        bool astray = !(distance(&to, &from) <= distance(&corner, &from));
        /* If this step leaves the box of the other one, the edge of that box is the nearest. */
        double *other = move_x ? &y : &x, there = move_x ? to.y : to.x;
        double held = to_box(s, there, block->c[move_x ? 1 : 0][i], &unused);
        *other = astray || held == there ? *other : held;
        move_x = move_y = astray || held != there;
    }
    if (move_x && move_y)
        set_slopes(&to, x, y, sign, least);
    *right = to.p - from.p;
    *down = to.d - from.d;
    return off;
}

static void project_row(void *job, int32_t part, int32_t y)
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
            count += project_texel(r->slopes, &block, i, &row[0][x], &row[1][x]);
        sum += row[0][x] * row[0][x] + row[1][x] * row[1][x];
        if (r->right != NULL) {
            r->right[start + (size_t) x] = (float) row[0][x];
            r->down[start + (size_t) x] = (float) row[1][x];
        }
    }
    r->sum[y] = sum;
    r->count[y] = count;
}

uint64_t ntp__round_trip_project(ntp__round_trip *r, const ntp__plane *heights, float *right,
                                 float *down, double *mean_square)
{
    uint64_t count = 0;
    double sum = 0;
    r->heights = *heights;
    r->right = right;
    r->down = down;
    ntp__crew_each(&r->crew, project_row, r, r->height);
    for (int32_t y = 0; y < r->height; y++) {
        sum += r->sum[y];
        count += r->count[y];
    }
    if (mean_square != NULL)
        *mean_square = sum / ((double) r->width * r->height);
    return count;
}
