/* SPDX-License-Identifier: MIT */
/*
 * float_vector.c - float vectors to levels, correctly rounded
 *
 * A quotient in double decides unless it lies within 2^-30 of an integer k.  Else M*M x*x and
 * k*k (x*x + y*y + z*z) are compared as integers.  These have up to 590 bits: floats are multiples
 * of 2^-149 below 2^128, so their squares are multiples of 2^-298 below 2^256; the factors have at
 * most 34 bits, and a sum of three terms has two more.
 */
#include "texel/float_vector.h"

#include "base/bignum.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* sum += factor * v * v, in units of 2^-298. */
static void add_square(ntp__wide *sum, uint64_t factor, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    int32_t exponent = (int32_t) (bits >> 23 & 255);
    uint64_t mantissa = bits & 0x7fffff;
    /* Denormals have the exponent of the smallest normal floats, and no leading bit. */
    if (exponent > 0)
        mantissa |= 0x800000;
    else
        exponent = 1;
    ntp__wide square, times, product, shifted;
    ntp__wide_set(&square, mantissa * mantissa);
    ntp__wide_set(&times, factor);
    ntp__wide_multiply(&product, &square, &times);
    ntp__wide_shift(&shifted, &product, 2 * (exponent - 1));
    ntp__wide_add(sum, &shifted);
}

/* The sign of num |v[i]| - k L. */
static int32_t compare_quotient(uint64_t num, uint64_t k, const float v[3], int32_t i)
{
    ntp__wide left, right;
    ntp__wide_set(&left, 0);
    ntp__wide_set(&right, 0);
    add_square(&left, num * num, v[i]);
    for (int32_t j = 0; j < 3; j++)
        add_square(&right, k * k, v[j]);
    return ntp__wide_compare(&left, &right);
}

/* floor(num |v[i]| / L); *whole: the quotient is an integer. */
static int32_t quotient(bool *whole, int32_t num, const float v[3], int32_t i)
{
    float other1 = v[(i + 1) % 3], other2 = v[(i + 2) % 3];
    *whole = true;
    if (v[i] == 0.0f)
        return 0;
    if (other1 == 0.0f && other2 == 0.0f)
        return num;
    double x = v[0], y = v[1], z = v[2], own = v[i] < 0 ? -(double) v[i] : (double) v[i];
    double d = num * (own / sqrt(x * x + y * y + z * z));
    int32_t near = (int32_t) (d + 0.5);
    double away = d - near;
    *whole = false;
    if (away > 0x1p-30)
        return near;
    if (away < -0x1p-30)
        return near - 1;
    int32_t sign = compare_quotient((uint64_t) num, (uint64_t) near, v, i);
    *whole = sign == 0;
    return sign >= 0 ? near : near - 1;
}

void ntp__vector_levels(int32_t level[3], int32_t *unsigned_z, const float v[3], int32_t m)
{
    for (int32_t i = 0; i < 3; i++) {
        bool whole;
        int32_t q = quotient(&whole, m, v, i);
        /* M + 1 is even, so the floor of the sum is the sum with the floor. */
        int32_t down = v[i] < 0 ? (whole ? -q : -q - 1) : q;
        level[i] = (m + 1 + down) / 2;
    }
    bool whole;
    *unsigned_z = (quotient(&whole, 2 * m, v, 2) + 1) / 2;
}
