/* SPDX-License-Identifier: MIT */
/*
 * slopes.c - rows of normals as slopes: -x/z to the right, y/z (Y up) down the picture
 *
 * Integer samples stay integer numerators.  Their common denominator cancels, so a slope is one
 * division.  Texels that hold no normal are flat.
 *
 * Where errors of x, y and z are alike, of size e, the stored z is off by e, and the one that is
 * derived by e r/z, with r^2 = x^2 + y^2.  So the most likely z is the mean of both with the weights
 * r^2 and z^2 = 1 - r^2: that is the mixed z.  On gentle ground it is free of errors of blue, and on
 * steep ground of those of red and green.
 */
#include "to_height/shared/slopes.h"

#include "texel/level.h"
#include "texel/unused.h"
#include "to_height/shared/solver_kernels.h"

#include <string.h>

void ntp__slopes_init(ntp__slopes *s, const ntp_const_image *src, const ntp__height_plan *plan)
{
    int32_t m = ntp__max(src->type);
    s->src = src;
    s->touch_unused = plan->touch_unused;
    if (src->encoding == NTP_ENCODING_VECTOR) /* of any length, so (2, 2, 2) is no padding */
        s->touch_unused |= NTP_UNUSED_BLACK | NTP_UNUSED_WHITE;
    s->derived = plan->z == NTP_Z_DERIVED || src->encoding == NTP_ENCODING_XY;
    s->mixed = plan->mix_z && !s->derived;
    s->decode = plan->decode;
    if (src->type == NTP_TYPE_F32 || s->decode == NTP_DECODE_AUTO)
        s->decode = NTP_DECODE_UNORM;
    s->zero = m + (s->decode == NTP_DECODE_SNORM) - (s->decode == NTP_DECODE_TRUNC);
    s->range = s->decode == NTP_DECODE_SNORM ? m - 1 : m;
    s->z_scale = s->range / m;
    s->neutral = s->decode == NTP_DECODE_NEUTRAL ? plan->neutral : 0;
    s->least = s->derived || plan->least_z * s->range < 1 ? 1 : plan->least_z * s->range;
}

static int32_t numerator(int32_t c, int32_t zero, int32_t neutral)
{
    int32_t v = 2 * c - zero;
    return v >= -neutral && v <= neutral ? 0 : v;
}

/* The mean of the stored z and the derived one, where x^2 + y^2 is `xy` of `square`. */
static double mix(double stored, double xy, double square, double least_rest)
{
    double rest = square - xy, made = sqrt(rest > least_rest ? rest : least_rest);
    return made + (xy < square ? xy / square : 1) * (stored - made);
}

/* z of n texels, times range, as stored or derived from x and y, or both. */
static void z_of_levels(const ntp__slopes *s, const ntp__block *b, double *z, int32_t n)
{
    double square = s->range * s->range, scale = s->z_scale;
    int32_t zero = s->zero, neutral = s->neutral;
    if (s->derived) {
        for (int32_t i = 0; i < n; i++) {
            double x = numerator(b->c[0][i], zero, neutral);
            double y = numerator(b->c[1][i], zero, neutral);
            double rest = square - x * x - y * y;
            z[i] = sqrt(rest > 1 ? rest : 1);
        }
    } else if (s->src->encoding == NTP_ENCODING_ZZERO) {
        for (int32_t i = 0; i < n; i++)
            z[i] = b->c[2][i] * scale;
    } else {
        for (int32_t i = 0; i < n; i++)
            z[i] = 2 * b->c[2][i] - zero;
    }
    for (int32_t i = 0; i < n && s->mixed; i++) {
        double x = numerator(b->c[0][i], zero, neutral), y = numerator(b->c[1][i], zero, neutral);
        z[i] = mix(z[i], x * x + y * y, square, 1);
    }
}

static void of_levels(const ntp__slopes *s, const ntp__block *b, double *right, double *down,
                      int32_t n)
{
    double z[NTP__BLOCK], sign = s->src->y == NTP_Y_UP ? 1 : -1, least = s->least;
    int32_t zero = s->zero, neutral = s->neutral;
    z_of_levels(s, b, z, n);
    for (int32_t i = 0; i < n; i++)
        z[i] = z[i] > least ? z[i] : least;
    for (int32_t i = 0; i < n; i++) {
        double x = numerator(b->c[0][i], zero, neutral), y = numerator(b->c[1][i], zero, neutral);
        right[i] = -x / z[i];
        down[i] = sign * y / z[i];
    }
}

static void of_floats(const ntp__slopes *s, double *right, double *down, int32_t x, int32_t y,
                      int32_t n)
{
    bool vector = s->src->encoding == NTP_ENCODING_VECTOR,
         zzero = s->src->encoding == NTP_ENCODING_ZZERO;
    double sign = s->src->y == NTP_Y_UP ? 1 : -1, least = s->least / s->range;
    for (int32_t i = 0; i < n; i++) {
        const float *c = ntp__at(s->src, x + i, y);
        double nx = vector ? (double) c[0] : 2 * (double) c[0] - 1;
        double ny = vector ? (double) c[1] : 2 * (double) c[1] - 1, nz;
        if (s->derived) {
            double rest = 1 - nx * nx - ny * ny;
            nz = rest > 0 ? sqrt(rest) : 0;
        } else {
            nz = vector || zzero ? (double) c[2] : 2 * (double) c[2] - 1;
            nz = s->mixed ? mix(nz, nx * nx + ny * ny, 1, 0) : nz;
        }
        nz = nz > least ? nz : least;
        right[i] = -nx / nz;
        down[i] = sign * ny / nz;
    }
}

