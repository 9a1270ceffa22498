/* SPDX-License-Identifier: MIT */
/*
 * encode_tmpl.h - a part of gradient_kernels.c: encodes tap sums of type SUM
 *
 * T is the type of the arithmetic, NAME(x) is x with the ending of both types, and ROUND is the
 * number that rounds a T.
 * All loops take n numbers, a multiple of NTP__LANES, so that none has a remainder.
 */

/* M/2 over the length of (x, y, 1). */
static void NAME(invert_lengths)(T *restrict inverse, const SUM *right, const SUM *down, int32_t n,
                                 const ntp__encode *e)
{
    const T cx = (T) e->cx, cy = (T) e->cy, half = (T) e->half;
    for (int32_t i = 0; i < n; i++) {
        T x = (T) right[i] * cx, y = (T) down[i] * cy;
        inverse[i] = half / SQRT(1 + (x * x + y * y));
    }
}

static ALWAYS_INLINE int32_t NAME(round_pairs)(int32_t *restrict red, int32_t *restrict green,
                                               int32_t *restrict doubt, const SUM *right,
                                               const SUM *down, const T *inverse, int32_t n,
                                               const ntp__encode *e, bool shorten)
{
    const T cx = (T) e->cx, cy = (T) e->cy, shortened = (T) (e->shortened * e->half);
    const T relative = (T) e->relative, absolute = (T) e->absolute;
    const int32_t zero = (int32_t) (e->half + 0.5);
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        T x = (T) right[i] * cx, y = (T) down[i] * cy, factor = inverse[i];
        if (shorten) {
            T other = shortened / SQRT(x * x + y * y);
            factor = other < factor ? other : factor;
        }
        x *= factor;
        y *= factor;
        T round_x = (x + ROUND) - ROUND, round_y = (y + ROUND) - ROUND;
        T over_x = x - round_x, over_y = y - round_y;
        red[i] = zero + (int32_t) round_x - (over_x < 0);
        green[i] = zero + (int32_t) round_y - (over_y < 0);
        T near_x = ABS(round_x) * relative - ABS(over_x);
        T near_y = ABS(round_y) * relative - ABS(over_y);
        T near = (near_x > near_y ? near_x : near_y) + absolute;
        doubt[i] = near > 0 ? NTP__DOUBT : 0;
        doubts |= doubt[i];
    }
    return doubts;
}

/* Blue rounded from z. */
static int32_t NAME(round_blues)(int32_t *restrict blue, int32_t *restrict doubt, const T *inverse,
                                 int32_t n, const ntp__encode *e)
{
    const T relative = (T) e->relative, absolute = (T) e->absolute;
    const T factor = e->zzero ? 2 : 1, more = (T) (e->zzero ? 0.5 : 0);
    const int32_t zero = e->zzero ? 0 : (int32_t) (e->half + 0.5);
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        T z = factor * inverse[i] + more;
        T round_z = (z + ROUND) - ROUND, over_z = z - round_z;
        blue[i] = zero + (int32_t) round_z - (over_z < 0);
        doubt[i] |= ABS(over_z) < round_z * relative + 2 * absolute ? NTP__DOUBT : 0;
        doubts |= doubt[i];
    }
    return doubts;
}

/* Blue derived from the rounded red and green. */
static int32_t NAME(derive_blues)(int32_t *restrict blue, int32_t *restrict doubt,
                                  const int32_t *red, const int32_t *green, int32_t n,
                                  const ntp__encode *e)
{
    const T half = (T) e->half, quarter = half * half;
    const T factor = e->zzero ? 2 : 1, more = (T) (e->zzero ? 0.5 : 0);
    const int32_t zero = e->zzero ? 0 : (int32_t) (e->half + 0.5);
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        T a = (T) red[i] - half, b = (T) green[i] - half;
        T rest = quarter - a * a - b * b;
        T root = SQRT(rest > 0 ? rest : (T) 0);
        blue[i] = zero + (int32_t) (factor * root + more);
        doubt[i] |= rest < 0 ? NTP__TOO_LONG : 0;
        doubts |= doubt[i];
    }
    return doubts;
}

static int32_t NAME(encode_lanes)(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                                  const SUM *right, const SUM *down, int32_t n,
                                  const ntp__encode *e)
{
    T inverse[NTP__BLOCK];
    NAME(invert_lengths)(inverse, right, down, n, e);
    int32_t doubts = e->use_shortened
                         ? NAME(round_pairs)(red, green, doubt, right, down, inverse, n, e, true)
                         : NAME(round_pairs)(red, green, doubt, right, down, inverse, n, e, false);
    if (blue == NULL)
        return doubts;
    return doubts | (e->derived ? NAME(derive_blues)(blue, doubt, red, green, n, e)
                                : NAME(round_blues)(blue, doubt, inverse, n, e));
}

/* The last few numbers go through their own arrays, filled up with the first of them. */
static int32_t NAME(encode)(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                            const SUM *right, const SUM *down, int32_t n, const ntp__encode *e)
{
    int32_t whole = n / NTP__LANES * NTP__LANES, rest = n - whole;
    int32_t doubts = NAME(encode_lanes)(red, green, blue, doubt, right, down, whole, e);
    if (rest == 0)
        return doubts;
    int32_t out[4][NTP__LANES];
    SUM in[2][NTP__LANES];
    for (int32_t i = 0; i < NTP__LANES; i++) {
        in[0][i] = right[i < rest ? whole + i : whole];
        in[1][i] = down[i < rest ? whole + i : whole];
    }
    doubts |= NAME(encode_lanes)(out[0], out[1], blue == NULL ? NULL : out[2], out[3], in[0], in[1],
                                 NTP__LANES, e);
    int32_t *const to[] = { red, green, blue, doubt };
    for (int32_t k = 0; k < 4; k++) {
        if (to[k] != NULL)
            memcpy(to[k] + whole, out[k], (size_t) rest * sizeof out[k][0]);
    }
    return doubts;
}
