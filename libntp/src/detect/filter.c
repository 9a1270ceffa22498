/* SPDX-License-Identifier: MIT */
/*
 * filter.c - weighted sums of rows and columns of floats
 */
#include "detect/filter.h"

#include "base/cpu.h"

#include <string.h>

void ntp__filter(float *out, const float *in, ptrdiff_t stride, const float *taps, int32_t count,
                 int32_t onto, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (n >= NTP__FILTER_LEAST && ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__filter_avx2(out, in, stride, taps, count, onto, n);
        return;
    }
#endif
    if (!onto)
        memset(out, 0, (size_t) n * sizeof *out);
    for (int32_t k = 0; k < count; k++) {
        const float *row = in + k * stride, tap = taps[k];
        for (int32_t i = 0; i < n && tap != 0; i++)
            out[i] += tap * row[i];
    }
}
