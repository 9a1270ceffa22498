/* SPDX-License-Identifier: MIT */
/*
 * gradient_kernels.c - the loops of heightfield -> normals, compiled once per instruction set
 *
 * Each loop is plain C that vectorizes.  tap_sums_tmpl.h and encode_tmpl.h are included once for
 * each type of number, dither_tmpl.h once.  Their loops do a multiple of NTP__LANES numbers, so that no loop has a
 * remainder, which would be most of the code.  The encoding is floating point with a proved bound.
 * Texels that are within this bound of a rounding boundary are reported.
 *
 * The bound.  u is the unit roundoff (2^-24 or 2^-53).  Every operation below errs by a factor
 * within 1 +- u; squares of u are left out.  The slope p = D * c: D may be rounded on
 * conversion (1), c is rounded, in double from a rounded N (2), the product (1): 4u.  p*p: 9u.
 * The sum of two such squares: 10u; with 1 added: 11u.  Its root: 5.5u + 1.  (M/2)/L: 7.5u.
 * Times p: 12.5u.  Shortened by min_z: M/2 sqrt(1 - z^2) 4u, the root of the sum of squares 6u,
 * their quotient 11u, times p: 16u.  So v = M/2 times the magnitude of a component, in units of
 * 2^-15, is off by less than 17u v.  In float that is less than v 2^-19, in double less than one
 * unit.  The level is right unless v is within this of a boundary; and 0 is none, as the sign is
 * right.  z: 8.5u of v.
 * Nothing overflows or falls below the normal range, because the caller keeps c/N within limits
 * (gradient.c).  Tap sums of int32_t are exact.  Those of doubles may not be; then the caller adds
 * an absolute bound.
 */
#include "from_height/gradient.h"

#include "texel/level.h"

#include <math.h>
#include <string.h>

#if defined(__GNUC__)
#  define ALWAYS_INLINE inline __attribute__((always_inline))
#  define SELDOM        __attribute__((noinline, cold))
#else
#  define ALWAYS_INLINE inline
#  define SELDOM
#endif

/* The taps are constants once the function of a kernel is inlined, and taps of 0 vanish. */
#define TERM(taps, k, value) ((taps)[k] != 0 ? (taps)[k] * (value) : 0)
#define NINE(taps, value)                                                                          \
    (TERM(taps, 0, value(0)) + TERM(taps, 1, value(1)) + TERM(taps, 2, value(2)) +                 \
     TERM(taps, 3, value(3)) + TERM(taps, 4, value(4)) + TERM(taps, 5, value(5)) +                 \
     TERM(taps, 6, value(6)) + TERM(taps, 7, value(7)) + TERM(taps, 8, value(8)))
#define ROW(k)    rows[k][NTP__MAX_RADIUS + i]
#define COLUMN(k) line[i + (k)]

/* The only tap is a 1 in the middle: the sums are the numbers themselves. */
#define IS_IDENTITY(taps)                                                                          \
    ((taps)[NTP__MAX_RADIUS] == 1 && (taps)[0] == 0 && (taps)[1] == 0 && (taps)[2] == 0 &&         \
     (taps)[3] == 0 && (taps)[5] == 0 && (taps)[6] == 0 && (taps)[7] == 0 && (taps)[8] == 0)

#define T       int32_t
#define NAME(x) x##_i
#include "from_height/tap_sums_tmpl.h"
#undef T
#undef NAME
#define T       double
#define NAME(x) x##_d
#include "from_height/tap_sums_tmpl.h"
#undef T
#undef NAME

/* v is taken in units of 1/UNITS.  With M = 65535 there are 2^30 of them. */
enum { UNIT_BITS = 15, UNITS = 1 << UNIT_BITS };

/* May `units`, off by less than `error`, lie on the other side of a multiple of `step`?  The sign of
 * exact sums is right, so with these 0 is not on the other side.  Units below `error` are then
 * passed as `error`. */
