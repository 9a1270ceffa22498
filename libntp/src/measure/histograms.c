/* SPDX-License-Identifier: MIT */
/*
 * histograms.c - how often a tally has which length, distance of blue, and angle of harm
 */
#include "measure/tally.h"

#include <string.h>

ntp_encoding ntp__encoding_at_hand(const ntp_tally *t)
{
    return t->summed ? (ntp_encoding) t->summed_encoding
                     : ntp__judged_as((ntp_encoding) t->encoding);
}

ntp_status ntp_tally_levels_off(uint64_t *counts, size_t size, ntp_tally *tally,
                                ntp_encoding encoding)
{
    if (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO)
        return NTP_ERR_ARGUMENT;
    /* These counts do not depend on the encoding that angles are measured by. */
    if (tally == NULL || tally->depth == 0 || counts == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(tally, ntp__encoding_at_hand(tally)));
    int32_t z = encoding == NTP_ENCODING_ZZERO;
    const ntp__fit_sums *used = &ntp__used(tally)->fit[z], *unused = &tally->unused.fit[z];
    if (size <= used->levels_off_max || size <= unused->levels_off_max)
        return NTP_ERR_ARGUMENT;
    size_t bins = (size_t) ntp__tally_max(tally) + 1;
    for (size_t i = 0; i < size && i < bins; i++)
        counts[i] = (uint64_t) used->levels_off[i] + unused->levels_off[i];
    return NTP_OK;
}

ntp_status ntp_tally_lengths(uint64_t counts[256], ntp_tally *tally, ntp_encoding encoding)
{
    if (counts == NULL || tally == NULL || tally->depth == 0 ||
        (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(tally, ntp__encoding_at_hand(tally)));
    int32_t z = encoding == NTP_ENCODING_ZZERO;
    const ntp__fit_sums *used = &ntp__used(tally)->fit[z], *unused = &tally->unused.fit[z];
    for (int32_t i = 0; i < NTP__LENGTH_BINS; i++)
        counts[i] = (uint64_t) used->lengths[i] + unused->lengths[i];
    return NTP_OK;
}

ntp_status ntp_tally_harm(ntp_harm *harm, ntp_tally *tally, ntp_encoding encoding, uint32_t kinds,
                          double degrees)
{
    if (harm == NULL || kinds > NTP_HARM_ALL || !(degrees >= 0 && degrees <= 180))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__sum_up(tally, encoding));
    uint64_t padding = ntp__padding_of_one_color(tally);
    const ntp__sums *const sums = ntp__used(tally);
    uint64_t used = sums->texels - padding, sum = 0, max = 0, below = used;
    memset(harm, 0, sizeof *harm);
    /* Where padding counts, it counts as what it is. */
    if (padding == 0)
        kinds |= (kinds >> 1 & 3) << NTP__HARM_KINDS;
    const ntp__harm_sums *of[NTP__ALL_HARM]; /* those with texels */
    int32_t number = 0;
    for (uint32_t k = 0; k < NTP__ALL_HARM; k++) {
        const ntp__harm_sums *one = &sums->harm[k];
        if (!(kinds >> k & 1) || one->texels == 0)
            continue;
        of[number++] = one;
        harm->texels += one->texels;
        sum += one->sum;
        max = one->max > max ? one->max : max;
    }
    if (harm->texels == 0)
        return NTP_OK;
    /* From the greatest angle down; `below` have at most this one. */
    const uint32_t bins = ntp__harm_bin(max) + 1, limit = (uint32_t) (degrees * 100 + 0.5);
    for (uint32_t i = bins; i-- > 0 && below * 100 >= used * 99;) {
        harm->p99 = i / 100.0;
        for (int32_t k = 0; k < number; k++)
            below -= of[k]->bins[i];
    }
    harm->over = harm->texels;
    for (int32_t k = 0; k < number; k++) {
        for (uint32_t i = 0; i < bins && i <= limit; i++)
            harm->over -= of[k]->bins[i];
    }
    harm->mean = (double) sum / (double) used / 1e6;
    harm->max = (double) max / 1e6;
    return NTP_OK;
}
