/* SPDX-License-Identifier: MIT */
/*
 * exponential.h - the exponential function and the logarithm, without libm
 *
 * Sums, products and quotients alone, so the bytes are the same everywhere.
 */
#ifndef NTP_EXPONENTIAL_H
#define NTP_EXPONENTIAL_H

#include <stdint.h>
#include <string.h>

/* ln 2 in two parts; the first has 32 bits, so its product with an exponent is exact. */
#define NTP__LN2_HIGH 0x1.62e42fefp-1
#define NTP__LN2_LOW  0x1.473de6af278edp-34

/* e^x to within 2^-50 of its value; x is held to -700..700, and NaN counts as -700.  The series
 * ends where |r|^14 / 14! < 2^-57, as |r| <= ln 2 / 2.  In this header, as loops call it. */
static inline double ntp__exp(double x)
{
    x = x > -700 ? x < 700 ? x : 700 : -700;
    double turns = x * 0x1.71547652b82fep+0;
    int32_t k = (int32_t) (turns + (turns < 0 ? -0.5 : 0.5));
    double r = x - k * NTP__LN2_HIGH - k * NTP__LN2_LOW, square = r * r;
    double odd = 1.0 / 6227020800, even = 1.0 / 479001600;
    odd = odd * square + 1.0 / 39916800, even = even * square + 1.0 / 3628800;
    odd = odd * square + 1.0 / 362880, even = even * square + 1.0 / 40320;
    odd = odd * square + 1.0 / 5040, even = even * square + 1.0 / 720;
    odd = odd * square + 1.0 / 120, even = even * square + 1.0 / 24;
    odd = odd * square + 1.0 / 6, even = even * square + 0.5;
    double v = 1 + (r + square * (even + odd * r));
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    bits += (uint64_t) (int64_t) k << 52;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The same in float, for loops that become vectors: to within 2^-21 of its value, x held to -87..87.
 * The series ends where |r|^7 / 7! < 2^-22. */
static inline float ntp__exp_float(float x)
{
    x = x > -87 ? x : -87;
    x = x < 87 ? x : 87;
    float turns = x * 0x1.715476p+0F;
    int32_t k = (int32_t) (turns + (turns < 0 ? -0.5F : 0.5F));
    float r = x - (float) k * 0x1.62ep-1F - (float) k * 0x1.0bfbe8p-15F;
    float v = 1.0F / 720 * r + 1.0F / 120;
    v = v * r + 1.0F / 24;
    v = v * r + 1.0F / 6;
    v = v * r + 0.5F;
    v = v * r * r + r + 1;
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    bits += (uint32_t) k << 23;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The natural logarithm of a normal x > 0, to within 2^-50 of its value or 2^-52. */
double ntp__log(double x);

#endif
