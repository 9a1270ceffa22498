/* SPDX-License-Identifier: MIT */
/*
 * ties.c - texels of flat ground, whose heights refinement keeps equal
 *
 * A slope of 0 lies on the edge of two boxes, and rounds to the upper of them, to level 128 of 255.
 * Where ground is flat, that level stands for slopes from 0 up, whose sum along a line that closes is
 * 0: only equal heights give the texture again.  No descent ends exactly at an edge, so these heights
 * are tied before.
 *
 * Gentle slopes round to that level too, but then as many round to the one below.
 *
 * Where a slope is made from two heights, that level says which of them is no higher.  All heights
 * on a circle of such steps are equal for sure, and there are no others that have to be.  The rest of
 * flat ground is tied as well at first, which brings heights nearer to the true ones, but the feet of
 * bumps may be among it: where that brings the rounds to a halt, only circles stay tied.
 *
 * Slopes of wider kernels tell nothing for sure about two heights.  There the ground amid flat texels
 * is tied, then what makes slopes that lie just beyond the edge.  A tie was wrong where it makes a
 * slope exactly 0 and the level says that it is not.
 */
#include "to_height/ties.h"

#include "base/finite.h"

#include <string.h>

enum { FLATTER = 4 }; /* so many times as many levels at the edge as below it */

typedef struct search {
    ntp__ties *ties;
    const ntp__round_trip *trip;
    const double *heights;
    unsigned char *flat; /* bit c: channel c is flat here */
    int32_t width, height;
    bool wrap_x, wrap_y;
} search;

void ntp__ties_init(ntp__ties *ties, const ntp__height_plan *plan, ntp__scratch *memory)
{
    size_t texels = (size_t) plan->width * (size_t) plan->height;
    ties->any = ties->sure = false;
    ties->texels = texels;
    ties->group = ntp__take(memory, texels * sizeof *ties->group);
    ties->count = ntp__take(memory, texels * sizeof *ties->count);
    ties->sum = ntp__take(memory, texels * sizeof *ties->sum);
}

/* ------------------------------------------------------------------------ flat texels */

/* Marks the channels of each texel that may be flat; returns those that are flatter than gentle. */
static unsigned char mark_flat(const search *s)
{
    int32_t edge = (s->trip->slopes->zero + 1) / 2;
    uint64_t at[2] = { 0, 0 }, below[2] = { 0, 0 };
    ntp__block block;
    for (int32_t y = 0; y < s->height; y++) {
        size_t start = (size_t) y * (size_t) s->width;
        for (int32_t x = 0; x < s->width; x++) {
            int32_t i = x % NTP__BLOCK, left = s->width - x;
            if (i == 0)
                ntp__unpack(&block, s->trip->slopes->src, x, y,
                            left < NTP__BLOCK ? left : NTP__BLOCK);
            s->flat[start + (size_t) x] = 0;
            if (ntp__is_nan(s->heights[start + (size_t) x]))
                continue;
            for (int32_t c = 0; c < 2; c++) {
                at[c] += block.c[c][i] == edge;
                below[c] += block.c[c][i] == edge - 1;
                if (block.c[c][i] == edge)
                    s->flat[start + (size_t) x] |= (unsigned char) (1 << c);
            }
        }
    }
    return (unsigned char) ((at[0] > FLATTER * below[0]) | (at[1] > FLATTER * below[1]) << 1);
}

/* Is the texel flat in these channels?  What lies beyond an edge is. */
static bool is_flat(const search *s, int32_t x, int32_t y, unsigned char channels)
{
    if (s->wrap_x)
        x = (x + s->width) % s->width;
    if (s->wrap_y)
        y = (y + s->height) % s->height;
    if (x < 0 || y < 0 || x >= s->width || y >= s->height)
        return true;
    return (s->flat[(size_t) y * (size_t) s->width + (size_t) x] & channels) == channels;
}

/* -------------------------------------------------------------------------------- groups */

static int32_t first_of(int32_t *group, int32_t i)
{
    while (group[i] != i) {
        group[i] = group[group[i]];
        i = group[i];
    }
    return i;
}

static void tie(const search *s, size_t i, size_t j)
{
    int32_t *group = s->ties->group, a, b;
    if (ntp__is_nan(s->heights[i]) || ntp__is_nan(s->heights[j]))
        return;
    a = first_of(group, (int32_t) i);
    b = first_of(group, (int32_t) j);
    group[a < b ? b : a] = a < b ? a : b;
}

/* Ties the elements at both ends of each pair of which a line makes element i; they lie `step` apart
 * in the planes. */
