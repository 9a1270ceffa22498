/* SPDX-License-Identifier: MIT */
/*
 * close_sums.c - adds 16-bit texels that are close to exact, as most are; close.h says which
 */
#include "base/cpu.h"
#include "texel/kernels_avx512.h"
#include "measure/far_texels.h"
#include "measure/judged_sums.h"

#include <stddef.h>
#include <string.h>

static void add_extremes(ntp__fit_sums *fit, uint32_t least, uint32_t greatest, uint32_t levels)
{
    ntp__merge_max(&fit->length_max, greatest);
    ntp__merge_max(&fit->length_inverted_min, ~least);
    ntp__merge_max(&fit->levels_off_max, levels);
}

static ntp__count_close_fn *close_kernel(void)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        return ntp__count_close_avx512;
#endif
    return ntp__kernels(NTP__CPU_ALL)->count_close;
}

#ifdef NTP_HAVE_AVX2
static int32_t add_far(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n)
{
#  ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        return ntp__add_far_avx512(sums, far, block, n);
#  endif
    return ntp__add_far_avx2(sums, far, block, n);
}
#endif

int32_t ntp__take_close_block(ntp__sums *sums, ntp__close_counts *close, ntp__far_counts *far,
                              ntp__block *block, int32_t n)
{
    ntp__fit_sums *const zz = &sums->fit[1];
    ntp__close_block found;
    int32_t *const colors[3] = { block->c[0], block->c[1], block->c[2] };
    ntp__count_close_fn *const count = close_kernel();
    if (count == NULL)
        return n;
#ifdef NTP_HAVE_AVX2
    /* There is a kernel that counts close ones, so there is AVX2.  After a block without close texels, far ones are
     * looked for first. */
    const bool first = far->first != 0;
    if (first)
        n = add_far(sums, far, block, n);
    if (n == 0)
        return 0;
#endif
    count(&found, close, zz->levels_off, colors, n);
    if (found.texels > 0) {
        zz->length_sum += (uint64_t) ((int64_t) found.texels * NTP__LENGTH_ONE + found.length_sum);
        zz->length_error2[0] += found.length_error2;
        add_extremes(zz, found.least, found.greatest, found.levels_off_max);
        sums->texels += (uint32_t) found.texels;
        sums->angles.texels += (uint32_t) found.texels;
        sums->angles.sum += found.angle_sum;
        if (found.angle_max > sums->angles.max)
            sums->angles.max = found.angle_max;
        for (int32_t k = 0; k < 3; k++)
            sums->angles.bins[k] += (uint32_t) found.angle_bins[k];
    }
#ifdef NTP_HAVE_AVX2
    if (!first)
        found.left = add_far(sums, far, block, found.left);
    far->first = found.texels == 0;
#else
    (void) far;
#endif
    return found.left;
}

void ntp__add_close_block(ntp__sums *sums, ntp__close_counts *close, ntp__far_counts *far,
                          ntp__block *block, int32_t n)
{
    ntp__add_block(sums, block, NULL, ntp__take_close_block(sums, close, far, block, n), 65535,
                   NTP_ENCODING_STANDARD);
}

void ntp__add_exact(ntp__sums *sums, const ntp__exact_block *found)
{
    ntp__fit_sums *const zz = &sums->fit[1];
    const uint32_t texels = (uint32_t) found->texels;
    sums->texels += texels;
    sums->angles.texels += texels;
    sums->angles.bins[0] += texels;
    if (found->far == 0)
        return;
    zz->length_sum += (uint64_t) (uint32_t) found->far * NTP__LENGTH_ONE + found->length_sum;
    zz->length_error2[0] += found->length_error2;
    add_extremes(zz, NTP__LENGTH_ONE + found->least, NTP__LENGTH_ONE + found->greatest,
                 found->levels_off_max);
}

/* How many rows and distances of exact texels are in use, if these sums include their extremes.  Others
 * stay untouched, as memory costs more than counts in small textures. */
static uint32_t exact_rows(const ntp__sums *sums)
{
    const uint32_t last = sums->fit[1].length_max / (NTP__LENGTH_ONE / 128);
    return last < 128 ? 0 : last - 127 < NTP__EXACT_ROWS ? last - 127 : NTP__EXACT_ROWS;
}

static uint32_t exact_distances(const ntp__sums *sums)
{
    const uint32_t most = NTP__EXACT_DISTANCES - NTP__EXACT_LESS,
                   used = sums->fit[1].levels_off_max + 1;
    return used < most ? used : most;
}

/* The bytes before the distances. */
static size_t close_prefix(const ntp__sums *sums)
{
    const size_t row = NTP__EXACT_ROW * NTP__CLOSE_COPIES * sizeof(uint32_t);
    return offsetof(ntp__close_counts, exact[NTP__EXACT_FAR]) + exact_rows(sums) * row;
}

