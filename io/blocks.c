/* SPDX-License-Identifier: MIT */
/*
 * blocks.c - BC1 to BC5: two ends, and texels that choose between values on the line
 */
#include "blocks.h"

#include <string.h>

static uint32_t word(const uint8_t *b)
{
    return (uint32_t) b[0] | (uint32_t) b[1] << 8;
}

/* ------------------------------------------------------------------------ colors */

/* round(255 (p a + q b) / ((p + q) top)): no ties, as the divisors are odd */
static uint8_t mix(uint32_t a, uint32_t b, uint32_t p, uint32_t q, uint32_t top)
{
    const uint32_t whole = (p + q) * top;
    return (uint8_t) ((2 * 255 * (p * a + q * b) + whole) / (2 * whole));
}

static void mix_color(uint8_t *rgba, uint32_t a, uint32_t b, uint32_t p, uint32_t q)
{
    rgba[0] = mix(a >> 11, b >> 11, p, q, 31);
    rgba[1] = mix(a >> 5 & 63, b >> 5 & 63, p, q, 63);
    rgba[2] = mix(a & 31, b & 31, p, q, 31);
    rgba[3] = 255;
}

/* The half of BC1 lies between two levels often enough: it is rounded up, as everywhere. */
static void colors(const uint8_t *block, uint8_t *rgba, bool may_have_three)
{
    const uint32_t a = word(block), b = word(block + 2);
    uint8_t palette[4][4];
    mix_color(palette[0], a, b, 1, 0);
    mix_color(palette[1], a, b, 0, 1);
    if (a > b || !may_have_three) {
        mix_color(palette[2], a, b, 2, 1);
        mix_color(palette[3], a, b, 1, 2);
    } else {
        mix_color(palette[2], a, b, 1, 1);
        memset(palette[3], 0, 4);
    }
    for (int i = 0; i < NTPIO__BLOCK_TEXELS; i++)
        memcpy(rgba + 4 * i, palette[block[4 + i / 4] >> 2 * (i % 4) & 3], 4);
}

void ntpio__bc1(const uint8_t *block, uint8_t *rgba)
{
    colors(block, rgba, true);
}

void ntpio__bc2(const uint8_t *block, uint8_t *rgba)
{
    colors(block + 8, rgba, false);
    for (int i = 0; i < NTPIO__BLOCK_TEXELS; i++)
        rgba[4 * i + 3] = (uint8_t) (17 * (block[i / 2] >> 4 * (i % 2) & 15));
}

/* ------------------------------------------------------------------------ one channel */

/* A value of the line from a to b: p of a and q of b, of p + q. */
typedef struct part {
    int32_t p, q;
} part;

/* What index i stands for, where a > b (eight values) and elsewhere (six, and the two ends of the
 * range, whose p + q is 0). */
static part part_of(int i, bool eight)
{
    const int32_t n = eight ? 7 : 5;
    return i < 2 ? (part) { 1 - i, i } : i <= n ? (part) { n + 1 - i, i - 1 } : (part) { 0, 0 };
}

static int index_of(const uint8_t *block, int i)
{
    const int bit = 3 * i, at = 2 + bit / 8;
    const uint32_t two = (uint32_t) block[at] | (at < 7 ? (uint32_t) block[at + 1] << 8 : 0);
    return (int) (two >> bit % 8 & 7);
}

/* round(257 (p a + q b) / (p + q)); the divisors are odd */
static uint16_t level_of(const uint8_t *ends, part w, bool last)
{
    const int32_t n = w.p + w.q;
    if (n == 0)
        return last ? 65535 : 0;
    return (uint16_t) ((2 * 257 * (w.p * ends[0] + w.q * ends[1]) + n) / (2 * n));
}

/* round((v + 1) / 2 65535), half up, of v = (p a + q b) / (127 (p + q)); -128 stands for -127. */
static uint16_t signed_level_of(const int8_t *ends, part w, bool last)
{
    const int64_t n = w.p + w.q;
    const int64_t a = ends[0] < -127 ? -127 : ends[0], b = ends[1] < -127 ? -127 : ends[1];
    if (n == 0)
        return last ? 65535 : 0;
    return (uint16_t) (((w.p * a + w.q * b + 127 * n) * 65535 + 127 * n) / (2 * 127 * n));
}

void ntpio__bc4(const uint8_t *block, bool is_signed, uint16_t *levels, int step)
{
    uint16_t palette[8];
    int8_t ends[2];
    memcpy(ends, block, 2);
    const bool eight = is_signed ? ends[0] > ends[1] : block[0] > block[1];
    for (int i = 0; i < 8; i++)
        palette[i] = is_signed ? signed_level_of(ends, part_of(i, eight), i == 7)
                               : level_of(block, part_of(i, eight), i == 7);
    for (int i = 0; i < NTPIO__BLOCK_TEXELS; i++)
        levels[i * step] = palette[index_of(block, i)];
}

void ntpio__bc3(const uint8_t *block, uint8_t *rgba)
{
    colors(block + 8, rgba, false);
    const bool eight = block[0] > block[1];
    uint8_t palette[8];
    for (int i = 0; i < 8; i++) {
        const part w = part_of(i, eight);
        const int32_t n = w.p + w.q;
        palette[i] = n == 0 ? (i == 7 ? 255 : 0)
                            : (uint8_t) ((2 * (w.p * block[0] + w.q * block[1]) + n) / (2 * n));
    }
    for (int i = 0; i < NTPIO__BLOCK_TEXELS; i++)
        rgba[4 * i + 3] = palette[index_of(block, i)];
}
