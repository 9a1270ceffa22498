/* SPDX-License-Identifier: MIT */
/*
 * convert_avx2.h - packed RGB between the two encodings with a Z, and between depths, with AVX2
 */
#ifndef NTP_CONVERT_AVX2_H
#define NTP_CONVERT_AVX2_H

#include "repair/convert.h"

/*
 * Converts n texels from s to d, of levels of packed RGB, without a flip.  Returns how many are done, a
 * multiple of 16: it stops before texels that have to be pulled or kept, and before the last ones.  Adds to
 * *negative how many negative z became |z|.
 */
typedef int32_t ntp__convert_rgb_fn(const ntp__conversion *j, uint8_t *d, const uint8_t *s,
                                    int32_t n, uint64_t *negative);

ntp__convert_rgb_fn ntp__convert_rgb_avx2;

/* All bits, where black texels hold no normal, or none. */
static inline uint32_t ntp__black_is_unused(const ntp__conversion *j)
{
    return (j->how.touch_unused & NTP_UNUSED_BLACK) ? 0 : UINT32_MAX;
}

/* With AVX-512; the less common conversions are those of AVX2. */
ntp__convert_rgb_fn ntp__convert_rgb_avx512;

/* Packed levels of 3 or 4 channels to float vectors, v + v/M with v = c*times - less for each channel.
 * Returns how many of n are done: it leaves some of the last ones. */
int32_t ntp__decode_avx2(float *d, const void *s, int32_t n, int32_t channels, bool deep,
                         const float times[4], const float less[4]);

/* Of 16 texels: bits of those whose levels are not known, or whose red and green are too long; and of
 * those with z < 0. */
typedef struct ntp__left {
    uint32_t doubt, overlong, negative;
} ntp__left;

/* Packed vectors to packed RGB with derived blue.  Returns how many of n are done, a multiple of 16,
 * with one of `left` for every 16. */
int32_t ntp__encode_rgb_avx2(void *d, const float *s, int32_t n, bool deep, bool zzero, bool flip,
                             ntp__left *left);

/* Does those of 16 texels, from s to d, that the former leaves (convert.c). */
void ntp__settle_vectors(const ntp__conversion *j, uint8_t *d, const float *s,
                         const ntp__left *left, ntp_convert_counts *counts);

#endif