static uint32_t sum_of_copies(const uint32_t *count, int32_t copies)
{
    uint32_t sum = 0;
    for (int32_t i = 0; i < copies; i++)
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
    add_extremes(fit, length, length, levels);
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

/* Exact texels by what their places say (close.h), as places of close ones. */
static void add_exact(ntp__sums *sums, uint32_t steep, uint32_t passed, uint32_t place_zz,
                      uint32_t count)
{
    const uint32_t length = (passed + 1) / 2, is_long = passed >= 2 ? NTP__CLOSE_LONG : 0;
    add_close_standard(&sums->fit[0],
                       steep << NTP__CLOSE_STEEP_BIT | NTP__CLOSE_ROUNDED | is_long | length,
                       count);
    add_close_zzero(&sums->fit[1], place_zz | NTP__CLOSE_ZZ_LONG, count);
}

static void add_exact_counts(ntp__sums *sums, const ntp__close_counts *close)
{
    enum { NEAR_ONES = 1 << NTP__EXACT_OFF_BIT, ONE = NTP__CLOSE_ZZ_LENGTH };
    ntp__fit_sums *const zz = &sums->fit[1];
    for (uint32_t i = NEAR_ONES; i < NTP__EXACT_NEAR_PLACES; i++) {
        const uint32_t off = (i >> NTP__EXACT_OFF_BIT) - 1, copies = NTP__EXACT_NEAR_COPIES;
        const uint32_t count = sum_of_copies(&close->exact[i * copies], NTP__EXACT_NEAR_COPIES);
        const uint32_t flags = flag_if(i, NTP__EXACT_NEIGHBOR, NTP__CLOSE_ZZ_NEIGHBOR) |
                               flag_if(i, NTP__EXACT_ROUNDED, NTP__CLOSE_ZZ_ROUNDED) |
                               (off == 0 ? NTP__CLOSE_ZZ_EXACT : 0);
        if (count == 0)
            continue;
        add_exact(sums, 0, i & NTP__EXACT_PASSED, flags | ONE, count);
        zz->levels_off[off] += count;
        zz->length_sum += (uint64_t) (NTP__LENGTH_ONE + off) * count;
        zz->length_error2[0] += (uint64_t) (off * off) * count;
        add_extremes(zz, NTP__LENGTH_ONE + off, NTP__LENGTH_ONE + off, off);
    }
    for (uint32_t i = 0; i < NTP__EXACT_ROW * exact_rows(sums); i++) {
        const uint32_t row = i / NTP__EXACT_ROW, steep = i % NTP__EXACT_ROW >> NTP__EXACT_STEEP_BIT;
        const uint32_t *const at = &close->exact[NTP__EXACT_FAR + i * NTP__CLOSE_COPIES];
        const uint32_t count = sum_of_copies(at, NTP__CLOSE_COPIES);
        if (count > 0)
            add_exact(sums, steep, i & NTP__EXACT_PASSED, (1 + row) * ONE, count);
    }
    for (uint32_t off = 0; off < exact_distances(sums); off++)
        zz->levels_off[off] += close->exact_off[off + NTP__EXACT_LESS];
}

void ntp__merge_close(ntp__close_counts *into, const ntp__close_counts *from, const ntp__sums *sums)
{
    ntp__merge_counts((uint32_t *) into, (const uint32_t *) from,
                      close_prefix(sums) / sizeof(uint32_t));
    ntp__merge_counts(into->exact_off, from->exact_off, exact_distances(sums) + NTP__EXACT_LESS);
}

void ntp__clear_close(ntp__close_counts *close, const ntp__sums *sums)
{
    memset(close, 0, close_prefix(sums));
    memset(close->exact_off, 0,
           (exact_distances(sums) + NTP__EXACT_LESS) * sizeof close->exact_off[0]);
}

void ntp__take_close(ntp__sums *sums, ntp__close_counts *close)
{
    for (uint32_t i = 0; i < NTP__CLOSE_PLACES; i++) {
        const uint32_t count = sum_of_copies(close->standard[i], NTP__CLOSE_COPIES);
        if (count > 0)
            add_close_standard(&sums->fit[0], i, count);
    }
    for (uint32_t i = 0; i < NTP__CLOSE_ZZ_PLACES; i++) {
        const uint32_t count = sum_of_copies(close->zzero[i], NTP__CLOSE_COPIES);
        if (count > 0)
            add_close_zzero(&sums->fit[1], i, count);
    }
    add_exact_counts(sums, close);
    ntp__clear_close(close, sums);
}
