/* SPDX-License-Identifier: MIT */
/*
 * judge_tmpl.h - judges texels for a measurement, in both encodings; a part of kernels.c
 *
 * Standard.  With A = k(k - 1) a square is 4A + 1.  One level further in or out it is
 * 4(A - 2(k - 1)) + 1 or 4(A + 2k) + 1.  Half a level further it is 4(k - 1)^2 = 4(A - (k - 1)) or
 * 4k^2 = 4(A + k).  M*M = 4 A_M + 1.
 *
 * Z-zero.  The square of blue is compared with 4e + 3, where e is made of x and y alone.  Half a
 * level in or out it is compared with 4q + 1.  Both fit into 32 bits unsigned if not negative.
 */

/* Extremes and sums, one plane after the other; then the texels that need more than count_wide. */
static void survey(ntp__survey *s, int32_t *r, int32_t *g, int32_t *b, int32_t n)
{
    enum { FLAT = 32767 }; /* and one more */
    int32_t *const planes[3] = { r, g, b };
    const int32_t filled = whole_lanes(n + LANES - 1);
    uint32_t odd = 0;
    for (int32_t k = 0; k < 3; k++) {
        int32_t *const c = planes[k];
        int32_t least = INT32_MAX, greatest = 0, sum = 0;
        for (int32_t i = n; i < filled; i++)
            c[i] = c[n - 1];
        for (int32_t i = 0; i < filled; i++) {
            least = c[i] < least ? c[i] : least;
            greatest = c[i] > greatest ? c[i] : greatest;
            sum += c[i];
        }
        s->least[k] = (uint32_t) least;
        s->greatest[k] = (uint32_t) greatest;
        s->sum[k] = (uint32_t) (sum - (filled - n) * c[n - 1]);
    }
    for (int32_t i = 0; i < filled; i++) {
        const int32_t narrow =
            (((r[i] >> 8) ^ r[i]) | ((g[i] >> 8) ^ g[i]) | ((b[i] >> 8) ^ b[i])) & 255;
        const int32_t from_flat = (r[i] - FLAT) | (g[i] - FLAT); /* both are 0 or 1? */
        odd |= (uint32_t) ((narrow == 0) | (((r[i] ^ g[i]) | (g[i] ^ b[i])) == 0) |
                           ((from_flat & ~1) == 0));
    }
    s->odd = odd;
}

/*
 * x(x + 1) + y(y + 1), and what is made of red and green alone: steepness and flags.  With this v,
 * rho*rho = 4v + 2 and M*M = 4 A_M + 1.  So rho is at least k/8 of M where v is at least
 * k*k A_M/64, a whole number; rho itself is never k/8 of M.
 */
ONE_COPY static void judge_pairs(int32_t *restrict xy, int32_t *restrict common,
                                 const int32_t *restrict r, const int32_t *restrict g, int32_t n,
                                 int32_t m)
{
    n = whole_lanes(n);
    /* ntp__is_padding: 16 levels of 8 bit from an end */
    const int32_t low = m == 255 ? 16 : 16 * 257 - 128, high = m - low;
    const int32_t k0 = (m + 1) / 2, am = k0 * (k0 - 1), a = am / 64;
    const int32_t far = (int32_t) ((NTP__FAR_SQUARED * ((double) m * m) - 2) / 4);
    for (int32_t i = 0; i < n; i++) {
        const int32_t x = r[i] - k0, y = g[i] - k0, v = x * (x + 1) + y * (y + 1);
        const int32_t padding = ((r[i] < low) | (r[i] > high)) & ((g[i] < low) | (g[i] > high));
        int32_t bin = (v >= a) + (v >= 4 * a) + (v >= 9 * a) + (v >= 16 * a) + (v >= 25 * a) +
                      (v >= 36 * a) + (v >= 49 * a);
        bin = padding ? NTP__PADDING_BIN : bin;
        xy[i] = v;
        common[i] = bin * 256 | (v > far ? NTP__FAR : 0) | (v >= am ? NTP_FLAG_XY_TOO_LONG : 0);
    }
}

