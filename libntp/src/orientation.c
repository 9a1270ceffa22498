/* SPDX-License-Identifier: MIT */
/*
 * orientation.c - which way is green: OpenGL or DirectX, from the texels alone
 *
 * The normals of a surface have slopes p = -x/z across and q = y/z down the picture (Y up), with
 * dp/dy = dq/dx; with green the other way round, dp/dy = -dq/dx.  So the sign of the product of the
 * two tells.  Both derivatives are taken by one 6 x 6 filter: the mean over the loop between four
 * texels of slopes that a binomial of sigma 1 has smoothed.  Everything that is summed is an
 * integer, by the size of the derivatives and by the block of the picture, so that parts merge
 * exactly; large derivatives are weighted down at the end.  docs/orientation.md tells the rest.
 */
#include "internal.h"
#include "level.h"

enum {
    TAPS = 6,
    BEFORE = 2, /* taps before a loop's texel (x, y) */
    AFTER = 3,

    SLOPE_ONE = 4096, /* fixed-point unit of slopes; the steepest used slope is below 10 */

    BITS = 12,  /* kept of a derivative in a product */
    SIZES = 25, /* bit lengths 0..24: 384 (the filter's sum of magnitudes) times 10 SLOPE_ONE */

    SIDE = 16, /* blocks along each side of the picture */
    CELL = 8,  /* but no smaller than this, as neighboring loops share texels */

    STEP_LOOPS = 32, /* rows of loops there are at least in a large image */
    STEP_MAX = 128,

    STRETCH = NTP__BLOCK - TAPS + 1 /* loops in a block of texels */
};

/* [1 4 6 4 1] with [1 1], and with [-1 1]. */
static const int32_t SMOOTH[TAPS] = { 1, 5, 10, 10, 5, 1 };
static const int32_t STEEP[TAPS] = { -1, -3, -2, 2, 3, 1 };

struct ntp_orientation {
    uint32_t width, height, every_row; /* 0: empty */
    uint64_t loops[SIZES];
    uint64_t energy[SIZES];            /* sums of u*u + v*v, in units of the size */
    int64_t cross[SIDE * SIDE][SIZES]; /* sums of u*v, likewise */
};

size_t ntp_orientation_size(void)
{
    return sizeof(ntp_orientation);
}

/* Rows between the sampled ones, a power of two. */
static int32_t step_of(int32_t height)
{
    int32_t step = 1;
    while (step < STEP_MAX && step * 2 * STEP_LOOPS <= height)
        step *= 2;
    return step;
}

/* One row in each `step`; an odd share near the golden section of the step moves it on from one to
 * the next, so that no pattern of the picture keeps pace. */
int32_t ntp_orientation_row(int32_t height, int32_t every_row, int32_t y)
{
    if (y < BEFORE || y >= height - AFTER)
        return 0;
    int32_t step = every_row ? 1 : step_of(height), onward = (step * 5 / 8) | 1;
    return y % step == y / step * onward % step;
}

/* The texels of a column, filtered down the picture. */
typedef struct columns {
    int32_t u[NTP__BLOCK]; /* of -p, derived */
    int32_t v[NTP__BLOCK]; /* of q, smoothed */
    uint8_t bad[NTP__BLOCK];
} columns;

/* Adds a row of texels with its two weights. */
static void add_row(columns *sums, const ntp__block *block, int32_t n, int32_t m, uint32_t touch,
                    int32_t steep, int32_t smooth)
{
    for (int32_t i = 0; i < n; i++) {
        int32_t r = block->c[0][i], g = block->c[1][i], x = ntp__num(r, m), y = ntp__num(g, m);
        /* Exact for every level; the quotient of 8-bit texels is never near an integer. */
        double s = (double) m * m - (double) x * x - (double) y * y;
        bool steepest = 100 * s < (double) m * m; /* z < 1/10 */
        double scale = (double) SLOPE_ONE, z = sqrt(steepest ? 1.0 : s);
        int32_t p = (int32_t) ((double) x * scale / z), q = (int32_t) ((double) y * scale / z);
        sums->bad[i] |= (uint8_t) steepest;
        sums->u[i] += steep * (steepest ? 0 : p);
        sums->v[i] += smooth * (steepest ? 0 : q);
    }
    for (int32_t i = 0; i < n; i++) {
        sums->bad[i] |= (uint8_t) ntp__unused(block->c[0][i], block->c[1][i], block->c[2][i],
                                              block->c[3][i], m, touch);
    }
    if (block->any_broken) {
        for (int32_t i = 0; i < n; i++)
            sums->bad[i] |= block->broken[i];
    }
}

/* Bits that v takes, 0 for 0. */
static int32_t bit_length(uint32_t v)
{
    int32_t bits = 0;
    for (int32_t half = 16; half > 0; half /= 2) {
        if (v >> half != 0) {
            v >>= half;
            bits += half;
        }
    }
    return bits + (v != 0);
}

static void add_loop(ntp_orientation *acc, int64_t *cross, int32_t u, int32_t v)
{
    uint32_t au = (uint32_t) ntp__abs(u), av = (uint32_t) ntp__abs(v);
    int32_t size = bit_length(au > av ? au : av), shift = size > BITS ? size - BITS : 0;
    uint64_t a = au >> shift, b = av >> shift;
    acc->loops[size]++;
    acc->energy[size] += a * a + b * b;
    cross[size] += (u < 0) == (v < 0) ? (int64_t) (a * b) : -(int64_t) (a * b);
}

