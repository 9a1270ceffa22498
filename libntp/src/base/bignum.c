/* SPDX-License-Identifier: MIT */
/*
 * bignum.c - natural numbers of up to 2048 bits, on the stack
 *
 * Schoolbook arithmetic is fast enough: the numbers seldom have more than twenty limbs.
 */
#include "base/bignum.h"

#include <stdbool.h>
#include <string.h>

static void trim(ntp__wide *a)
{
    while (a->n > 0 && a->limb[a->n - 1] == 0)
        a->n--;
}

void ntp__wide_set(ntp__wide *a, uint64_t value)
{
    a->n = 2;
    a->limb[0] = (uint32_t) value;
    a->limb[1] = (uint32_t) (value >> 32);
    trim(a);
}

void ntp__wide_copy(ntp__wide *a, const ntp__wide *b)
{
    a->n = b->n;
    memcpy(a->limb, b->limb, (size_t) b->n * sizeof b->limb[0]);
}

int32_t ntp__wide_bits(const ntp__wide *a)
{
    if (a->n == 0)
        return 0;
    int32_t bits = 32 * (a->n - 1);
    for (uint32_t top = a->limb[a->n - 1]; top != 0; top >>= 1)
        bits++;
    return bits;
}

int32_t ntp__wide_compare(const ntp__wide *a, const ntp__wide *b)
{
    if (a->n != b->n)
        return a->n < b->n ? -1 : 1;
    for (int32_t i = a->n - 1; i >= 0; i--) {
        if (a->limb[i] != b->limb[i])
            return a->limb[i] < b->limb[i] ? -1 : 1;
    }
    return 0;
}

void ntp__wide_multiply(ntp__wide *out, const ntp__wide *a, const ntp__wide *b)
{
    out->n = a->n + b->n;
    memset(out->limb, 0, (size_t) out->n * sizeof out->limb[0]);
    for (int32_t i = 0; i < a->n; i++) {
        uint64_t carry = 0;
        for (int32_t k = 0; k < b->n; k++) {
            carry += (uint64_t) a->limb[i] * b->limb[k] + out->limb[i + k];
            out->limb[i + k] = (uint32_t) carry;
            carry >>= 32;
        }
        out->limb[i + b->n] = (uint32_t) carry;
    }
    trim(out);
}

void ntp__wide_shift(ntp__wide *out, const ntp__wide *a, int32_t bits)
{
    int32_t limbs = bits / 32, rest = bits % 32;
    if (a->n == 0) {
        out->n = 0;
        return;
    }
    out->n = a->n + limbs + 1;
    memset(out->limb, 0, (size_t) limbs * sizeof out->limb[0]);
    uint32_t carry = 0;
    for (int32_t i = 0; i < a->n; i++) {
        uint64_t v = (uint64_t) a->limb[i] << rest | carry;
        out->limb[limbs + i] = (uint32_t) v;
        carry = (uint32_t) (v >> 32);
    }
    out->limb[limbs + a->n] = carry;
    trim(out);
}

void ntp__wide_add(ntp__wide *a, const ntp__wide *b)
{
    uint64_t carry = 0;
    int32_t n = a->n > b->n ? a->n : b->n;
    for (int32_t i = 0; i < n; i++) {
        carry += (uint64_t) (i < a->n ? a->limb[i] : 0) + (i < b->n ? b->limb[i] : 0);
        a->limb[i] = (uint32_t) carry;
        carry >>= 32;
    }
    a->n = n;
    if (carry != 0) {
        a->limb[a->n++] = (uint32_t) carry;
    }
}

void ntp__wide_subtract(ntp__wide *a, const ntp__wide *b)
{
    uint32_t borrow = 0;
    for (int32_t i = 0; i < a->n; i++) {
        uint64_t take = (uint64_t) (i < b->n ? b->limb[i] : 0) + borrow;
        borrow = a->limb[i] < take;
        a->limb[i] = (uint32_t) (a->limb[i] - take);
    }
    trim(a);
}

