/* SPDX-License-Identifier: MIT */
/*
 * orientation.c - which way green points: OpenGL or DirectX, from the texels alone
 *
 * This room finds out from its texels how a texture was made.
 *   orientation.c  which way green points; stretch_avx2.c and stretch_avx512.c do the same with vectors
 *   find_kernel.c  which kernel took the slopes
 *   find_border.c  which border the heights had at the edges
 *   find_borders.c the borders of both axes, from bands of the texture
 *   ends_meet.c    which of them is the better guess for a damaged texture
 *   find_seams.c   whether the texture tiles
 *   find_steps.c   whether slopes come in steps, because the heights had few levels
 *
 * Normals (Y up) have slopes p = -x/z to the right and q = y/z down the picture.  On a surface
 * dp/dy = dq/dx; if green points the other way, dp/dy = -dq/dx.  So the sign of the product of the
 * two tells.  Both derivatives are taken on a loop between four texels, by two filters: a wide one
 * of 6 x 6 texels, the mean of slopes that a binomial of sigma 1 has smoothed, which noise hardly
 * disturbs, and a narrow one of these four texels alone, which edges hardly disturb.  All sums are
 * integers, kept by the size of the derivatives and by the block of the picture, so parts merge
 * exactly.  Large derivatives get less weight at the end.  docs/orientation.md tells the rest.
 */
#include "base/cpu.h"
#include "detect/stretch.h"
#include "texel/level.h"

#include <math.h>
#include <string.h>

enum {
    STEP_LOOPS = 32, /* least number of rows of loops in a large image */
    STEP_MOST_BITS = 7
};

size_t ntp_orientation_size(void)
{
    return sizeof(ntp_orientation);
}

/* Rows between the sampled ones, as a power of 2. */
static int32_t step_bits(int32_t height)
{
    int32_t bits = 0;
    while (bits < STEP_MOST_BITS && STEP_LOOPS << (bits + 1) <= height)
        bits++;
    return bits;
}

/* One row in each `step` rows.  From one step to the next its place moves on by an odd number near
 * the golden section of the step, so no pattern of the picture keeps pace with it. */
int32_t ntp_orientation_row(int32_t height, int32_t every_row, int32_t y)
{
    if (y < BEFORE || y >= height - AFTER)
        return 0;
    const int32_t bits = every_row ? 0 : step_bits(height), step = 1 << bits;
    const int32_t onward = (step * 5 / 8) | 1;
    return ((y ^ (y >> bits) * onward) & (step - 1)) == 0;
}

/* p and q of a row, and their parts of the columns.  Texels with z below 1/10 are bad; black and white
 * are among them. */
