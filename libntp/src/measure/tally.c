/* SPDX-License-Identifier: MIT */
/*
 * tally.c - merges and empties tallies, and turns their cells into sums
 */
#include "texel/level.h"
#include "measure/tally.h"

#include <string.h>

/* ------------------------------------------------------------------------- merge and clear */

static void merge_channel(ntp__channel_sums *into, const ntp__channel_sums *from)
{
    into->sum += from->sum;
    ntp__merge_max(&into->max, from->max);
    ntp__merge_max(&into->inverted_min, from->inverted_min);
}

/* The greatest magnitude of a red or green of 8 bit. */
static int32_t steepest(const ntp_tally *t)
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
    ntp__merge_sums(&into->transparent_wide, &from->transparent_wide);
    ntp__merge_sums(&into->transparent_narrow, &from->transparent_narrow);
    ntp__merge_samples(into, from);
    ntp__merge_cells(&into->cells, &from->cells, steepest(from));
    return NTP_OK;
}

ntp_status ntp_tally_clear(ntp_tally *t)
{
    if (t == NULL)
        return NTP_ERR_ARGUMENT;
    if (t->depth == 0)
        return NTP_OK;
    ntp__clear_cells(&t->cells, steepest(t));
    ntp__clear_samples(t);
    if (t->wide.texels > 0)
        ntp__clear_close(&t->close, &t->wide);
    ntp__clear_sums(&t->wide);
    ntp__clear_sums(&t->transparent_wide);
    ntp__clear_sums(&t->transparent_narrow);
    if (t->wide_flat > 0)
        memset(t->wide_flat_seen, 0, sizeof t->wide_flat_seen);
    memset(t, 0, offsetof(ntp_tally, cells));
    return NTP_OK;
}

/* --------------------------------------------------------------------------- cells to sums */

/* Adds the cells of one row. */
static void add_row(ntp_tally *t, ntp__color_batch *batch, int32_t row, int32_t m,
                    ntp_encoding encoding)
{
    ntp__cells cells;
    const int32_t by = m / 255;
    const int32_t r = (t->cells.row_pair[row] & 255) * by, g = (t->cells.row_pair[row] >> 8) * by;
    const int32_t n = ntp__row_cells(&cells, &t->cells, row);
    for (int32_t done = 0, end; done < n; done = end) {
        int32_t at = batch->n;
        end = n - done < NTP__BLOCK - at ? n : done + NTP__BLOCK - at;
        for (int32_t i = done; i < end; i++, at++) {
            t->blues[cells.blue[i]] += cells.count[i];
            batch->block.c[0][at] = r;
            batch->block.c[1][at] = g;
            batch->block.c[2][at] = cells.blue[i] * by;
            batch->count[at] = cells.count[i];
        }
        batch->n = at;
        if (at == NTP__BLOCK)
            ntp__end_batch(&t->used, batch, m, encoding);
    }
}

static void add_cells(ntp_tally *t, int32_t m, ntp_encoding encoding)
{
    ntp__color_batch batch;
    batch.n = 0;
    ntp__note_rows(&t->cells, steepest(t));
    for (int32_t row = 0; (row = ntp__next_row(t->cells.at.row_seen, row)) < NTP__ROWS; row++)
        add_row(t, &batch, row, m, encoding);
    ntp__end_batch(&t->used, &batch, m, encoding);
}

static void add_gray(ntp_tally *t, int32_t level, int32_t m, uint64_t count, ntp_encoding encoding)
{
    const int32_t gray[] = { level, level, level };
    if (count > 0)
        ntp__add(&t->unused, gray, (uint32_t) count, m, encoding);
}

ntp_status ntp__sum_up(ntp_tally *t, ntp_encoding encoding)
{
    if (t == NULL || t->depth == 0 ||
        (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO &&
         encoding != NTP_ENCODING_XY))
        return NTP_ERR_ARGUMENT;
    int32_t m = ntp__tally_max(t);
    bool picture = t->encoding == NTP_ENCODING_HEIGHT;
    if (!picture && m != 255 && encoding != ntp__judged_as((ntp_encoding) t->encoding))
        return NTP_ERR_FORMAT;
    if (t->summed && t->summed_encoding == (uint32_t) encoding)
        return NTP_OK;
    const ntp__sums *transparent = m == 255 ? &t->transparent_narrow : &t->transparent_wide;
    ntp__clear_sums(&t->used);
    ntp__clear_sums(&t->unused);
    memset(t->blues, 0, sizeof t->blues);
    if (!picture) {
        if (t->wide.texels > 0) {
            ntp__take_close(&t->wide, &t->close);
            ntp__take_others(&t->wide);
        }
        if (t->narrow > 0) {
            ntp__merge_sums(&t->used, &t->wide);
            add_cells(t, m, encoding);
        }
        ntp__merge_sums(&t->unused, transparent);
        add_gray(t, 0, m, t->black, encoding);
        add_gray(t, m, m, t->white, encoding);
    }
    t->summed = 1;
    t->summed_encoding = (uint32_t) encoding;
    return NTP_OK;
}
