/* SPDX-License-Identifier: MIT */
/*
 * merge.c - merges and empties tallies, and their sums as wholes
 */
#include "measure/tally.h"

#include <string.h>

/* --------------------------------------------------------------------------- sums */

void ntp__clear_sums(ntp__sums *s)
{
    if (s->texels == 0)
        return;
    for (int32_t z = 0; z < 2; z++) {
        ntp__fit_sums *fit = &s->fit[z];
        memset(fit->levels_off, 0, (fit->levels_off_max + 1) * sizeof fit->levels_off[0]);
        memset(fit, 0, offsetof(ntp__fit_sums, levels_off));
    }
    ntp__angles_clear(&s->angles);
    for (int32_t k = 0; k < NTP__ALL_HARM; k++) {
        ntp__harm_sums *const harm = &s->harm[k];
        if (harm->texels > 0)
            memset(harm, 0,
                   offsetof(ntp__harm_sums, bins) +
                       (ntp__harm_bin(harm->max) + 1) * sizeof harm->bins[0]);
    }
    s->texels = 0;
}

static void merge_harm(ntp__harm_sums *into, const ntp__harm_sums *from)
{
    if (from->texels == 0)
        return;
    into->texels += from->texels;
    into->sum += from->sum;
    into->max = from->max > into->max ? from->max : into->max;
    ntp__merge_counts(into->bins, from->bins, (size_t) ntp__harm_bin(from->max) + 1);
}

static void merge_others(ntp__fit_sums *into, const ntp__fit_sums *from)
{
    ntp__merge_counts(into->flags, from->other_flags, NTP__ALL_BINS * 256);
    ntp__merge_counts(into->lengths, from->other_lengths, NTP__LENGTH_BINS);
}

void ntp__take_others(ntp__sums *s)
{
    for (int32_t z = 0; z < 2; z++) {
        ntp__fit_sums *fit = &s->fit[z];
        merge_others(fit, fit);
        memset(fit->other_flags, 0, sizeof fit->other_flags);
        memset(fit->other_lengths, 0, sizeof fit->other_lengths);
    }
}

void ntp__merge_sums(ntp__sums *into, const ntp__sums *from)
{
    if (from->texels == 0)
        return;
    into->texels += from->texels;
    for (int32_t z = 0; z < 2; z++) {
        ntp__fit_sums *a = &into->fit[z];
        const ntp__fit_sums *b = &from->fit[z];
        ntp__merge_counts(a->flags, b->flags, NTP__ALL_BINS * 256);
        ntp__merge_counts(a->lengths, b->lengths, NTP__LENGTH_BINS);
        merge_others(a, b);
        ntp__merge_counts(a->levels_off, b->levels_off, (size_t) b->levels_off_max + 1);
        ntp__merge_max(&a->levels_off_max, b->levels_off_max);
        for (int32_t i = 0; i < NTP__ALL_BINS; i++)
            a->length_error[i] += b->length_error[i];
        for (int32_t i = 0; i < 2; i++)
            a->length_error2[i] += b->length_error2[i];
        a->length_sum += b->length_sum;
        ntp__merge_max(&a->length_max, b->length_max);
        ntp__merge_max(&a->length_inverted_min, b->length_inverted_min);
    }
    ntp__angles_merge(&into->angles, &from->angles);
    for (int32_t k = 0; k < NTP__ALL_HARM; k++)
        merge_harm(&into->harm[k], &from->harm[k]);
}

/* ------------------------------------------------------------------------ samples */

static void add_samples(ntp__samples *a, const ntp__samples *b)
{
    a->n += b->n;
    for (int32_t k = 0; k < 3; k++) {
        a->sum[k] += b->sum[k];
        a->square[k] += b->square[k];
        a->product[k] += b->product[k];
    }
    a->red_low += b->red_low;
    a->green_low += b->green_low;
    a->gamma_flat += b->gamma_flat;
    a->gamma_unit += b->gamma_unit;
}

static void merge_samples(ntp_tally *into, const ntp_tally *from)
{
    add_samples(&into->samples, &from->samples);
    add_samples(&into->padding_samples, &from->padding_samples);
    if (from->depth == 8)
        return;
    for (int32_t group = 0; group < 65536 / NTP__PAIR_GROUP; group++) {
        if (from->pair_seen[group] == 0)
            continue;
        if (!into->pair_seen[group])
            ntp__begin_pairs(into, (uint32_t) group);
        into->pairs_full = 1;
        for (int32_t i = group * NTP__PAIR_GROUP; i < (group + 1) * NTP__PAIR_GROUP; i++) {
            const ntp__pair more = ntp__pair_at(from, (uint32_t) i);
            into->pair_texels[i] += (uint32_t) more.texels;
            into->pair_blue[i] += more.blue;
        }
    }
}

static void clear_samples(ntp_tally *t)
{
    memset(&t->samples, 0, sizeof t->samples);
    memset(&t->padding_samples, 0, sizeof t->padding_samples);
    if (t->depth == 8)
        return;
    for (int32_t group = 0; t->pairs_full && group < 65536 / NTP__PAIR_GROUP; group++) {
        int32_t first = group * NTP__PAIR_GROUP;
        if (t->pair_seen[group] == 0)
            continue;
        memset(&t->pair_texels[first], 0, NTP__PAIR_GROUP * sizeof t->pair_texels[0]);
        memset(&t->pair_blue[first], 0, NTP__PAIR_GROUP * sizeof t->pair_blue[0]);
    }
    memset(t->pair_seen, 0, sizeof t->pair_seen);
    t->pairs_full = 0;
}

