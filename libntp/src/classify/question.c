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

bool ntp__blue_is_idle(const ntp__evidence *e)
{
    double blue = e->stats.used_mean[2], off_end = least(blue, 1 - blue);
    if (e->used_sd[2] < CONSTANT_DEVIATION)
        return true;
    return off_end < IDLE_BLUE_OFF_END && e->used_sd[2] < IDLE_BLUE_DEVIATION &&
           off_end * e->blue_drop < IDLE_BLUE_DROP * (1 - blue) &&
           1 - blue > IDLE_BLUE_SLOPES * e->blue_drop &&
           distance(e->blue_slope, 0) < IDLE_BLUE_SLOPE &&
           distance(e->blue_correlation, 0) < IDLE_BLUE_FOLLOWS;
}

double ntp__blue_drop_before(const ntp__evidence *e)
{
    const double *sd = e->used_sd, *alike = e->correlation;
    double slopes = sd[0] * sd[0] + sd[1] * sd[1];
    double brightness = most(0, (alike[1] * sd[0] + alike[2] * sd[1]) * sd[2] / 2);
    return slopes > 0 ? e->blue_drop * slopes / (slopes + LOST_SLOPES * brightness) : 1;
}

double ntp__blue_alike(const ntp__evidence *e)
{
    double others = most(e->used_sd[0], e->used_sd[1]);
    if (e->used_sd[2] < BLUE_VARIES * others)
        return 0;
    return most(distance(e->correlation[1], 0), distance(e->correlation[2], 0));
}

/* The mean square of the difference of two channels. */
static double apart(const ntp__evidence *e, int32_t first, int32_t second)
{
    const double *sd = e->used_sd, *mean = e->stats.used_mean;
    double of_means = mean[first] - mean[second];
    double correlation = e->correlation[first + second - 1];
    return sd[first] * sd[first] + sd[second] * sd[second] -
           2 * correlation * sd[first] * sd[second] + of_means * of_means;
}

bool ntp__is_tinted_gray(const ntp__evidence *e)
{
    double most_apart = most(most(apart(e, 0, 1), apart(e, 0, 2)), apart(e, 1, 2));
    return most_apart < TINT * TINT && e->used_sd[1] > TINTED_VARIES * TINT &&
           least(e->correlation[1], e->correlation[2]) > NEARLY_ONE;
}

bool ntp__is_noise(const ntp__evidence *e)
{
    const double *mean = e->stats.used_mean, *sd = e->used_sd;
    double low = least(least(sd[0], sd[1]), sd[2]), high = most(most(sd[0], sd[1]), sd[2]);
    return distance(mean[2], mean[0]) < NOISE_MEAN && distance(mean[2], mean[1]) < NOISE_MEAN &&
           high < NOISE_SPREAD * low;
}

void ntp__set_shares(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    const ntp_fit *fit[2] = { &s->standard, &s->zzero };
    double x = 2 * s->used_mean[0] - 1, y = 2 * s->used_mean[1] - 1;
    q->all_used = most(1, (double) (s->texels - s->unused) - (double) s->not_finite);
    q->used = q->all_used - (double) e->padding;
    q->lean = sqrt(x * x + y * y);
    for (int32_t z = 0; z < 2; z++) {
        q->unit[z] = (double) (fit[z]->neighbor - fit[z]->unused_neighbor) / q->used;
        q->rounded[z] = (double) (fit[z]->rounded - fit[z]->unused_rounded) / q->used;
        q->near[z] = q->e->fit[z].near_unit[2];
    }
    q->negative = (double) e->used_z_negative / q->used;
    q->red_low = (double) e->red_low / q->used;
    q->green_low = (double) e->green_low / q->used;
    q->too_long = (double) (s->xy_too_long - s->unused_xy_too_long - e->padding) / q->used;
}

bool ntp__has_slopes(const question *q)
{
    return ntp__count_bins(q->e, 1, NTP__STEEPNESS_BINS) >=
           most(SLOPING_TEXELS_LEAST, TILTED_LEAST * q->used);
}

double ntp__steep_share(const question *q)
{
    return ntp__count_bins(q->e, NTP__STEEPNESS_BINS / 2, NTP__STEEPNESS_BINS) / q->used;
}

double ntp__too_long(const question *q)
{
    return (double) (q->s->xy_too_long - q->s->unused_xy_too_long) / q->all_used;
}
