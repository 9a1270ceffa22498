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
 * their quotient 11u, times p: 16u.  So v = M/2 times a component is off by less than 17u |v|,
 * and its distance to the nearest integer k is exact: floor(v) is right unless that distance is
 * below 17u (|k| + 1/1000).  18u |k| covers it, with the roundings of the test itself; and k = 0 is
 * no boundary in doubt, as the sign is right.  z: 8.5u of v, 2 v + 1/2 less than 18u of it.
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
#else
#  define ALWAYS_INLINE inline
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

/*
 * Adding this number and subtracting it again rounds a float (double) to the nearest integer.  This
 * relies on the default rounding of C, and no flag here lets the compiler change it.
 */
#define ROUND_F 12582912.0f        /* 1.5 * 2^23 */
#define ROUND_D 6755399441055744.0 /* 1.5 * 2^52 */

/*
 * The level of n = v / half in [-1, 1] is floor(v) + zero.  It is in doubt where v is within
 * relative |v| + absolute of an integer.  Three short loops are faster than one with two roots in a
 * row, because a processor works on many turns of a short loop at a time.
 *
 * Blue is derived in the same way.  With v = floor(M n / 2) the numerators of red and green are
 * X = 2 v_x + 1 and Y, and S/4 = (M^2 - X^2 - Y^2)/4 is an exact float (M = 255) or double.  S is
 * 7 mod 8, so 4 k^2 - S is at least 1 and root(S/4) stays 1/(8 M) below any integer k above it, far
 * more than its rounding: floor(root) is right.  For Z-zero, floor(root(S) + 1/2) is as safe:
 * 4 S = 28 mod 32, and (2b - 1)^2 is odd.
 */
#define T       float
#define SUM     int32_t
#define SQRT    sqrtf
#define ABS     fabsf
#define ROUND   ROUND_F
#define NAME(x) x##_single
#include "from_height/encode_tmpl.h"
#undef T
#undef SQRT
#undef ABS
#undef ROUND
#undef NAME
#define T       double
#define SQRT    sqrt
#define ABS     fabs
#define ROUND   ROUND_D
#define NAME(x) x##_i
#include "from_height/encode_tmpl.h"
#undef SUM
#undef NAME
#define SUM     double
#define NAME(x) x##_d
#include "from_height/encode_tmpl.h"

#include "from_height/dither_tmpl.h"

static inline bool is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* A word of eight bytes holds two pixels in six.  The next store, or the last pixels one by one,
 * overwrites the two bytes behind them. */
static void pack_rgb8(uint8_t *dst, const int32_t *red, const int32_t *green, const int32_t *blue,
                      int32_t n)
{
    uint32_t packed[NTP__BLOCK];
    int32_t i = 0;
    for (int32_t k = 0; k < n; k++)
        packed[k] = (uint32_t) (red[k] | green[k] << 8 | blue[k] << 16);
    for (; is_little_endian() && i + 4 <= n; i += 2) {
        uint64_t word = packed[i] | (uint64_t) packed[i + 1] << 24;
        memcpy(dst + 3 * i, &word, sizeof word);
    }
    for (; i < n; i++) {
        dst[3 * i] = (uint8_t) red[i];
        dst[3 * i + 1] = (uint8_t) green[i];
        dst[3 * i + 2] = (uint8_t) blue[i];
    }
}

#define TABLE_NAME_(isa) ntp__gradient_kernels_##isa
#define TABLE_NAME(isa)  TABLE_NAME_(isa)

extern const ntp__gradient_kernels TABLE_NAME(NTP_ISA);
const ntp__gradient_kernels TABLE_NAME(NTP_ISA) = {
    tap_sums_i, tap_sums_d, encode_single, encode_i, encode_d, dither, pack_rgb8,
};
