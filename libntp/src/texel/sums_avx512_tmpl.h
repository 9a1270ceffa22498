/* SPDX-License-Identifier: MIT */
/*
 * sums_avx512_tmpl.h - sums and maxima over lanes, with AVX-512
 */
#ifndef NTP_SUMS_AVX512_TMPL_H
#define NTP_SUMS_AVX512_TMPL_H

#include "texel/packed_avx512_tmpl.h"

#include <immintrin.h>
#include <stdint.h>

/* Of eight lanes. */
ONE_COPY static uint64_t sum_of_wide(const __m512i *v)
{
    return (uint64_t) _mm512_reduce_add_epi64(*v);
}

/* Of sixteen. */
ONE_COPY static uint32_t greatest_of(const __m512i *v)
{
    return _mm512_reduce_max_epu32(*v);
}

#endif
