/* SPDX-License-Identifier: MIT */
/*
 * summarize.c - the facts that follow from a tally
 */
#include "srgb.h"
#include "tally.h"

#include <math.h>
#include <string.h>

static void merge_max(uint32_t *into, uint32_t from)
{
    if (from > *into)
        *into = from;
}

static uint64_t flagged(const ntp__fit_sums *fit, uint32_t mask, uint32_t value)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < NTP_STEEPNESS_BINS * 256; i++)
        count += (i & mask) == value ? fit->flags[i] : 0;
    return count;
}

static double share(uint64_t part, uint64_t whole)
{
    return whole > 0 ? (double) part / (double) whole : 0.0;
}

/* Texels whose length lies within `bins` of 1/128 from 1. */
static uint64_t near_unit(const ntp__fit_sums *fit, int32_t bins)
{
    uint64_t count = 0;
    for (int32_t i = 128 - bins; i < 128 + bins; i++)
        count += fit->lengths[i];
    return count;
}

static void describe_fit(ntp_fit *out, const ntp_tally *t, int32_t z)
{
    const ntp__fit_sums *used = &t->used.fit[z], *unused = &t->unused.fit[z];
    uint64_t n = t->used.texels, all = n + t->unused.texels;
    out->unused_neighbor = flagged(unused, NTP_PASS_NEIGHBOR, NTP_PASS_NEIGHBOR);
    out->unused_rounded = flagged(unused, NTP_PASS_ROUNDED, NTP_PASS_ROUNDED);
    out->unused_exact = flagged(unused, NTP_PASS_EXACT, NTP_PASS_EXACT);
    out->neighbor = out->unused_neighbor + flagged(used, NTP_PASS_NEIGHBOR, NTP_PASS_NEIGHBOR);
    out->rounded = out->unused_rounded + flagged(used, NTP_PASS_ROUNDED, NTP_PASS_ROUNDED);
    out->exact = out->unused_exact + flagged(used, NTP_PASS_EXACT, NTP_PASS_EXACT);
    out->exact_mirrored =
        flagged(used, NTP__MIRRORED, NTP__MIRRORED) + flagged(unused, NTP__MIRRORED, NTP__MIRRORED);
    uint64_t le = 0;
    for (int32_t i = 0; i < 4; i++) {
        le += used->levels_off[i];
        out->used_levels_le[i] = le;
    }
    double one = NTP__LENGTH_ONE;
    uint32_t inverted = used->length_inverted_min > unused->length_inverted_min
                            ? used->length_inverted_min
                            : unused->length_inverted_min;
    uint32_t longest =
        used->length_max > unused->length_max ? used->length_max : unused->length_max;
    out->length_min = all > 0 ? ~inverted / one : 0.0;
    out->length_max = longest / one;
    out->length_mean = share(used->length_sum + unused->length_sum, all) / one;
    out->used_length_mean = share(used->length_sum, n) / one;
    double off = out->used_length_mean - 1.0;
    double variance = share(used->length_error2, n) / (one * one) - off * off;
    out->used_length_sd = n > 0 && variance > 0 ? sqrt(variance) : 0.0;
    for (int32_t i = 0; i < 3; i++)
        out->used_near_unit[i] = share(near_unit(used, 4 << i), n);
    out->used_short = share(flagged(used, NTP_PASS_ROUNDED | NTP__LONG, 0), n);
    out->used_long = share(flagged(used, NTP_PASS_ROUNDED | NTP__LONG, NTP__LONG), n);
}

static void describe_steepness(ntp_stats *s, const ntp__fit_sums *fit)
{
    for (int32_t i = 0; i < NTP_STEEPNESS_BINS; i++) {
        uint64_t all = 0, rounded = 0, neighbor = 0;
        const uint32_t *flags = &fit->flags[i * 256];
        for (uint32_t f = 0; f < 256; f++) {
            all += flags[f];
            rounded += f & NTP_PASS_ROUNDED ? flags[f] : 0;
            neighbor += f & NTP_PASS_NEIGHBOR ? flags[f] : 0;
        }
        s->steepness[i] = all;
        s->steepness_not_rounded[i] = all - rounded;
        s->steepness_not_neighbor[i] = all - neighbor;
        s->steepness_length_error[i] = share(fit->length_error[i], all) / NTP__LENGTH_ONE;
    }
}

