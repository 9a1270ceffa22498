/* SPDX-License-Identifier: MIT */
/*
 * relief.c - how steep a heightfield is, and the scale that makes its normals visible
 *
 * The squares of slopes at scale 1 are counted in bins of equal ratio: the exponent of the double
 * and the first bits of its mantissa.  Counts of parts add up, so the order of texels is free.
 */
#include "from_height/gradient.h"

#include <math.h>
#include <string.h>

enum {
    SIDE = 256,                 /* texels measured on each axis, where there are more */
    FRACTION_BITS = 6,          /* a bin is 2^(1/64) wide, half of that in slopes */
    LEAST_EXPONENT = 1023 - 48, /* 2^-48 as IEEE 754 stores it; the last bins end at 2^16 */
    STEEP_SHARE = 20,           /* one in so many is steeper than 45 degrees */
    MANTISSA_BITS = 52
};

/* Spreads the columns of neighboring rows, so that a regular pattern is not met at one place. */
static const int64_t SHIFT = 97;

int32_t ntp_relief_row(int32_t width, int32_t height, int32_t y, int32_t *first)
{
    const int32_t down = height > SIDE ? height / SIDE : 1, step = width > SIDE ? width / SIDE : 1;
    *first = 0;
    if (y % down != 0)
        return 0;
    *first = (int32_t) (y / down * SHIFT % step);
    return step;
}

static int32_t bin_of(double square)
{
    uint64_t bits;
    memcpy(&bits, &square, sizeof bits);
    const int64_t bin = (int64_t) (bits >> (MANTISSA_BITS - FRACTION_BITS)) -
                        ((int64_t) LEAST_EXPONENT << FRACTION_BITS);
    return bin < 0 ? 0 : bin >= NTP_RELIEF_BINS ? NTP_RELIEF_BINS - 1 : (int32_t) bin;
}

/* The least number above a bin. */
static double end_of(int32_t bin)
{
    const uint64_t bits = (uint64_t) (bin + 1 + (LEAST_EXPONENT << FRACTION_BITS))
                          << (MANTISSA_BITS - FRACTION_BITS);
    double square;
    memcpy(&square, &bits, sizeof square);
    return square;
}

ntp_status ntp_relief_add(ntp_relief *relief, const ntp_const_image *src,
                          const ntp_normals_options *how, int32_t x, int32_t y, int32_t step)
{
    float unused[3] = { 0 };
    ntp__gradient g;
    if (relief == NULL || src == NULL || how == NULL || x < 0 || y < 0 || step < 1 ||
        y >= src->height)
        return NTP_ERR_ARGUMENT;
    ntp_normals_options plain = *how;
    plain.scale = 1;
    const ntp_image dst = { .data = unused,
                            .width = src->width,
                            .height = src->height,
                            .pixel_stride = sizeof unused,
                            .channels = 3,
                            .type = NTP_TYPE_F32,
                            .encoding = NTP_ENCODING_VECTOR };
    NTP__TRY(ntp__gradient_plan(&g, &dst, src, &plain));
    for (; x < src->width; x += step) {
        double p[2];
        if (ntp__gradient_slopes(&g, x, y, p) && (p[0] != 0 || p[1] != 0))
            relief->texels[bin_of(p[0] * p[0] + p[1] * p[1])]++;
    }
    return NTP_OK;
}

static double rounded(double v)
{
    return (double) (int64_t) (v + 0.5);
}

/* A positive number, rounded to three digits: the double nearest to the decimal. */
static double short_number(double v)
{
    double up = 1, down = 1;
    while (v * up < 100)
        up *= 10;
    while (v / down >= 999.5)
        down *= 10;
    return rounded(v * up / down) * down / up;
}

double ntp_relief_scale(const ntp_relief *relief)
{
    uint64_t all = 0, steep = 0;
    int32_t bin = NTP_RELIEF_BINS - 1;
    if (relief == NULL)
        return 0;
    for (int32_t i = 0; i < NTP_RELIEF_BINS; i++)
        all += relief->texels[i];
    if (all == 0)
        return 0;
    for (; bin > 0; bin--) {
        steep += relief->texels[bin];
        if (steep * STEEP_SHARE > all)
            break;
    }
    return short_number(1 / sqrt(end_of(bin)));
}
