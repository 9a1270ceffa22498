/* SPDX-License-Identifier: MIT */
/*
 * far_counts.c - merges and empties the counts of far_texels.h
 */
#include "measure/far_texels.h"

#include <stddef.h>
#include <string.h>

#ifdef NTP_HAVE_AVX2

/* Words of ntp__sums that may be counted.  The last ones are never read (judged_sums.h). */
typedef struct range {
    size_t first, n;
} range;

enum { READ = 3 + NTP__ALL_HARM, RANGES = READ + 2 };

#  define WORD(member) (offsetof(ntp__sums, member) / sizeof(uint32_t))

static void find_ranges(range to[RANGES], const ntp__sums *of)
{
    const size_t fit = (WORD(fit[1]) - WORD(fit[0])), harm = WORD(harm[1]) - WORD(harm[0]);
    const size_t levels = WORD(fit[0].levels_off);
    for (size_t k = 0; k < 2; k++) {
        to[k] = (range) { levels + k * fit, of->fit[k].levels_off_max + 1 };
        to[READ + k] = (range) { levels + k * fit + NTP__NO_BLUE, 1 };
    }
    to[2] = (range) { WORD(angles.bins), (of->angles.max + 500) / 1000 + 1 };
    for (size_t k = 0; k < NTP__ALL_HARM; k++)
        to[3 + k] = (range) { WORD(harm[0].bins) + k * harm, ntp__harm_bin(of->harm[k].max) + 1 };
}

/* Are eight of them 0?  Then their words stay untouched, as memory costs more than counts in small
 * textures. */
static bool none_of_eight(const uint8_t *few)
{
    uint64_t all;
    memcpy(&all, few, sizeof all);
    return all == 0;
}

static void add_range(uint32_t *words, const uint8_t *few, size_t n)
{
    for (size_t i = 0; i < n; i += 8) {
        if (i + 8 <= n && none_of_eight(few + i))
            continue;
        for (size_t k = i; k < i + 8 && k < n; k++)
            words[k] += few[k];
    }
}

static void clear_range(uint8_t *few, size_t n)
{
    for (size_t i = 0; i < n; i += 8) {
        const size_t some = n - i < 8 ? n - i : 8;
        if (some < 8 || !none_of_eight(few + i))
            memset(few + i, 0, some);
    }
}

/* Returns how many there are of this key. */
static uint32_t add_lengths(uint32_t *lengths, const ntp__far_counts *far, uint32_t key)
{
    const uint8_t *const shapes = far->shapes + key * NTP__LENGTH_BINS;
    uint32_t count = 0;
    add_range(lengths, shapes, NTP__LENGTH_BINS);
    for (int32_t i = 0; i < NTP__LENGTH_BINS; i++)
        count += shapes[i];
    return count;
}

static uint32_t flag_if(uint32_t key, uint32_t bit, uint32_t flag)
{
    return key & bit ? flag : 0;
}

void ntp__merge_far(ntp__sums *into, const ntp__far_counts *far, const ntp__sums *of)
{
    range ranges[RANGES];
    uint32_t *const words = (uint32_t *) (void *) into;
    if (!far->used)
        return;
    find_ranges(ranges, of);
    for (int32_t k = 0; k < READ; k++)
        add_range(words + ranges[k].first, far->few + ranges[k].first, ranges[k].n);
    for (uint32_t i = 0; i < NTP__KEYS; i++) {
        const uint32_t count = far->keys[i] + add_lengths(into->fit[0].lengths, far, i);
        const uint32_t bin = i / NTP__KEY_STEEP * 256;
        const uint32_t common = flag_if(i, NTP__KEY_FAR, NTP__FAR) |
                                flag_if(i, NTP__KEY_TOO_LONG, NTP_FLAG_XY_TOO_LONG);
        const uint32_t standard = flag_if(i, NTP__KEY_NEGATIVE, NTP_FLAG_Z_NEGATIVE) |
                                  flag_if(~i, NTP__KEY_SHORT, NTP__LONG);
        into->fit[0].flags[bin + (common | standard)] += count;
        into->fit[1].flags[bin + (common | flag_if(i, NTP__KEY_ZZ_LONG, NTP__LONG))] += count;
    }
}

void ntp__clear_far(ntp__far_counts *far, const ntp__sums *of)
{
    range ranges[RANGES];
    far->skip = 0;
    if (!far->used)
        return;
    find_ranges(ranges, of);
    for (int32_t k = 0; k < RANGES; k++)
        clear_range(far->few + ranges[k].first, ranges[k].n);
    memset(far, 0, offsetof(ntp__far_counts, few));
}

#else /* nothing counts there */
void ntp__merge_far(ntp__sums *into, const ntp__far_counts *far, const ntp__sums *of)
{
    (void) into, (void) far, (void) of;
}

void ntp__clear_far(ntp__far_counts *far, const ntp__sums *of)
{
    (void) far, (void) of;
}
#endif
