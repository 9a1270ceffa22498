/* SPDX-License-Identifier: MIT */
/*
 * int128.h - signed integers of 128 bits, in plain C
 *
 * Two's complement in two words.  Sums and products are taken mod 2^128, so they are right
 * whenever the result fits.  Resizing sums weighted levels in them.  Blending needs them for
 * numerators of up to 120 bits.
 */
#ifndef NTP_INT128_H
#define NTP_INT128_H

#include <stdbool.h>
#include <stdint.h>

typedef struct ntp__i128 {
    uint64_t lo, hi;
} ntp__i128;

static inline ntp__i128 ntp__i128_of(int64_t v)
{
    ntp__i128 r = { (uint64_t) v, v < 0 ? UINT64_MAX : 0 };
    return r;
}

static inline bool ntp__i128_negative(ntp__i128 a)
{
    return a.hi >> 63 != 0;
}

static inline bool ntp__i128_is_zero(ntp__i128 a)
{
    return (a.lo | a.hi) == 0;
}

static inline ntp__i128 ntp__i128_add(ntp__i128 a, ntp__i128 b)
{
    ntp__i128 r = { a.lo + b.lo, a.hi + b.hi };
    r.hi += r.lo < a.lo;
    return r;
}

static inline ntp__i128 ntp__i128_negate(ntp__i128 a)
{
    ntp__i128 r = { ~a.lo + 1, ~a.hi };
    r.hi += r.lo == 0;
    return r;
}

static inline ntp__i128 ntp__i128_subtract(ntp__i128 a, ntp__i128 b)
{
    return ntp__i128_add(a, ntp__i128_negate(b));
}

/* The upper half of a 64 x 64 bit product. */
static inline uint64_t ntp__mul_high(uint64_t a, uint64_t b)
{
    uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
    uint64_t middle = a1 * b0 + (a0 * b0 >> 32);
    uint64_t other = a0 * b1 + (middle & 0xffffffffu);
    return a1 * b1 + (middle >> 32) + (other >> 32);
}

static inline ntp__i128 ntp__i128_multiply(ntp__i128 a, int64_t factor)
{
    ntp__i128 b = ntp__i128_of(factor), r;
    r.lo = a.lo * b.lo;
    r.hi = ntp__mul_high(a.lo, b.lo) + a.hi * b.lo + a.lo * b.hi;
    return r;
}

/* a * 2^bits, 0 <= bits <= 63. */
static inline ntp__i128 ntp__i128_shift(ntp__i128 a, int32_t bits)
{
    ntp__i128 r = { a.lo << bits, a.hi << bits };
    r.hi |= bits > 0 ? a.lo >> (64 - bits) : 0;
    return r;
}

/* The relative error is at most 2^-52. */
static inline double ntp__i128_to_double(ntp__i128 a)
{
    bool negative = ntp__i128_negative(a);
    if (negative)
        a = ntp__i128_negate(a);
    double d = (double) a.hi * 0x1p64 + (double) a.lo;
    return negative ? -d : d;
}

#endif
