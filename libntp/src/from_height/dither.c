/* SPDX-License-Identifier: MIT */
/*
 * dither.c - rounding that keeps the sum of slopes: one texel
 *
 * The difference in height of two texels is a sum of slopes, so rounding errors add up along a row.
 * Here each texel leaves the error of its slope, as a reader of the texture will see it, to the
 * next texel, which takes as much of it as a level there can hold.  So on gentle ground a sum is
 * never off by more than the error of one texel.
 */
#include "from_height/gradient.h"
#include "texel/level.h"

#include <math.h>

/* floor((M + 1 + M n) / 2) for n in [-1, 1].  A double is precise enough here. */
static int32_t level_of(double n, int32_t m)
{
    int32_t k = (int32_t) ((n + 1) / 2 * m + 0.5);
    return k < m ? k : m;
}

static double between(double v, double most)
{
    return v > most ? most : v < -most ? -most : v;
}

static double limited(double slope)
{
    const double steepest = 1e6; /* beyond the last level of 16 bits; its powers are no infinity */
    return between(slope, steepest);
}

/*
 * How much of the errors the slopes w can take: the step between levels there, (1 + w^2)^(3/2) /
 * (M/2).  More, as a cliff leaves it, would turn the flat texel beside it over.  Where w is so steep
 * that a step is most of it, a tenth of its length: the normal turns by some degrees.
 */
static double most_taken(const double w[2], double half)
{
    double length2 = 1 + w[0] * w[0] + w[1] * w[1], length = sqrt(length2);
    double step = length2 * length / half;
    return step < length / 10 ? step : length / 10;
}

void ntp__dither(int32_t level[3], const ntp__gradient *g, const double xy[2], double *along,
                 double *down)
{
    int32_t m = g->m;
    const double w[2] = { limited(xy[0]), limited(xy[1]) }, most = most_taken(w, m / 2.0);
    double x = w[0] + between(*along, most), y = w[1] + between(*down, most);
    double length2 = 1 + x * x + y * y, factor = 1 / sqrt(length2);
    if (factor < g->min_z)
        factor = g->shortened / sqrt(x * x + y * y);
    level[0] = level_of(x * factor, m);
    level[1] = level_of(y * factor, m);
    level[2] = ntp__derive(&level[0], &level[1], m, g->dst->encoding == NTP_ENCODING_ZZERO);
    double z = sqrt((double) ntp__rest(level[0], level[1], m));
    *along = x - ntp__num(level[0], m) / z;
    *down = y - ntp__num(level[1], m) / z;
}
