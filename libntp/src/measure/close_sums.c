/* SPDX-License-Identifier: MIT */
/*
 * close_sums.c - adds 16-bit texels that are close to exact, as most are; close.h says which
 */
#include "texel/kernels.h"
#include "measure/judged_sums.h"

void ntp__add_close_block(ntp__sums *sums, ntp__close_counts *close, ntp__block *block, int32_t n)
{
    ntp__fit_sums *const zz = &sums->fit[1];
    ntp__close_block found;
    int32_t *const colors[3] = { block->c[0], block->c[1], block->c[2] };
    ntp__count_close_fn *const count = ntp__kernels(NTP__CPU_ALL)->count_close;
    if (count == NULL) {
        ntp__add_block(sums, block, NULL, n, 65535, NTP_ENCODING_STANDARD);
        return;
    }
    count(&found, close, zz->levels_off, colors, n);
    if (found.texels > 0) {
        zz->length_sum += (uint64_t) (found.texels * (int64_t) NTP__LENGTH_ONE + found.length_sum);
        zz->length_error2[0] += found.length_error2;
        ntp__merge_max(&zz->length_max, (uint32_t) (NTP__LENGTH_ONE + found.greatest));
        ntp__merge_max(&zz->length_inverted_min, ~(uint32_t) (NTP__LENGTH_ONE + found.least));
        ntp__merge_max(&zz->levels_off_max, (uint32_t) found.levels_off_max);
        sums->texels += (uint32_t) found.texels;
        sums->angles.texels += (uint32_t) (found.texels - found.turned);
        sums->angles.bins[0] += (uint32_t) (found.texels - found.turned);
        for (int32_t i = 0; i < found.turned; i++)
            ntp__angles_add(&sums->angles, (uint32_t) found.angle[i], 1);
    }
    ntp__add_block(sums, block, NULL, found.left, 65535, NTP_ENCODING_STANDARD);
}

static uint32_t sum_of_copies(const uint32_t count[NTP__CLOSE_COPIES])
{
    uint32_t sum = 0;
    for (int32_t i = 0; i < NTP__CLOSE_COPIES; i++)
        sum += count[i];
    return sum;
}

static uint32_t flag_if(uint32_t place, uint32_t bit, uint32_t flag)
{
    return place & bit ? flag : 0;
}

static void add_close_standard(ntp__fit_sums *fit, uint32_t place, uint32_t count)
{
    const uint32_t length = NTP__LENGTH_ONE - 1 + (place & NTP__CLOSE_LENGTH);
    const uint32_t steep = place >> NTP__CLOSE_STEEP_BIT, inexact = place & NTP__CLOSE_INEXACT;
    const uint32_t off = length != NTP__LENGTH_ONE, levels = inexact != 0;
    uint32_t bin = 0;
    while ((bin + 1) * (bin + 1) <= steep)
        bin++;
    const uint32_t flags = NTP_FLAG_NEIGHBOR | (inexact ? 0 : NTP_FLAG_EXACT) |
                           flag_if(place, NTP__CLOSE_ROUNDED, NTP_FLAG_ROUNDED) |
                           flag_if(place, NTP__CLOSE_LONG, NTP__LONG);
    fit->flags[bin * 256 + flags] += count;
    fit->lengths[length / (NTP__LENGTH_ONE / 128)] += count;
    fit->length_sum += (uint64_t) length * count;
    fit->length_error[bin] += off * (uint64_t) count;
    fit->length_error2[0] += off * (uint64_t) count;
    fit->levels_off[levels] += count;
    ntp__merge_max(&fit->levels_off_max, levels);
    ntp__merge_max(&fit->length_max, length);
    ntp__merge_max(&fit->length_inverted_min, ~length);
}

static void add_close_zzero(ntp__fit_sums *fit, uint32_t place, uint32_t count)
{
    const uint32_t flags = flag_if(place, NTP__CLOSE_ZZ_NEIGHBOR, NTP_FLAG_NEIGHBOR) |
                           flag_if(place, NTP__CLOSE_ZZ_ROUNDED, NTP_FLAG_ROUNDED) |
                           flag_if(place, NTP__CLOSE_ZZ_EXACT, NTP_FLAG_EXACT) |
                           flag_if(place, NTP__CLOSE_ZZ_LONG, NTP__LONG);
    fit->flags[flags] += count; /* of Z-zero, nothing but padding is told apart by steepness */
    fit->lengths[NTP__CLOSE_ZZ_SHORTEST + place / NTP__CLOSE_ZZ_LENGTH] += count;
}

void ntp__add_close(ntp__sums *sums, const ntp__close_counts *close)
{
    for (uint32_t i = 0; i < NTP__CLOSE_PLACES; i++) {
        const uint32_t count = sum_of_copies(close->standard[i]);
        if (count > 0)
            add_close_standard(&sums->fit[0], i, count);
    }
    for (uint32_t i = 0; i < NTP__CLOSE_ZZ_PLACES; i++) {
        const uint32_t count = sum_of_copies(close->zzero[i]);
        if (count > 0)
            add_close_zzero(&sums->fit[1], i, count);
    }
}
