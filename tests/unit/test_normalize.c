/* SPDX-License-Identifier: MIT */
/*
 * test_normalize.c - packed RGB of 8 bit over its lengths
 *
 * What the kernel does not leave is what the integers of level.h make of it.  What it leaves stays as it
 * is, and is seldom more than red and green of 0 or 255.  tests/test_exhaustive.py takes all texels.
 */
#include "guarded.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { RUNS = 2000, MOST = 256, SKIPPED = 77 };

static uint8_t random_byte(uint64_t *seed)
{
    return (uint8_t) random_bits(seed);
}

/* Random texels, those near to length 1 with both signs of z, and colors of 0 and 255 alone. */
static void fill(uint8_t *src, int32_t n, uint64_t *seed)
{
    for (int32_t i = 0; i < n; i++) {
        int32_t c[3] = { random_byte(seed), random_byte(seed), random_byte(seed) };
        if (i % 2) {
            const int32_t blue = ntp__derive(&c[0], &c[1], 255, false) - random_byte(seed) % 4;
            c[2] = i % 3 ? blue : 255 - blue;
        }
        for (int32_t k = 0; k < 3; k++)
            src[3 * i + k] = (uint8_t) (i % 41 == 7 ? -(random_byte(seed) & 1) : c[k]);
    }
}

/* Returns how many texels are left for no reason but doubt. */
static int32_t check_result(const uint8_t *dst, const uint8_t *src, int32_t n, const int32_t *at,
                            int32_t found, uint64_t changed)
{
    int32_t kept[MOST] = { 0 }, doubts = 0;
    for (int32_t i = 0; i < found; i++)
        kept[at[i]] = 1;
    for (int32_t i = 0; i < n; i++) {
        int32_t c[3] = { src[3 * i], src[3 * i + 1], src[3 * i + 2] };
        const bool corner = (c[0] == 0 || c[0] == 255) && (c[1] == 0 || c[1] == 255);
        CHECK(kept[i] || !corner);
        doubts += kept[i] && !corner;
        if (!kept[i])
            ntp__clean(c, 255, NTP_ENCODING_STANDARD, NTP_CLEAN_NORMALIZE, false);
        for (int32_t k = 0; k < 3; k++)
            CHECK(dst[3 * i + k] == c[k]);
        changed -= memcmp(&dst[3 * i], &src[3 * i], 3) != 0;
    }
    CHECK(changed == 0);
    return doubts;
}

int main(int argc, char **argv)
{
    (void) argc, (void) argv;
    const ntp__kernels_table *level = ntp__kernels(NTP__CPU_ALL);
    if (level->normalize_rgb8 == NULL)
        return SKIPPED;
    uint64_t seed = 4321;
    int32_t doubts = 0;
    for (int32_t run = 0; run < RUNS; run++) {
        const int32_t n = run % 7 ? MOST : NTP__KERNEL_STEP * (1 + run % 16);
        uint8_t src[3 * MOST], dst[3 * MOST + 1];
        int32_t at[MOST];
        uint64_t changed = 5, again = 5;
        fill(src, n, &seed);
        dst[3 * n] = 77;
        const int32_t found = level->normalize_rgb8(dst, src, n, at, &changed);
        doubts += check_result(dst, src, n, at, found, changed - 5);
        CHECK(dst[3 * n] == 77);
        CHECK(level->normalize_rgb8(src, src, n, at, &again) == found); /* in place */
        CHECK(memcmp(src, dst, (size_t) n * 3) == 0 && again == changed);
    }
    CHECK(doubts > 0 && doubts < RUNS * MOST / 500);
    return 0;
}