static void add_slopes(columns *restrict sums, float *restrict p, float *restrict q,
                       const int32_t *restrict r, const int32_t *restrict g, int32_t n, int32_t m,
                       float steep, float smooth)
{
    uint32_t m2 = (uint32_t) m * (uint32_t) m, least = ntp__least_rest(m);
    int32_t far = ntp__far_sum(m);
    /* The shift keeps S within int32_t; x and y are scaled to match z. */
    int32_t half = m == 255 ? 0 : 1, shift = 2 * half;
    for (int32_t i = 0; i < n; i++) {
        int32_t x = ntp__num(r[i], m), y = ntp__num(g[i], m);
        uint32_t ax = (uint32_t) ntp__abs(x), ay = (uint32_t) ntp__abs(y);
        uint32_t most = m2 - ax * ax, y2 = ay * ay, s = most > y2 ? most - y2 : 0;
        int32_t end = ntp__abs(x + y) > far;
        sums->bad[i] |= s < least ? TOO_STEEP + end : 0;
        s = s < least ? least : s;
        /* Each step is rounded to float, even where the processor calculates with more bits.  For
         * one root or one quotient the result is the same. */
        float z = sqrtf((float) (int32_t) (s >> shift));
        float px = (float) (x * (1 << (SLOPE_ONE_BITS - half))) / z,
              py = (float) (y * (1 << (SLOPE_ONE_BITS - half))) / z;
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

/* Adds row k of the texels around a row of loops. */
static void add_row(columns *sums, ntp__block *block, int32_t n, int32_t m, uint32_t touch,
                    int32_t k)
{
    float between[2][NTP__BLOCK];
    const bool middle = k == BEFORE || k == BEFORE + 1;
    float *const p = middle ? sums->p[k - BEFORE] : between[0];
    float *const q = middle ? sums->q[k - BEFORE] : between[1];
    add_slopes(sums, p, q, block->c[0], block->c[1], n, m, -STEEP[k], SMOOTH[k]);
    if (!(touch & NTP_UNUSED_TRANSPARENT)) {
        for (int32_t i = 0; i < n; i++)
            sums->bad[i] |= block->c[3][i] == 0 ? NO_NORMAL : 0;
    }
    if (block->any_broken) {
        for (int32_t i = 0; i < n; i++)
            sums->bad[i] |= block->broken[i] ? NO_NORMAL : 0;
    }
}

/* The other direction of the filter, for loops: a smoothed and b derived along the row. */
static void across(float *smooth, float *steep, const float *a, const float *b, int32_t n)
{
    for (int32_t i = 0; i < n; i++, a++, b++) {
        smooth[i] = (a[0] + a[5]) + 5 * (a[1] + a[4]) + 10 * (a[2] + a[3]);
        steep[i] = (b[5] - b[0]) + 3 * (b[4] - b[1]) + 2 * (b[3] - b[2]);
    }
}

static void any_bad(int32_t *bad, const columns *c, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        const int32_t *a = c->bad + i;
        bad[i] = a[0] | a[1] | a[2] | a[3] | a[4] | a[5];
    }
}

/* What loops add, in planes, of which compilers make vectors. */
typedef struct products {
    int32_t size[COLUMNS], energy[COLUMNS], cross[COLUMNS];
} products;

/* Integers u and v, of which the greater magnitude takes `size` bits, lose their lowest bits.  Quotients by
 * a power of 2 are rounded toward 0, so both signs lose them alike. */
static void multiply(products *restrict to, const float *restrict u, const float *restrict v,
                     int32_t n)
{
    enum { MANTISSA_BITS = 23, ONE = 127, HALF = 126, NO_SIGN = 0x7fffffff };
    for (int32_t i = 0; i < n; i++) {
        int32_t au, av;
        float part;
        memcpy(&au, &u[i], sizeof au);
        memcpy(&av, &v[i], sizeof av);
        au &= NO_SIGN;
        av &= NO_SIGN;
        /* Exponents as stored, which are 0 of 0 and -0. */
        const int32_t most = (au > av ? au : av) >> MANTISSA_BITS;
        const int32_t size = most > HALF ? most - HALF : 0;
        const int32_t shift = size > BITS ? size - BITS : 0;
        const int32_t bits = (ONE - shift) << MANTISSA_BITS;
        memcpy(&part, &bits, sizeof part);
        const int16_t a = (int16_t) (int32_t) (u[i] * part), b = (int16_t) (int32_t) (v[i] * part);
        to->size[i] = size;
        to->energy[i] = a * a + b * b;
        to->cross[i] = a * b;
    }
}

static inline void add_loop(loop_sums *acc, int32_t block, const products *of, int32_t i)
{
    const int32_t size = of->size[i];
    acc->loops[size]++;
    acc->energy[size] += (uint32_t) of->energy[i];
    acc->cross[size][block] += of->cross[i];
}

/* Each loop by its own four texels alone. */
static void multiply_narrow(products *to, const columns *c, int32_t n)
{
    const float *p = c->p[0] + BEFORE, *q = c->q[0] + BEFORE;
    const float *p1 = c->p[1] + BEFORE, *q1 = c->q[1] + BEFORE;
    float u[COLUMNS], v[COLUMNS];
    for (int32_t i = 0; i < n; i++) {
        u[i] = (p[i] + p[i + 1]) - (p1[i] + p1[i + 1]);
        v[i] = (q[i + 1] + q1[i + 1]) - (q[i] + q1[i]);
    }
    multiply(to, u, v, n);
}

/* Adds n loops of row y, from x on. */
static void add_stretch(ntp_orientation *acc, const ntp_const_image *src, uint32_t touch, int32_t x,
                        int32_t y, int32_t n)
{
    columns sums;
    products wide_ones, narrow_ones;
    ntp__block block;
    float u[COLUMNS], v[COLUMNS], p_x[COLUMNS], q_y[COLUMNS];
    int32_t bad[COLUMNS];
    int32_t m = ntp__max(src->type), texels = n + TAPS - 1, wide = ntp__cell_side(src->width);
    const int32_t whole = (n + COLUMN_LANES - 1) & -COLUMN_LANES;
    memset(&sums, 0, sizeof sums);
    for (int32_t k = 0; k < TAPS; k++) {
        ntp__unpack(&block, src, x - BEFORE, y - BEFORE + k, texels);
        add_row(&sums, &block, texels, m, touch, k);
    }
    across(u, v, sums.u, sums.v, whole);
    across(q_y, p_x, sums.q_steep, sums.p_smooth, whole);
    any_bad(bad, &sums, whole);
    multiply(&wide_ones, u, v, whole);
    multiply_narrow(&narrow_ones, &sums, whole);
    int32_t cell_y = y / ntp__cell_side(src->height) * SIDE, cell_x = x / wide,
            next = (cell_x + 1) * wide - x; /* the loop the next block starts */
    for (int32_t i = 0; i < n; i++) {
        if (i == next) {
            cell_x++;
            next += wide;
        }
        acc->steep += bad[i] == TOO_STEEP;
        if (bad[i])
            continue;
        add_loop(&acc->sums[WIDE], cell_y + cell_x, &wide_ones, i);
        add_loop(&acc->sums[NARROW], cell_y + cell_x, &narrow_ones, i);
        int64_t a = (int64_t) p_x[i] / ALONG_UNIT, b = (int64_t) q_y[i] / ALONG_UNIT;
        acc->along += (uint64_t) (a * a + b * b);
        a = (int64_t) sums.p[0][i + BEFORE], b = (int64_t) sums.q[0][i + BEFORE];
        int64_t both = a * b;
        acc->both += (uint64_t) (both < 0 ? -2 * both : 2 * both);
        acc->either += (uint64_t) (a * a + b * b);
    }
}

static void add_some(ntp_orientation *acc, const ntp_const_image *src, uint32_t touch, int32_t x,
                     int32_t y, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__add_stretch_avx2(acc, src, touch, x, y, n);
        return;
    }
#endif
    add_stretch(acc, src, touch, x, y, n);
}