/* Verdicts, signs, and how far blue is off; `want` is the blue of the encoding of the angles. */
ONE_COPY static void judge_levels(int32_t *restrict std, int32_t *restrict off_std,
                                  int32_t *restrict zz, int32_t *restrict off_zz,
                                  int32_t *restrict want, const int32_t *restrict pairs,
                                  const int32_t *restrict common, const int32_t *restrict r,
                                  const int32_t *restrict g, const int32_t *restrict b, int32_t n,
                                  int32_t m, int32_t zzero)
{
    n = whole_lanes(n);
    const int32_t k0 = (m + 1) / 2, e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    const uint32_t am = (uint32_t) k0 * (uint32_t) (k0 - 1);
    for (int32_t i = 0; i < n; i++) {
        const int32_t x = r[i] - k0, y = g[i] - k0, z = b[i] - k0, up = z < 0 ? m - b[i] : b[i];
        const int32_t xy = pairs[i], e = e0 - xy, in = e >= 0;
        const int32_t root = ntp__root30(in ? e : 0), d = e - root * root, w = k0 + root;
        const int32_t v = 2 * root + (2 * d + 1 >= root) + (2 * d >= 3 * root); /* as in blue() */
        const uint32_t kxy = (uint32_t) (half_up(x) + half_up(y)), k = kxy + (uint32_t) half_up(z);
        const uint32_t a = (uint32_t) xy + (uint32_t) (z * (z + 1));
        /* 4(a - 2(k - 3)) + 3 <= 4 am + 1 <= 4(a + 2k) + 3, and 4(a - k + 3) <= 4 am + 1 <= 4(a +
         * k); the square of the length is 4a + 3 */
        std[i] = (int32_t) (((a + 6 < am + 2 * k) & (a + 2 * k >= am)) * NTP_FLAG_NEIGHBOR |
                            ((a + 3 <= am + k) & (a + k > am)) * NTP_FLAG_ROUNDED |
                            (uint32_t) (in & (b[i] == w)) * NTP_FLAG_EXACT |
                            (uint32_t) (in & (m - b[i] == w)) * NTP__MIRRORED |
                            (uint32_t) (z < 0) * NTP_FLAG_Z_NEGATIVE |
                            (uint32_t) (a >= am) * NTP__LONG | (uint32_t) common[i]);
        /* (u - 1)^2 is 1, not 0, where u is 0: both are below 4 e_in + 3 */
        const uint32_t u = (uint32_t) b[i], u2 = u * u;
        const int32_t e_in = e + 2 * ((int32_t) kxy - 2), e_out = e - 2 * (int32_t) kxy;
        /* q = (M*M - 1)/4 - sum of k*k (out) or of (k - 1)^2 (in) */
        const int32_t q_in = e + ((int32_t) kxy - 1), q_out = e + 1 - (int32_t) kxy;
        uint32_t neighbor = (e_in >= 0) & (u2 - 2 * u + 1 <= 4 * (uint32_t) e_in + 3);
        uint32_t rounded = (q_in >= 0) & (u2 - u <= 4 * (uint32_t) q_in);
        neighbor &= (e_out < 0) | (u2 + 2 * u >= 4 * (uint32_t) e_out + 2);
        rounded &= (q_out < 0) | (u2 + u >= 4 * (uint32_t) q_out + 1);
        zz[i] = (int32_t) (neighbor * NTP_FLAG_NEIGHBOR | rounded * NTP_FLAG_ROUNDED |
                           (uint32_t) (in & (b[i] == v)) * NTP_FLAG_EXACT |
                           (uint32_t) ((e < 0) | (u2 >= 4 * (uint32_t) e + 4)) * NTP__LONG |
                           (uint32_t) common[i]);
        off_std[i] = !in ? NTP__NO_BLUE : up < w ? w - up : up - w;
        off_zz[i] = !in ? NTP__NO_BLUE : b[i] < v ? v - b[i] : b[i] - v;
        want[i] = !in ? -1 : zzero ? v : w;
    }
}

