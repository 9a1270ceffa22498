/* SPDX-License-Identifier: MIT */
/*
 * normalize_tmpl.h - levels over the length of their vector; a part of kernels.c
 *
 * The levels are found as in directions_tmpl.h, blue too.  The numerators of a vector are odd, so no
 * quotient is 0, and their squares have the sum 8 h + 3.  Floats decide in units of 2^-13 of a level
 * at 8 bit, where the sum is exact, and else in units of 2^-7.  What is in doubt at 16 bit is decided
 * once more, in doubles.
 *
 * With u = 2^-24 floats are off by this much: 8 h + 3 by at most 1.4 u (where h >= 2^24 has to be
 * rounded, adding 3/8 rounds to the same number), its root by 0.7 u more than its own rounding, and
 * the quotient and the product by u each: 3.7 u of at most 2^22 units.  That is less than one.  (At 8
 * bit it is 3 u of 2^20 units.)
 */
enum { UNITS_8 = 13, UNITS_16 = 7, UNITS_DOUBLE = 15 };

/* Where the units are next to a whole level, the level may be wrong. */
static inline int32_t near_level(int32_t units, int32_t bits)
{
    return ((units + 1) & ((1 << bits) - 1)) <= 1;
}

/* `low` is the greatest blue to be mirrored; whole lanes. */
ONE_COPY static int32_t normalize_floats(int32_t *restrict to_r, int32_t *restrict to_g,
                                         int32_t *restrict to_b, int32_t *restrict doubt,
                                         const int32_t *restrict r, const int32_t *restrict g,
                                         const int32_t *restrict b, int32_t n, int32_t m,
                                         int32_t low, int32_t *restrict changed)
{
    const int32_t k = (m + 1) / 2, bits = m == 255 ? UNITS_8 : UNITS_16, half_am = k / 2 * (k - 1);
    const float half = 0.5F * (float) (m << bits);
    int32_t any = 0, count = 0;
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const int32_t up = b[i] <= low ? m - b[i] : b[i];
        const int32_t p = r[i] - k, q = g[i] - k, s = up - k;
        /* The products are even, and half their sum has 31 bits. */
        const int32_t h =
            (int32_t) ((uint32_t) (p * (p + 1) + q * (q + 1)) / 2 + (uint32_t) (s * (s + 1)) / 2);
        const float factor = half / sqrtf(8.0F * ((float) h + 0.375F));
        const int32_t x = 2 * p + 1, y = 2 * q + 1, z = 2 * s + 1;
        const int32_t u = (int32_t) (fabsf((float) x) * factor);
        const int32_t v = (int32_t) (fabsf((float) y) * factor);
        const int32_t w = (int32_t) (fabsf((float) z) * factor);
        /* as in judge_standard, all halved */
        const int32_t ks = half_up(p) + half_up(q) + half_up(s), off = 2 * (h - half_am);
        const int32_t rounded = (off + 3 <= ks) & (off > -ks);
        const int32_t odd = near_level(u, bits) | near_level(v, bits) | near_level(w, bits);
        const int32_t red = rounded ? r[i] : k + (u >> bits ^ -(p < 0));
        const int32_t green = rounded ? g[i] : k + (v >> bits ^ -(q < 0));
        const int32_t blue = rounded ? up : k + (w >> bits ^ -(s < 0));
        const int32_t in_doubt = rounded ? 0 : odd;
        to_r[i] = red;
        to_g[i] = green;
        to_b[i] = blue;
        doubt[i] = in_doubt;
        any |= in_doubt;
        const int32_t differs = (red ^ r[i]) | (green ^ g[i]) | (blue ^ b[i]);
        count += differs != 0;
    }
    *changed += count;
    return any;
}

/* Vectors that are not rounded ones, in place; whole lanes. */
ONE_COPY static int32_t normalize_doubles(int32_t *restrict r, int32_t *restrict g,
                                          int32_t *restrict b, int32_t *restrict doubt, int32_t n,
                                          int32_t m)
{
    const int32_t k = (m + 1) / 2;
    const double half = 0.5 * (1 << UNITS_DOUBLE) * m;
    int32_t any = 0;
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const int32_t p = r[i] - k, q = g[i] - k, s = b[i] - k;
        const double x = 2 * p + 1, y = 2 * q + 1, z = 2 * s + 1;
        const double factor = half / sqrt(x * x + y * y + z * z);
        const int32_t u = (int32_t) (fabs(x) * factor), v = (int32_t) (fabs(y) * factor);
        const int32_t w = (int32_t) (fabs(z) * factor);
        r[i] = k + (u >> UNITS_DOUBLE ^ -(p < 0));
        g[i] = k + (v >> UNITS_DOUBLE ^ -(q < 0));
        b[i] = k + (w >> UNITS_DOUBLE ^ -(s < 0));
        doubt[i] =
            near_level(u, UNITS_DOUBLE) | near_level(v, UNITS_DOUBLE) | near_level(w, UNITS_DOUBLE);
        any |= doubt[i];
    }
    return any;
}

static int32_t normalize(int32_t *const to[3], int32_t *doubt, int32_t *const from[3], int32_t n,
                         int32_t m, int32_t low, int32_t *changed)
{
    int32_t at[256 + LANES], few[3][256], still[256];
    n = whole_lanes(n + LANES - 1);
    int32_t any =
        normalize_floats(to[0], to[1], to[2], doubt, from[0], from[1], from[2], n, m, low, changed);
    if (m == 255 || any == 0)
        return any;
    const int32_t found = find(at, doubt, 1, n), filled = whole_lanes(found + LANES - 1);
    memset(at + found, 0, LANES * sizeof at[0]);
    for (int32_t i = 0; i < filled; i++) {
        const int32_t j = at[i], b = from[2][j];
        few[0][i] = from[0][j];
        few[1][i] = from[1][j];
        few[2][i] = b <= low ? m - b : b;
    }
    any = normalize_doubles(few[0], few[1], few[2], still, filled, m);
    for (int32_t i = 0; i < found; i++) {
        const int32_t j = at[i], r = few[0][i], g = few[1][i], b = few[2][i];
        const int32_t from_r = from[0][j], from_g = from[1][j], from_b = from[2][j];
        *changed -= (to[0][j] != from_r) | (to[1][j] != from_g) | (to[2][j] != from_b);
        *changed += (r != from_r) | (g != from_g) | (b != from_b);
        to[0][j] = r;
        to[1][j] = g;
        to[2][j] = b;
        doubt[j] = still[i];
    }
    return any;
}