double ntp__power_of_two(int32_t exponent)
{
    double value;
    uint64_t bits = (uint64_t) (exponent + 1023) << 52;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool bit(const ntp__wide *a, int32_t i)
{
    return i >= 0 && i / 32 < a->n && (a->limb[i / 32] >> (i % 32) & 1u) != 0;
}

/* Is a bit below bit i set? */
static bool any_below(const ntp__wide *a, int32_t i)
{
    if (i <= 0)
        return false;
    for (int32_t k = 0; k < i / 32 && k < a->n; k++) {
        if (a->limb[k] != 0)
            return true;
    }
    return i / 32 < a->n && (a->limb[i / 32] & ((1u << (i % 32)) - 1u)) != 0;
}

double ntp__wide_to_double(const ntp__wide *a, int32_t exponent)
{
    int32_t bits = ntp__wide_bits(a);
    if (bits == 0)
        return 0.0;
    /* The place of the last bit kept: 53 bits, fewer where the result is denormal. */
    int32_t drop = bits - 53;
    if (drop + exponent < -1074)
        drop = -1074 - exponent;
    uint64_t mantissa = 0;
    for (int32_t i = bits - 1; i >= (drop > 0 ? drop : 0); i--)
        mantissa = mantissa << 1 | bit(a, i);
    if (drop > 0 && bit(a, drop - 1) && ((mantissa & 1u) || any_below(a, drop - 1)))
        mantissa++;
    int32_t e = exponent + (drop > 0 ? drop : 0);
    /* mantissa 2^e is a double, so each step is exact unless it overflows. */
    double value = (double) mantissa;
    for (; e > 900; e -= 900)
        value *= 0x1p900;
    for (; e < -900; e += 900)
        value *= 0x1p-900;
    return value * ntp__power_of_two(e);
}

/*
 * Exponents that lie far apart are brought closer first, so that the shifted terms stay short.
 * Let the terms be sorted by exponent.  The upper two are multiples of the second's 2^e.  As long
 * as the lowest term is below that, it can only break their tie, and its exact size does not
 * matter.  So its exponent may rise until the term is just below.  In the same way the exponent of
 * the highest term may fall, as long as its 2^e exceeds the sum of the other two.
 */
int32_t ntp__wide_sign(const ntp__wide *x, int32_t ex, const ntp__wide *y, int32_t ey,
                       const ntp__wide *z, int32_t ez)
{
    const ntp__wide *term[3] = { x, y, z };
    int32_t e[3] = { ex, ey, ez }, order[3], count = 0;
    for (int32_t i = 0; i < 3; i++) {
        if (term[i]->n == 0)
            continue;
        int32_t k = count++;
        for (; k > 0 && e[order[k - 1]] > e[i]; k--)
            order[k] = order[k - 1];
        order[k] = i;
    }
    for (int32_t i = 1; i < count; i++) {
        /* No sum of the terms below has more bits: two terms add one bit. */
        int32_t bits = 0;
        for (int32_t k = 0; k < i; k++) {
            int32_t top = e[order[k]] + ntp__wide_bits(term[order[k]]) + 1;
            bits = k == 0 || top > bits ? top : bits;
        }
        int32_t excess = e[order[i]] - bits - 1;
        if (excess > 0) {
            for (int32_t k = i; k < count; k++)
                e[order[k]] -= excess;
        }
    }
    ntp__wide left, right, shifted;
    ntp__wide_set(&left, 0);
    ntp__wide_set(&right, 0);
    for (int32_t i = 0; i < count; i++) {
        ntp__wide_shift(&shifted, term[order[i]], e[order[i]] - e[order[0]]);
        ntp__wide_add(order[i] == 0 ? &left : &right, &shifted);
    }
    return ntp__wide_compare(&left, &right);
}
