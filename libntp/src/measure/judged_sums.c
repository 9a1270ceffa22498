/* SPDX-License-Identifier: MIT */
/*
 * judged_sums.c - adds texels of one color, or a block of colors, to the sums of a measurement
 */
#include "texel/kernels.h"
#include "texel/level.h"
#include "measure/judged_sums.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* The limit |(x, y)| <= 1.00774 of the reference program, squared. */
static const double FAR_SQUARED = 1.00774 * 1.00774;

void ntp__row_init(ntp__row *row, int32_t r, int32_t g, int32_t m)
{
    int64_t s = ntp__rest(r, g, m);
    row->m = m;
    row->r = row->cleaned[0] = r;
    row->g = row->cleaned[1] = g;
    row->xy2 = ntp__sq(m) - s;
    int32_t bin = ntp__steepness_bin((double) row->xy2, m);
    row->steepness = bin < NTP__STEEPNESS_BINS ? bin : NTP__STEEPNESS_BINS - 1;
    if (ntp__is_padding(r, g, m))
        row->steepness = NTP__PADDING_BIN;
    row->flags = 0;
    row->pair_fails = false;
    if (s >= 0) {
        row->want[0] = row->cleaned_blue[0] = ntp__blue_of_rest(s, m, false);
        row->want[1] = row->cleaned_blue[1] = ntp__blue_of_rest(s, m, true);
        return;
    }
    row->flags = NTP_FLAG_XY_TOO_LONG;
    int64_t x = ntp__abs(ntp__num(r, m)), y = ntp__abs(ntp__num(g, m));
    row->pair_fails = ntp__sq(x > 2 ? x - 2 : 1) + ntp__sq(y > 2 ? y - 2 : 1) > ntp__sq(m);
    if ((double) row->xy2 > FAR_SQUARED * (double) ntp__sq(m))
        row->flags |= NTP__FAR;
    row->want[0] = row->want[1] = -1;
    ntp__pull(&row->cleaned[0], &row->cleaned[1], m);
    s = ntp__rest(row->cleaned[0], row->cleaned[1], m);
    row->cleaned_blue[0] = ntp__blue_of_rest(s, m, false);
    row->cleaned_blue[1] = ntp__blue_of_rest(s, m, true);
}

static void add_length(ntp__fit_sums *fit, int32_t steepness, uint32_t flags, int32_t levels_off,
                       int32_t length, uint32_t count)
{
    uint64_t error =
        (uint64_t) (length > NTP__LENGTH_ONE ? length - NTP__LENGTH_ONE : NTP__LENGTH_ONE - length);
    uint32_t bin = (uint32_t) length / (NTP__LENGTH_ONE / 128), inverted = ~(uint32_t) length;
    fit->flags[(uint32_t) steepness * 256 + flags] += count;
    if (levels_off >= 0)
        fit->levels_off[levels_off] += count;
    if (levels_off > (int32_t) fit->levels_off_max)
        fit->levels_off_max = (uint32_t) levels_off;
    fit->lengths[bin < NTP__LENGTH_BINS ? bin : NTP__LENGTH_BINS - 1] += count;
    fit->length_sum += (uint64_t) length * count;
    fit->length_error[steepness] += error * count;
    fit->length_error2[steepness == NTP__PADDING_BIN] += error * error * count;
    if ((uint32_t) length > fit->length_max)
        fit->length_max = (uint32_t) length;
    if (inverted > fit->length_inverted_min)
        fit->length_inverted_min = inverted;
}

/* Returns the flags. */
static uint32_t add_fit(ntp__fit_sums *fit, const ntp__row *row, int32_t b, uint32_t count,
                        bool zzero)
{
    int32_t m = row->m, want = row->want[zzero], levels_off = -1;
    bool negative = !zzero && ntp__z_negative(b, m);
    uint32_t flags = row->flags | (negative ? (uint32_t) NTP_FLAG_Z_NEGATIVE : 0);
    if (ntp__neighbor(row->r, row->g, b, m, zzero))
        flags |= NTP_FLAG_NEIGHBOR;
    if (ntp__rounded(row->r, row->g, b, m, zzero))
        flags |= NTP_FLAG_ROUNDED;
    if (want >= 0) {
        if (b == want)
            flags |= NTP_FLAG_EXACT;
        if (!zzero && m - b == want)
            flags |= NTP__MIRRORED;
        levels_off = ntp__abs((negative ? m - b : b) - want);
    }
    int64_t length2 = row->xy2 + ntp__sq(zzero ? b : ntp__num(b, m));
    if (length2 > ntp__sq(m))
        flags |= NTP__LONG;
    add_length(fit, row->steepness, flags, levels_off, ntp__fixed_length((double) length2, m),
               count);
    return flags;
}