static void tie_line(const search *s, const ntp__line *line, int32_t i, size_t start, size_t step)
{
    ntp__line_terms terms;
    ntp__line_row(&terms, line, i);
    for (int32_t a = 0, b = terms.count - 1; a < b; a++, b--) {
        if (terms.weight[a] == -terms.weight[b])
            tie(s, start + (size_t) terms.at[a] * step, start + (size_t) terms.at[b] * step);
    }
}

/* Makes the slope of a texel 0, along rows (channel 0) or columns; in its own line alone or in all
 * that the kernel reads. */
static void tie_slope(const search *s, int32_t channel, int32_t x, int32_t y, bool own)
{
    const ntp__stencil *stencil = s->trip->stencil;
    const ntp__line *along = channel == 0 ? &stencil->along_x[0] : &stencil->along_y[0];
    const ntp__line *across = channel == 0 ? &stencil->across_y[0] : &stencil->across_x[0];
    size_t width = (size_t) s->width, line = channel == 0 ? width : 1;
    ntp__line_terms terms = { .count = 1, .at = { channel == 0 ? y : x } };
    if (!own)
        ntp__line_row(&terms, across, channel == 0 ? y : x);
    for (int32_t i = 0; i < terms.count; i++)
        tie_line(s, along, channel == 0 ? x : y, (size_t) terms.at[i] * line, width / line);
}

/* Are the three texels along the channel's axis flat in it, in `beside` lines on each side? */
static bool amid_flat(const search *s, int32_t channel, int32_t x, int32_t y, int32_t beside)
{
    unsigned char bit = (unsigned char) (1 << channel);
    for (int32_t i = -1; i <= 1; i++) {
        for (int32_t j = -beside; j <= beside; j++) {
            if (!is_flat(s, channel == 0 ? x + i : x + j, channel == 0 ? y + j : y + i, bit))
                return false;
        }
    }
    return true;
}

/* Ties a texel to its neighbors. */
static void tie_neighbors(const search *s, int32_t x, int32_t y)
{
    size_t width = (size_t) s->width, at = (size_t) y * width + (size_t) x;
    if (x > 0 || s->wrap_x)
        tie(s, at, x > 0 ? at - 1 : at + width - 1);
    if (x + 1 < s->width)
        tie(s, at, at + 1);
    if (y > 0 || s->wrap_y)
        tie(s, at, y > 0 ? at - width : at + width * ((size_t) s->height - 1));
    if (y + 1 < s->height)
        tie(s, at, at + width);
}

/* ------------------------------------------------------------------------------- circles */

/* Besides the channels, in `flat`: how many steps from the texel are done, counted by STEP, and
 * whether it is the first that was seen of its part, as far as is known. */
enum { STEP = 4, FIRST = 0x80 };

/* The other one of the two heights that make element i of a line; -1: there are not two. */
static int32_t other_end(const ntp__line *line, int32_t i, int32_t own)
{
    ntp__line_terms ends;
    ntp__line_row(&ends, line, i);
    if (ends.count != 2 || ends.weight[0] != -ends.weight[1])
        return -1;
    return ends.at[ends.at[0] == own];
}

/* The k-th texel that flat ones say to be no higher than texel (x, y); -1: there are fewer. */
static int32_t no_higher(const search *s, int32_t x, int32_t y, int32_t k)
{
    double sign = s->trip->slopes->src->y == NTP_Y_UP ? -1 : 1;
    for (int32_t c = 0; c < 2; c++) {
        const ntp__line *along =
            c == 0 ? &s->trip->stencil->along_x[0] : &s->trip->stencil->along_y[0];
        ntp__line_terms slopes;
        ntp__line_column(&slopes, along, c == 0 ? x : y);
        for (int32_t i = 0; i < slopes.count; i++) {
            int32_t at = slopes.at[i], other;
            if ((c == 0 ? slopes.weight[i] : sign * slopes.weight[i]) >= 0 ||
                !is_flat(s, c == 0 ? at : x, c == 0 ? y : at, (unsigned char) (1 << c)))
                continue;
            other = other_end(along, at, c == 0 ? x : y);
            if (other < 0)
                continue;
            other = c == 0 ? y * s->width + other : other * s->width + x;
            if (!ntp__is_nan(s->heights[other]) && k-- == 0)
                return other;
        }
    }
    return -1;
}

/* The walk over all steps, by the algorithm of Pearce for strongly connected components.  Ranks count
 * from 1 up where the walk is, and from the number of texels down in parts that are complete; 0: not
 * seen yet.  `under` links texels to those under them on one of two stacks: the way of the walk, and
 * texels whose steps are done while their part is not complete. */
typedef struct walk {
    const search *s;
    int32_t *rank, *under;
    int32_t next, part, at, waiting;
} walk;