/* Blue as a numerator; without a condition, for which loops would be made twice. */
static inline int32_t upward(int32_t b, int32_t m, int32_t zzero)
{
    return b + (b & (zzero - 1)) - m * (1 - zzero);
}

static void judge_lengths_slowly(int32_t *restrict length, const int32_t *restrict xy,
                                 const int32_t *restrict b, int32_t n, int32_t m, int32_t zzero)
{
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const double z = upward(b[i], m, zzero);
        length[i] = ntp__fixed_length(4.0 * xy[i] + 2.0 + z * z, m);
    }
}

/*
 * The lengths, in floats.  With k next to the root of s, that is k + (s - k*k)/(root + k).  There
 * s - k*k is exact even if 32 bits do not hold s, and a root in float is enough for the sum.  So
 * what lies beyond the whole number k * `whole` is off by less than 2^-19 at 16 bit, and 2^-13 at
 * 8.  Returns whether a length is nearly that close to the middle between two.
 */
static int32_t judge_lengths_quickly(int32_t *restrict length, const int32_t *restrict xy,
                                     const int32_t *restrict b, int32_t n, int32_t m, int32_t zzero)
{
    n = whole_lanes(n);
    const int32_t whole = NTP__LENGTH_ONE / m, bias = m == 255 ? 256 : 4;
    const float more = 1.0f / (float) m, by = (float) NTP__LENGTH_ONE / (float) m;
    const float half = (float) bias + 0.5f, doubt = m == 255 ? 0x1p-12f : 0x1p-16f;
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t z = upward(b[i], m, zzero);
        const float root = sqrtf(4.0f * (float) xy[i] + 2.0f + (float) z * (float) z);
        const int32_t k = (int32_t) (root + 0.5f);
        const uint32_t square = 4 * (uint32_t) xy[i] + 2 + (uint32_t) z * (uint32_t) z;
        const float rest = (float) (int32_t) (square - (uint32_t) k * (uint32_t) k);
        const float beyond = (float) k * more + rest / (root + (float) k) * by + half;
        const int32_t down = (int32_t) beyond;
        const float part = beyond - (float) down;
        any |= (part < doubt) | (part > 1.0f - doubt);
        length[i] = k * whole + down - bias;
    }
    return any;
}

ONE_COPY static void judge_lengths(int32_t *restrict length, const int32_t *restrict xy,
                                   const int32_t *restrict b, int32_t n, int32_t m, int32_t zzero)
{
    if (judge_lengths_quickly(length, xy, b, n, m, zzero))
        judge_lengths_slowly(length, xy, b, n, m, zzero);
}

/* The sums and extremes of a block, with off[i], how far the length is from 1. */
ONE_COPY static void sum_lengths(ntp__judged_fit *restrict fit, const uint32_t *restrict count,
                                 int32_t n)
{
    n = whole_lanes(n);
    int32_t least = INT32_MAX, greatest = 0, most = 0, every = -1, some = 0;
    uint64_t sum = 0, all = 0, of_padding = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t length = fit->length[i], off = length - NTP__LENGTH_ONE;
        const int32_t levels = fit->levels_off[i] == NTP__NO_BLUE ? 0 : fit->levels_off[i];
        least = length < least ? length : least;
        greatest = length > greatest ? length : greatest;
        most = levels > most ? levels : most;
        every &= fit->key[i];
        some |= fit->key[i];
        fit->off[i] = (uint32_t) (off < 0 ? -off : off);
    }
    for (int32_t i = 0; i < n; i++) {
        const uint64_t off = fit->off[i], times = count[i];
        const uint64_t squares = (uint32_t) (off * off) * times;
        sum += (uint32_t) fit->length[i] * times;
        all += squares;
        of_padding += fit->key[i] >= NTP__PADDING_BIN * 256 ? squares : 0;
    }
    fit->length_sum = sum;
    fit->length_error2[0] = all - of_padding;
    fit->length_error2[1] = of_padding;
    fit->least = (uint32_t) least;
    fit->greatest = (uint32_t) greatest;
    fit->levels_off_max = (uint32_t) most;
    fit->every = (uint32_t) every;
    fit->some = (uint32_t) some;
}

