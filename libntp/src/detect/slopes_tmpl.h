/* SPDX-License-Identifier: MIT */
/*
 * slopes_tmpl.h - the slopes of a row, added to columns; compiled for AVX2 too (slopes_avx2.c)
 */
#ifndef NTP_SLOPES_TMPL_H
#define NTP_SLOPES_TMPL_H

#include "base/view.h"
#include "texel/level.h"

#include <math.h>

enum { SLOPE_ONE = 4096 /* fixed-point unit of slopes; the steepest used slope is below 10 */ };

/* Why a texel cannot be used. */
enum { TOO_STEEP = 1, NO_NORMAL = 2 };

/* Loops over columns go on to whole lanes, so that none has a remainder. */
enum { COLUMN_LANES = 8, COLUMNS = NTP__BLOCK + COLUMN_LANES };

/* Columns of texels, filtered down the picture.  All values are integers below 2^24: there float
 * arithmetic is exact, and it is fast on every processor. */
typedef struct columns {
    float u[COLUMNS]; /* of -p, derived */
    float v[COLUMNS]; /* of q, smoothed */
    float p_smooth[COLUMNS], q_steep[COLUMNS];
    int32_t bad[COLUMNS];
    float p[2][COLUMNS], q[2][COLUMNS]; /* of the two rows in the middle: not sums */
} columns;

/* p and q of a row, and their parts of the columns.  Texels with z below 1/10 are bad; black and white
 * are among them. */
static inline void ntp__add_slopes(columns *restrict sums, float *restrict p, float *restrict q,
                                   const int32_t *restrict r, const int32_t *restrict g, int32_t n,
                                   int32_t m, float steep, float smooth)
{
    uint32_t m2 = (uint32_t) m * (uint32_t) m, least = m2 / 100 + 1;
    int32_t far = m * 8 / 5;
    /* The shift keeps S within int32_t; x and y are scaled to match z. */
    uint32_t shift = m == 255 ? 0 : 2, half = shift / 2;
    for (int32_t i = 0; i < n; i++) {
        int32_t x = ntp__num(r[i], m), y = ntp__num(g[i], m);
        uint32_t ax = (uint32_t) ntp__abs(x), ay = (uint32_t) ntp__abs(y);
        uint32_t most = m2 - ax * ax, y2 = ay * ay, s = most > y2 ? most - y2 : 0;
        /* Black, white, and what JPEG makes of them: longer than 1.13, so it is no normal. */
        int32_t end = ntp__abs(x + y) > far;
        sums->bad[i] |= s < least ? TOO_STEEP + end : 0;
        s = s < least ? least : s;
        /* Each step is rounded to float, even where the processor calculates with more bits.  For
         * one root or one quotient the result is the same. */
        float z = sqrtf((float) (int32_t) (s >> shift));
        float px = (float) (x * (SLOPE_ONE >> half)) / z,
              py = (float) (y * (SLOPE_ONE >> half)) / z;
        /* Compilers may truncate these as floats, which makes -0 of small ones. */
        p[i] = (float) (int32_t) px;
        q[i] = (float) (int32_t) py;
    }
    for (int32_t i = 0; i < n; i++) {
        sums->u[i] += steep * p[i];
        sums->v[i] += smooth * q[i];
        sums->p_smooth[i] += smooth * p[i];
        sums->q_steep[i] += steep * q[i];
    }
}

#ifdef NTP_HAVE_AVX2
/* The same of whole lanes: red and green change beyond n. */
void ntp__add_slopes_avx2(columns *sums, float *p, float *q, ntp__block *block, int32_t n,
                          int32_t m, float steep, float smooth);
#endif

#endif