static void enter(walk *w, int32_t texel)
{
    w->under[texel] = w->at;
    w->s->flat[texel] |= FIRST;
    w->rank[texel] = w->next++;
    w->at = texel;
}

static void leave(walk *w)
{
    int32_t texel = w->at;
    w->at = w->under[texel];
    if ((w->s->flat[texel] & FIRST) == 0) {
        w->under[texel] = w->waiting;
        w->waiting = texel;
        return;
    }
    while (w->waiting >= 0 && w->rank[texel] <= w->rank[w->waiting]) {
        w->rank[w->waiting] = w->part;
        w->waiting = w->under[w->waiting];
        w->next--;
    }
    w->rank[texel] = w->part--;
    w->next--;
}

static void walk_from(walk *w, int32_t texel)
{
    unsigned char *flat = w->s->flat;
    enter(w, texel);
    while (w->at >= 0) {
        int32_t at = w->at, steps = (flat[at] & ~FIRST) / STEP;
        int32_t to = no_higher(w->s, at % w->s->width, at / w->s->width, steps);
        if (to < 0) {
            leave(w);
        } else if (w->rank[to] == 0) {
            enter(w, to); /* the step counts when it is tried again */
        } else {
            flat[at] = (unsigned char) (flat[at] + STEP);
            if (w->rank[to] < w->rank[at]) {
                w->rank[at] = w->rank[to];
                flat[at] &= (unsigned char) ~FIRST;
            }
        }
    }
}

/* Ties all texels on circles, and no others. */
static void tie_circles(const search *s)
{
    int32_t *group = s->ties->group, *first = s->ties->count, texels = (int32_t) s->ties->texels;
    walk w = { s, group, first, 1, texels, -1, -1 };
    memset(group, 0, s->ties->texels * sizeof *group);
    for (int32_t i = 0; i < texels; i++) {
        if (group[i] == 0)
            walk_from(&w, i);
    }
    memset(first, 0, s->ties->texels * sizeof *first);
    for (int32_t i = 0; i < texels; i++) {
        int32_t *of_part = &first[group[i] - 1];
        if (*of_part == 0)
            *of_part = i + 1;
        group[i] = *of_part - 1;
    }
}

/* -------------------------------------------------------------------------- flat ground */

static void count_groups(ntp__ties *ties)
{
    memset(ties->count, 0, ties->texels * sizeof *ties->count);
    for (size_t i = 0; i < ties->texels; i++) {
        ties->group[i] = first_of(ties->group, (int32_t) i);
        ties->count[ties->group[i]]++;
    }
    for (size_t i = 0; i < ties->texels; i++) {
        if (ties->count[ties->group[i]] == 1)
            ties->group[i] = -1;
        ties->any = ties->any || ties->group[i] >= 0;
    }
}

static search search_of(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                        const double *heights)
{
    return (search) { ties,
                      trip,
                      heights,
                      (unsigned char *) ties->sum,
                      plan->width,
                      plan->height,
                      plan->border_x == NTP_BORDER_WRAP,
                      plan->border_y == NTP_BORDER_WRAP };
}

void ntp__ties_find(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                    const double *heights)
{
    search s = search_of(ties, trip, plan, heights);
    bool pairs = plan->kernel == NTP_KERNEL_FORWARD || plan->kernel == NTP_KERNEL_CENTRAL;
    unsigned char channels = 0;
    ties->any = false;
    if (trip->slopes->src->type != NTP_TYPE_F32 && trip->slopes->zero % 2 == 1 &&
        ties->texels <= INT32_MAX)
        channels = mark_flat(&s);
    if (channels == 0)
        return;
    for (size_t i = 0; i < ties->texels; i++)
        ties->group[i] = (int32_t) i;
    if (pairs) {
        tie_circles(&s);
        mark_flat(&s);
    }
    for (int32_t y = 0; y < plan->height; y++) {
        for (int32_t x = 0; x < plan->width; x++) {
            bool amid[2];
            for (int32_t c = 0; c < 2; c++) {
                amid[c] = (channels >> c & 1) != 0 && amid_flat(&s, c, x, y, pairs ? 0 : 1);
                if (amid[c])
                    tie_slope(&s, c, x, y, true);
            }
            if (!pairs && amid[0] && amid[1])
                tie_neighbors(&s, x, y);
        }
    }
    count_groups(ties);
}

/* Besides the channels, in `flat`: the slope lies just beyond the edge (times the channel's bit), and
 * the texel is to be free again. */
enum { BEYOND = 4, FREED = 16 };

