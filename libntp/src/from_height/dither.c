/* SPDX-License-Identifier: MIT */
/*
 * dither.c - rounding that keeps the sum of slopes: one texel
 *
 * The difference in height of two texels is a sum of slopes, so rounding errors add up along a row.
 * Here each texel leaves the error of its slope, as a reader of the texture will see it, to the
 * next texel.  So a sum is never off by more than the error of one texel.
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

/*
 * The error of a slope w = n.x / n.z that is stored as `got`.  If a slope is too steep for every
 * level, the error would grow with each texel.  So it is held to the step between levels there,
 * (1 + w^2)^(3/2) / (M/2).
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
