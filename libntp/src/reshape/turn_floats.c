/* SPDX-License-Identifier: MIT */
/*
 * turn_floats.c - float texels that are only moved and mirrored
 *
 * Only levels tell whether a texel is unused, and to make these takes longer than all else.  So a run is asked first
 * whether any of its texels may be unused.
 */
#include "reshape/turn_floats.h"

#include "base/inlining.h"
#include "texel/unused.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Level 0 is below the first of a unit range, or of a vector, and level M above the other. */
static const float LOW = 0.0001F, LOW_COMPONENT = -0.9999F, HIGH = 0.9999F;

static inline float lesser(float a, float b)
{
    return a < b ? a : b;
}

static inline float greater(float a, float b)
{
    return a > b ? a : b;
}

/* May any of n texels be unused, or no vector?  One of length 0 stays as it is in any case, but for signs of 0. */
static bool any_unused(const ntp_const_image *src, const char *s, int32_t n)
{
    const float low = src->encoding == NTP_ENCODING_VECTOR ? LOW_COMPONENT : LOW;
    const bool alpha = src->channels == 4;
    bool any = src->encoding == NTP_ENCODING_XY || src->channels < 3;
    for (int32_t i = 0; i < n && !any; i++, s += src->pixel_stride) {
        const float *c = (const float *) (const void *) s;
        const float least = lesser(lesser(c[0], c[1]), c[2]);
        const float most = greater(greater(c[0], c[1]), c[2]);
        /* of what is not finite the sum is not, either */
        any = !(fabsf(c[0] + c[1] + c[2]) <= FLT_MAX) || most < low || least > HIGH ||
              (least == 0 && most == 0) || (alpha && !(c[3] >= LOW));
    }
    return any;
}

static ALWAYS_INLINE void turn(char *d, ptrdiff_t d_step, const char *s, ptrdiff_t s_step,
                               int32_t n, const ntp__turning *how, int32_t channels, double one)
{
    const bool swap = how->swap, mirror_r = how->mirror_r, mirror_g = how->mirror_g;
    for (int32_t i = 0; i < n; i++, s += s_step, d += d_step) {
        const float *const c = (const float *) (const void *) s;
        float *const out = (float *) (void *) d;
        const float r = c[swap], g = c[!swap];
        const float other_r = (float) (one - (double) r), other_g = (float) (one - (double) g);
        for (int32_t k = 2; k < channels; k++)
            out[k] = c[k];
        out[0] = mirror_r ? other_r : r;
        out[1] = mirror_g ? other_g : g;
    }
}

/* One by one, as some are unused. */
SELDOM static void turn_used(const ntp_image *dst, const ntp_const_image *src,
                             const ntp__turning *how, int32_t x, int32_t y, int32_t n, double one)
{
    ntp__block block;
    const char *s = ntp__at(src, x, y);
    char *d = ntp__at_mut(dst, x, y);
    ntp__unpack(&block, src, x, y, n);
    for (int32_t i = 0; i < n; i++, s += src->pixel_stride, d += dst->pixel_stride) {
        if (ntp__texel_unused(&block, i, ntp__max(src->type), 0))
            memcpy(d, s, (size_t) src->channels * sizeof(float));
        else
            turn(d, 0, s, 0, 1, how, src->channels, one);
    }
}

void ntp__turn_floats(const ntp_image *dst, const ntp_const_image *src, const ntp__turning *how,
                      int32_t x, int32_t y, int32_t n)
{
    const double one = src->encoding == NTP_ENCODING_VECTOR ? 0.0 : 1.0;
    const char *s = ntp__at(src, x, y);
    char *d = ntp__at_mut(dst, x, y);
    if (any_unused(src, s, n))
        turn_used(dst, src, how, x, y, n, one);
    else if (src->channels == 3)
        turn(d, dst->pixel_stride, s, src->pixel_stride, n, how, 3, one);
    else
        turn(d, dst->pixel_stride, s, src->pixel_stride, n, how, 4, one);
}