/* ------------------------------------------------------------------------ tallies */

int32_t ntp__steepest_of(const ntp_tally *t)
{
    const uint32_t bits = t->depth == 8 ? 0 : 8; /* 257 v >> 8 = v */
    int32_t most = 0;
    for (int32_t k = 0; k < 2; k++) {
        const ntp__channel_sums *const c = &t->channel[k];
        const int32_t greatest = (int32_t) (c->max >> bits);
        const int32_t least = (int32_t) ((~c->inverted_min & 65535) >> bits);
        const int32_t one = ntp__steepest(least, greatest);
        most = one > most ? one : most;
    }
    return most;
}

static void merge_channel(ntp__channel_sums *into, const ntp__channel_sums *from)
{
    into->sum += from->sum;
    ntp__merge_max(&into->max, from->max);
    ntp__merge_max(&into->inverted_min, from->inverted_min);
}

static void merge_colors(ntp_tally *into, const ntp_tally *from)
{
    if (into->colors == 0) {
        into->colors = from->colors;
        memcpy(into->color, from->color, sizeof into->color);
    } else if (from->colors > 1 ||
               (from->colors == 1 && memcmp(into->color, from->color, sizeof into->color) != 0)) {
        into->colors = 2;
    }
}

ntp_status ntp_tally_merge(ntp_tally *into, const ntp_tally *from)
{
    if (into == NULL || from == NULL || into == from)
        return NTP_ERR_ARGUMENT;
    if (from->depth == 0)
        return NTP_OK;
    if (into->depth != 0 && (into->depth != from->depth || into->channels != from->channels ||
                             into->encoding != from->encoding || into->touched != from->touched))
        return NTP_ERR_FORMAT;
    if (into->texels + from->texels > UINT32_MAX)
        return NTP_ERR_SHAPE;
    into->depth = from->depth;
    into->channels = from->channels;
    into->encoding = from->encoding;
    into->touched = from->touched;
    into->is_wide |= from->is_wide;
    into->summed = 0;
    into->texels += from->texels;
    into->black += from->black;
    into->white += from->white;
    into->transparent += from->transparent;
    into->not_finite += from->not_finite;
    into->gray += from->gray;
    into->ag_in_disc += from->ag_in_disc;
    into->narrow += from->narrow;
    into->wide_flat += from->wide_flat;
    for (int32_t i = 0; i < 2; i++) {
        into->block_count[i] += from->block_count[i];
        into->wide_alpha_ends[i] += from->wide_alpha_ends[i];
        for (int32_t k = 0; k < 3; k++)
            into->block_steps[k][i] += from->block_steps[k][i];
    }
    ntp__merge_counts(into->alpha, from->alpha, 256);
    merge_channel(&into->alpha_levels, &from->alpha_levels);
    for (int32_t k = 0; k < 3; k++)
        merge_channel(&into->channel[k], &from->channel[k]);
    merge_colors(into, from);
    if (from->wide_flat > 0) {
        for (size_t i = 0; i < sizeof into->wide_flat_seen; i++)
            into->wide_flat_seen[i] |= from->wide_flat_seen[i];
    }
    ntp__merge_sums(&into->wide, &from->wide);
    if (from->wide.texels > 0)
        ntp__merge_close(&into->close, &from->close, &from->wide);
    ntp__merge_far(&into->wide, &from->far, &from->wide);
    ntp__merge_sums(&into->transparent_wide, &from->transparent_wide);
    into->hidden |= from->hidden;
    if (from->hidden)
        ntp__merge_close(&into->close_hidden, &from->close_hidden, &from->transparent_wide);
    ntp__merge_far(&into->transparent_wide, &from->far_hidden, &from->transparent_wide);
    ntp__merge_sums(&into->transparent_narrow, &from->transparent_narrow);
    merge_samples(into, from);
    ntp__merge_cells(&into->cells, &from->cells, ntp__steepest_of(from));
    return NTP_OK;
}

ntp_status ntp_tally_clear(ntp_tally *t)
{
    if (t == NULL)
        return NTP_ERR_ARGUMENT;
    if (t->depth == 0)
        return NTP_OK;
    ntp__clear_cells(&t->cells, ntp__steepest_of(t));
    clear_samples(t);
    if (t->wide.texels > 0)
        ntp__clear_close(&t->close, &t->wide);
    ntp__clear_far(&t->far, &t->wide);
    if (t->hidden)
        ntp__clear_close(&t->close_hidden, &t->transparent_wide);
    ntp__clear_far(&t->far_hidden, &t->transparent_wide);
    ntp__clear_sums(&t->wide);
    ntp__clear_sums(&t->transparent_wide);
    ntp__clear_sums(&t->transparent_narrow);
    if (t->wide_flat > 0)
        memset(t->wide_flat_seen, 0, sizeof t->wide_flat_seen);
    memset(t, 0, offsetof(ntp_tally, linear_square));
    return NTP_OK;
}