/* Frees all texels that make the slope of one, along rows or columns. */
static void free_slope(const search *s, int32_t channel, int32_t x, int32_t y)
{
    const ntp__stencil *stencil = s->trip->stencil;
    ntp__line_terms across, down;
    ntp__line_row(&across, channel == 0 ? &stencil->along_x[0] : &stencil->across_x[0], x);
    ntp__line_row(&down, channel == 0 ? &stencil->across_y[0] : &stencil->along_y[0], y);
    for (int32_t j = 0; j < down.count; j++) {
        for (int32_t i = 0; i < across.count; i++)
            s->flat[(size_t) down.at[j] * (size_t) s->width + (size_t) across.at[i]] |= FREED;
    }
}

/* Marks slopes just beyond the edge.  A slope that is exactly 0 where the level says otherwise was
 * made so by ties that are wrong.  Returns whether there were any of both. */
static bool look_for_wrong(const search *s)
{
    double *const *row = s->trip->parts[0].row, sign = s->trip->slopes->src->y == NTP_Y_UP ? 1 : -1;
    ntp__plane plane = { s->heights, NULL, s->width };
    bool any = false;
    for (int32_t y = 0; y < s->height; y++) {
        unsigned char *flat = s->flat + (size_t) y * (size_t) s->width;
        ntp__stencil_slopes(s->trip->stencil, row[0], row[1], row[2], &plane, y);
        for (int32_t x = 0; x < s->width; x++) {
            bool hole = ntp__is_nan(s->heights[(size_t) y * (size_t) s->width + (size_t) x]);
            for (int32_t c = 0; c < 2 && !hole; c++) {
                double slope = c == 0 ? row[0][x] : -sign * row[1][x];
                bool is = (flat[x] >> c & 1) != 0;
                any = any || (is && slope > 0) || (!is && slope == 0);
                if (is && slope > 0)
                    flat[x] |= (unsigned char) (BEYOND << c);
                else if (!is && slope == 0)
                    free_slope(s, c, x, y);
            }
        }
    }
    return any;
}

/* Leaves the freed texels alone in their groups, and every other in its group. */
static void regroup(const search *s)
{
    int32_t *group = s->ties->group, *first = s->ties->count;
    for (size_t i = 0; i < s->ties->texels; i++)
        first[i] = -1;
    for (size_t i = 0; i < s->ties->texels; i++) {
        if (group[i] < 0 || (s->flat[i] & FREED) != 0) {
            group[i] = (int32_t) i;
            continue;
        }
        if (first[group[i]] < 0)
            first[group[i]] = (int32_t) i;
        group[i] = first[group[i]];
    }
}

bool ntp__ties_change(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                      const double *heights)
{
    search s = search_of(ties, trip, plan, heights);
    bool pairs = plan->kernel == NTP_KERNEL_FORWARD || plan->kernel == NTP_KERNEL_CENTRAL;
    if (trip->stencil->terms > 1 || ties->sure)
        return false;
    mark_flat(&s);
    if (pairs) {
        ties->sure = true;
        tie_circles(&s);
    } else if (look_for_wrong(&s)) {
        regroup(&s);
        for (int32_t i = 0; i < (int32_t) ties->texels; i++) {
            for (int32_t c = 0; c < 2; c++) {
                if ((s.flat[i] & BEYOND << c) != 0)
                    tie_slope(&s, c, i % s.width, i / s.width, false);
            }
        }
    } else {
        return false;
    }
    count_groups(ties);
    return true;
}

/* ------------------------------------------------------------------------------- leveling */

static void clear_sums(const ntp__ties *ties)
{
    memset(ties->sum, 0, ties->texels * sizeof *ties->sum);
}

static double mean_of(const ntp__ties *ties, int32_t group)
{
    return ties->sum[group] / ties->count[group];
}

void ntp__ties_level(const ntp__ties *ties, double *plane)
{
    if (!ties->any)
        return;
    clear_sums(ties);
    for (size_t i = 0; i < ties->texels; i++) {
        if (ties->group[i] >= 0)
            ties->sum[ties->group[i]] += plane[i];
    }
    for (size_t i = 0; i < ties->texels; i++) {
        if (ties->group[i] >= 0)
            plane[i] = mean_of(ties, ties->group[i]);
    }
}

void ntp__ties_level_floats(const ntp__ties *ties, float *plane)
{
    if (!ties->any)
        return;
    clear_sums(ties);
    for (size_t i = 0; i < ties->texels; i++) {
        if (ties->group[i] >= 0)
            ties->sum[ties->group[i]] += (double) plane[i];
    }
    for (size_t i = 0; i < ties->texels; i++) {
        if (ties->group[i] >= 0)
            plane[i] = (float) mean_of(ties, ties->group[i]);
    }
}
