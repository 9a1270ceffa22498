/* SPDX-License-Identifier: MIT */
/*
 * sums_avx512_tmpl.h - sums and maxima over lanes, with AVX-512; in exact16_avx512.c, for all files
 */
#ifndef NTP_SUMS_AVX512_TMPL_H
#define NTP_SUMS_AVX512_TMPL_H

#include <immintrin.h>
#include <stdint.h>

uint64_t ntp__sum_of_wide_avx512(const __m512i *v); /* of eight lanes */
uint64_t ntp__sum_of_avx512(const __m512i *v);      /* of sixteen */
uint32_t ntp__greatest_of_avx512(const __m512i *v);

static inline uint64_t sum_of_wide(const __m512i *v)
{
    return ntp__sum_of_wide_avx512(v);
}

static inline uint64_t sum_of(const __m512i *v)
{
    return ntp__sum_of_avx512(v);
}

static inline uint32_t greatest_of(const __m512i *v)
{
    return ntp__greatest_of_avx512(v);
}

#endif
