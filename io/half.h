/* SPDX-License-Identifier: MIT */
/*
 * half.h - floats of 16 bits
 */
#ifndef NTPIO_HALF_H
#define NTPIO_HALF_H

#include <stdint.h>

/* The bits of a half float to those of the single float of the same value. */
static inline uint32_t ntpio__from_half(uint32_t h)
{
    const uint32_t sign = (h & 0x8000) << 16, exponent = h >> 10 & 31;
    uint32_t fraction = h & 1023;
    if (exponent == 31)
        return sign | 0x7f800000 | fraction << 13;
    if (exponent != 0)
        return sign | (exponent + 112) << 23 | fraction << 13;
    if (fraction == 0)
        return sign;
    uint32_t power = 113;
    for (; (fraction & 1024) == 0; power--)
        fraction <<= 1;
    return sign | power << 23 | (fraction & 1023) << 13;
}

#endif