static ALWAYS_INLINE int32_t near_level(int32_t units, int32_t error, int32_t step)
{
    return ((units + error) & (step - 1)) < 2 * error;
}

/* -1 for x < 0, else 0.  A comparison of doubles that gives integers is not vectorized. */
static ALWAYS_INLINE int32_t is_negative_double(double x)
{
    return (int32_t) copysign(1.0, x + 0.0) >> 1;
}

#define T              float
#define SQRT           sqrtf
#define ABS            fabsf
#define ERROR(units)   ((units) >> 19)
#define IS_NEGATIVE(x) (-((x) < 0))
#define NAME(x)        x##_single
#include "from_height/encode_tmpl.h"
#undef T
#undef SQRT
#undef ABS
#undef ERROR
#undef IS_NEGATIVE
#undef NAME
#define T              double
#define SQRT           sqrt
#define ABS            fabs
#define ERROR(units)   0
#define IS_NEGATIVE(x) is_negative_double(x)
#define NAME(x)        x##_double
#include "from_height/encode_tmpl.h"

/* The slopes of tap sums. */
#define MAKE_SLOPES(T)                                                                             \
    T x[NTP__BLOCK], y[NTP__BLOCK];                                                                \
    const T cx = (T) e->cx, cy = (T) e->cy;                                                        \
    n = (n + NTP__LANES - 1) / NTP__LANES * NTP__LANES;                                            \
    for (int32_t i = 0; i < n; i++) {                                                              \
        x[i] = (T) right[i] * cx;                                                                  \
        y[i] = (T) down[i] * cy;                                                                   \
    }

static int32_t encode_i(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                        const int32_t *right, const int32_t *down, int32_t n, const ntp__encode *e)
{
    MAKE_SLOPES(float)
    return round_slopes_single(red, green, blue, doubt, x, y, n, e);
}

static int32_t encode_d(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                        const double *right, const double *down, int32_t n, const ntp__encode *e)
{
    MAKE_SLOPES(float)
    return round_slopes_single(red, green, blue, doubt, x, y, n, e);
}

static int32_t encode_precisely(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                                const double *right, const double *down, int32_t n,
                                const ntp__encode *e)
{
    MAKE_SLOPES(double)
    return round_slopes_double(red, green, blue, doubt, x, y, n, e);
}

/* Magnitudes are compared as the integers that have their bits. */
static void take_floats(double *restrict height, const float *restrict s, int32_t n,
                        ntp__magnitudes *m)
{
    int32_t least = m->least, most = m->most;
    for (int32_t i = 0; i < n; i++) {
        int32_t bits;
        memcpy(&bits, &s[i], sizeof bits);
        const int32_t size = bits & INT32_MAX, below = (size - 1) & INT32_MAX;
        most = size > most ? size : most;
        least = below < least ? below : least;
        height[i] = (double) s[i];
    }
    m->least = least;
    m->most = most;
}

/* Beyond the last level of 16 bits; its powers are no infinity. */
#define STEEPEST 1e6

#ifdef __AVX2__
#  include "from_height/dither_avx2_tmpl.h"
ntp__encode_packed_fn ntp__encode_avx2;
ntp__take_heights_fn ntp__take_heights_avx2;
#  define encode_packed ntp__encode_avx2
#  define take_heights  ntp__take_heights_avx2
#else
#  include "from_height/dither_tmpl.h"
#  define encode_packed NULL
#  define take_heights  NULL
#endif

#define TABLE_NAME_(isa) ntp__gradient_kernels_##isa
#define TABLE_NAME(isa)  TABLE_NAME_(isa)

extern const ntp__gradient_kernels TABLE_NAME(NTP_ISA);
const ntp__gradient_kernels TABLE_NAME(NTP_ISA) = {
    tap_sums_i,    tap_sums_d,   take_floats, encode_i,   encode_d,    encode_precisely,
    encode_packed, take_heights, dither,      put_slopes, take_levels,
};