static void channel_from(ntp_channel *out, const ntp__channel_sums *sums, uint64_t texels,
                         uint32_t by)
{
    out->min = texels > 0 ? ~sums->inverted_min / by : 0;
    out->max = sums->max / by;
    out->mean = share(sums->sum, texels) / by;
}

/* Channels of 8-bit images: red and green from the pairs, blue from the cells. */
static void describe_channels8(ntp_stats *s, const ntp_tally *t)
{
    ntp__channel_sums sums[3];
    memcpy(sums, t->channel, sizeof sums);
    for (int32_t i = 0; i < 65536; i++) {
        uint64_t n = t->pair_texels[i];
        if (n == 0)
            continue;
        uint32_t level[2] = { (uint32_t) i & 255, (uint32_t) i >> 8 };
        for (int32_t k = 0; k < 2; k++) {
            sums[k].sum += level[k] * n;
            merge_max(&sums[k].max, level[k]);
            merge_max(&sums[k].inverted_min, ~level[k]);
        }
        sums[2].sum += t->pair_blue[i];
        const uint32_t *cell = t->cell[t->row_of[i]];
        for (uint32_t b = 0; b < 256; b++) {
            if (cell[b] > 0) {
                merge_max(&sums[2].max, b);
                merge_max(&sums[2].inverted_min, ~b);
            }
        }
    }
    for (int32_t k = 0; k < 3; k++) {
        if (t->black > 0)
            merge_max(&sums[k].inverted_min, ~0u);
        if (t->white > 0) {
            merge_max(&sums[k].max, 255);
            merge_max(&sums[k].inverted_min, ~255u);
            sums[k].sum += 255 * t->white;
        }
        channel_from(&s->channel[k], &sums[k], t->texels - t->not_finite, 1);
    }
}

static void describe_alpha(ntp_stats *s, const ntp_tally *t)
{
    bool alpha = t->channels == 4 || (t->encoding == NTP_HEIGHT && t->channels == 2);
    double mean = 0, square = 0;
    uint64_t n = 0;
    ntp__channel_sums sums = { 0, 0, 0 };
    if (!alpha)
        return;
    for (uint32_t a = 0; a < 256; a++) {
        uint64_t count = t->alpha[a];
        n += count;
        mean += (double) (count * a) / 255.0;
        square += (double) (count * a * a) / (255.0 * 255.0);
        if (count > 0) {
            merge_max(&sums.max, a);
            merge_max(&sums.inverted_min, ~a);
            sums.sum += a * count;
        }
    }
    s->used_mean[3] = mean / (double) n;
    double variance = square / (double) n - s->used_mean[3] * s->used_mean[3];
    s->used_sd[3] = variance > 0 ? sqrt(variance) : 0;
    if (t->depth == 8) {
        channel_from(&s->channel[3], &sums, n, 1);
        s->alpha_zero = t->alpha[0];
        s->alpha_full = t->alpha[255];
    } else {
        channel_from(&s->channel[3], &t->alpha_levels, n, s->max == 255 ? 257 : 1);
        s->alpha_zero = t->wide_alpha_ends[0];
        s->alpha_full = t->wide_alpha_ends[1];
    }
}

static bool linear_near_unit(uint32_t r, uint32_t g, double b)
{
    double low = NTP__LINEAR_OF_SRGB[(int32_t) b], fraction = b - (int32_t) b;
    double high = NTP__LINEAR_OF_SRGB[b < 255 ? (int32_t) b + 1 : 255];
    double x = NTP__LINEAR_OF_SRGB[r] / 32767.5 - 1, y = NTP__LINEAR_OF_SRGB[g] / 32767.5 - 1;
    double z = (low + (high - low) * fraction) / 32767.5 - 1;
    double square = x * x + y * y + z * z;
    return square >= 0.875 * 0.875 && square <= 1.125 * 1.125;
}

/* Moments of the used colors from the pairs. */
typedef struct moments {
    double n, sum[3], square[2], product[3];
} moments;

static double correlate(double product, double sum_a, double sum_b, double var_a, double var_b,
                        double n)
{
    double covariance = product / n - sum_a / n * (sum_b / n), scale = sqrt(var_a * var_b);
    return scale > 1e-12 ? covariance / scale : 0.0;
}

static double variance_of(double square, double sum, double n)
{
    double v = square / n - sum / n * (sum / n);
    return v > 0 ? v : 0;
}

