/* SPDX-License-Identifier: MIT */
/*
 * solver_kernels.c - the loops of solver_kernels.h; compiled with -DNTP_ISA=... for each one
 *
 * fft_lines_tmpl.h and row_loops_tmpl.h are included twice, for float and for double.
 */
#include "to_height/shared/solver_kernels.h"

#include "base/inlining.h"
#include "base/view.h"

#include <math.h>
#include <string.h>

enum {
    LANES = NTP__FFT_LANES,
    CELL = 2 * LANES, /* numbers of one complex element in all lanes */
    TILE = 16
};

/* What is done with each pair of frequencies: once, only to save code, for processors from before 2013. */
#if defined NTP_HAVE_AVX2 && !defined __AVX2__
#  define OF_A_PAIR ONE_COPY static
#else
#  define OF_A_PAIR static ALWAYS_INLINE
#endif

#define REAL    float
#define NAME(x) x##_single
#include "to_height/shared/fft_lines_tmpl.h"
#include "to_height/shared/row_loops_tmpl.h"
#undef REAL
#undef NAME
#define REAL    double
#define NAME(x) x##_double
#include "to_height/shared/fft_lines_tmpl.h"
#include "to_height/shared/row_loops_tmpl.h"
#undef REAL
#undef NAME

/* ------------------------------------------------------------------------------- columns */

static void down(double *restrict state, float *restrict row, const double *restrict r,
                 double scale, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        state[k] = scale * (double) row[k] + r[k] * state[k];
        row[k] = (float) state[k];
    }
}

static void down_live(double *restrict state, float *restrict row, const double *restrict r,
                      double scale, double *restrict sum, double *restrict power, double tiny,
                      int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        double f = scale * (double) row[k];
        state[k] = f + r[k] * state[k];
        sum[k] += power[k] * f;
        power[k] = power[k] > tiny ? power[k] * r[k] : 0;
        row[k] = (float) state[k];
    }
}

static void up(double *restrict state, float *restrict row, const double *restrict r, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        state[k] = r[k] * ((double) row[k] + state[k]);
        row[k] = (float) state[k];
    }
}

static void up_live(double *restrict state, float *restrict row, const double *restrict r,
                    const double *restrict inverse, double *restrict entry,
                    const double *restrict start, const double *restrict begin, double at,
                    int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        double kept = entry[k] * inverse[k];
        entry[k] = begin[k] == at ? start[k] : kept;
        state[k] = r[k] * ((double) row[k] + entry[k] + state[k]);
        row[k] = (float) state[k];
    }
}

/* --------------------------------------------------------------------------------- slopes */

/* Twice the value, as half of it would be no integer; the factor cancels in the quotients. */
static ALWAYS_INLINE int32_t numerator(int32_t c, int32_t zero, int32_t neutral)
{
    int32_t v = 2 * c - zero;
    return v >= -neutral && v <= neutral ? 0 : v;
}

/* x, y and z of n texels, and whether one of them may be unused. */
static ALWAYS_INLINE int32_t levels8(float *restrict x, float *restrict y, float *restrict z,
                                     const uint8_t *restrict src, int32_t step, int32_t n,
                                     const ntp__slope_levels *how)
{
    const int32_t zero = how->zero, neutral = how->neutral;
    const float z_scale = how->z_scale, z_zero = how->z_zero;
    int32_t suspect = 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t r = src[step * i], g = src[step * i + 1], b = src[step * i + 2];
        x[i] = (float) numerator(r, zero, neutral);
        y[i] = (float) numerator(g, zero, neutral);
        z[i] = (float) b * z_scale - z_zero;
        suspect |= ((r | g | b) == 0) | ((r & g & b) == 255);
        if (step == 4)
            suspect |= src[4 * i + 3] == 0;
    }
    return suspect;
}

static ALWAYS_INLINE float derived_z(float xy, float square)
{
    float rest = square - xy;
    return sqrtf(rest > 1 ? rest : 1);
}

