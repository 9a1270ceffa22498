/* SPDX-License-Identifier: MIT */
/*
 * judge.c - what one texel, or many of one color, add to the sums of a measurement
 */
#include "level.h"
#include "tally.h"

#include <math.h>
#include <string.h>

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
    row->steepness = bin < NTP_STEEPNESS_BINS ? bin : NTP_STEEPNESS_BINS - 1;
    row->flags = 0;
    if (s >= 0) {
        row->want[0] = row->cleaned_blue[0] = ntp__blue_of_rest(s, m, false);
        row->want[1] = row->cleaned_blue[1] = ntp__blue_of_rest(s, m, true);
        return;
    }
    row->flags = NTP_XY_TOO_LONG;
    if ((double) row->xy2 > FAR_SQUARED * (double) ntp__sq(m))
        row->flags |= NTP__FAR;
    row->want[0] = row->want[1] = -1;
    ntp__pull(&row->cleaned[0], &row->cleaned[1], m);
    s = ntp__rest(row->cleaned[0], row->cleaned[1], m);
    row->cleaned_blue[0] = ntp__blue_of_rest(s, m, false);
    row->cleaned_blue[1] = ntp__blue_of_rest(s, m, true);
}

void ntp__add_fit(ntp__fit_sums *fit, int32_t steepness, uint32_t flags, int32_t levels_off,
                  int32_t length, uint32_t count)
{
    uint64_t error =
        (uint64_t) (length > NTP__LENGTH_ONE ? length - NTP__LENGTH_ONE : NTP__LENGTH_ONE - length);
    uint32_t bin = (uint32_t) length / (NTP__LENGTH_ONE / 128), inverted = ~(uint32_t) length;
    fit->flags[(uint32_t) steepness * 256 + flags] += count;
    if (levels_off >= 0)
        fit->levels_off[levels_off] += count;
    fit->lengths[bin < NTP__LENGTH_BINS ? bin : NTP__LENGTH_BINS - 1] += count;
    fit->length_sum += (uint64_t) length * count;
    fit->length_error[steepness] += error * count;
    fit->length_error2 += error * error * count;
    if ((uint32_t) length > fit->length_max)
        fit->length_max = (uint32_t) length;
    if (inverted > fit->length_inverted_min)
        fit->length_inverted_min = inverted;
}

static void add_fit(ntp__fit_sums *fit, const ntp__row *row, int32_t b, uint32_t count, bool zzero)
{
    int32_t m = row->m, want = row->want[zzero], levels_off = -1;
    bool negative = !zzero && ntp__z_negative(b, m);
    uint32_t flags = row->flags | (negative ? (uint32_t) NTP_Z_NEGATIVE : 0);
    if (ntp__neighbor(row->r, row->g, b, m, zzero))
        flags |= NTP_PASS_NEIGHBOR;
    if (ntp__rounded(row->r, row->g, b, m, zzero))
        flags |= NTP_PASS_ROUNDED;
    if (want >= 0) {
        if (b == want)
            flags |= NTP_PASS_EXACT;
        if (!zzero && m - b == want)
            flags |= NTP__MIRRORED;
        levels_off = ntp__abs((negative ? m - b : b) - want);
    }
    int64_t length2 = row->xy2 + ntp__sq(zzero ? b : ntp__num(b, m));
    if (length2 > ntp__sq(m))
        flags |= NTP__LONG;
    ntp__add_fit(fit, row->steepness, flags, levels_off, ntp__fixed_length((double) length2, m),
                 count);
}

static void add_angle(ntp__angle_sums *angles, const ntp__row *row, int32_t b, uint32_t count,
                      ntp_encoding encoding)
{
    int32_t m = row->m;
    bool zzero = encoding == NTP_ZZERO;
    int64_t x = ntp__num(row->r, m), y = ntp__num(row->g, m), z, wz;
    if (encoding == NTP_XY) {
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
}

void ntp__add(ntp__sums *sums, const ntp__row *row, int32_t b, uint32_t count,
              ntp_encoding encoding)
{
    sums->texels += count;
    add_fit(&sums->fit[0], row, b, count, false);
    add_fit(&sums->fit[1], row, b, count, true);
    add_angle(&sums->angles, row, b, count, encoding);
}
