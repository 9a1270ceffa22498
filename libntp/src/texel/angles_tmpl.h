/* SPDX-License-Identifier: MIT */
/*
 * angles_tmpl.h - angles between the vectors of two blocks; a part of kernels.c
 *
 * The same operations on doubles in the same order as in angle.c, so the same micro-degrees.
 * Levels have 16 bits, so doubles hold all products.
 */
static void sines_and_cosines(double *restrict s, double *restrict d,
                              const ntp__vectors *restrict v, const ntp__vectors *restrict w,
                              int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        double x1 = v->c[0][i], y1 = v->c[1][i], z1 = v->c[2][i];
        double x2 = w->c[0][i], y2 = w->c[1][i], z2 = w->c[2][i];
        double cx = y1 * z2 - z1 * y2, cy = z1 * x2 - x1 * z2, cz = x1 * y2 - y1 * x2;
        s[i] = sqrt(cx * cx + cy * cy + cz * cz);
        d[i] = x1 * x2 + y1 * y2 + z1 * z2;
    }
}

/* The angle is start + turn (atan(eighth / 8) + rest). */
static void reduce(int32_t *restrict eighth, double *restrict rest, double *restrict start,
                   double *restrict turn, const double *restrict s, const double *restrict d,
                   int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        double a = fabs(d[i]), t = (s[i] < a ? s[i] : a) / (s[i] < a ? a : s[i]);
        int32_t k = (int32_t) (t * 8.0 + 0.5);
        double c = k * 0.125, u = (t - c) / (1.0 + t * c), u2 = u * u;
        double series = 1.0 + u2 * (-1.0 / 3 + u2 * (1.0 / 5 + u2 * (-1.0 / 7 + u2 * (1.0 / 9))));
        double side = d[i] < 0 ? -1.0 : 1.0;
        eighth[i] = k;
        rest[i] = u * series;
        start[i] = s[i] > a ? NTP__PI / 2 : d[i] < 0 ? NTP__PI : 0.0;
        turn[i] = s[i] > a ? -side : side;
    }
}

static void angles(int32_t *angle, ntp__vectors *v, ntp__vectors *w, int32_t n)
{
    double s[256], d[256], rest[256], start[256], turn[256];
    const int32_t filled = (n + LANES - 1) / LANES * LANES;
    for (int32_t i = n; i < filled; i++) {
        for (int k = 0; k < 3; k++)
            v->c[k][i] = w->c[k][i] = 1;
    }
    sines_and_cosines(s, d, v, w, filled);
    reduce(angle, rest, start, turn, s, d, filled);
    for (int32_t i = 0; i < filled; i++)
        rest[i] = ntp__atan_eighths[angle[i]] + rest[i];
    for (int32_t i = 0; i < filled; i++)
        angle[i] = (int32_t) ((start[i] + turn[i] * rest[i]) * (180e6 / NTP__PI) + 0.5);
}