static double blue_square(const ntp_tally *t)
{
    /* Of mean blues per pair for 16 bit, which keep no cells; exact for 8 bit. */
    double square = 0;
    if (t->wide.texels == 0 && t->encoding != NTP_HEIGHT) {
        uint64_t count[256] = { 0 };
        uint8_t used[NTP__ROWS];
        memset(used, 0, sizeof used);
        for (int32_t i = 0; i < 65536; i++)
            used[t->row_of[i]] |= t->pair_texels[i] > 0;
        for (int32_t row = 0; row < NTP__ROWS; row++) {
            for (int32_t b = 0; used[row] && b < 256; b++)
                count[b] += t->cell[row][b];
        }
        for (int32_t b = 0; b < 256; b++)
            square += (double) count[b] * b * b / (255.0 * 255.0);
        return square;
    }
    for (int32_t i = 0; i < 65536; i++) {
        double n = (double) t->pair_texels[i], b = (double) t->pair_blue[i] / 255.0;
        square += n > 0 ? b * b / n : 0;
    }
    return square;
}

static void describe_pairs(ntp_stats *s, const ntp_tally *t)
{
    moments m = { 0 };
    uint64_t gamma = 0, used = 0;
    for (int32_t i = 0; i < 65536; i++) {
        uint64_t n = t->pair_texels[i];
        if (n == 0)
            continue;
        uint32_t r = (uint32_t) i & 255, g = (uint32_t) i >> 8;
        double x = r / 255.0, y = g / 255.0, dn = (double) n;
        double blue = (double) t->pair_blue[i] / 255.0;
        used += n;
        m.sum[0] += dn * x;
        m.sum[1] += dn * y;
        m.sum[2] += blue;
        m.square[0] += dn * x * x;
        m.square[1] += dn * y * y;
        m.product[0] += dn * x * y;
        m.product[1] += x * blue;
        m.product[2] += y * blue;
        s->red_low += r < 128 ? n : 0;
        s->green_low += g < 128 ? n : 0;
        s->near_gamma_flat += r >= 185 && r <= 191 && g >= 185 && g <= 191 ? n : 0;
        gamma += linear_near_unit(r, g, blue / dn * 255.0) ? n : 0;
    }
    m.n = (double) used;
    if (used == 0)
        return;
    double var[3] = { variance_of(m.square[0], m.sum[0], m.n),
                      variance_of(m.square[1], m.sum[1], m.n),
                      variance_of(blue_square(t), m.sum[2], m.n) };
    for (int32_t k = 0; k < 3; k++) {
        s->used_mean[k] = m.sum[k] / m.n;
        s->used_sd[k] = sqrt(var[k]);
    }
    s->correlation[0] = correlate(m.product[0], m.sum[0], m.sum[1], var[0], var[1], m.n);
    s->correlation[1] = correlate(m.product[1], m.sum[0], m.sum[2], var[0], var[2], m.n);
    s->correlation[2] = correlate(m.product[2], m.sum[1], m.sum[2], var[1], var[2], m.n);
    s->gamma_near_unit = share(gamma, used);
    s->ag_in_disc = share(t->ag_in_disc, used);
}

static int32_t bits_set(uint8_t byte)
{
    int32_t n = 0;
    for (; byte != 0; byte = (uint8_t) (byte & (byte - 1)))
        n++;
    return n;
}

static void describe_colors(ntp_stats *s, const ntp_tally *t)
{
    bool cells = s->max == 255 && t->encoding != NTP_HEIGHT;
    if (cells) {
        for (int32_t row = NTP__ROWS - NTP__FLAT_ROWS; row < NTP__ROWS; row++) {
            for (int32_t b = 0; b < 256; b++) {
                s->flat += t->cell[row][b];
                s->distinct_flat += t->cell[row][b] > 0;
            }
        }
    } else {
        s->flat = t->wide_flat;
        for (size_t i = 0; t->wide_flat > 0 && i < sizeof t->wide_flat_seen; i++)
            s->distinct_flat += (uint64_t) bits_set(t->wide_flat_seen[i]);
    }
    if (t->depth != 8 || t->encoding == NTP_HEIGHT) {
        s->distinct = t->colors;
        return;
    }
    for (int32_t i = 0; i < 65536 && s->distinct < 2; i++) {
        for (int32_t b = 0; t->pair_texels[i] > 0 && b < 256; b++)
            s->distinct += t->cell[t->row_of[i]][b] > 0;
    }
    if (s->distinct > 2)
        s->distinct = 2;
}

