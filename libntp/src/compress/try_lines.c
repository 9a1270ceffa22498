/* SPDX-License-Identifier: MIT */
/*
 * try_lines.c - the errors of lines of one length at sixteen places
 */
#include "compress/search.h"

#ifndef NTP_ISA
#  define NTP_ISA base
#endif
#define JOIN_(a, b) a##b
#define JOIN(a, b)  JOIN_(a, b)

static const float TO_INTEGER = 12582912; /* 1.5 2^23: adding it rounds */

enum { AT_ONCE = NTP__TEXELS / 2 }; /* texels between two looks at the sums */

ntp__try_lines_fn JOIN(ntp__try_lines_, NTP_ISA);

float JOIN(ntp__try_lines_, NTP_ISA)(float error[NTP__LANES], const ntp__lines *lines, float first,
                                     float apart)
{
    float from[NTP__LANES], sum[NTP__LANES], least = 0;
    const float step = lines->step, last = lines->last, per_step = 1 / step;
    for (int l = 0; l < NTP__LANES; l++) {
        from[l] = first + (float) l * apart;
        sum[l] = 0;
    }
    for (int32_t i = 0; i < lines->count; i++) {
        const float value = lines->value[i], weight = lines->weight[i], cap = lines->cap[i];
        for (int l = 0; l < NTP__LANES; l++) {
            const float at = value - from[l];
            float k = at * per_step;
            k = k > 0 ? k : 0;
            k = k < last ? k : last;
            k = (k + TO_INTEGER) - TO_INTEGER;
            const float off = at - k * step;
            const float square = off * off;
            sum[l] += weight * (square < cap ? square : cap);
        }
        if (i % AT_ONCE == AT_ONCE - 1 || i == lines->count - 1) {
            float half[NTP__LANES / 2];
            for (int l = 0; l < NTP__LANES / 2; l++)
                half[l] = sum[l] < sum[l + NTP__LANES / 2] ? sum[l] : sum[l + NTP__LANES / 2];
            least = half[0];
            for (int l = 1; l < NTP__LANES / 2; l++)
                least = half[l] < least ? half[l] : least;
            if (least >= lines->enough)
                return least;
        }
    }
    for (int l = 0; l < NTP__LANES; l++)
        error[l] = sum[l];
    return least;
}
