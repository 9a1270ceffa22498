/* SPDX-License-Identifier: MIT */
/*
 * gradient_kernels.c - the loops of heightfield -> normals, compiled once per instruction set
 *
 * Each loop is plain C that vectorises.  The tap sums are exact; the encoding is floating point
 * with a proved bound, and texels that come within it of a rounding boundary are reported.
 *
 * The bound.  u is the unit roundoff (2^-24 or 2^-53); every operation below errs by a factor
 * within 1 +- u, squares of factors are left out.  The slope p = D * c: D may be rounded on
 * conversion (1), c is rounded, in double from a rounded N (2), the product (1): 4u.  p*p: 9u.
 * The sum of two such squares: 10u; with 1 added: 11u.  Its root: 5.5u + 1.  (M/2)/L: 7.5u.
 * Times p: 12.5u.  Shortened by min_z: M/2 sqrt(1 - z^2) 4u, the root of the sum of squares 6u,
 * their quotient 11u, times p: 16u.  So v = M/2 times a component is off by less than 17u |v|,
 * and its distance to the nearest integer k is exact: floor(v) is right unless that distance is
 * below 17u (|k| + 1/1000).  18u |k| covers it, with the roundings of the test itself; and k = 0 is
 * no boundary in doubt, as the sign is right.  z: 8.5u of v, 2 v + 1/2 less than 18u of it.
 * Nothing overflows or falls below the normal range, as the caller keeps c/N within limits
 * (gradient.c).  Tap sums that are not exact add an absolute bound.
 */
#include "from_height/gradient.h"

#include <math.h>
#include <string.h>

#if defined(__GNUC__)
#  define ALWAYS_INLINE inline __attribute__((always_inline))
#else
#  define ALWAYS_INLINE inline
#endif

/* The taps are constants once a kernel's function is inlined, and those of 0 vanish. */
#define TERM(taps, k, value) ((taps)[k] != 0 ? (taps)[k] * (value) : 0)
#define NINE(taps, value)                                                                          \
    (TERM(taps, 0, value(0)) + TERM(taps, 1, value(1)) + TERM(taps, 2, value(2)) +                 \
     TERM(taps, 3, value(3)) + TERM(taps, 4, value(4)) + TERM(taps, 5, value(5)) +                 \
     TERM(taps, 6, value(6)) + TERM(taps, 7, value(7)) + TERM(taps, 8, value(8)))
#define ROW(k)    rows[k][i]
#define COLUMN(k) line[i + (k)]

/* Tap 1 in the middle and no other: the sums are the numbers themselves. */
#define IS_IDENTITY(taps)                                                                          \
    ((taps)[NTP__MAX_RADIUS] == 1 && (taps)[0] == 0 && (taps)[1] == 0 && (taps)[2] == 0 &&         \
     (taps)[3] == 0 && (taps)[5] == 0 && (taps)[6] == 0 && (taps)[7] == 0 && (taps)[8] == 0)

/* Vertical sums of one term, then horizontal ones; one pass where one of them is the identity. */
#define DEFINE_TERM(NAME, T)                                                                       \
    static ALWAYS_INLINE void NAME(T *restrict sums, const T *const rows[NTP__MAX_TAPS],           \
                                   const int32_t *vertical, const int32_t *horizontal,             \
                                   int32_t radius, int32_t add, int32_t n)                         \
    {                                                                                              \
        T summed[NTP__GRADIENT_ROW];                                                               \
        const T *line = summed;                                                                    \
        const int32_t first = NTP__MAX_RADIUS - radius, last = n + NTP__MAX_RADIUS + radius;       \
        if (!add && IS_IDENTITY(horizontal)) {                                                     \
            for (int32_t i = NTP__MAX_RADIUS; i < n + NTP__MAX_RADIUS; i++)                        \
                sums[i - NTP__MAX_RADIUS] = NINE(vertical, ROW);                                   \
            return;                                                                                \
        }                                                                                          \
        if (IS_IDENTITY(vertical)) {                                                               \
            line = rows[NTP__MAX_RADIUS];                                                          \
        } else {                                                                                   \
            for (int32_t i = first; i < last; i++)                                                 \
                summed[i] = NINE(vertical, ROW);                                                   \
        }                                                                                          \
        if (add) {                                                                                 \
            for (int32_t i = 0; i < n; i++)                                                        \
                sums[i] += NINE(horizontal, COLUMN);                                               \
        } else {                                                                                   \
            for (int32_t i = 0; i < n; i++)                                                        \
                sums[i] = NINE(horizontal, COLUMN);                                                \
        }                                                                                          \
    }

