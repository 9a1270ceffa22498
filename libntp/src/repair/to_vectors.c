/* SPDX-License-Identifier: MIT */
/*
 * to_vectors.c - conversion to float vectors, where convert_packed.c has no quicker way
 *
 * Levels become V/M and b/M, the nearest floats; floats become 2v - 1, and vectors stay as they are.  Blue of XY is
 * derived from levels, of 16 bit if the samples are floats.
 */
#include "base/inlining.h"
#include "repair/convert.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <math.h>
#include <string.h>

/* 2v - 1 rounded once, or v. */
static void component_of_floats(float *restrict to, const char *s, ptrdiff_t stride, int32_t n,
                                bool biased)
{
    for (int32_t i = 0; i < n; i++, s += stride)
        to[i] = *(const float *) (const void *) s;
    for (int32_t i = 0; biased && i < n; i++)
        to[i] = (float) (2.0 * (double) to[i] - 1.0);
}

/* z of XY, and x and y of pairs that are too long. */
static void derive_z(const ntp__conversion *j, ntp__float_planes to, const ntp__block *in,
                     bool suspect, int32_t n, ntp_convert_counts *counts)
{
    const int32_t m = j->ms;
    const double m2 = (double) m * m;
    double rest[NTP__BLOCK];
    float z[NTP__BLOCK];
    uint64_t any = 0; /* its first bit: one is negative */
    for (int32_t i = 0; i < n; i++) {
        const double x = ntp__num(in->c[0][i], m), y = ntp__num(in->c[1][i], m);
        rest[i] = m2 - x * x - y * y;
    }
    for (int32_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &rest[i], sizeof bits);
        any |= bits;
        z[i] = (float) (sqrt(rest[i]) / m); /* of less than 0 it is written below */
    }
    for (int32_t i = 0; (suspect || any >> 63 != 0) && i < n; i++) {
        if (suspect && ntp__texel_unused(in, i, m, j->how.touch_unused)) {
            z[i] = to[2][i];
        } else if (rest[i] < 0) {
            int32_t c[2] = { in->c[0][i], in->c[1][i] };
            ntp__pull(&c[0], &c[1], m);
            ntp__floats_of_levels(&to[0][i], &c[0], 1, m, true);
            ntp__floats_of_levels(&to[1][i], &c[1], 1, m, true);
            z[i] = (float) (sqrt((double) ntp__rest(c[0], c[1], m)) / m);
            counts->pulled++;
        }
    }
    for (int32_t i = 0; i < n; i++)
        to[2][i] = z[i];
}

/* Is a component not finite, or a vector 0?  Also of floats that are too large to be doubled. */
static bool may_be_broken(ntp__float_planes v, int32_t n)
{
    float any = 0;
    for (int32_t i = 0; i < n; i++) {
        const float size = fabsf(v[0][i]) + fabsf(v[1][i]) + fabsf(v[2][i]);
        any += size * 0 + (float) (size == 0);
    }
    return any != 0;
}

/* What is no vector is flat. */
SELDOM static uint64_t flatten_broken(ntp__float_planes to, const ntp__block *in, int32_t n)
{
    uint64_t found = 0;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t k = 0; in->broken[i] && k < 4; k++)
            to[k][i] = k < 2 ? 0 : 1;
        found += in->broken[i];
    }
    return found;
}

void ntp__convert_to_vectors(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                             ntp_convert_counts *counts)
{
    const ntp_encoding from = j->src->encoding;
    const bool floats = j->src->type == NTP_TYPE_F32, xy = from == NTP_ENCODING_XY;
    const int32_t channels = j->src->channels;
    const bool vector = from == NTP_ENCODING_VECTOR;
    ntp__block in;
    ntp__float_planes to;
    for (int32_t k = 0; floats && k < channels; k++)
        component_of_floats(to[k], (const char *) ntp__at(j->src, x, y) + k * sizeof(float),
                            j->src->pixel_stride, n,
                            k < (from == NTP_ENCODING_ZZERO ? 2 : 3) && !vector);
    in.any_broken = false;
    bool suspect = false;
    if (!floats || xy || (j->flip && !vector) || may_be_broken(to, n)) {
        ntp__unpack(&in, j->src, x, y, n);
        suspect = in.any_broken || (!vector && ntp__any_suspect(&in, n, j->ms));
    }
    for (int32_t k = floats ? channels : 0; k < j->dst->channels; k++) {
        if (k < 3 || channels == 4)
            ntp__floats_of_levels(to[k], in.c[k], n, j->ms,
                                  k < (from == NTP_ENCODING_ZZERO ? 2 : 3));
        for (int32_t i = 0; k == 3 && channels < 4 && i < n; i++)
            to[3][i] = 1;
    }
    if (xy)
        derive_z(j, to, &in, suspect, n, counts);
    for (int32_t i = 0; j->flip && i < n; i++) {
        if (!suspect || vector || !ntp__texel_unused(&in, i, j->ms, j->how.touch_unused))
            to[1][i] = -to[1][i];
    }
    if (in.any_broken)
        counts->not_finite += flatten_broken(to, &in, n);
    ntp__pack_floats(j->dst, to, x, y, n);
}
