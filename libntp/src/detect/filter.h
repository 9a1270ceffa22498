/* SPDX-License-Identifier: MIT */
/*
 * filter.h - weighted sums of rows and columns of floats
 */
#ifndef NTP_FILTER_H
#define NTP_FILTER_H

#include <stddef.h>
#include <stdint.h>

/* For i below n: out[i] is the sum of taps[k] in[k stride + i], or that is added to it (`onto`).  Taps of 0
 * are left out; nothing that is read may be out. */
void ntp__filter(float *out, const float *in, ptrdiff_t stride, const float *taps, int32_t count,
                 int32_t onto, int32_t n);

#ifdef NTP_HAVE_AVX2
enum { NTP__FILTER_LEAST = 8 };

/* n is no less than that. */
void ntp__filter_avx2(float *out, const float *in, ptrdiff_t stride, const float *taps,
                      int32_t count, int32_t onto, int32_t n);
#endif

#endif
