/* SPDX-License-Identifier: MIT */
/*
 * count_far.c - counts texels that are far from exact (far_texels.h)
 *
 * What this takes is the number of counts, rather than the memory they fall into.
 */
#include "measure/far_texels.h"

#ifdef NTP_HAVE_AVX2

/* Once in 256 times. */
#  define UNLIKELY(condition) __builtin_expect(condition, 0)

static inline void count_in(ntp__sums *sums, uint8_t *few, uint32_t word)
{
    if (UNLIKELY(++few[word] == 0))
        ((uint32_t *) (void *) sums)[word] += 256;
}

static inline void count_one(ntp__sums *sums, ntp__far_counts *far, const ntp__far_places *at,
                             int32_t i, uint32_t *lengths_zz)
{
    enum { LENGTHS = NTP__LENGTH_BINS };
    const uint64_t levels = at->words[i], angles = at->words[NTP__FAR_STEP + i];
    const uint32_t shape = at->shape[i] / LENGTHS;
    lengths_zz[at->shape[i] % LENGTHS]++;
    if (UNLIKELY(++far->shapes[shape] == 0)) {
        far->keys[shape / LENGTHS] += 256;
        sums->fit[0].lengths[shape % LENGTHS] += 256;
    }
    count_in(sums, far->few, (uint32_t) levels);
    count_in(sums, far->few, (uint32_t) (levels >> 32));
    count_in(sums, far->few, (uint32_t) angles);
    count_in(sums, far->few, (uint32_t) (angles >> 32));
}

void ntp__count_places(ntp__sums *sums, ntp__far_counts *far, const ntp__far_places *at, int32_t n)
{
    ntp__fit_sums *const zz = &sums->fit[1];
    far->used = 1;
    for (int32_t i = 0; i < n; i += 2) {
        count_one(sums, far, at, i, zz->lengths);
        count_one(sums, far, at, i + 1, zz->other_lengths);
    }
}

void ntp__add_padding_harm(ntp__sums *sums, const int32_t *kinds, const int32_t *angles,
                           uint32_t which)
{
    for (; which != 0; which &= which - 1) {
        const int32_t i = __builtin_ctz(which);
        const uint32_t angle = (uint32_t) angles[i];
        ntp__harm_sums *const harm =
            &sums->harm[(uint32_t) kinds[i] / (sizeof *harm / sizeof(uint32_t))];
        harm->texels++;
        harm->sum += angle;
        harm->max = angle > harm->max ? angle : harm->max;
    }
}

#endif
