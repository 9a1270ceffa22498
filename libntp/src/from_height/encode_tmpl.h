/* SPDX-License-Identifier: MIT */
/*
 * encode_tmpl.h - a part of gradient_kernels.c: rounds slopes of type T to levels
 *
 * NAME(x) is x with the ending of the type.  ERROR(units) bounds the relative error of so many units.
 * All loops do whole lanes, so that none has a remainder; planes have room for these.
 */

static ALWAYS_INLINE int32_t NAME(round_pairs)(int32_t *restrict red, int32_t *restrict green,
                                               int32_t *restrict doubt, const T *restrict x,
                                               const T *restrict y, int32_t n, const ntp__encode *e,
                                               bool shorten)
{
    const T most = (T) (e->half * UNITS), shortened = (T) (e->shortened * e->half * UNITS);
    const int32_t zero = (int32_t) (e->half + 0.5), off = e->off, exact = -(off <= 1);
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        T square = x[i] * x[i] + y[i] * y[i], factor = most / SQRT(1 + square);
        if (shorten) {
            T other = shortened / SQRT(square);
            factor = other < factor ? other : factor;
        }
        int32_t u = (int32_t) (ABS(x[i]) * factor), v = (int32_t) (ABS(y[i]) * factor);
        int32_t error = ERROR(u > v ? u : v) + off;
        red[i] = zero + ((u >> UNIT_BITS) ^ IS_NEGATIVE(x[i]));
        green[i] = zero + ((v >> UNIT_BITS) ^ IS_NEGATIVE(y[i]));
        int32_t least = error & exact;
        doubt[i] = near_level(u > least ? u : least, error, UNITS) |
                   near_level(v > least ? v : least, error, UNITS);
        doubts |= doubt[i];
    }
    return doubts;
}

/* Blue rounded from z.  Z-zero has twice as many levels, and so half as many units in each. */
static int32_t NAME(round_blues)(int32_t *restrict blue, int32_t *restrict doubt,
                                 const T *restrict x, const T *restrict y, int32_t n,
                                 const ntp__encode *e)
{
    const T most = (T) (e->half * UNITS);
    const int32_t shift = e->zzero ? UNIT_BITS - 1 : UNIT_BITS, more = e->zzero ? UNITS / 4 : 0;
    const int32_t zero = e->zzero ? 0 : (int32_t) (e->half + 0.5), off = e->off;
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t u = (int32_t) (most / SQRT(1 + (x[i] * x[i] + y[i] * y[i]))) + more;
        blue[i] = zero + (u >> shift);
        doubt[i] |= near_level(u, ERROR(u) + off, 1 << shift);
        doubts |= doubt[i];
    }
    return doubts;
}

static int32_t NAME(round_slopes)(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                                  const T *x, const T *y, int32_t n, const ntp__encode *e)
{
    int32_t doubts = e->use_shortened ? NAME(round_pairs)(red, green, doubt, x, y, n, e, true)
                                      : NAME(round_pairs)(red, green, doubt, x, y, n, e, false);
    return blue == NULL ? doubts : doubts | NAME(round_blues)(blue, doubt, x, y, n, e);
}
