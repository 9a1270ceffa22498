/* SPDX-License-Identifier: MIT */
/*
 * angle.c - angles between vectors of integers, the same on every system
 *
 * The angle is atan2(|a x b|, a . b), and the products are exact.  The arc tangent of t in 0..1 is
 * expanded about the nearest i/8: atan(t) = atan(i/8) + atan(u), u = (t - i/8)/(1 + t i/8).  There
 * |u| <= 1/16, so the series to u^9 is off by less than 1/16^11/11 = 6e-15 radians.
 */
#include "texel/angle.h"

#include <math.h>
#include <string.h>

const double ntp__atan_eighths[9] = {
    0.0,
    0.12435499454676143503,
    0.24497866312686415417,
    0.35877067027057222040,
    0.46364760900080611621,
    0.55859931534356243597,
    0.64350110879328438680,
    0.71882999962162450542,
    0.78539816339744830962,
};

static double arc_tangent(double t)
{
    int i = (int) (t * 8.0 + 0.5);
    double c = i * 0.125;
    double u = (t - c) / (1.0 + t * c), u2 = u * u;
    double series = 1.0 + u2 * (-1.0 / 3 + u2 * (1.0 / 5 + u2 * (-1.0 / 7 + u2 * (1.0 / 9))));
    return ntp__atan_eighths[i] + u * series;
}

double ntp__radians(double s, double d)
{
    if (s <= d)
        return arc_tangent(s / d);
    if (d <= -s)
        return NTP__PI - arc_tangent(s / -d);
    return NTP__PI / 2 - (d < 0 ? -arc_tangent(-d / s) : arc_tangent(d / s));
}

uint32_t ntp__angle(int64_t x1, int64_t y1, int64_t z1, int64_t x2, int64_t y2, int64_t z2)
{
    double cx = (double) (y1 * z2 - z1 * y2), cy = (double) (z1 * x2 - x1 * z2);
    double cz = (double) (x1 * y2 - y1 * x2);
    double s = sqrt(cx * cx + cy * cy + cz * cz);
    double d = (double) (x1 * x2 + y1 * y2 + z1 * z2);
    return (uint32_t) (ntp__radians(s, d) * (180e6 / NTP__PI) + 0.5);
}

void ntp__angles_clear(ntp__angle_sums *angles)
{
    /* The bins above the greatest angle are empty. */
    memset(angles->bins, 0, ((angles->max + 500) / 1000 + 1) * sizeof angles->bins[0]);
    angles->texels = angles->sum = angles->max = 0;
}

void ntp__angles_merge(ntp__angle_sums *into, const ntp__angle_sums *from)
{
    into->texels += from->texels;
    into->sum += from->sum;
    if (from->max > into->max)
        into->max = from->max;
    for (uint64_t i = 0; i <= (from->max + 500) / 1000; i++)
        into->bins[i] += from->bins[i];
}

enum { RUN = 64 }; /* bins */

void ntp__angles_describe(ntp_angles *out, const ntp__angle_sums *sums)
{
    out->texels = sums->texels;
    out->mean = out->p99 = 0;
    out->max = (double) sums->max / 1e6;
    if (sums->texels == 0)
        return;
    out->mean = (double) sums->sum / (double) sums->texels / 1e6;
    /* From the greatest angle down; `up_to` have at most this one. */
    const uint64_t rank = (sums->texels * 99 + 99) / 100;
    uint64_t i = (sums->max + 500) / 1000, up_to = sums->texels;
    /* A few turned texels leave long runs of empty bins. */
    while (i >= RUN) {
        uint32_t run = 0; /* of texels, which are fewer than 2^32 */
        for (uint64_t k = 0; k < RUN; k++)
            run += sums->bins[i - k];
        if (up_to - run < rank)
            break;
        up_to -= run;
        i -= RUN;
    }
    while (i > 0 && up_to - sums->bins[i] >= rank)
        up_to -= sums->bins[i--];
    out->p99 = (double) i / 1000.0;
}
