/* SPDX-License-Identifier: MIT */
/*
 * summarize.c - the facts that follow from a tally: ntp_stats, and the evidence
 */
#include "measure/tally.h"

#include <math.h>
#include <string.h>

/* How many texels have which flags; combinations that do not occur are left out. */
typedef struct flag_counts {
    int32_t n;
    uint32_t flags[256];
    uint64_t count[256];
} flag_counts;

static void count_flags(flag_counts *out, const ntp__sums *sums, int32_t z, int32_t bins)
{
    uint32_t count[256] = { 0 };
    out->n = 0;
    if (sums->texels == 0)
        return;
    for (int32_t i = 0; i < bins; i++)
        ntp__merge_counts(count, &sums->fit[z].flags[i * 256], 256);
    for (uint32_t f = 0; f < 256; f++) {
        if (count[f] == 0)
            continue;
        out->flags[out->n] = f;
        out->count[out->n++] = count[f];
    }
}

static uint64_t flagged(const flag_counts *count, uint32_t mask, uint32_t value)
{
    uint64_t sum = 0;
    for (int32_t i = 0; i < count->n; i++)
        sum += (count->flags[i] & mask) == value ? count->count[i] : 0;
    return sum;
}

static double share(uint64_t part, uint64_t whole)
{
    return whole > 0 ? (double) part / (double) whole : 0.0;
}

static void describe_flags(ntp_fit *out, const flag_counts *yes, const flag_counts *no)
{
    out->unused_neighbor = flagged(no, NTP_FLAG_NEIGHBOR, NTP_FLAG_NEIGHBOR);
    out->unused_rounded = flagged(no, NTP_FLAG_ROUNDED, NTP_FLAG_ROUNDED);
    out->unused_exact = flagged(no, NTP_FLAG_EXACT, NTP_FLAG_EXACT);
    out->neighbor = out->unused_neighbor + flagged(yes, NTP_FLAG_NEIGHBOR, NTP_FLAG_NEIGHBOR);
    out->rounded = out->unused_rounded + flagged(yes, NTP_FLAG_ROUNDED, NTP_FLAG_ROUNDED);
    out->exact = out->unused_exact + flagged(yes, NTP_FLAG_EXACT, NTP_FLAG_EXACT);
    out->exact_mirrored =
        flagged(yes, NTP__MIRRORED, NTP__MIRRORED) + flagged(no, NTP__MIRRORED, NTP__MIRRORED);
}

static void describe_fit(ntp_fit *out, const ntp_tally *t, int32_t z)
{
    const ntp__sums *const sums = ntp__used(t);
    const ntp__fit_sums *used = &sums->fit[z], *unused = &t->unused.fit[z];
    uint64_t n = sums->texels, all = n + t->unused.texels;
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
}

/* Counts padding with all flags of this mask. */
static uint64_t count_padding(const ntp__sums *sums, uint32_t mask)
{
    uint64_t count = 0;
    for (uint32_t f = 0; f < 256; f++)
        count += (f & mask) == mask ? sums->fit[0].flags[NTP__PADDING_BIN * 256 + f] : 0;
    return count;
}

/* How many used texels are padding that can be left out: not where hardly others would be left. */
static uint64_t padding_to_leave_out(const ntp_tally *t)
{
    enum { OTHERS_LEAST = 16 }; /* one in this many */
    const ntp__sums *const used = ntp__used(t);
    uint64_t padding = count_padding(used, 0);
    bool left = OTHERS_LEAST * (used->texels - padding) >= used->texels &&
                t->samples.n > t->padding_samples.n;
    return left ? padding : 0;
}