/*
 * A vector and the cleaned vector differ in z alone where x, y are not too long.  So with
 * rho = |(x, y)| the tangent of the angle between them is rho |z - z'| / (rho*rho + z z').
 * Where `want` is negative there is none, and the angle is -1, as where it is in doubt.
 */
ONE_COPY static void turn_angles(int32_t *restrict angle, const int32_t *restrict xy,
                                 const int32_t *restrict b, const int32_t *restrict want, int32_t n,
                                 int32_t m, int32_t zzero)
{
    double s2[256], d[256];
    int32_t doubt[256];
    n = whole_lanes(n + LANES - 1);
    if (n <= 0)
        return;
    for (int32_t i = 0; i < n; i++) {
        const double z = upward(b[i], m, zzero), w = upward(want[i], m, zzero);
        const double rho2 = 4.0 * xy[i] + 2.0;
        s2[i] = rho2 * (z - w) * (z - w);
        d[i] = rho2 + z * w;
    }
    round_angles(angle, doubt, s2, d, n);
    for (int32_t i = 0; i < n; i++)
        angle[i] |= -doubt[i] | -(want[i] < 0);
}

/*
 * The angles below M/2 micro-degrees, in floats.  There the series is 1 but for a rounding, and 11
 * roundings of 2^-24 make at most 2^-20 of the angle: none cancels, as z and z' have one sign where
 * the angle is small.  Returns whether one is larger, or as close to the middle between two.
 */
static int32_t judge_angles_quickly(int32_t *restrict angle, const int32_t *restrict xy,
                                    const int32_t *restrict b, const int32_t *restrict want,
                                    int32_t n, int32_t m, int32_t zzero)
{
    n = whole_lanes(n);
    /* Where `most` is a constant, GCC makes branches. */
    const int32_t half = m / 2;
    const float most = (float) half, error = 0x1p-20f, degrees = (float) (180e6 / NTP__PI);
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t z = upward(b[i], m, zzero), w = upward(want[i], m, zzero);
        const float rho2 = 4.0f * (float) xy[i] + 2.0f, along = rho2 + (float) z * (float) w;
        const float across = sqrtf(rho2) * (float) (z < w ? w - z : z - w) * degrees;
        const float turn = fabsf(across / along), up = (turn < most ? turn : most) + 0.5f;
        const float doubt = (up + 1.0f) * error;
        const int32_t down = (int32_t) up, large = -(across >= along * most);
        const float part = up - (float) down;
        angle[i] = down | large | -(want[i] < 0); /* want < 0: there is none */
        any |= (large | -(part < doubt) | -(part > 1.0f - doubt)) & ~want[i];
    }
    return any < 0;
}

ONE_COPY static void judge_angles(int32_t *restrict angle, const int32_t *restrict xy,
                                  const int32_t *restrict b, const int32_t *restrict want,
                                  int32_t n, int32_t m, int32_t zzero)
{
    for (int32_t i = 0; i < n; i += LANES) {
        if (judge_angles_quickly(angle + i, xy + i, b + i, want + i, LANES, m, zzero)) {
            turn_angles(angle + i, xy + i, b + i, want + i, n - i, m, zzero);
            return; /* large angles are seldom alone */
        }
    }
}

