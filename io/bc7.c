/* SPDX-License-Identifier: MIT */
/*
 * bc7.c - BC7: eight modes of one to three subsets, with ends of 4 to 8 bits
 *
 * The tables are those of the format (Khronos Data Format, BPTC).
 */
#include <string.h>

#include "blocks.h"

typedef struct mode {
    uint8_t subsets, partition_bits, rotation_bits, selector_bits, color_bits, alpha_bits;
    uint8_t own_p;    /* a bit more for each end */
    uint8_t shared_p; /* a bit more for both ends of a subset */
    uint8_t index_bits, second_bits;
} mode;

static const mode MODES[8] = {
    { 3, 4, 0, 0, 4, 0, 1, 0, 3, 0 }, { 2, 6, 0, 0, 6, 0, 0, 1, 3, 0 },
    { 3, 6, 0, 0, 5, 0, 0, 0, 2, 0 }, { 2, 6, 0, 0, 7, 0, 1, 0, 2, 0 },
    { 1, 0, 2, 1, 5, 6, 0, 0, 2, 3 }, { 1, 0, 2, 0, 7, 8, 0, 0, 2, 2 },
    { 1, 0, 0, 0, 7, 7, 1, 0, 4, 0 }, { 2, 6, 0, 0, 5, 5, 1, 0, 2, 0 },
};

/* A bit a texel. */
static const uint16_t TWO[64] = {
    0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80,
    0xe800, 0xffe8, 0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310,
    0x3100, 0x8cce, 0x088c, 0x3110, 0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c, 0xaaaa,
    0xf0f0, 0x5a5a, 0x33cc, 0x3c3c, 0x55aa, 0x9696, 0xa55a, 0x73ce, 0x13c8, 0x324c, 0x3bdc,
    0x6996, 0xc33c, 0x9966, 0x0660, 0x0272, 0x04e4, 0x4e40, 0x2720, 0xc936, 0x936c, 0x39c6,
    0x639c, 0x9336, 0x9cc6, 0x817e, 0xe718, 0xccf0, 0x0fcc, 0x7744, 0xee22,
};

/* Two bits a texel. */
static const uint32_t THREE[64] = {
    0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050,
    0xaa550000, 0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494, 0xa4a4a4a4, 0xa9a59450, 0x2a0a4250,
    0xa5945040, 0x0a425054, 0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500,
    0x0050a4a4, 0xaaa59090, 0x14696914, 0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200,
    0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424, 0x00aa5500, 0x24924924, 0x24499224, 0x50a50a50,
    0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0, 0x69286928, 0x44aaaa44, 0x66666600,
    0xaa444444, 0x54a854a8, 0x95809580, 0x96969600, 0xa85454a8, 0x80959580, 0xaa141414, 0x96960000,
    0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44, 0x2a4a5254,
};

/* The texel of the second subset (of two; of three) and of the third whose index lacks its first
 * bit, a hexadecimal digit for each partition. */
static const char SECOND_OF_TWO[] =
    "fffffffffffffffff282288f28228822ff6828ff28222ff66268ff22fffff22f";
static const char SECOND_OF_THREE[] =
    "33ff83ff88666533338f336a588685ff8f356a8ff3f5ffff3f55585a5a8dfc33";
static const char THIRD_OF_THREE[] =
    "f883ff38fffffff8f8f3f8f83f6affa8f3faa89a6f8f3668f3ffffffffff3ff8";

static const uint8_t WEIGHTS_2[] = { 0, 21, 43, 64 };
static const uint8_t WEIGHTS_3[] = { 0, 9, 18, 27, 37, 46, 55, 64 };
static const uint8_t WEIGHTS_4[] = { 0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64 };

/* ------------------------------------------------------------------------ reading */

typedef struct bits {
    const uint8_t *block;
    uint32_t at;
} bits;

static uint32_t take(bits *b, uint32_t count)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < count; i++, b->at++)
        value |= (uint32_t) (b->block[b->at / 8] >> b->at % 8 & 1) << i;
    return value;
}

typedef struct shape {
    const mode *m;
    uint32_t partition;
    uint8_t ends[6][4]; /* RGBA, 8 bit: two of each subset */
} shape;

