/* SPDX-License-Identifier: MIT */
/*
 * convert_packed.c - packed samples as they are, or flipped, and as float vectors
 */
#include "base/cpu.h"
#include "repair/convert.h"
#include "texel/unused.h"

#ifdef NTP_HAVE_AVX2
#  include "base/rgb_avx2.h"
#  include "repair/convert_avx2.h"
#endif

#include <string.h>

enum { CHUNK = 48 /* samples: whole texels of 2, 3 and 4 channels */ };

#define SAMPLE        uint8_t
#define FOR_SAMPLE(f) f##_8
#include "repair/packed_tmpl.h"
#undef SAMPLE
#undef FOR_SAMPLE
#define SAMPLE        uint16_t
#define FOR_SAMPLE(f) f##_16
#include "repair/packed_tmpl.h"

/* To float vectors: V/M, b/M.  v = c*times - less is the numerator over 2^8 or 2^16, which is exact.
 * With 1/M as a float, v + v/M is the quotient of numerator and M, rounded once, for all numerators
 * that there are (shown by tests/test_convert.py).  Unused texels are not flipped.  To biased floats all
 * are c/M. */
void ntp__decode(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                 ntp_convert_counts *counts)
{
    const int32_t channels = j->src->channels;
    const float m = (float) j->ms, unit = j->ms > 255 ? 0x1p-16F : 0x1p-8F, over = 1 / m;
    float *d = ntp__at_mut(j->dst, x, y);
    const int32_t signs = j->dst->encoding != NTP_ENCODING_VECTOR  ? 0
                          : j->src->encoding == NTP_ENCODING_ZZERO ? 2
                                                                   : 3;
    float times[4], less[4];
    int32_t done = 0;
    for (int32_t k = 0; k < 4; k++) {
        const bool biased = k < signs;
        const float sign = k == 1 && j->flip ? -1 : 1;
        times[k] = sign * unit * (biased ? 2 : 1);
        less[k] = biased ? sign * unit * m : 0;
    }
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        done = ntp__decode_avx2(d, ntp__at(j->src, x, y), n, channels, j->ms > 255, times, less);
#endif
    ntp__block in;
    for (int32_t at = j->flip ? 0 : done, some; at < n; at += some) {
        some = n - at < NTP__BLOCK ? n - at : NTP__BLOCK;
        ntp__unpack(&in, j->src, x + at, y, some);
        float *to = d + (ptrdiff_t) channels * at;
        for (int32_t k = 0; k < channels; k++) {
            for (int32_t i = done > at ? done - at : 0; i < some; i++) {
                const float v = (float) in.c[k][i] * times[k] - less[k];
                to[channels * i + k] = v + v * over;
            }
        }
        const bool suspect = j->flip && ntp__any_suspect(&in, some, j->ms);
        for (int32_t i = 0; suspect && i < some; i++) {
            if (ntp__texel_unused(&in, i, j->ms, j->how.touch_unused))
                to[channels * i + 1] = -to[channels * i + 1];
        }
    }
    (void) counts;
}
