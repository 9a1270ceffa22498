/* SPDX-License-Identifier: MIT */
/*
 * stretch.h - the loops of a stretch of texels, for orientation.c and stretch_avx2.c
 */
#ifndef NTP_STRETCH_H
#define NTP_STRETCH_H

#include "base/view.h"
#include "detect/orientation.h"

enum {
    TAPS = 6,
    BEFORE = 2, /* taps before a loop's texel (x, y) */
    AFTER = 3,

    CELL =
        4, /* blocks of the picture are no smaller than this, as neighboring loops share texels */

    SLOPE_ONE_BITS =
        12, /* of the fixed-point unit of slopes; the steepest used slope is below 10 */

    STRETCH = NTP__BLOCK - TAPS + 1 /* loops in a block of texels */
};

/* [1 4 6 4 1] convolved with [1 1], and with [-1 1]. */
static const float SMOOTH[TAPS] = { 1, 5, 10, 10, 5, 1 };
static const float STEEP[TAPS] = { -1, -3, -2, 2, 3, 1 };

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

/* Texels whose S = M*M - x*x - y*y is smaller are too steep: z is below 1/10. */
static inline uint32_t ntp__least_rest(int32_t m)
{
    return (uint32_t) m * (uint32_t) m / 100 + 1;
}

/* Black, white, and what JPEG makes of them have x + y further from 0: longer than 1.13, so no normal. */
static inline int32_t ntp__far_sum(int32_t m)
{
    return m * 8 / 5;
}

/* The block of the picture's grid that a loop belongs to, along one side. */
static inline int32_t ntp__cell_side(int32_t side)
{
    int32_t least = (side + SIDE - 1) / SIDE;
    return least < CELL ? CELL : least;
}

#ifdef NTP_HAVE_AVX2
/* Adds n <= STRETCH loops of row y, from x on. */
void ntp__add_stretch_avx2(ntp_orientation *acc, const ntp_const_image *src, uint32_t touch,
                           int32_t x, int32_t y, int32_t n);
#endif
#ifdef NTP_HAVE_AVX512
/* Filters n >= 16 columns of packed texels of 8 bit; `alpha`: those of alpha 0 hold no normal. */
void ntp__filter_down8_avx512(columns *to, const uint8_t *const rows[TAPS], int32_t channels,
                              int32_t n, bool alpha);
#endif

#endif