static int32_t cell(int32_t side)
{
    int32_t least = (side + SIDE - 1) / SIDE;
    return least < CELL ? CELL : least;
}

/* The loops of row y from x on; n of them. */
static void add_stretch(ntp_orientation *acc, const ntp_const_image *src, uint32_t touch, int32_t x,
                        int32_t y, int32_t n)
{
    columns sums = { { 0 }, { 0 }, { 0 } };
    ntp__block block;
    int32_t m = ntp__max(src->type), texels = n + TAPS - 1, wide = cell(src->width);
    for (int32_t k = 0; k < TAPS; k++) {
        ntp__unpack(&block, src, x - BEFORE, y - BEFORE + k, texels);
        add_row(&sums, &block, texels, m, touch, -STEEP[k], SMOOTH[k]);
    }
    int64_t(*row)[SIZES] = acc->cross + y / cell(src->height) * SIDE;
    for (int32_t i = 0; i < n; i++) {
        int32_t u = 0, v = 0, bad = 0;
        for (int32_t k = 0; k < TAPS; k++) {
            u += SMOOTH[k] * sums.u[i + k];
            v += STEEP[k] * sums.v[i + k];
            bad |= sums.bad[i + k];
        }
        if (!bad)
            add_loop(acc, row[(x + i) / wide], u, v);
    }
}

/* Makes the accumulator one of this image, or tells that it is of another. */
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

ntp_status ntp_orientation_measure(ntp_orientation *orientation, const ntp_const_image *src,
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
            add_stretch(orientation, src, touch_unused, x, y, x1 - x < STRETCH ? x1 - x : STRETCH);
    }
    return NTP_OK;
}

ntp_status ntp_orientation_merge(ntp_orientation *into, const ntp_orientation *from)
{
    if (into == NULL || from == NULL)
        return NTP_ERR_ARGUMENT;
    if (from->width == 0)
        return NTP_OK;
    NTP__TRY(adopt(into, from->width, from->height, from->every_row));
    for (int32_t k = 0; k < SIZES; k++) {
        into->loops[k] += from->loops[k];
        into->energy[k] += from->energy[k];
        for (int32_t i = 0; i < SIDE * SIDE; i++)
            into->cross[i][k] += from->cross[i][k];
    }
    return NTP_OK;
}

/* What is found in real textures with a label: below these the answers begin to be wrong. */
static const double LEAST_STATISTIC = 0.1, LEAST_SCORE = 5;
/* From here on it is as sure as it gets. */
static const double SURE_STATISTIC = 0.5, SURE_SCORE = 10;
/* Labeled textures contradict even a clear answer now and then. */
static const double CONFIDENCE_LEAST = 0.8, CONFIDENCE_MOST = 0.99;

/* Weights that hold derivatives of more than three times the root mean square to it, and 4^shift to
 * undo what add_loop shifted out; false: nothing varies. */
static bool weigh(double weight[SIZES], double *energy, const ntp_orientation *acc)
{
    double total = 0, loops = 0, held = 0;
    for (int32_t k = 0; k < SIZES; k++) {
        int32_t shift = k > BITS ? k - BITS : 0;
        weight[k] = (double) ((int64_t) 1 << 2 * shift);
        total += (double) acc->energy[k] * weight[k];
        loops += (double) acc->loops[k];
    }
    if (total <= 0)
        return false;
    for (int32_t k = 0; k < SIZES; k++) {
        double own = (double) acc->energy[k] * weight[k];
        double most = 9 * (total / loops) * (double) acc->loops[k];
        if (own > most)
            weight[k] *= most / own;
        held += (double) acc->energy[k] * weight[k];
    }
    *energy = held;
    return true;
}

static double held_to_one(double v)
{
    return v < 1 ? v : 1;
}

ntp_status ntp_orientation_decide(ntp_orientation_result *result,
                                  const ntp_orientation *orientation)
{
    if (result == NULL || orientation == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_orientation_result r = { 0, NTP_Y_UP, 0, 0, 0, 0 };
    double weight[SIZES], energy, sum = 0, squares = 0;
    for (int32_t k = 0; k < SIZES; k++)
        r.loops += orientation->loops[k];
    *result = r;
    if (!weigh(weight, &energy, orientation))
        return NTP_OK;
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        double block = 0;
        for (int32_t k = 0; k < SIZES; k++)
            block += (double) orientation->cross[i][k] * weight[k];
        sum += block;
        squares += block * block;
    }
    r.statistic = 2 * sum / energy;
    r.score = squares > 0 ? sum / sqrt(squares) : 0;
    double clear = sum < 0 ? -r.statistic : r.statistic, steady = sum < 0 ? -r.score : r.score;
    r.y = sum < 0 ? NTP_Y_DOWN : NTP_Y_UP;
    r.decided = clear >= LEAST_STATISTIC && steady >= LEAST_SCORE;
    if (r.decided) {
        double a = held_to_one(clear / SURE_STATISTIC), b = held_to_one(steady / SURE_SCORE);
        r.confidence = CONFIDENCE_LEAST + (CONFIDENCE_MOST - CONFIDENCE_LEAST) * (a < b ? a : b);
    }
    *result = r;
    return NTP_OK;
}
