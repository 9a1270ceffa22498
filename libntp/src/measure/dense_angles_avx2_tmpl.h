/* SPDX-License-Identifier: MIT */
/*
 * dense_angles_avx2_tmpl.h - the angles of rows of cells of one v, to vectors with the derived blue; included by
 * dense_row_avx2.c, whose rows and notation these are
 *
 * With t(u) = atan2(Z, rho), where rho = |(x, y)|, the angle to the derived vector is |t(u) - t(root)|
 * above the horizon and t(u) + t(root) below it; that to the vector with the other sign of z is 2 t(u).
 * So one arc tangent serves three angles.  Each t is off by at most 1e-5 micro-degrees
 * (texel/angles_tmpl.h).  Where the sum of two lies within MARGIN = 6e-5 of the middle between two whole
 * numbers, angle.c decides.
 */

/* t(u), in micro-degrees; as in texel/angles_tmpl.h. */
ONE_COPY static void elevations(double *restrict t, double rho)
{
    for (int32_t u = 0; u < HALF; u++) {
        const double z = 2 * u + 1, low = z < rho ? z : rho, high = z < rho ? rho : z;
        const double less = low - high, more = low + high;
        const bool beyond = low > TAN_22_ * high;
        const double q = (beyond ? less : low) / (beyond ? more : high), w = q * q;
        const double w2 = w * w, w4 = w2 * w2;
        const double a = (C0 + C1 * w) + (C2 + C3 * w) * w2;
        const double c = (C4 + C5 * w) + (C6 + C7 * w) * w2;
        const double s = (a + c * w4) * q + (beyond ? 45e6 : 0.0);
        t[u] = z < rho ? s : 90e6 - s;
    }
}

/* Rounds |t(u) * times + more|; returns whether one is in doubt. */
ONE_COPY static int32_t round_sums(int32_t *restrict angle, int32_t *restrict doubt,
                                   const double *restrict t, double times, double more)
{
    int32_t any = 0;
    for (int32_t u = 0; u < HALF; u++) {
        const double up = fabs(t[u] * times + more) + (0.5 - MARGIN);
        angle[u] = (int32_t) up;
        doubt[u] = (int32_t) (up + 2 * MARGIN) - angle[u];
        any |= doubt[u];
    }
    return any;
}

/* Those of pairs that are too long, to the vector of the pulled pair. */
ONE_COPY static void pulled_angles(int32_t *angle, const dense_rows *d)
{
    int32_t r = K + d->k1, g = K + d->k2, want = -1;
    double s2[256], along[256];
    const double x = 2 * d->k1 + 1, y = 2 * d->k2 + 1;
    ntp__clean_long(&r, &g, &want, 1, M, false);
    const double w = 2 * want - M, x2 = 2 * r - M, y2 = 2 * g - M, xy = x * x2 + y * y2;
    const double square = x * x + y * y, square2 = x2 * x2 + y2 * y2 + w * w;
    for (int32_t i = 0; i < MIRRORED; i++) {
        const int32_t up = 2 * (i % HALF) + 1;
        const double z = i < BELOW ? up : -up, dot = xy + z * w;
        s2[i] = (square + z * z) * square2 - dot * dot;
        along[i] = dot;
    }
    ntp__kernels(NTP__CPU_ALL)->angles_of(angle, s2, along, MIRRORED);
}

ONE_COPY static void find_angles(int32_t *angle, const dense_rows *d)
{
    double t[HALF];
    int32_t doubt[ANGLES] = { 0 };
    const int32_t x = 2 * d->k1 + 1, y = 2 * d->k2 + 1, w = 2 * d->root + 1;
    elevations(t, sqrt(4.0 * d->v + 2.0));
    int32_t any = round_sums(angle + MIRRORED, doubt + MIRRORED, t, 2, 0);
    if (d->on_disc) {
        any |= round_sums(angle + ABOVE, doubt + ABOVE, t, 1, -t[d->root]);
        any |= round_sums(angle + BELOW, doubt + BELOW, t, 1, t[d->root]);
    } else {
        pulled_angles(angle, d);
    }
    for (int32_t i = 0; any != 0 && i < ANGLES; i++) {
        const int32_t z = 2 * (i % HALF) + 1;
        if (doubt[i] != 0)
            angle[i] = (int32_t) ntp__angle(x, y, i < BELOW ? z : -z, x, y, i < MIRRORED ? w : z);
    }
}
