/* SPDX-License-Identifier: MIT */
/*
 * ends_meet.c - is wrap the better guess for a damaged texture?
 *
 * With a free border the errors of slopes add up: a lean of a quarter of a level becomes a ramp from
 * edge to edge.  With wrap they do not, but the step by which heights at the two ends differ bends
 * them instead.  So two losses are compared.  The slopes along line i add up to the step D[i].  The
 * slopes across the lines, along the last edge less along the first, add up to the same steps V[i],
 * but for a constant.  The errors of both have nothing to do with each other.  So the mean of D V is
 * the square of the true step, and that of (D - V)^2 is what the errors make of it.  Steps that change
 * along the edge within s lines bend heights as far as s / pi into the picture, so stretches of
 * lines are compared with their neighbors, at all lengths, and long ones count more.  What all lines
 * have in common shows in D alone: it is a lean, of the surface or of the errors.
 */
#include "detect/ends_meet.h"

#include "detect/line.h"
#include "texel/level.h"

#include <math.h>
#include <stddef.h>

enum {
    MOST_LINES = 512,
    MOST_TEXELS = 1 << 18, /* of all lines; of longer ones half, which tell more each */
    LONG = 512,
    LEAST_LINES = 16,
    END = 4 /* texels at an end of a line whose mean height counts */
};

/* The square of an 8-bit level over 12, of lengths.  Levels that were cut off make four times that. */
static const double rounding = 4.0 / (255.0 * 255.0 * 12.0), most_error = 5;
/* Decoding can be off by half a level, and damage by as much: a steeper lean is one of the surface. */
static const double most_lean = 1.5 / 255;
/* Steps must be less than this part of what errors make of them.  And the ramp that a free border
 * makes must have so many times the square of them, of what they can be by chance, and of the errors.
 * These were chosen on the maps of `./dev bench heights --auto`. */
static const double most_steps = 0.2, over_steps = 2, by_chance = 0.3, over_errors = 0.05;
/* But not where the slopes at the ends differ by so many times as much as neighbors inside, and hardly
 * any of these differ as much: walls of bricks that were cut. */
static const double most_jump = 4, least_rank = 0.1;

typedef struct lines {
    ntp_const_image src; /* lines are its rows */
    uint32_t touch;
    int32_t along; /* the channel of slopes along a line */
    ntp__line read;
} lines;

/* The sum of the slopes along line y.  errors2: squares of twice the errors of lengths are added, if it
 * is asked for. */
static double whole(lines *l, int32_t y, double *errors2)
{
    const double level = 2.0 / ntp__max(l->src.type);
    double sum = 0;
    for (int32_t x = 0; x < l->src.width; x += NTP__BLOCK) {
        int32_t n = l->src.width - x < NTP__BLOCK ? l->src.width - x : NTP__BLOCK;
        ntp__read_line(&l->read, &l->src, l->touch, l->along, x, y, n);
        for (int32_t i = 0; i < n; i++)
            sum += l->read.p[i + 1];
        for (int32_t i = 0; i < n && errors2 != NULL; i++) {
            double off = -1;
            for (int32_t c = 0; c < 3; c++) {
                double v = l->read.block.c[c][i] * level - 1;
                off += v * v;
            }
            *errors2 += off * off;
        }
    }
    return sum;
}

/* The slope across line y at its end less that at its beginning.  beyond: the step between the
 * middles of both ends, around the seam. */
static double across(lines *l, int32_t y, double *beyond)
{
    double difference = 0, sum = 0;
    for (int32_t end = 0; end < 2; end++) {
        ntp__read_line(&l->read, &l->src, l->touch, l->along, end == 0 ? 0 : l->src.width - END, y,
                       END);
        difference = -difference;
        for (int32_t i = 1; i <= END; i++) {
            sum += l->read.p[i];
            difference += l->read.q[i];
        }
    }
    *beyond = sum / 2;
    return difference / END;
}

/* Is the loss with wrap less?  seen: the steps of n lines as slopes across them show them.  Both are
 * used up. */
static bool costs_less(double *step, double *seen, int32_t n, const ntp_const_image *src)
{
    double steps = 0;              /* squares of the true ones, */
    double summed = 0, looked = 0; /* and of each with its errors */
    for (int32_t half = n / 2; half > 0; half /= 2) {
        double weight = 1.0 / half / half; /* the mean of pairs, in proportion to their length */
        for (int32_t i = 0; i < half; i++) {
            double d = (step[2 * i] - step[2 * i + 1]) / 2, v = (seen[2 * i] - seen[2 * i + 1]) / 2;
            step[i] = step[2 * i] - d;
            seen[i] = seen[2 * i] - v;
            steps += weight * d * v;
            summed += weight * d * d;
            looked += weight * v * v;
        }
    }
    double lean = fabs(step[0]), ramp = lean * lean * 8 / 12 * src->width / src->height;
    double errors = summed + looked - 2 * steps, chance = by_chance * sqrt(summed * looked);
    return lean <= most_lean * src->width && steps < most_steps * errors &&
           ramp > over_steps * ((steps > 0 ? steps : 0) + chance) + over_errors * errors;
}

bool ntp__ends_meet(const ntp_const_image *src, uint32_t touch_unused, int32_t down)
{
    double step[MOST_LINES], seen[MOST_LINES], sum = 0, beyond, errors2 = 0;
    lines l = { .src = down ? ntp__transposed(src) : *src, .touch = touch_unused, .along = down };
    int32_t n = LEAST_LINES, next = 0, height = l.src.height;
    for (int32_t k = 0; k < LEAST_LINES; k++)
        sum += whole(&l, (int32_t) ((int64_t) k * height / LEAST_LINES), &errors2);
    /* So few lines tell a lean that is far too steep. */
    if (src->encoding != NTP_ENCODING_STANDARD ||
        fabs(sum) > 2 * most_lean * LEAST_LINES * l.src.width ||
        errors2 <= 4 * most_error * rounding * LEAST_LINES * l.src.width)
        return false;
    const int32_t most = l.src.width > LONG ? MOST_TEXELS / 2 : MOST_TEXELS;
    while (2 * n <= height && n < MOST_LINES && 2 * n <= most / l.src.width)
        n *= 2;
    for (int32_t y = 0; next < n; y++) {
        double here = across(&l, y, &beyond) / (src->y == NTP_Y_UP ? -2 : 2);
        sum += here;
        if (y == (int32_t) ((int64_t) next * height / n)) {
            seen[next] = sum + beyond;
            step[next++] = whole(&l, y, NULL);
        }
        sum += here;
    }
    ntp_seam seam;
    return costs_less(step, seen, n, &l.src) &&
           ntp_find_seams(down ? NULL : &seam, down ? &seam : NULL, src, touch_unused) == NTP_OK &&
           (seam.jump <= most_jump || seam.rank >= least_rank);
}