static void judge_lanes(ntp__judged *j, const int32_t *r, const int32_t *g, const int32_t *b,
                        const uint32_t *count, int32_t n, int32_t m, int32_t zzero)
{
    int32_t xy[256], common[256];
    judge_pairs(xy, common, r, g, n, m);
    judge_levels(j->fit[0].key, j->fit[0].levels_off, j->fit[1].key, j->fit[1].levels_off, j->want,
                 xy, common, r, g, b, n, m, zzero);
    for (int32_t k = 0; k < 2; k++) {
        judge_lengths(j->fit[k].length, xy, b, n, m, k);
        sum_lengths(&j->fit[k], count, n);
    }
    if (zzero > 1)
        return;
    judge_angles(j->angle, xy, b, j->want, n, m, zzero);
    if (zzero || !(j->fit[0].some & NTP_FLAG_Z_NEGATIVE))
        return;
    for (int32_t i = 0; i < n; i++)
        common[i] = 2 * b[i] < m ? m - b[i] : -1;
    turn_angles(j->mirrored, xy, b, common, n, m, 0);
}

/* The outputs of a block have room for whole lanes, so only the inputs have to be filled up: with
 * the last texel, counted 0 times. */
static void judge_block(ntp__judged *j, const int32_t *r, const int32_t *g, const int32_t *b,
                        const uint32_t *count, int32_t n, int32_t m, int32_t zzero)
{
    int32_t in[3][256];
    uint32_t counts[256];
    const int32_t filled = (n + LANES - 1) / LANES * LANES;
    if (filled == n) {
        judge_lanes(j, r, g, b, count, n, m, zzero);
        return;
    }
    const int32_t *const planes[3] = { r, g, b };
    for (int32_t i = 0; i < filled; i++) {
        const int32_t from = i < n ? i : n - 1;
        counts[i] = i < n ? count[i] : 0;
        for (int32_t k = 0; k < 3; k++)
            in[k][i] = planes[k][from];
    }
    judge_lanes(j, in[0], in[1], in[2], counts, filled, m, zzero);
}

/*
 * Pulls as ntp__pull does.  With the odd numbers 2u - 1 < t < 2u + 1 around a projection, and
 * 2v - 1, 2v + 1 around the other one, the pair of the lower ones is on the disc, that of the
 * greater ones is not, and of the other two each reaches farther than the first.  (t + 1)/2 is taken
 * in double, in units of 2^-15, as in directions_tmpl.h.  A projection is below |X|, so what seems to be
 * (|X| + 1)/2 is not, as on the axes.
 */
static int32_t pull(int32_t *restrict r, int32_t *restrict g, int32_t *restrict doubt, int32_t n,
                    int32_t m)
{
    const int32_t k = (m + 1) / 2, am = k * (k - 1);
    const double half = 0.5 * FRACTION * m;
    int32_t any = 0;
    n = (n + LANES - 1) / LANES * LANES;
    for (int32_t i = 0; i < n; i++) {
        const int32_t p = 2 * r[i] - m, q = 2 * g[i] - m, ax = p < 0 ? -p : p, ay = q < 0 ? -q : q;
        const double x = ax, y = ay, factor = half / sqrt(x * x + y * y);
        const int32_t s = (int32_t) (x * factor + 0.5 * FRACTION);
        const int32_t t = (int32_t) (y * factor + 0.5 * FRACTION), u = s >> 15, v = t >> 15;
        const int32_t squares = u * u + v * v, more = u - v;
        const int32_t right = (squares + more < am) & (ax != ay);
        const int32_t down = (squares - more < am) & (ax != ay);
        const int32_t a = u + (right & ((ax > ay) | (down ^ 1)));
        const int32_t c = v + (down & ((ay > ax) | (right ^ 1)));
        doubt[i] = (in_doubt(s, 0) & ((s + 1) >> 14 != ax + 1)) |
                   (in_doubt(t, 0) & ((t + 1) >> 14 != ay + 1));
        any |= doubt[i];
        /* M less a level are the other bits of it. */
        r[i] = (k - 1 + a) ^ (p < 0 ? m : 0);
        g[i] = (k - 1 + c) ^ (q < 0 ? m : 0);
    }
    return any;
}