/* x and y become slopes, by a mixed z; see slopes.c. */
static void mix(float *restrict x, float *restrict y, const float *restrict z, int32_t n,
                const ntp__slope_levels *how)
{
    const float square = how->square, part = 1 / square, sign = how->sign, least = how->least;
    for (int32_t i = 0; i < n; i++) {
        float xy = x[i] * x[i] + y[i] * y[i], made = derived_z(xy, square);
        float mixed = made + (xy < square ? xy : square) * part * (z[i] - made);
        float inverse = 1 / (mixed > least ? mixed : least);
        x[i] = -x[i] * inverse;
        y[i] = sign * y[i] * inverse;
    }
}

static int32_t slopes8(float *restrict right, float *restrict down_row, const uint8_t *src,
                       int32_t step, int32_t n, const ntp__slope_levels *how)
{
    const float square = how->square, sign = how->sign, least = how->least;
    float z[NTP__BLOCK];
    int32_t suspect = step == 3 ? levels8(right, down_row, z, src, 3, n, how)
                                : levels8(right, down_row, z, src, 4, n, how);
    if (how->mixed) {
        mix(right, down_row, z, n, how);
        return suspect;
    }
    for (int32_t i = 0; i < n && how->derived; i++)
        z[i] = derived_z(right[i] * right[i] + down_row[i] * down_row[i], square);
    for (int32_t i = 0; i < n; i++) {
        float below = z[i] > least ? z[i] : least;
        right[i] = -right[i] / below;
        down_row[i] = sign * down_row[i] / below;
    }
    return suspect;
}

/* ----------------------------------------------------------------------------- residual */

static void squares_off(double *restrict out, double *const *row, int32_t x, int32_t n)
{
    const double *restrict right = row[0] + x, *restrict down_row = row[1] + x;
    const double *restrict p = row[2] + x, *restrict q = row[3] + x;
    for (int32_t i = 0; i < n; i++) {
        double a = right[i], b = down_row[i], c = p[i], d = q[i];
        double ours = sqrt(1 + a * a + b * b), theirs = sqrt(1 + c * c + d * d);
        double ex = a / ours - c / theirs, ey = b / ours - d / theirs;
        out[i] = ex * ex + ey * ey;
    }
}

/* ---------------------------------------------------------------------------------- range */

static void find_range(float range[2], const float *row, int32_t n)
{
    enum { WIDE = 16 };
    float least[WIDE], most[WIDE];
    for (int32_t l = 0; l < WIDE; l++) {
        least[l] = range[0];
        most[l] = range[1];
    }
    int32_t whole = n - n % WIDE;
    for (int32_t i = 0; i < whole; i += WIDE) {
        for (int32_t l = 0; l < WIDE; l++) {
            least[l] = row[i + l] < least[l] ? row[i + l] : least[l];
            most[l] = row[i + l] > most[l] ? row[i + l] : most[l];
        }
    }
    for (int32_t i = whole; i < n; i++) {
        least[0] = row[i] < least[0] ? row[i] : least[0];
        most[0] = row[i] > most[0] ? row[i] : most[0];
    }
    for (int32_t l = 0; l < WIDE; l++) {
        range[0] = least[l] < range[0] ? least[l] : range[0];
        range[1] = most[l] > range[1] ? most[l] : range[1];
    }
}

/* ---------------------------------------------------------------------------------- table */

#define TABLE_NAME_(isa) ntp__solver_kernels_##isa
#define TABLE_NAME(isa)  TABLE_NAME_(isa)

extern const ntp__solver_kernels TABLE_NAME(NTP_ISA);
const ntp__solver_kernels TABLE_NAME(NTP_ISA) = {
    { forward_single, inverse_single, filter_single, respond_single },
    { forward_double, inverse_double, filter_double, respond_double },
    { set_pair_single, add_pair_single, sum_single, sum_squares_single },
    { set_pair_double, add_pair_double, sum_double, sum_squares_double },
    { down, down_live, up, up_live },
    slopes8,
    squares_off,
    find_range,
};
