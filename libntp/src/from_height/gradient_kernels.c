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

#include "base/inlining.h"
#include "texel/level.h"

#include <math.h>
#include <string.h>

/* Sums of texel i of so many rows; taps of 0 are left out.  Integers are multiplied by constants, as
 * processors before AVX2 are slow to multiply them; doubles by numbers in registers. */
#define TAP(k) (taps[k] != 0 ? taps[k] * from[k][first + i] : 0)
#define LINE(NAME)                                                                                 \
    case NTP__LINE_##NAME: {                                                                       \
        static const int32_t taps[NTP__MAX_TAPS] = NTP__##NAME;                                    \
        for (int32_t i = 0; i < n; i++)                                                            \
            to[i] =                                                                                \
                TAP(0) + TAP(1) + TAP(2) + TAP(3) + TAP(4) + TAP(5) + TAP(6) + TAP(7) + TAP(8);    \
        break;                                                                                     \
    }
#define TWO   (w[0] * a[0][i] + w[1] * a[1][i])
#define THREE (TWO + w[2] * a[2][i])
#define FOUR  (THREE + w[3] * a[3][i])
#define FIVE  (FOUR + w[4] * a[4][i])
#define SIX   (FIVE + w[5] * a[5][i])
#define SEVEN (SIX + w[6] * a[6][i])
#define EIGHT (SEVEN + w[7] * a[7][i])
#define NINE  (EIGHT + w[8] * a[8][i])
#define CASE(COUNT, SUM)                                                                           \
    case COUNT:                                                                                    \
        for (int32_t i = 0; i < n; i++)                                                            \
            to[i] = SUM + 0;                                                                       \
        break;

/* to[i] = the sum of taps[k] from[k][first + i] over all k, for the taps along or across; for groups of
 * NTP__LANES texels. */
static void sum_i(int32_t *restrict to, const int32_t *const from[NTP__MAX_TAPS], int32_t first,
                  const ntp__taps *of, bool along, int32_t groups)
{
    const int32_t n = groups * NTP__LANES; /* so loops have no remainder */
    switch (along ? of->along_line : of->across_line) {
        NTP__EACH_LINE(LINE)
    case NTP__LINES:
        break;
    }
}

/* The same.  One loop serves all lines of as many taps.  0 is added so that no sum is -0. */
static void sum_d(double *restrict to, const double *const from[NTP__MAX_TAPS], int32_t first,
                  const ntp__taps *of, bool along, int32_t groups)
{
    const int32_t *taps = along ? of->along : of->across;
    const double *a[NTP__MAX_TAPS];
    double w[NTP__MAX_TAPS];
    int32_t count = 0;
    for (int32_t k = 0; k < NTP__MAX_TAPS; k++) {
        if (taps[k] != 0) {
            a[count] = from[k] + first;
            w[count++] = taps[k];
        }
    }
    const int32_t n = groups * NTP__LANES;
    switch (count) {
        CASE(2, TWO)
        CASE(3, THREE)
        CASE(4, FOUR)
        CASE(5, FIVE)
        CASE(6, SIX)
        CASE(7, SEVEN)
        CASE(8, EIGHT)
        CASE(9, NINE)
    default: /* no kernel has fewer, but for the identity */
        break;
    }
}

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
    /* Lanes beyond the texels hold any numbers, whose sum may be too great. */
    return (int32_t) (((uint32_t) units + (uint32_t) error) & (uint32_t) (step - 1)) < 2 * error;
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

#ifndef __AVX2__
/* What is closer to the middle of two floats than this part of it is in doubt (vectors_tmpl.h says why). */
static const double float_doubt = 0x1p-45;

/* The error of (n + 1)/2 that does not shrink with it: 16u n/2. */
static const double unit_error = 0x1p-49;

/* A component as a float, plain or as (n + 1)/2; returns 1 if it is in doubt, else 0. */
static int32_t round_component(float *to, double v, bool unit, double rough)
{
    const double t = unit ? v * 0.5 + 0.5 : v;
    const double off = fabs(t) * float_doubt + (unit ? rough / 2 + unit_error : rough);
    const float low = (float) (t - off), high = (float) (t + off);
    *to = low + 0.0F; /* never -0 */
    return low != high;
}

static int32_t encode_vectors(float *d, int32_t *at, const void *const from[3],
                              ntp__packed_from which, int32_t n, const ntp__encode *e)
{
    const int32_t *const ints = which == NTP__FROM_SUMS_I ? from[0] : NULL;
    const bool unit = e->unit && !e->zzero; /* of z */
    const float least = (float) (unit ? (e->min_z + 1) / 2 : e->min_z);
    int32_t found = 0;
    for (int32_t i = 0; i < n; i++, d += 3) {
        const double x = e->cx * (ints != NULL ? (double) ints[i] : ((const double *) from[0])[i]);
        const double y = e->cy * (ints != NULL ? (double) ((const int32_t *) from[1])[i]
                                               : ((const double *) from[1])[i]);
        const double square = x * x + y * y, z = 1 / sqrt(1 + square);
        double factor = z;
        if (e->use_shortened) {
            const double other = e->shortened / sqrt(square);
            factor = other < z ? other : z;
        }
        const int32_t doubt = round_component(d, x * factor, e->unit, e->rough) |
                              round_component(d + 1, y * factor, e->unit, e->rough) |
                              round_component(d + 2, z, unit, e->rough);
        d[2] = d[2] > least ? d[2] : least;
        at[found] = i;
        found += doubt;
    }
    return found;
}
#endif

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
ntp__encode_vectors_fn ntp__vectors_avx2;
ntp__take_heights_fn ntp__take_heights_avx2;
#  define encode_packed  ntp__encode_avx2
#  define encode_vectors ntp__vectors_avx2
#  define take_heights   ntp__take_heights_avx2
#else
#  include "from_height/dither_tmpl.h"
#  define encode_packed NULL
#  define take_heights  NULL
#endif

#define TABLE_NAME_(isa) ntp__gradient_kernels_##isa
#define TABLE_NAME(isa)  TABLE_NAME_(isa)

extern const ntp__gradient_kernels TABLE_NAME(NTP_ISA);
const ntp__gradient_kernels TABLE_NAME(NTP_ISA) = {
    tap_sums_i,     tap_sums_d,    take_floats,  encode_i, encode_d,   encode_precisely,
    encode_vectors, encode_packed, take_heights, dither,   put_slopes, take_levels,
};
