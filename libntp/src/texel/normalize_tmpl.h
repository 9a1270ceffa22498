/* SPDX-License-Identifier: MIT */
/*
 * normalize_tmpl.h - levels over the length of their vector; a part of kernels.c, which includes it
 * for each type REAL
 *
 * The levels are found as in directions_tmpl.h, blue too, in units of 1/STEPS.  The numerators of a
 * vector are odd.  So no unit is 0, and the three squares have an exact sum.  A quotient is wrong by
 * at most three roundings: in float, where M is 255, it is below 2^20 units and wrong by less than
 * a quarter of one.
 */
ONE_COPY static int32_t FOR_REAL(normalize)(int32_t *restrict to_r, int32_t *restrict to_g,
                                            int32_t *restrict to_b, int32_t *restrict doubt,
                                            const int32_t *restrict r, const int32_t *restrict g,
                                            const int32_t *restrict b, int32_t n, int32_t m)
{
    const int32_t k = (m + 1) / 2;
    const uint32_t am = (uint32_t) k * (uint32_t) (k - 1);
    const REAL half = (REAL) (0.5 * STEPS * m);
    int32_t any = 0;
    n = (n + LANES - 1) / LANES * LANES;
    for (int32_t i = 0; i < n; i++) {
        int32_t p = r[i] - k, q = g[i] - k, s = b[i] - k;
        REAL x = (REAL) (2 * p + 1), y = (REAL) (2 * q + 1), z = (REAL) (2 * s + 1);
        REAL factor = half / SQRT(x * x + y * y + z * z);
        int32_t u = (int32_t) (ABS(x) * factor), v = (int32_t) (ABS(y) * factor);
        int32_t w = (int32_t) (ABS(z) * factor);
        /* as in judge_standard */
        uint32_t ks = (uint32_t) (half_up(p) + half_up(q) + half_up(s));
        uint32_t a = (uint32_t) (p * (p + 1) + q * (q + 1)) + (uint32_t) (s * (s + 1));
        uint32_t rounded = (a + 3 <= am + ks) & (a + ks > am);
        int32_t odd = (((u + 1) & (STEPS - 1)) <= 1) | (((v + 1) & (STEPS - 1)) <= 1) |
                      (((w + 1) & (STEPS - 1)) <= 1);
        to_r[i] = rounded ? r[i] : k + (u / STEPS ^ -(p < 0));
        to_g[i] = rounded ? g[i] : k + (v / STEPS ^ -(q < 0));
        to_b[i] = rounded ? b[i] : k + (w / STEPS ^ -(s < 0));
        doubt[i] = rounded ? 0 : odd;
        any |= doubt[i];
    }
    return any;
}
