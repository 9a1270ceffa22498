/* SPDX-License-Identifier: MIT */
/*
 * bignum.h - natural numbers of up to 2048 bits, on the stack
 *
 * These decide the rounding of the few texels and vectors for which a double is not precise
 * enough.  There is only what that needs: product, sum, difference, shift, comparison.  A number
 * is an array of 32-bit limbs, the lowest first, because plain C can multiply two of those.  Sums
 * and blends need no more than the 128 bits of int128.h.
 */
#ifndef NTP_BIGNUM_H
#define NTP_BIGNUM_H

#include <stdint.h>

enum { NTP__WIDE_LIMBS = 64 };

/* n limbs are in use; the highest of them is not 0; zero has none. */
typedef struct ntp__wide {
    int32_t n;
    uint32_t limb[NTP__WIDE_LIMBS];
} ntp__wide;

void ntp__wide_set(ntp__wide *a, uint64_t value);
void ntp__wide_copy(ntp__wide *a, const ntp__wide *b);

/* Number of bits: 0 for zero. */
int32_t ntp__wide_bits(const ntp__wide *a);

/* -1, 0, 1 for a < b, a == b, a > b. */
int32_t ntp__wide_compare(const ntp__wide *a, const ntp__wide *b);

/* The caller sees to it that the result fits.  out is another object than a and b. */
void ntp__wide_multiply(ntp__wide *out, const ntp__wide *a, const ntp__wide *b);
void ntp__wide_shift(ntp__wide *out, const ntp__wide *a, int32_t bits);
void ntp__wide_add(ntp__wide *a, const ntp__wide *b);
/* a - b, a >= b. */
void ntp__wide_subtract(ntp__wide *a, const ntp__wide *b);

/* 2^exponent, -1022 <= exponent <= 1023. */
double ntp__power_of_two(int32_t exponent);

/* a 2^exponent as a double, rounded once, ties to even; denormals and overflow as in IEEE 754. */
double ntp__wide_to_double(const ntp__wide *a, int32_t exponent);

/*
 * The sign of x 2^ex - y 2^ey - z 2^ez for any exponents.  x, y and z have at most 640 bits.
 */
int32_t ntp__wide_sign(const ntp__wide *x, int32_t ex, const ntp__wide *y, int32_t ey,
                       const ntp__wide *z, int32_t ez);

#endif