/* Makes the accumulator one of this image; an error: it is one of another. */
static ntp_status adopt(ntp_orientation *acc, uint32_t width, uint32_t height, uint32_t every_row)
{
    if (acc->width != 0 &&
        (acc->width != width || acc->height != height || acc->every_row != every_row))
        return NTP_ERR_SHAPE;
    acc->width = width;
    acc->height = height;
    acc->every_row = every_row;
    return NTP_OK;
}

ntp_status ntp_orientation_add(ntp_orientation *orientation, const ntp_const_image *src,
                               uint32_t touch_unused, int32_t every_row, const ntp_rect *area)
{
    if (orientation == NULL || touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    NTP__TRY(adopt(orientation, (uint32_t) src->width, (uint32_t) src->height, every_row != 0));
    int32_t x0 = rect.x0 < BEFORE ? BEFORE : rect.x0;
    int32_t x1 = rect.x1 > src->width - AFTER ? src->width - AFTER : rect.x1;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        if (!ntp_orientation_row(src->height, every_row, y))
            continue;
        for (int32_t x = x0; x < x1; x += STRETCH)
            add_some(orientation, src, touch_unused, x, y, x1 - x < STRETCH ? x1 - x : STRETCH);
    }
    return NTP_OK;
}

static void merge_sums(loop_sums *into, const loop_sums *from)
{
    for (int32_t k = 0; k < SIZES; k++) {
        into->loops[k] += from->loops[k];
        into->energy[k] += from->energy[k];
        for (int32_t i = 0; i < SIDE * SIDE; i++)
            into->cross[k][i] += from->cross[k][i];
    }
}

ntp_status ntp_orientation_merge(ntp_orientation *into, const ntp_orientation *from)
{
    if (into == NULL || from == NULL)
        return NTP_ERR_ARGUMENT;
    if (from->width == 0)
        return NTP_OK;
    NTP__TRY(adopt(into, from->width, from->height, from->every_row));
    into->steep += from->steep;
    into->along += from->along;
    into->both += from->both;
    into->either += from->either;
    for (int32_t f = 0; f < FILTERS; f++)
        merge_sums(&into->sums[f], &from->sums[f]);
    return NTP_OK;
}

ntp_status ntp_orientation_clear(ntp_orientation *orientation)
{
    if (orientation == NULL)
        return NTP_ERR_ARGUMENT;
    memset(orientation, 0, sizeof *orientation);
    return NTP_OK;
}