/* Repeats the upper bits below, so that the greatest value is 255. */
static uint8_t to_8_bits(uint32_t value, uint32_t count)
{
    value <<= 8 - count;
    return (uint8_t) (value | value >> count);
}

static void take_ends(shape *s, bits *b)
{
    const mode *m = s->m;
    const uint32_t count = 2u * m->subsets;
    uint32_t raw[6][4], p[6] = { 0 };
    for (uint32_t c = 0; c < 4; c++) {
        for (uint32_t i = 0; i < count; i++)
            raw[i][c] = take(b, c < 3 ? m->color_bits : m->alpha_bits);
    }
    for (uint32_t i = 0; i < count; i++)
        p[i] = m->own_p || (m->shared_p && i % 2 == 0) ? take(b, 1) : i > 0 ? p[i - 1] : 0;
    const uint32_t more = m->own_p | m->shared_p;
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t c = 0; c < 4; c++) {
            const uint32_t have = c < 3 ? m->color_bits : m->alpha_bits;
            s->ends[i][c] =
                have == 0 ? 255 : to_8_bits(raw[i][c] << more | (more & p[i]), have + more);
        }
    }
}

static uint32_t hex(char digit)
{
    return (uint32_t) (digit <= '9' ? digit - '0' : digit - 'a' + 10);
}

static uint32_t subset_of(const shape *s, uint32_t texel)
{
    return s->m->subsets == 1   ? 0
           : s->m->subsets == 2 ? TWO[s->partition] >> texel & 1u
                                : THREE[s->partition] >> 2 * texel & 3u;
}

/* The first bit of these indices is 0 and not stored. */
static bool is_anchor(const shape *s, uint32_t texel)
{
    const uint32_t p = s->partition;
    return texel == 0 || (s->m->subsets == 2 && texel == hex(SECOND_OF_TWO[p])) ||
           (s->m->subsets == 3 &&
            (texel == hex(SECOND_OF_THREE[p]) || texel == hex(THIRD_OF_THREE[p])));
}

static void take_weights(const shape *s, bits *b, uint32_t count, uint8_t *weights)
{
    const uint8_t *table = count == 2 ? WEIGHTS_2 : count == 3 ? WEIGHTS_3 : WEIGHTS_4;
    for (uint32_t i = 0; i < NTPIO__BLOCK_TEXELS; i++)
        weights[i] = table[take(b, is_anchor(s, i) ? count - 1 : count)];
}

static uint8_t between(uint32_t a, uint32_t b, uint32_t weight)
{
    return (uint8_t) (((64 - weight) * a + weight * b + 32) >> 6);
}

void ntpio__bc7(const uint8_t *block, uint8_t *rgba)
{
    bits b = { block, 0 };
    uint32_t number = 0;
    while (number < 8 && take(&b, 1) == 0)
        number++;
    if (number == 8) { /* reserved: the format says black and transparent */
        memset(rgba, 0, 4 * NTPIO__BLOCK_TEXELS);
        return;
    }
    shape s = { .m = &MODES[number] };
    const mode *m = s.m;
    s.partition = take(&b, m->partition_bits);
    const uint32_t rotation = take(&b, m->rotation_bits), selector = take(&b, m->selector_bits);
    take_ends(&s, &b);
    uint8_t color[NTPIO__BLOCK_TEXELS], alpha[NTPIO__BLOCK_TEXELS];
    take_weights(&s, &b, m->index_bits, color);
    memcpy(alpha, color, sizeof alpha);
    if (m->second_bits != 0)
        /* The selector gives the first indices to alpha, which has a copy of them already. */
        take_weights(&s, &b, m->second_bits, selector != 0 ? color : alpha);
    for (uint32_t i = 0; i < NTPIO__BLOCK_TEXELS; i++, rgba += 4) {
        const uint8_t *ends = s.ends[2 * subset_of(&s, i)];
        for (uint32_t c = 0; c < 4; c++)
            rgba[c] = between(ends[c], ends[4 + c], c < 3 ? color[i] : alpha[i]);
        if (rotation != 0) {
            const uint8_t swapped = rgba[3];
            rgba[3] = rgba[rotation - 1];
            rgba[rotation - 1] = swapped;
        }
    }
}
