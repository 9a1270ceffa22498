/* SPDX-License-Identifier: MIT */
/*
 * srgb_levels.c - the exact inverse of sRGB, in integers
 *
 * Up to 0.04045 linear light is s / 12.92, above it is ((s + 0.055) / 1.055)^2.4.  With s = k / 2M,
 * it is at least q / 2M, where (100 k + 11 M)^12 * 32 >= q^5 * 211^12 * M^7 (both sides are raised
 * to the fifth power).  That takes fewer than 320 bits.  Halves of levels are enough for rounding
 * to the nearest level and for the levels that were rounded to one.
 */
#include "write/srgb_levels.h"

#include <stdbool.h>

#include "os/threads.h"

enum { LIMBS = 12 }; /* of 32 bits: 384 bits */

typedef struct big {
    uint32_t limb[LIMBS]; /* the lowest first */
} big;

static void times(big *b, uint32_t factor, int power)
{
    while (power-- > 0) {
        uint64_t carry = 0;
        for (int i = 0; i < LIMBS; i++) {
            carry += (uint64_t) b->limb[i] * factor;
            b->limb[i] = (uint32_t) carry;
            carry >>= 32;
        }
    }
}

static bool at_least(const big *a, const big *b)
{
    for (int i = LIMBS - 1; i >= 0; i--) {
        if (a->limb[i] != b->limb[i])
            return a->limb[i] > b->limb[i];
    }
    return true;
}

/* Is the linear light of k / 2 sRGB levels at least q / 2 levels? */
static bool reaches(uint32_t k, uint32_t q, uint32_t max)
{
    if ((uint64_t) 100000 * k <= (uint64_t) 8090 * max) /* 0.04045 * 2 M */
        return (uint64_t) 25 * k >= (uint64_t) 323 * q; /* 12.92 is 323 / 25 */
    big light = { { 32 } }, wanted = { { 1 } };
    times(&light, 100 * k + 11 * max, 12);
    times(&wanted, q, 5);
    times(&wanted, 211, 12);
    times(&wanted, max, 7);
    return at_least(&light, &wanted);
}

static uint16_t linear_8[256], linear_16[65536];
static uint8_t loss_8[256], loss_16[65536];
static const srgb_levels tables[2] = { { 255, linear_8, loss_8 }, { 65535, linear_16, loss_16 } };

static void fill(const srgb_levels *t, uint32_t max)
{
    uint32_t nearest = 0, first = 0, last = 0; /* the linear levels that become s: first..last */
    for (uint32_t s = 0; s <= max; s++) {
        while (nearest < max && reaches(2 * s, 2 * nearest + 1, max))
            nearest++;
        while (last < max && reaches(2 * s + 1, 2 * (last + 1), max))
            last++;
        const uint32_t below = nearest > first ? nearest - first : 0;
        const uint32_t above = last > nearest ? last - nearest : 0;
        t->linear[s] = (uint16_t) nearest;
        t->loss[s] = (uint8_t) (last < first ? 0 : below > above ? below : above);
        first = last + 1;
    }
}

static void fill_8(void)
{
    fill(&tables[0], 255);
}

static void fill_16(void)
{
    fill(&tables[1], 65535);
}

const srgb_levels *srgb_levels_of(uint32_t max)
{
    static os_once once[2] = { OS_ONCE, OS_ONCE };
    const bool deep = max != 255;
    os_call_once(&once[deep], deep ? fill_16 : fill_8);
    return &tables[deep];
}