/* Marks the texels that hold no normal, as they become flat; false: there is none. */
static bool find_unused(bool flat[NTP__BLOCK], const ntp__slopes *s, const ntp__block *b, int32_t n,
                        ntp__slope_counts *counts)
{
    int32_t m = ntp__max(s->src->type);
    if (!ntp__any_suspect(b, n, m))
        return false;
    for (int32_t i = 0; i < n; i++) {
        bool broken = b->any_broken && b->broken[i];
        bool unused =
            ntp__unused(b->c[0][i], b->c[1][i], b->c[2][i], b->c[3][i], m, s->touch_unused);
        flat[i] = broken || unused;
        if (counts != NULL && flat[i]) {
            counts->not_finite += broken;
            counts->unused += !broken;
        }
    }
    return true;
}

void ntp__slopes_row(const ntp__slopes *s, double *right, double *down, int32_t y,
                     ntp__slope_counts *counts)
{
    ntp__block block;
    bool flat[NTP__BLOCK];
    for (int32_t x = 0; x < s->src->width; x += NTP__BLOCK) {
        int32_t n = s->src->width - x < NTP__BLOCK ? s->src->width - x : NTP__BLOCK;
        ntp__unpack(&block, s->src, x, y, n);
        if (s->src->type == NTP_TYPE_F32)
            of_floats(s, right + x, down + x, x, y, n);
        else
            of_levels(s, &block, right + x, down + x, n);
        bool any = find_unused(flat, s, &block, n, counts);
        for (int32_t i = 0; any && i < n; i++) {
            if (flat[i])
                right[x + i] = down[x + i] = 0;
        }
    }
}

/* ------------------------------------------------------------------ in float arithmetic */

enum { RGB = 3 };

/* As packed pixels, so that the kernel rounds every layout alike. */
static const uint8_t *packed_at(uint8_t *copy, const ntp_const_image *src, int32_t x, int32_t y,
                                int32_t n)
{
    const uint8_t *from = ntp__at(src, x, y);
    const size_t channels = (size_t) src->channels;
    if (src->pixel_stride == (ptrdiff_t) channels)
        return from;
    for (int32_t i = 0; i < n; i++, from += src->pixel_stride) {
        memcpy(copy + channels * (size_t) i, from, RGB);
        if (channels > RGB)
            copy[channels * (size_t) i + RGB] = from[RGB];
    }
    return copy;
}

/* Other types than 8-bit colors go by way of doubles. */
static void single_block(const ntp__slopes *s, const ntp__block *block, float *right, float *down,
                         int32_t x, int32_t y, int32_t n)
{
    double p[NTP__BLOCK], q[NTP__BLOCK];
    if (s->src->type == NTP_TYPE_F32)
        of_floats(s, p, q, x, y, n);
    else
        of_levels(s, block, p, q, n);
    for (int32_t i = 0; i < n; i++) {
        right[i] = (float) p[i];
        down[i] = (float) q[i];
    }
}

void ntp__slopes_row_single(const ntp__slopes *s, float *right, float *down, int32_t y,
                            ntp__slope_counts *counts)
{
    const ntp_const_image *src = s->src;
    const ntp__solver_kernels *kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    bool zzero = src->encoding == NTP_ENCODING_ZZERO;
    const ntp__slope_levels how = { .zero = s->zero,
                                    .neutral = s->neutral,
                                    .z_scale = zzero ? (float) s->z_scale : 2,
                                    .z_zero = zzero ? 0 : (float) s->zero,
                                    .square = (float) (s->range * s->range),
                                    .sign = src->y == NTP_Y_UP ? 1 : -1,
                                    .least = (float) s->least,
                                    .derived = s->derived,
                                    .mixed = s->mixed };
    ntp__block block;
    bool flat[NTP__BLOCK];
    uint8_t pixels[(RGB + 1) * NTP__BLOCK];
    const bool colors = src->type == NTP_TYPE_U8 && src->channels >= RGB;
    for (int32_t x = 0; x < src->width; x += NTP__BLOCK) {
        int32_t n = src->width - x < NTP__BLOCK ? src->width - x : NTP__BLOCK;
        if (colors && kernels->slopes8(right + x, down + x, packed_at(pixels, src, x, y, n),
                                       src->channels, n, &how) == 0)
            continue;
        ntp__unpack(&block, src, x, y, n);
        if (!colors)
            single_block(s, &block, right + x, down + x, x, y, n);
        bool any = find_unused(flat, s, &block, n, counts);
        for (int32_t i = 0; any && i < n; i++) {
            if (flat[i])
                right[x + i] = down[x + i] = 0;
        }
    }
}
