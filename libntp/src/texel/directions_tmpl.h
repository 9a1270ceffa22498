/* SPDX-License-Identifier: MIT */
/*
 * directions_tmpl.h - vectors of any length to levels, fast; a part of kernels.c
 *
 * With M + 1 even, the level floor((M + 1 + M x/L)/2) is (M + 1)/2 + floor(M x/2L).  M |x|/2L is
 * taken in double, in units of 2^-15.  That is at most 2^30, and wrong by less than half a unit.
 * So only where the fraction is 0 or the last one below 1 can the floor be wrong.
 *
 * Of 8 bit, floats come first.  With u = 2^-24 the components and the sum of their squares are
 * wrong by u and 5u of themselves, so the factor is by 4.5u and the quotient by 6.5u.  Where it is
 * farther from an integer than 8u of itself its floor is right; others are done in double.
 */

enum { FRACTION = 1 << 15, LAST = FRACTION - 1 };

/* -1 where x < 0, else 0, also for -0.0: a comparison of doubles that gives integers is not
 * vectorized everywhere. */
static inline int32_t is_negative(double x)
{
    return (int32_t) copysign(1.0, x + 0.0) >> 1;
}

/* negative = -1: the floor of a negative quotient lies one below, unless the quotient is an integer. */
static inline int32_t level_of_units(int32_t units, int32_t negative, int32_t k)
{
    return k + ((units >> 15) ^ negative);
}

/* Changes no square of a vector, but that of length 0. */
#define NOTHING 0x1p-1000

static inline int32_t in_doubt(int32_t units, int32_t least)
{
    return (((units + 1) & LAST) <= 1) & (units >= least);
}

static inline void round_direction(int32_t *restrict r, int32_t *restrict g, int32_t *restrict down,
                                   int32_t *restrict doubt, const ntp__vectors *restrict v,
                                   int32_t i, int32_t m, int32_t least)
{
    const int32_t k = (m + 1) / 2;
    const double half = 0.5 * FRACTION * m;
    double x = v->c[0][i], y = v->c[1][i], z = v->c[2][i], square = x * x + y * y + z * z;
    double factor = half / sqrt(square + NOTHING);
    int32_t a = (int32_t) (fabs(x) * factor), b = (int32_t) (fabs(y) * factor);
    down[i] = is_negative(z);
    r[i] = level_of_units(a, is_negative(x), k);
    g[i] = level_of_units(b, is_negative(y), k);
    doubt[i] = in_doubt(a, least) | in_doubt(b, least);
}

ONE_COPY static void round_directions(int32_t *restrict r, int32_t *restrict g,
                                      int32_t *restrict down, int32_t *restrict doubt,
                                      const ntp__vectors *restrict v, int32_t n, int32_t m,
                                      int32_t least)
{
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++)
        round_direction(r, g, down, doubt, v, i, m, least);
}

static inline int32_t is_negative_float(float x)
{
    return (int32_t) copysignf(1.0F, x + 0.0F) >> 1;
}

/* The same of 8 bit; returns how many are in doubt. */
ONE_COPY static int32_t round_in_float(int32_t *restrict r, int32_t *restrict g,
                                       int32_t *restrict down, int32_t *restrict doubt,
                                       const ntp__vectors *restrict v, int32_t n, int32_t least)
{
    const float near = 0x1p-21F, less = least ? -0x1p-100F : 0x1p-30F; /* 0 may be exact */
    int32_t found = 0;
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const float x = (float) v->c[0][i], y = (float) v->c[1][i], z = (float) v->c[2][i];
        const float square = x * x + y * y + z * z;
        const float size = fabsf(x) + fabsf(y) + fabsf(z); /* not 0 where the square is too small */
        const float factor = 127.5F / sqrtf(square + 0x1p-100F);
        const float a = fabsf(x) * factor, b = fabsf(y) * factor;
        const float from_a = fabsf(a - (float) (int32_t) (a + 0.5F));
        const float from_b = fabsf(b - (float) (int32_t) (b + 0.5F));
        down[i] = is_negative_float(z);
        r[i] = 128 + ((int32_t) a ^ is_negative_float(x));
        g[i] = 128 + ((int32_t) b ^ is_negative_float(y));
        doubt[i] = (from_a <= a * near + less) | (from_b <= b * near + less) |
                   (square >= 0x1p100F) | ((square < 0x1p-60F) & (size != 0));
        found += doubt[i];
    }
    return found;
}

static void round_bytes(int32_t *r, int32_t *g, int32_t *down, int32_t *doubt,
                        const ntp__vectors *v, int32_t n, int32_t least)
{
    int32_t found = round_in_float(r, g, down, doubt, v, n, least);
    if (found > n / 8) { /* such as flat ones, twice as strong */
        round_directions(r, g, down, doubt, v, n, 255, least);
        return;
    }
    for (int32_t i = 0; found > 0 && i < n; i++) {
        found -= doubt[i];
        if (doubt[i])
            round_direction(r, g, down, doubt, v, i, 255, least);
    }
}

static inline int32_t derive_directions(int32_t *restrict b, int32_t *restrict doubt,
                                        const int32_t *restrict down, const int32_t *restrict r,
                                        const int32_t *restrict g, int32_t n, int32_t m,
                                        int32_t zzero)
{
    int32_t k = (m + 1) / 2, any = 0;
    int32_t e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    for (int32_t i = 0; i < n; i++) {
        int32_t a = r[i] - k, c = g[i] - k;
        int32_t e = e0 - a * (a + 1) - c * (c + 1);
        int32_t z = blue(e < 0 ? 0 : e, k, zzero);
        b[i] = !zzero && down[i] ? m - z : z;
        doubt[i] |= e < 0 ? NTP__OVERLONG : 0;
        any |= doubt[i];
    }
    return any;
}

/* Works on whole lanes; vectors beyond n become 0. */
static int32_t directions(int32_t *r, int32_t *g, int32_t *b, int32_t *doubt, ntp__vectors *v,
                          int32_t n, int32_t m, int32_t zzero, int32_t exact)
{
    int32_t down[256], filled = (n + LANES - 1) / LANES * LANES;
    for (int k = 0; k < 3; k++)
        memset(v->c[k] + n, 0, (size_t) (filled - n) * sizeof v->c[k][0]);
    if (FLOATS && m == 255)
        round_bytes(r, g, down, doubt, v, filled, exact ? 1 : 0);
    else
        round_directions(r, g, down, doubt, v, filled, m, exact ? 1 : 0);
    return zzero ? derive_directions(b, doubt, down, r, g, filled, m, 1)
                 : derive_directions(b, doubt, down, r, g, filled, m, 0);
}