ntp_status ntp_summarize(ntp_stats *s, ntp_tally *t, ntp_encoding encoding)
{
    if (s == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(t, encoding));
    ntp__flush_pairs(t);
    memset(s, 0, sizeof *s);
    const ntp__fit_sums *used = &t->used.fit[0], *unused = &t->unused.fit[0];
    s->texels = t->texels;
    s->black = t->black;
    s->white = t->white;
    s->transparent = t->transparent;
    s->unused = t->black + t->white + t->transparent;
    s->not_finite = t->not_finite;
    s->max = (uint32_t) ntp__tally_max(t);
    s->stored_max = t->depth == 8 ? 255 : 65535;
    s->channels = (int32_t) t->channels;
    s->gray = t->gray;
    s->unused_xy_too_long = flagged(unused, NTP_XY_TOO_LONG, NTP_XY_TOO_LONG);
    s->xy_too_long = s->unused_xy_too_long + flagged(used, NTP_XY_TOO_LONG, NTP_XY_TOO_LONG);
    s->xy_far_too_long = flagged(used, NTP__FAR, NTP__FAR) + flagged(unused, NTP__FAR, NTP__FAR);
    s->neighbor_and_near = flagged(used, NTP_PASS_NEIGHBOR | NTP__FAR, NTP_PASS_NEIGHBOR) +
                           flagged(unused, NTP_PASS_NEIGHBOR | NTP__FAR, NTP_PASS_NEIGHBOR);
    s->unused_z_negative = flagged(unused, NTP_Z_NEGATIVE, NTP_Z_NEGATIVE);
    s->used_z_negative = flagged(used, NTP_Z_NEGATIVE, NTP_Z_NEGATIVE);
    s->z_negative = s->used_z_negative + s->unused_z_negative;
    for (int32_t z = 0; z < 2; z++) {
        for (uint32_t i = 0; i <= s->max; i++) {
            if (t->used.fit[z].levels_off[i] > 0)
                s->levels_off_max[z] = i;
        }
    }
    describe_fit(&s->standard, t, 0);
    describe_fit(&s->zzero, t, 1);
    ntp__angles_describe(&s->angles, &t->used.angles);
    describe_steepness(s, used);
    if (t->depth == 8 && t->encoding != NTP_HEIGHT) {
        describe_channels8(s, t);
    } else {
        uint64_t n = t->texels - t->not_finite;
        for (int32_t k = 0; k < 3; k++)
            channel_from(&s->channel[k], &t->channel[k], n,
                         t->depth == 16 && s->max == 255 ? 257 : 1);
    }
    describe_pairs(s, t);
    describe_alpha(s, t);
    describe_colors(s, t);
    for (int32_t k = 0; k < 3; k++) {
        double within = share(t->block_steps[k][0], t->block_count[0]);
        double across = share(t->block_steps[k][1], t->block_count[1]);
        s->block_step[k] = within > 0 ? across / within : 0.0;
    }
    return NTP_OK;
}

ntp_status ntp_levels_off(uint64_t *counts, size_t size, ntp_tally *tally, ntp_encoding encoding)
{
    if (encoding != NTP_STANDARD && encoding != NTP_ZZERO)
        return NTP_ERR_ARGUMENT;
    /* Levels do not depend on the encoding that angles are taken for. */
    if (tally == NULL || tally->depth == 0 || counts == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(tally, tally->summed ? (ntp_encoding) tally->summed_encoding
                                              : ntp__judged_as((ntp_encoding) tally->encoding)));
    size_t bins = (size_t) ntp__tally_max(tally) + 1;
    if (size < bins)
        return NTP_ERR_ARGUMENT;
    int32_t z = encoding == NTP_ZZERO;
    for (size_t i = 0; i < bins; i++)
        counts[i] =
            (uint64_t) tally->used.fit[z].levels_off[i] + tally->unused.fit[z].levels_off[i];
    return NTP_OK;
}

ntp_status ntp_lengths(uint64_t counts[256], ntp_tally *tally, ntp_encoding encoding)
{
    if (counts == NULL || tally == NULL || tally->depth == 0 ||
        (encoding != NTP_STANDARD && encoding != NTP_ZZERO))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(tally, tally->summed ? (ntp_encoding) tally->summed_encoding
                                              : ntp__judged_as((ntp_encoding) tally->encoding)));
    int32_t z = encoding == NTP_ZZERO;
    for (int32_t i = 0; i < NTP__LENGTH_BINS; i++)
        counts[i] = (uint64_t) tally->used.fit[z].lengths[i] + tally->unused.fit[z].lengths[i];
    return NTP_OK;
}
