/* SPDX-License-Identifier: MIT */
/*
 * kernels_avx512.h - loops over packed RGB with AVX-512, which replace those of kernels.c
 */
#ifndef NTP_KERNELS_AVX512_H
#define NTP_KERNELS_AVX512_H

#include "texel/kernels.h"

ntp__normalize_rgb_fn ntp__normalize_rgb8_avx512, ntp__normalize_rgb16_avx512;
ntp__clean8_fn ntp__clean_rgb8_avx512, ntp__clean_rgba8_avx512;
ntp__derive16_fn ntp__derive_rgb16_avx512;
ntp__validate_rgb_fn ntp__validate_rgb_avx512;
ntp__count_close8_fn ntp__count_close8_avx512; /* adds to the survey, too */
ntp__count8_fn ntp__count_cells_avx512;
ntp__count_exact_fn ntp__count_exact_avx512;
ntp__count_close_fn ntp__count_close_avx512; /* all that are close, whatever is beside them */

#endif
