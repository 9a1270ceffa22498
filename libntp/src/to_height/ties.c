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
    ties->any = false;
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

bool ntp__ties_add(ntp__ties *ties, const ntp__round_trip *trip, const ntp__height_plan *plan,
                   const double *heights)
{
    search s = search_of(ties, trip, plan, heights);
    double *const *row = trip->parts[0].row, sign = trip->slopes->src->y == NTP_Y_UP ? 1 : -1;
    ntp__plane plane = { heights, NULL, plan->width };
    bool added = false;
    if (trip->stencil->terms > 1)
        return false;
    mark_flat(&s);
    for (size_t i = 0; i < ties->texels; i++)
        ties->group[i] = ties->group[i] < 0 ? (int32_t) i : ties->group[i];
    for (int32_t y = 0; y < plan->height; y++) {
        ntp__stencil_slopes(trip->stencil, row[0], row[1], row[2], &plane, y);
        for (int32_t x = 0; x < plan->width; x++) {
            bool off[2] = { is_flat(&s, x, y, 1) && row[0][x] > 0,
                            is_flat(&s, x, y, 2) && sign * row[1][x] < 0 };
            for (int32_t c = 0; c < 2; c++) {
                if (off[c])
                    tie_slope(&s, c, x, y, false);
                added = added || off[c];
            }
        }
    }
    count_groups(ties);
    return added;
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
