/* SPDX-License-Identifier: MIT */
/*
 * to_vectors.c - conversion to float vectors, where convert_packed.c has no quicker way
 *
 * Levels become V/M and b/M, the nearest floats; floats become 2v - 1, and vectors stay as they are.  Blue of XY is
 * derived from levels, of 16 bit if the samples are floats.
 */
#include "base/inlining.h"
#include "repair/convert.h"
#include "texel/direction.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <math.h>

/* 2v - 1 rounded once, or v. */
static void component_of_floats(float *restrict to, const char *s, ptrdiff_t stride, int32_t n,
                                bool biased)
{
    for (int32_t i = 0; i < n; i++, s += stride)
        to[i] = *(const float *) (const void *) s;
    for (int32_t i = 0; biased && i < n; i++)
        to[i] = (float) (2.0 * (double) to[i] - 1.0);
}

/* The roots of what x and y leave of 1. */
static void roots_of(float *restrict z, const int32_t *restrict r, const int32_t *restrict g,
                     int32_t n, int32_t m)
{
    const double m2 = (double) m * m;
    double rest[NTP__BLOCK];
    for (int32_t i = 0; i < n; i++) {
        const double x = ntp__num(r[i], m), y = ntp__num(g[i], m);
        rest[i] = m2 - x * x - y * y;
    }
    for (int32_t i = 0; i < n; i++)
        z[i] = (float) (sqrt(rest[i]) / m);
}

/* z of XY, and x and y of pairs that are too long. */
static void derive_z(const ntp__conversion *j, ntp__float_planes to, ntp__block *in, bool suspect,
                     int32_t n, ntp_convert_counts *counts)
{
    const int32_t m = j->ms;
    int32_t marks[NTP__BLOCK], found = 0;
    uint8_t kept[NTP__BLOCK] = { 0 };
    float z[NTP__BLOCK];
    j->kernels->derive(marks, in->c[0], in->c[1], n, m, false);
    for (int32_t i = 0; suspect && i < n; i++) {
        kept[i] = ntp__texel_unused(in, i, m, j->how.touch_unused);
        marks[i] = kept[i] ? 0 : marks[i];
    }
    for (int32_t i = 0; i < n; i++)
        found += marks[i] < 0;
    if (found > 0)
        ntp__pull_pairs(in->c[0], in->c[1], marks, n, m);
    for (int32_t i = 0; found > 0 && i < n; i++) {
        for (int32_t k = 0; marks[i] < 0 && k < 2; k++)
            ntp__floats_of_levels(&to[k][i], &in->c[k][i], 1, m, true);
    }
    counts->pulled += (uint64_t) found;
    roots_of(z, in->c[0], in->c[1], n, m);
    for (int32_t i = 0; i < n; i++)
        to[2][i] = kept[i] ? to[2][i] : z[i];
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
