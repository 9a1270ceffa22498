/* SPDX-License-Identifier: MIT */
/*
 * dither.c - rounding that keeps the sum of slopes: one texel
 *
 * The height between two texels is a sum of slopes, so their rounding errors add up along a row.
 * Here the error of a slope, as a reader of the texture will see it, goes to the next texel: the
 * sum is then off by one texel's error only, anywhere.
 */
#include "from_height/gradient.h"
#include "texel/level.h"

#include <math.h>

/* floor((M + 1 + M n) / 2) for n in [-1, 1]; a double is near enough here. */
static int32_t level_of(double n, int32_t m)
{
    int32_t k = (int32_t) ((n + 1) / 2 * m + 0.5);
    return k < m ? k : m;
}

/*
 * What is left of a wanted component w = n.x / n.z when `got` is stored.  A slope so steep that no
 * level stands for it would leave more with each texel: what is left is held to the step between
 * levels there, (1 + w^2)^(3/2) / (M/2).
 */
static double left(double want, double got, double length2, double half)
{
    double step = length2 * sqrt(length2) / half, rest = want - got;
    return rest > step ? step : rest < -step ? -step : rest == rest ? rest : 0;
}

void ntp__dither(int32_t level[3], const ntp__gradient *g, const double xy[2], double *along,
                 double *down)
{
    const double steepest = 1e6; /* beyond the last level of 16 bits; its square is no infinity */
    int32_t m = g->m;
    double x = xy[0] + *along, y = xy[1] + *down, half = m / 2.0;
    x = x > steepest ? steepest : x < -steepest ? -steepest : x;
    y = y > steepest ? steepest : y < -steepest ? -steepest : y;
    double length2 = 1 + x * x + y * y, factor = 1 / sqrt(length2);
    if (factor < g->min_z)
        factor = g->shortened / sqrt(x * x + y * y);
    level[0] = level_of(x * factor, m);
    level[1] = level_of(y * factor, m);
    level[2] = ntp__derive(&level[0], &level[1], m, g->dst->encoding == NTP_ENCODING_ZZERO);
    double z = sqrt((double) ntp__rest(level[0], level[1], m));
    *along = left(x, ntp__num(level[0], m) / z, length2, half);
    *down = left(y, ntp__num(level[1], m) / z, length2, half);
}