#define DEFINE_KERNEL(NAME, T)                                                                     \
    static ALWAYS_INLINE void NAME##_kernel(T *restrict sums, const T *const rows[NTP__MAX_TAPS],  \
                                            const ntp__kernel *k, int32_t down, int32_t n)         \
    {                                                                                              \
        const ntp__taps *a = &k->term[0], *b = &k->term[1];                                        \
        NAME##_term(sums, rows, down ? a->along : a->across, down ? a->across : a->along,          \
                    k->radius, 0, n);                                                              \
        if (k->terms > 1)                                                                          \
            NAME##_term(sums, rows, down ? b->along : b->across, down ? b->across : b->along,      \
                        k->radius, 1, n);                                                          \
    }

DEFINE_TERM(sums_i_term, int32_t)
DEFINE_TERM(sums_d_term, double)
DEFINE_KERNEL(sums_i, int32_t)
DEFINE_KERNEL(sums_d, double)

#define CASE(NAME, KERNEL)                                                                         \
    case KERNEL:                                                                                   \
        if (down)                                                                                  \
            NAME##_kernel(sums, rows, &ntp__kernel_table[KERNEL], 1, n);                           \
        else                                                                                       \
            NAME##_kernel(sums, rows, &ntp__kernel_table[KERNEL], 0, n);                           \
        break;

static void tap_sums_i(int32_t *sums, const int32_t *const rows[NTP__MAX_TAPS], ntp_kernel kernel,
                       int32_t down, int32_t n)
{
    switch (kernel) {
        CASE(sums_i, NTP_KERNEL_CENTRAL)
        CASE(sums_i, NTP_KERNEL_FORWARD)
        CASE(sums_i, NTP_KERNEL_PREWITT3)
        CASE(sums_i, NTP_KERNEL_SOBEL3)
        CASE(sums_i, NTP_KERNEL_SCHARR3)
        CASE(sums_i, NTP_KERNEL_PREWITT5)
        CASE(sums_i, NTP_KERNEL_SOBEL5)
        CASE(sums_i, NTP_KERNEL_GIMP5)
        CASE(sums_i, NTP_KERNEL_GIMP7)
        CASE(sums_i, NTP_KERNEL_GIMP9)
    case NTP_KERNEL_BAKED: /* has no taps */
        break;
    }
}

static void tap_sums_d(double *sums, const double *const rows[NTP__MAX_TAPS], ntp_kernel kernel,
                       int32_t down, int32_t n)
{
    switch (kernel) {
        CASE(sums_d, NTP_KERNEL_CENTRAL)
        CASE(sums_d, NTP_KERNEL_FORWARD)
        CASE(sums_d, NTP_KERNEL_PREWITT3)
        CASE(sums_d, NTP_KERNEL_SOBEL3)
        CASE(sums_d, NTP_KERNEL_SCHARR3)
        CASE(sums_d, NTP_KERNEL_PREWITT5)
        CASE(sums_d, NTP_KERNEL_SOBEL5)
        CASE(sums_d, NTP_KERNEL_GIMP5)
        CASE(sums_d, NTP_KERNEL_GIMP7)
        CASE(sums_d, NTP_KERNEL_GIMP9)
    case NTP_KERNEL_BAKED: /* has no taps */
        break;
    }
}

/*
 * Adding and taking away this number rounds a double (float) to the nearest integer; the result
 * of C's default rounding, which no flag here lets the compiler change.
 */
#define ROUND_F 12582912.0f        /* 1.5 * 2^23 */
#define ROUND_D 6755399441055744.0 /* 1.5 * 2^52 */

/*
 * Levels of n = v / half in [-1, 1]: floor(v) + zero; in doubt near an integer, where v
 * comes within relative |v| + absolute.  Three short loops, of which a processor has many turns at
 * work at a time, are faster than one with two roots in a row.
 *
 * The derived blue goes along.  With v = floor(M n / 2) the numerators of red and green are
 * X = 2 v_x + 1 and Y, and S/4 = (M^2 - X^2 - Y^2)/4 is an exact float (M = 255) or double.  S is
 * 7 mod 8, so 4 k^2 - S is at least 1 and root(S/4) stays 1/(8 M) below any integer k above it, far
 * more than its rounding: floor(root) is right.  For Z-zero, floor(root(S) + 1/2) is as safe:
 * 4 S = 28 mod 32, and (2b - 1)^2 is odd.
 */
enum { NO_BLUE, NEAREST_BLUE, DERIVED_BLUE };