/* Adds texels of one color that may be wrong by more than rounding. */
static void add_harm(ntp__sums *sums, const int32_t c[3], int32_t m, ntp_encoding encoding,
                     bool pair_fails, uint32_t flags, uint32_t angle, uint32_t count)
{
    bool padding = pair_fails && ntp__is_padding(c[0], c[1], m);
    int64_t x = ntp__num(c[0], m), y = ntp__num(c[1], m), z = ntp__num(c[2], m);
    int32_t kind = 0;
    if (encoding == NTP_ENCODING_STANDARD && c[2] < (m - 1) / 2) {
        kind = 2;
        angle = ntp__angle(x, y, z, x, y, -z);
    } else if (pair_fails) {
        kind = 1;
        /* without z there is no angle: how far x, y lie outside the circle stands for it */
        if (encoding == NTP_ENCODING_XY)
            angle = (uint32_t) ((sqrt((double) (x * x + y * y)) / m - 1.0) * (180e6 / PI) + 0.5);
    } else if (encoding == NTP_ENCODING_XY || (flags & NTP_FLAG_NEIGHBOR)) {
        return;
    }
    ntp__harm_sums *harm = &sums->harm[padding ? kind + NTP__PADDING_HARM : kind];
    harm->texels += count;
    harm->sum += (uint64_t) angle * count;
    harm->bins[ntp__harm_bin(angle)] += count;
    if (angle > harm->max)
        harm->max = angle;
}

static uint32_t add_angle(ntp__angle_sums *angles, const ntp__row *row, int32_t b, uint32_t count,
                          ntp_encoding encoding)
{
    int32_t m = row->m;
    bool zzero = encoding == NTP_ENCODING_ZZERO;
    int64_t x = ntp__num(row->r, m), y = ntp__num(row->g, m), z, wz;
    if (encoding == NTP_ENCODING_XY) {
        z = row->want[0] < 0 ? 0 : ntp__num(row->want[0], m);
        wz = ntp__num(row->cleaned_blue[0], m);
    } else {
        z = zzero ? b : ntp__num(b, m);
        wz = zzero ? row->cleaned_blue[1] : ntp__num(row->cleaned_blue[0], m);
    }
    uint32_t angle = 0;
    if (row->want[0] < 0 || z != wz)
        angle = ntp__angle(x, y, z, ntp__num(row->cleaned[0], m), ntp__num(row->cleaned[1], m), wz);
    ntp__angles_add(angles, angle, count);
    return angle;
}

void ntp__add(ntp__sums *sums, const ntp__row *row, int32_t b, uint32_t count,
              ntp_encoding encoding)
{
    sums->texels += count;
    uint32_t flags[2] = { add_fit(&sums->fit[0], row, b, count, false),
                          add_fit(&sums->fit[1], row, b, count, true) };
    uint32_t angle = add_angle(&sums->angles, row, b, count, encoding);
    const int32_t c[3] = { row->r, row->g, b };
    add_harm(sums, c, row->m, encoding, row->pair_fails, flags[encoding == NTP_ENCODING_ZZERO],
             angle, count);
}

/* The sums and extremes of a block.  off[i] becomes how far the length is from 1.  count NULL: one
 * each; inline, so that this case gets loops of its own. */
