/* SPDX-License-Identifier: MIT */
/*
 * odd_texel.h - which 16-bit texels a survey looks at again: flat, gray, or widened from 8 bits
 */
#ifndef ODD_TEXEL_H
#define ODD_TEXEL_H

#include <stdbool.h>
#include <stdint.h>

static inline bool is_gray(const int32_t c[3])
{
    return c[0] == c[1] && c[1] == c[2];
}

static inline bool is_odd_beside_gray(const int32_t c[3])
{
    const bool flat = c[0] >= 32767 && c[0] <= 32768 && c[1] >= 32767 && c[1] <= 32768;
    const bool narrow = c[0] % 257 == 0 && c[1] % 257 == 0 && c[2] % 257 == 0;
    return flat || narrow;
}

static inline bool is_odd(const int32_t c[3])
{
    return is_odd_beside_gray(c) || is_gray(c);
}

#endif