#define DEFINE_ENCODE(NAME, T, S, SQRT, ABS, ROUND)                                                \
    static ALWAYS_INLINE int32_t NAME##_loop(                                                      \
        int32_t *restrict red, int32_t *restrict green, int32_t *restrict blue,                    \
        int32_t *restrict doubt, const S *restrict right, const S *restrict down, int32_t n,       \
        const ntp__encode *e, int32_t use_shortened, int32_t which, int32_t zzero)                 \
    {                                                                                              \
        const T cx = (T) e->cx, cy = (T) e->cy, half = (T) e->half;                                \
        const T shortened = (T) (e->shortened * e->half);                                          \
        const T relative = (T) e->relative, absolute = (T) e->absolute;                            \
        const int32_t zero = (int32_t) (e->half + 0.5);                                            \
        const T quarter = half * half;                                                             \
        int32_t doubts = 0;                                                                        \
        T inverse[NTP__BLOCK];                                                                     \
        for (int32_t i = 0; i < n; i++) {                                                          \
            T x = (T) right[i] * cx, y = (T) down[i] * cy;                                         \
            inverse[i] = half / SQRT(1 + (x * x + y * y));                                         \
        }                                                                                          \
        for (int32_t i = 0; i < n; i++) {                                                          \
            T x = (T) right[i] * cx, y = (T) down[i] * cy, factor = inverse[i];                    \
            if (use_shortened) {                                                                   \
                T other = shortened / SQRT(x * x + y * y);                                         \
                factor = other < factor ? other : factor;                                          \
            }                                                                                      \
            x *= factor;                                                                           \
            y *= factor;                                                                           \
            T round_x = (x + ROUND) - ROUND, round_y = (y + ROUND) - ROUND;                        \
            T over_x = x - round_x, over_y = y - round_y;                                          \
            red[i] = zero + (int32_t) round_x - (over_x < 0);                                      \
            green[i] = zero + (int32_t) round_y - (over_y < 0);                                    \
            T near_x = ABS(round_x) * relative - ABS(over_x);                                      \
            T near_y = ABS(round_y) * relative - ABS(over_y);                                      \
            T near = (near_x > near_y ? near_x : near_y) + absolute;                               \
            doubt[i] = near > 0 ? NTP__DOUBT : 0;                                                  \
            doubts |= doubt[i];                                                                    \
        }                                                                                          \
        for (int32_t i = 0; which == NEAREST_BLUE && i < n; i++) {                                 \
            T z = zzero ? 2 * inverse[i] + (T) 0.5 : inverse[i];                                   \
            T round_z = (z + ROUND) - ROUND, over_z = z - round_z;                                 \
            blue[i] = (zzero ? 0 : zero) + (int32_t) round_z - (over_z < 0);                       \
            doubt[i] |= ABS(over_z) < round_z * relative + 2 * absolute ? NTP__DOUBT : 0;          \
            doubts |= doubt[i];                                                                    \
        }                                                                                          \
        for (int32_t i = 0; which == DERIVED_BLUE && i < n; i++) {                                 \
            T a = (T) red[i] - half, b = (T) green[i] - half;                                      \
            T rest = quarter - a * a - b * b;                                                      \
            T root = SQRT(rest > 0 ? rest : (T) 0);                                                \
            blue[i] = zzero ? (int32_t) (2 * root + (T) 0.5) : zero + (int32_t) root;              \
            doubt[i] |= rest < 0 ? NTP__TOO_LONG : 0;                                              \
            doubts |= doubt[i];                                                                    \
        }                                                                                          \
        return doubts;                                                                             \
    }

/* The loop with its choices made. */
#define CHOOSE_ENCODE(NAME, S)                                                                     \
    static int32_t NAME(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,               \
                        const S *right, const S *down, int32_t n, const ntp__encode *e)            \
    {                                                                                              \
        if (blue == NULL)                                                                          \
            return NAME##_loop(red, green, blue, doubt, right, down, n, e, e->use_shortened,       \
                               NO_BLUE, 0);                                                        \
        if (!e->derived)                                                                           \
            return NAME##_loop(red, green, blue, doubt, right, down, n, e, e->use_shortened,       \
                               NEAREST_BLUE, e->zzero);                                            \
        if (e->use_shortened)                                                                      \
            return NAME##_loop(red, green, blue, doubt, right, down, n, e, 1, DERIVED_BLUE,        \
                               e->zzero);                                                          \
        return e->zzero                                                                            \
                   ? NAME##_loop(red, green, blue, doubt, right, down, n, e, 0, DERIVED_BLUE, 1)   \
                   : NAME##_loop(red, green, blue, doubt, right, down, n, e, 0, DERIVED_BLUE, 0);  \
    }

DEFINE_ENCODE(encode_single, float, int32_t, sqrtf, fabsf, ROUND_F)
DEFINE_ENCODE(encode_i, double, int32_t, sqrt, fabs, ROUND_D)
DEFINE_ENCODE(encode_d, double, double, sqrt, fabs, ROUND_D)
CHOOSE_ENCODE(encode_single, int32_t)
CHOOSE_ENCODE(encode_i, int32_t)
CHOOSE_ENCODE(encode_d, double)

static inline bool is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* Two pixels of 0..255 a word, of which six bytes are stored over eight: the next store, or the
 * last pixels one by one, put right what lies behind. */
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
    tap_sums_i, tap_sums_d, encode_single, encode_i, encode_d, pack_rgb8,
};
