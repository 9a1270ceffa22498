/* SPDX-License-Identifier: MIT */
/*
 * angles_tmpl.h - angles between the vectors of two blocks; a part of kernels.c
 *
 * The same micro-degrees as angle.c gives, with one quotient and no table.  With a = |d|, the
 * fraction min(s, a)/max(s, a) or, beyond tan(22.5 degrees), 45 degrees less, is at most
 * tan(22.5 degrees), and a polynomial of 8 terms gives its arc tangent to 0.9e-5 micro-degrees.
 * Roundings of doubles add less than 1e-6, in angle.c too.  So an angle that lies MARGIN or more
 * from the middle between two whole ones is rounded as there; others are done again by angle.c.
 *
 * Levels of 8 bits have products and sums below 2^18: floats hold them, and doubles hold
 * s^2 = |v|^2 |w|^2 - d^2.  Of 16 bits doubles hold the components of the product vector.
 */
#include "texel/angle_series.h"

static inline int32_t numerator(int32_t level, int32_t doubled, int32_t less)
{
    return level + (level & doubled) - less;
}

#define NUMERATORS(real)                                                                           \
    const real x1 = (real) numerator(r1[i], f.doubled, f.less);                                    \
    const real y1 = (real) numerator(g1[i], f.doubled, f.less);                                    \
    const real z1 = (real) numerator(b1[i], f.doubled_z, f.less_z);                                \
    const real x2 = (real) numerator(r2[i], h.doubled, h.less);                                    \
    const real y2 = (real) numerator(g2[i], h.doubled, h.less);                                    \
    const real z2 = (real) numerator(b2[i], h.doubled_z, h.less_z)

/* The squares of s, and d. */
ONE_COPY static void products(double *restrict s2, double *restrict d,
                              const ntp__numbers *restrict v, const ntp__numbers *restrict w,
                              int32_t n)
{
    const ntp__numbers f = *v, h = *w;
    const int32_t *restrict r1 = f.c[0], *restrict g1 = f.c[1], *restrict b1 = f.c[2];
    const int32_t *restrict r2 = h.c[0], *restrict g2 = h.c[1], *restrict b2 = h.c[2];
    n = whole_lanes(n);
    if (FLOATS && f.m == 255 && h.m == 255) {
        for (int32_t i = 0; i < n; i++) {
            NUMERATORS(float);
            const double k = x1 * x1 + y1 * y1 + z1 * z1, l = x2 * x2 + y2 * y2 + z2 * z2;
            const double dot = x1 * x2 + y1 * y2 + z1 * z2;
            s2[i] = k * l - dot * dot;
            d[i] = dot;
        }
        return;
    }
    for (int32_t i = 0; i < n; i++) {
        NUMERATORS(double);
        const double x = y1 * z2 - z1 * y2, y = z1 * x2 - x1 * z2, z = x1 * y2 - y1 * x2;
        s2[i] = x * x + y * y + z * z;
        d[i] = x1 * x2 + y1 * y2 + z1 * z2;
    }
}

/* Angles of atan2(s, d) in micro-degrees; returns whether one is in doubt. */
ONE_COPY static int32_t round_angles(int32_t *restrict angle, int32_t *restrict doubt,
                                     const double *restrict s2, const double *restrict d, int32_t n)
{
    int32_t any = 0;
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const double s = sqrt(s2[i]), a = fabs(d[i]);
        const double low = s < a ? s : a, high = s < a ? a : s;
        const double less = low - high, more = low + high;
        const bool beyond = low > TAN_22_ * high;
        const double u = (beyond ? less : low) / (beyond ? more : high), w = u * u;
        /* In pairs, which wait for each other less than one term after the other would. */
        const double w2 = w * w, w4 = w2 * w2;
        const double p = (C0 + C1 * w) + (C2 + C3 * w) * w2;
        const double q = (C4 + C5 * w) + (C6 + C7 * w) * w2;
        double t = (p + q * w4) * u + (beyond ? 45e6 : 0.0);
        t = s < a ? t : 90e6 - t;
        t = (d[i] < 0 ? 180e6 - t : t) + (0.5 - MARGIN);
        angle[i] = (int32_t) t;
        doubt[i] = (int32_t) (t + 2 * MARGIN) - angle[i];
        any |= doubt[i];
    }
    return any;
}

/* Those of n <= 256; changes s2 and d beyond n, up to whole lanes. */
static void angles_of(int32_t *angle, double *s2, double *d, int32_t n)
{
    int32_t doubt[256];
    const int32_t filled = (n + LANES - 1) / LANES * LANES;
    for (int32_t i = n; i < filled; i++) {
        s2[i] = 0;
        d[i] = 1;
    }
    if (round_angles(angle, doubt, s2, d, filled) == 0)
        return;
    for (int32_t i = 0; i < n; i++) {
        if (doubt[i] != 0)
            angle[i] = (int32_t) (ntp__radians(sqrt(s2[i]), d[i]) * (180e6 / NTP__PI) + 0.5);
    }
}

static void angles(int32_t *angle, const ntp__numbers *v, const ntp__numbers *w, int32_t n)
{
    double s2[256], d[256];
    const int32_t filled = (n + LANES - 1) / LANES * LANES;
    for (int32_t i = n; i < filled; i++) {
        for (int k = 0; k < 3; k++) {
            v->c[k][i] = v->less == 0;
            w->c[k][i] = w->less == 0;
        }
    }
    products(s2, d, v, w, filled);
    angles_of(angle, s2, d, n);
}

#undef NUMERATORS