uint64_t ntp__padding_of_one_color(const ntp_tally *t)
{
    enum { PICTURE_SHARE = 64 }; /* one texel in this many: wrong texels hardly have one color */
    const double spread = 8;     /* levels; JPEG of quality 75 spreads a flat color by less */
    const ntp__samples *s = &t->padding_samples;
    uint64_t padding = padding_to_leave_out(t);
    if (padding * PICTURE_SHARE < t->texels || s->n == 0)
        return 0;
    for (int32_t k = 0; k < 3; k++) {
        double n = (double) s->n, mean = (double) s->sum[k] / n;
        if ((double) s->square[k] / n - mean * mean > spread * spread)
            return 0;
    }
    return padding;
}

/* Fills in the counts that follow from flags. */
static void describe_verdicts(ntp_stats *s, const ntp_tally *t)
{
    flag_counts yes, no;
    const flag_counts *used = &yes, *unused = &no;
    const ntp__sums *const sums = ntp__used(t);
    count_flags(&yes, sums, 1, NTP__ALL_BINS);
    count_flags(&no, &t->unused, 1, NTP__ALL_BINS);
    describe_flags(&s->zzero, used, unused);
    count_flags(&yes, sums, 0, NTP__ALL_BINS);
    count_flags(&no, &t->unused, 0, NTP__ALL_BINS);
    describe_flags(&s->standard, used, unused);
    s->unused_xy_too_long = flagged(unused, NTP_FLAG_XY_TOO_LONG, NTP_FLAG_XY_TOO_LONG);
    s->xy_too_long =
        s->unused_xy_too_long + flagged(used, NTP_FLAG_XY_TOO_LONG, NTP_FLAG_XY_TOO_LONG);
    s->xy_far_too_long = flagged(used, NTP__FAR, NTP__FAR) + flagged(unused, NTP__FAR, NTP__FAR);
    s->neighbor_and_near = flagged(used, NTP_FLAG_NEIGHBOR | NTP__FAR, NTP_FLAG_NEIGHBOR) +
                           flagged(unused, NTP_FLAG_NEIGHBOR | NTP__FAR, NTP_FLAG_NEIGHBOR);
    s->unused_z_negative = flagged(unused, NTP_FLAG_Z_NEGATIVE, NTP_FLAG_Z_NEGATIVE);
    s->z_negative = s->unused_z_negative + flagged(used, NTP_FLAG_Z_NEGATIVE, NTP_FLAG_Z_NEGATIVE);
    s->padding = ntp__padding_of_one_color(t);
    if (s->padding > 0)
        s->padding_z_negative = count_padding(sums, NTP_FLAG_Z_NEGATIVE);
}

static void channel_from(ntp_channel *out, const ntp__channel_sums *sums, uint64_t texels,
                         uint32_t by)
{
    out->min = texels > 0 ? ~sums->inverted_min / by : 0;
    out->max = sums->max / by;
    out->mean = share(sums->sum, texels) / by;
}

static bool has_alpha(const ntp_tally *t)
{
    return t->channels == 4 || (t->encoding == NTP_ENCODING_HEIGHT && t->channels == 2);
}

