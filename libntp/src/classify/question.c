/* SPDX-License-Identifier: MIT */
/*
 * question.c - sums over the evidence that several rules ask for
 */
#include "classify/question.h"
#include "classify/thresholds.h"

#include <math.h>

double ntp__count_bins(const ntp__evidence *e, int32_t first_bin, int32_t end_bin)
{
    double count = 0;
    for (int32_t i = first_bin; i < end_bin; i++)
        count += (double) e->steepness[i];
    return count;
}

double ntp__length_error(const ntp__evidence *e, int32_t first_bin, int32_t end_bin)
{
    double sum = 0, count = ntp__count_bins(e, first_bin, end_bin);
    for (int32_t i = first_bin; i < end_bin; i++)
        sum += (double) e->steepness[i] * e->steepness_length_error[i];
    return count > 0 ? sum / count : 0;
}

bool ntp__keep_to_a_line(const ntp__evidence *e, int32_t first, int32_t second)
{
    double a = e->used_sd[first] * e->used_sd[first], b = e->used_sd[second] * e->used_sd[second];
    double ab = e->correlation[first + second - 1] * e->used_sd[first] * e->used_sd[second];
    double middle = (a + b) / 2, apart = sqrt((a - b) * (a - b) / 4 + ab * ab);
    double across = most(middle - apart, 0);
    return across < LINE_WIDTH * LINE_WIDTH * (middle + apart) + LINE_NOISE * LINE_NOISE;
}

double ntp__block_step(const ntp__evidence *e)
{
    const double *step = e->block_step;
    double greatest = most(most(step[0], step[1]), step[2]);
    return step[0] + step[1] + step[2] - greatest - least(least(step[0], step[1]), step[2]);
}