static inline void add_lengths(ntp__fit_sums *sums, uint32_t *off, const ntp__judged_fit *fit,
                               const uint32_t *count, int32_t n)
{
    int32_t least = INT32_MAX, greatest = 0, levels_off = 0;
    uint64_t sum = 0, error2 = 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t length = fit->length[i];
        least = length < least ? length : least;
        greatest = length > greatest ? length : greatest;
        levels_off = fit->levels_off[i] > levels_off ? fit->levels_off[i] : levels_off;
        off[i] = (uint32_t) ntp__abs(length - NTP__LENGTH_ONE);
    }
    for (int32_t i = 0; i < n; i++) {
        const uint32_t texels = count != NULL ? count[i] : 1;
        sum += (uint64_t) (uint32_t) fit->length[i] * texels;
        error2 += (uint64_t) off[i] * off[i] * texels;
    }
    sums->length_sum += sum;
    sums->length_error2[0] += error2; /* texels of a block are not too long, so no padding */
    if ((uint32_t) levels_off > sums->levels_off_max)
        sums->levels_off_max = (uint32_t) levels_off;
    if ((uint32_t) greatest > sums->length_max)
        sums->length_max = (uint32_t) greatest;
    if (~(uint32_t) least > sums->length_inverted_min)
        sums->length_inverted_min = ~(uint32_t) least;
}

static inline void count_fit(ntp__fit_sums *sums, const ntp__judged_fit *fit, int32_t i,
                             uint32_t off, uint32_t count)
{
    const uint32_t key = (uint32_t) fit->key[i];
    sums->flags[key] += count;
    sums->levels_off[fit->levels_off[i]] += count;
    sums->lengths[(uint32_t) fit->length[i] / (NTP__LENGTH_ONE / 128)] += count;
    sums->length_error[key / 256] += (uint64_t) off * count;
}

/* An angle that is too large for the short series of the kernel. */
static uint32_t long_angle(const ntp__judged *j, int32_t i, const ntp__block *block, int32_t m,
                           bool zzero)
{
    int64_t x = ntp__num(block->c[0][i], m), y = ntp__num(block->c[1][i], m);
    int32_t b = block->c[2][i], want = j->fit[zzero].want[i];
    if (zzero)
        return ntp__angle(x, y, b, x, y, want);
    return ntp__angle(x, y, ntp__num(b, m), x, y, ntp__num(want, m));
}

/* Each count waits for the one before it if both are in one place, as they mostly are.  So all
 * counts of a texel are in one loop, where they wait at the same time. */
static inline void add_judged(ntp__sums *sums, const ntp__judged *j, const ntp__block *block,
                              const uint32_t *count, int32_t n, int32_t m, ntp_encoding encoding)
{
    const bool zzero = encoding == NTP_ENCODING_ZZERO;
    const int32_t down = encoding == NTP_ENCODING_STANDARD ? (m - 1) / 2 : 0;
    uint32_t off[2][NTP__BLOCK];
    add_lengths(&sums->fit[0], off[0], &j->fit[0], count, n);
    add_lengths(&sums->fit[1], off[1], &j->fit[1], count, n);
    for (int32_t i = 0; i < n; i++) {
        const uint32_t texels = count != NULL ? count[i] : 1;
        const uint32_t flags = (uint32_t) j->fit[zzero].key[i];
        uint32_t angle = 0;
        count_fit(&sums->fit[0], &j->fit[0], i, off[0][i], texels);
        count_fit(&sums->fit[1], &j->fit[1], i, off[1][i], texels);
        if (encoding != NTP_ENCODING_XY)
            angle = j->angle[i] >= 0 ? (uint32_t) j->angle[i] : long_angle(j, i, block, m, zzero);
        sums->texels += texels;
        ntp__angles_add(&sums->angles, angle, texels);
        if (block->c[2][i] < down || !(flags & NTP_FLAG_NEIGHBOR)) {
            const int32_t c[3] = { block->c[0][i], block->c[1][i], block->c[2][i] };
            add_harm(sums, c, m, encoding, false, flags, angle, texels);
        }
    }
}

void ntp__add_block(ntp__sums *sums, const ntp__block *block, const uint32_t *count, int32_t n,
                    int32_t m, ntp_encoding encoding)
{
    ntp__judged j;
    if (n == 0)
        return;
    ntp__kernels(NTP__CPU_ALL)
        ->judge_block(&j, block->c[0], block->c[1], block->c[2], n, m,
                      encoding == NTP_ENCODING_ZZERO);
    if (count == NULL)
        add_judged(sums, &j, block, NULL, n, m, encoding);
    else
        add_judged(sums, &j, block, count, n, m, encoding);
}

/* ------------------------------------------------------------------------- sums as wholes */

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
        if (s->harm[k].texels > 0)
            memset(&s->harm[k], 0, sizeof s->harm[k]);
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
