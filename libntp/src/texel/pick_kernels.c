/* SPDX-License-Identifier: MIT */
/*
 * pick_kernels.c - the table of texel kernels for this processor
 */
#include "texel/kernels_avx512.h"

extern const ntp__kernels_table ntp__kernels_base, ntp__kernels_avx2;

const ntp__kernels_table *ntp__kernels(int mask)
{
    return NTP__CPU_PICK(mask, ntp__kernels_base, ntp__kernels_avx2);
}

void ntp__pick_kernels(ntp__kernels_table *kernels, int mask)
{
    *kernels = *ntp__kernels(mask);
#ifdef NTP_HAVE_AVX512
    if (!ntp__cpu_has_avx512(mask))
        return;
    kernels->clean_rgb8 = ntp__clean_rgb8_avx512;
    kernels->clean_rgb8_blindly = ntp__clean_rgb8_avx512;
    kernels->clean_rgba8 = ntp__clean_rgba8_avx512;
    kernels->derive_rgb16 = ntp__derive_rgb16_avx512;
    kernels->count_cells = ntp__count_cells_avx512;
    kernels->count_close8 = ntp__count_close8_avx512;
    kernels->count_exact = ntp__count_exact_avx512;
    kernels->validate_rgb = ntp__validate_rgb_avx512;
    kernels->normalize_rgb8 = ntp__normalize_rgb8_avx512;
    kernels->normalize_rgb16 = ntp__normalize_rgb16_avx512;
#endif
}