static void describe_alpha(ntp_stats *s, const ntp_tally *t)
{
    uint64_t n = 0;
    ntp__channel_sums sums = { 0, 0, 0 };
    if (!has_alpha(t))
        return;
    for (uint32_t a = 0; a < 256; a++) {
        uint64_t count = t->alpha[a];
        if (count == 0)
            continue;
        n += count;
        ntp__merge_max(&sums.max, a);
        ntp__merge_max(&sums.inverted_min, ~a);
        sums.sum += a * count;
    }
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

/* ------------------------------------------------------------------ means and variances */

typedef struct moments {
    double n, sum[3], square[3], product[3]; /* products: r g, r b, g b */
} moments;

static double variance_of(const moments *m, int32_t k)
{
    double mean = m->sum[k] / m->n, v = m->square[k] / m->n - mean * mean;
    return v > 0 ? v : 0;
}

static double correlation_of(const moments *m, int32_t product, int32_t a, int32_t b)
{
    double covariance = m->product[product] / m->n - m->sum[a] / m->n * (m->sum[b] / m->n);
    double scale = sqrt(variance_of(m, a) * variance_of(m, b));
    return scale > 1e-12 ? covariance / scale : 0.0;
}

/* Moments of i / 255, each i taken count[i] times. */
static moments moments_of_levels(const uint64_t count[256])
{
    moments m = { 0 };
    for (int32_t i = 0; i < 256; i++) {
        if (count[i] == 0)
            continue;
        double n = (double) count[i], v = i / 255.0;
        m.n += n;
        m.sum[0] += n * v;
        m.square[0] += n * v * v;
    }
    return m;
}

static moments moments_of_alpha(const ntp_tally *t)
{
    moments m = { 0 };
    for (uint32_t a = 0; a < 256; a++) {
        uint64_t count = t->alpha[a];
        if (count == 0)
            continue;
        m.n += (double) count;
        m.sum[0] += (double) (count * a) / 255.0;
        m.square[0] += (double) (count * a * a) / (255.0 * 255.0);
    }
    return m;
}

/* Moments of the used texels; only sampled rows have them. */
static moments moments_of_samples(const ntp__samples *all)
{
    moments m = { .n = (double) all->n };
    for (int32_t k = 0; k < 3; k++) {
        m.sum[k] = (double) all->sum[k] / 255.0;
        m.square[k] = (double) all->square[k] / (255.0 * 255.0);
        m.product[k] = (double) all->product[k] / (255.0 * 255.0);
    }
    return m;
}

static bool is_picture(const ntp_tally *t)
{
    return t->encoding == NTP_ENCODING_HEIGHT;
}

static uint64_t used_texels(const ntp_tally *t)
{
    return is_picture(t) ? t->texels - t->not_finite : t->narrow + t->wide.texels;
}

/* A count of sampled texels, scaled to all used ones. */
static uint64_t scaled(const ntp_tally *t, uint64_t count)
{
    double scale = (double) used_texels(t) / (double) t->samples.n;
    return (uint64_t) ((double) count * scale + 0.5);
}

/* Exact moments of blue, from the cells; false: some used texels are not in the cells. */
static bool moments_of_blue(moments *blue, const ntp_tally *t)
{
    *blue = moments_of_levels(t->blues);
    return !is_picture(t) && (uint64_t) blue->n == used_texels(t);
}

/* The exact mean of a channel over the used texels; false: the colors of unused ones are not known,
 * as of transparent texels. */
static bool mean_of_channel(double *mean, const ntp_tally *t, int32_t k)
{
    uint64_t used = used_texels(t), finite = t->texels - t->not_finite;
    uint64_t white = is_picture(t) ? 0 : t->white, black = is_picture(t) ? 0 : t->black;
    if (used == 0 || finite != used + black + white)
        return false;
    double full = t->depth == 8 ? 255 : 65535;
    *mean = ((double) t->channel[k].sum - (double) white * full) / ((double) used * full);
    return true;
}

static void take_away(ntp__samples *from, const ntp__samples *part)
{
    from->n -= part->n;
    for (int32_t k = 0; k < 3; k++) {
        from->sum[k] -= part->sum[k];
        from->square[k] -= part->square[k];
        from->product[k] -= part->product[k];
    }
    from->red_low -= part->red_low;
    from->green_low -= part->green_low;
    from->gamma_unit -= part->gamma_unit;
}

static void describe_samples(ntp_stats *s, const ntp_tally *t)
{
    moments blue;
    if (has_alpha(t)) {
        moments alpha = moments_of_alpha(t);
        s->used_mean[3] = alpha.sum[0] / alpha.n;
    }
    if (t->samples.n == 0)
        return;
    ntp__samples sampled = t->samples;
    if (s->padding > 0)
        take_away(&sampled, &t->padding_samples);
    moments m = moments_of_samples(&sampled);
    s->near_gamma_flat = scaled(t, t->samples.gamma_flat);
    for (int32_t k = 0; k < 3; k++) {
        if (s->padding > 0 || !mean_of_channel(&s->used_mean[k], t, k))
            s->used_mean[k] = m.sum[k] / m.n;
    }
    if (s->padding == 0 && moments_of_blue(&blue, t))
        s->used_mean[2] = blue.sum[0] / blue.n;
}

/* ------------------------------------------------------------------------------- colors */

/* Counts the set bits of `size` bytes, a multiple of 8. */
static uint64_t bits_set(const uint8_t *bytes, size_t size)
{
    uint64_t n = 0, word;
    for (size_t i = 0; i < size; i += sizeof word) {
        memcpy(&word, bytes + i, sizeof word);
        for (; word != 0; word &= word - 1)
            n++;
    }
    return n;
}

static void describe_colors(ntp_stats *s, const ntp_tally *t)
{
    ntp__cells cells;
    if (s->max == 255 && t->encoding != NTP_ENCODING_HEIGHT) {
        for (int32_t row = NTP__ROWS - NTP__FLAT_ROWS; row < NTP__ROWS; row++) {
            if (t->cells.at.row_seen[row] == 0)
                continue;
            const int32_t n = ntp__row_cells(&cells, &t->cells, row);
            s->distinct_flat += (uint64_t) n;
            for (int32_t i = 0; i < n; i++)
                s->flat += cells.count[i];
        }
    } else {
        s->flat = t->wide_flat;
        if (t->wide_flat > 0)
            s->distinct_flat = bits_set(t->wide_flat_seen, sizeof t->wide_flat_seen);
    }
    s->distinct = t->colors;
}

ntp_status ntp_tally_summarize(ntp_stats *s, ntp_tally *t, ntp_encoding encoding)
{
    if (s == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(t, encoding));
    memset(s, 0, sizeof *s);
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
    describe_verdicts(s, t);
    const ntp__sums *const sums = ntp__used(t);
    for (int32_t z = 0; z < 2; z++)
        s->levels_off_max[z] = sums->fit[z].levels_off_max;
    describe_fit(&s->standard, t, 0);
    describe_fit(&s->zzero, t, 1);
    ntp__angles_describe(&s->angles, &sums->angles);
    for (int32_t k = 0; k < 3; k++)
        channel_from(&s->channel[k], &t->channel[k], t->texels - t->not_finite,
                     t->depth == 16 && s->max == 255 ? 257 : 1);
    describe_samples(s, t);
    describe_alpha(s, t);
    describe_colors(s, t);
    return NTP_OK;
}

/* ----------------------------------------------------------------------------- evidence */

/* Texels whose length lies within `bins` of 1/128 from 1. */
static uint64_t near_unit(const ntp__fit_sums *fit, int32_t bins)
{
    uint64_t count = 0;
    for (int32_t i = 128 - bins; i < 128 + bins; i++)
        count += fit->lengths[i];
    return count;
}

static void gather_lengths(ntp__fit_evidence *out, const ntp__sums *used, int32_t z,
                           uint64_t padding)
{
    const ntp__fit_sums *fit = &used->fit[z];
    uint64_t n = used->texels - padding, sum = fit->length_sum, error2 = fit->length_error2[0];
    double one = NTP__LENGTH_ONE;
    flag_counts count;
    count_flags(&count, used, z, padding > 0 ? NTP__STEEPNESS_BINS : NTP__ALL_BINS);
    if (padding > 0) /* each is longer than 1 */
        sum -= padding * NTP__LENGTH_ONE + fit->length_error[NTP__PADDING_BIN];
    else
        error2 += fit->length_error2[1];
    out->too_short = share(flagged(&count, NTP_FLAG_ROUNDED | NTP__LONG, 0), n);
    out->too_long = share(flagged(&count, NTP_FLAG_ROUNDED | NTP__LONG, NTP__LONG), n);
    out->length_mean = share(sum, n) / one;
    double off = out->length_mean - 1.0;
    double variance = share(error2, n) / (one * one) - off * off;
    out->length_sd = n > 0 && variance > 0 ? sqrt(variance) : 0.0;
    for (int32_t i = 0; i < 3; i++)
        out->near_unit[i] = share(near_unit(fit, 4 << i), n);
}

static void gather_steepness(ntp__evidence *e, const ntp__fit_sums *fit)
{
    const int32_t last = NTP__STEEPNESS_BINS - 1;
    uint64_t error[NTP__STEEPNESS_BINS] = { 0 };
    for (int32_t bin = 0; bin < (e->padding > 0 ? last + 1 : NTP__ALL_BINS); bin++) {
        const uint32_t *flags = &fit->flags[bin * 256];
        const int32_t i = bin < last ? bin : last;
        for (uint32_t f = 0; f < 256; f++) {
            e->steepness[i] += flags[f];
            e->used_z_negative += f & NTP_FLAG_Z_NEGATIVE ? flags[f] : 0;
            e->steepness_not_rounded[i] += f & NTP_FLAG_ROUNDED ? 0 : flags[f];
            e->steepness_not_neighbor[i] += f & NTP_FLAG_NEIGHBOR ? 0 : flags[f];
        }
        error[i] += fit->length_error[bin];
    }
    for (int32_t i = 0; i <= last; i++)
        e->steepness_length_error[i] = share(error[i], e->steepness[i]) / NTP__LENGTH_ONE;
}

static void gather_samples(ntp__evidence *e, const ntp_tally *t)
{
    moments blue;
    if (has_alpha(t)) {
        moments alpha = moments_of_alpha(t);
        e->used_sd[3] = sqrt(variance_of(&alpha, 0));
    }
    if (t->samples.n == 0)
        return;
    ntp__samples sampled = t->samples;
    if (e->padding > 0)
        take_away(&sampled, &t->padding_samples);
    moments m = moments_of_samples(&sampled);
    e->red_low = scaled(t, sampled.red_low);
    e->green_low = scaled(t, sampled.green_low);
    e->gamma_near_unit = share(sampled.gamma_unit, sampled.n);
    e->ag_in_disc = share(t->ag_in_disc, used_texels(t));
    for (int32_t k = 0; k < 3; k++) {
        e->used_sd[k] = sqrt(variance_of(&m, k));
        e->stats.used_mean[k] = e->padding > 0 ? m.sum[k] / m.n : e->stats.used_mean[k];
    }
    e->correlation[0] = correlation_of(&m, 0, 0, 1);
    e->correlation[1] = correlation_of(&m, 1, 0, 2);
    e->correlation[2] = correlation_of(&m, 2, 1, 2);
    if (e->padding == 0 && moments_of_blue(&blue, t))
        e->used_sd[2] = sqrt(variance_of(&blue, 0));
}

static ntp_status gather(ntp__evidence *e, ntp_tally *t)
{
    memset(e, 0, sizeof *e);
    NTP__TRY(ntp_tally_summarize(&e->stats, t, (ntp_encoding) t->summed_encoding));
    e->padding = padding_to_leave_out(t);
    const ntp__sums *const used = ntp__used(t);
    for (int32_t z = 0; z < 2; z++)
        gather_lengths(&e->fit[z], used, z, e->padding);
    gather_steepness(e, &used->fit[0]);
    gather_samples(e, t);
    ntp__describe_blue(e, t);
    for (int32_t k = 0; k < 3; k++) {
        double within = share(t->block_steps[k][0], t->block_count[0]);
        double across = share(t->block_steps[k][1], t->block_count[1]);
        e->block_step[k] = within > 0 ? across / within : 0.0;
    }
    return NTP_OK;
}

ntp_status ntp__gather_evidence(const ntp__evidence **e, ntp_tally *t)
{
    if (t == NULL || t->depth == 0)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(t, ntp__encoding_at_hand(t)));
    if (!t->gathered)
        NTP__TRY(gather(&t->evidence, t));
    t->gathered = 1;
    *e = &t->evidence;
    return NTP_OK;
}
