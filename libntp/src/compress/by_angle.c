/* SPDX-License-Identifier: MIT */
/*
 * by_angle.c - both channels of a block of normals by the angle between the vectors
 *
 * The vector of a texel is its x and y with z = sqrt(1 - x^2 - y^2), in the source and in the block.
 * The distance between two unit vectors stands for their angle.  Near the source its square is
 * dx^2 + dy^2 + dz^2 with z dz = -(x dx + y dy).  Where dy is known, this is the error of x from
 * another wanted value, with a weight.  So each channel is searched again with what the other has
 * come to.  A second round gains a hundredth of the error, and takes as long as all before.
 */
#include "compress/block.h"

#include <math.h>

enum { PAIRS = NTP__VALUES * NTP__VALUES, M16 = 65535 };

/* Less of z^2 counts as this much: the weights would have no bound. */
static const double LEAST_Z_SQUARED = 1.0 / 64;

typedef struct vectors {
    double x[PAIRS], y[PAIRS], z[PAIRS];
} vectors;

static double square(double v)
{
    return v * v;
}

static void set_vector(vectors *v, int32_t i, double x, double y)
{
    const double rest = 1 - x * x - y * y;
    const double length = rest < 0 ? sqrt(x * x + y * y) : 1;
    v->x[i] = x / length;
    v->y[i] = y / length;
    v->z[i] = rest > 0 ? sqrt(rest) : 0;
}

static double component(int32_t level)
{
    return (2 * level - M16) / (double) M16;
}

static double component_of_parts(int32_t parts)
{
    return (2.0 * parts / NTP__PARTS - M16) / M16;
}

/* The pair of values of each texel that is nearest to its vector.  Returns the sum of
 * the distances. */
static double choose_pairs(ntp__coded coded[2], const vectors *source, const uint8_t *seen)
{
    int32_t palette[2][NTP__VALUES];
    vectors pair;
    double sum = 0;
    for (int32_t c = 0; c < 2; c++)
        ntp__palette(palette[c], &coded[c].ends);
    for (int32_t k = 0; k < PAIRS; k++)
        set_vector(&pair, k, component_of_parts(palette[0][k % NTP__VALUES]),
                   component_of_parts(palette[1][k / NTP__VALUES]));
    for (int32_t i = 0; i < NTP__TEXELS; i++) {
        double error[PAIRS], least = 8;
        for (int32_t k = 0; k < PAIRS; k++)
            error[k] = square(pair.x[k] - source->x[i]) + square(pair.y[k] - source->y[i]) +
                       square(pair.z[k] - source->z[i]);
        for (int32_t k = 0; k < PAIRS; k++) {
            if (error[k] >= least)
                continue;
            least = error[k];
            coded[0].chosen[i] = (uint8_t) (k % NTP__VALUES);
            coded[1].chosen[i] = (uint8_t) (k / NTP__VALUES);
        }
        sum += seen[i] ? sqrt(least) : 0;
    }
    return sum;
}

/* What a channel shall be where the other is as it is coded. */
static void want_beside(ntp__wanted *wanted, const ntp__block_levels *block, int32_t channel,
                        const ntp__coded *other, const vectors *source)
{
    int32_t palette[NTP__VALUES];
    ntp__palette(palette, &other->ends);
    for (int32_t i = 0; i < NTP__TEXELS; i++) {
        const double own = channel == 0 ? source->x[i] : source->y[i];
        const double beside = channel == 0 ? source->y[i] : source->x[i];
        const double off =
            palette[other->chosen[i]] / (double) NTP__PARTS - block->level[1 - channel][i];
        double zz = square(source->z[i]);
        zz = zz > LEAST_Z_SQUARED ? zz : LEAST_Z_SQUARED;
        const double level = block->level[channel][i] - off * own * beside / (zz + own * own);
        wanted->level[i] = level < 0 ? 0 : level > M16 ? M16 : level;
        wanted->weight[i] = block->seen[i] * (1 + own * own / zz);
    }
}

void ntp__code_by_angle(ntp__coded coded[2], const ntp__block_levels *block)
{
    vectors source;
    for (int32_t i = 0; i < NTP__TEXELS; i++)
        set_vector(&source, i, component(block->level[0][i]), component(block->level[1][i]));
    double best = choose_pairs(coded, &source, block->seen);
    for (int32_t c = 0; c < 2; c++) {
        ntp__coded tried[2] = { coded[0], coded[1] };
        ntp__wanted wanted;
        want_beside(&wanted, block, c, &coded[1 - c], &source);
        tried[c].ends = ntp__search_ends(&wanted, true);
        const double error = choose_pairs(tried, &source, block->seen);
        if (error < best) {
            best = error;
            coded[0] = tried[0];
            coded[1] = tried[1];
        }
    }
}
