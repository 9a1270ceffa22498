/* SPDX-License-Identifier: MIT */
/*
 * test_normalize.c - packed RGB over its lengths
 *
 * What the kernels do not leave is what the integers of level.h make of it.  What they leave stays as it
 * is, and is seldom more than red and green of 0 or M.  For 8 bit tests/test_exhaustive.py takes all
 * texels.
 */
#include "guarded.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { RUNS = 2000, MOST = 256, SKIPPED = 77 };

/* A texel that is just a rounded one, or just none: with sizes 2p + 1 of its numerators and
 * K = (M + 1)/2, the sum of all (p + 1)^2 or of all p^2 is K(K - 1) + 1. */
static void fill_edge(int32_t *c, int32_t m, uint64_t *seed)
{
    const int32_t k = (m + 1) / 2, sum = k * (k - 1) + 1;
    const int32_t less = random_level(seed, 1), first = random_level(seed, 2);
    int32_t p[3] = { 0 };
    for (bool found = false; !found;) {
        p[0] = (int32_t) ntp__isqrt((uint64_t) sum) - random_level(seed, m > 255 ? 100 : 30);
        for (int32_t rest = sum - p[0] * p[0]; !found && p[1] * p[1] <= rest; p[1]++) {
            p[2] = (int32_t) ntp__isqrt((uint64_t) (rest - p[1] * p[1]));
            found = p[1] >= less && p[2] >= less && p[1] * p[1] + p[2] * p[2] == rest;
        }
        p[1] = found ? p[1] - 1 : 0;
    }
    for (int32_t i = 0; i < 3; i++) {
        const int32_t a = p[i] - less < k ? p[i] - less : k - 1;
        c[(first + i) % 3] = k + (random_level(seed, 1) ? a : -1 - a);
    }
}

/* Random texels, those near to length 1 with both signs of z, and colors of 0 and M alone. */
static void fill(int32_t *src, int32_t n, int32_t m, uint64_t *seed)
{
    for (int32_t i = 0; i < n; i++) {
        int32_t *c = src + 3 * i;
        for (int32_t k = 0; k < 3; k++)
            c[k] = random_level(seed, i % 41 == 7 ? 1 : m) * (i % 41 == 7 ? m : 1);
        if (i % 41 == 20) {
            fill_edge(c, m, seed);
        } else if (i % 41 != 7 && i % 2) {
            const int32_t blue = ntp__derive(&c[0], &c[1], m, false) - random_level(seed, 3);
            c[2] = i % 3 ? blue : m - blue;
        }
    }
}

static void to_bytes(void *bytes, const int32_t *level, int32_t samples, int32_t m)
{
    for (int32_t i = 0; i < samples; i++) {
        if (m > 255)
            ((uint16_t *) bytes)[i] = (uint16_t) level[i];
        else
            ((uint8_t *) bytes)[i] = (uint8_t) level[i];
    }
}

/* Returns how many texels are left for no reason but doubt. */
static int32_t check_result(const void *dst, const int32_t *src, int32_t n, int32_t m,
                            const int32_t *at, int32_t found, uint64_t changed)
{
    int32_t kept[MOST] = { 0 }, want[3 * MOST], doubts = 0;
    uint16_t bytes[3 * MOST];
    for (int32_t i = 0; i < found; i++)
        kept[at[i]] = 1;
    memcpy(want, src, sizeof want);
    for (int32_t i = 0; i < n; i++) {
        int32_t *c = want + 3 * i;
        const bool corner = (c[0] == 0 || c[0] == m) && (c[1] == 0 || c[1] == m);
        CHECK(kept[i] || !corner);
        doubts += kept[i] && !corner;
        if (!kept[i])
            ntp__clean(c, m, NTP_ENCODING_STANDARD, NTP_CLEAN_NORMALIZE, false);
        changed -= memcmp(c, src + 3 * i, 3 * sizeof *c) != 0;
    }
    CHECK(changed == 0);
    to_bytes(bytes, want, 3 * n, m);
    CHECK(memcmp(bytes, dst, (size_t) (3 * n * (m > 255 ? 2 : 1))) == 0);
    return doubts;
}

static void check_depth(ntp__normalize_rgb_fn *normalize, int32_t m)
{
    uint64_t seed = 4321;
    int32_t doubts = 0;
    for (int32_t run = 0; run < RUNS; run++) {
        const int32_t n = run % 7 ? MOST : NTP__KERNEL_STEP * (1 + run % 16);
        const size_t size = (size_t) 3 * (size_t) n * (m > 255 ? 2 : 1);
        uint16_t src[3 * MOST], dst[3 * MOST + 1];
        int32_t level[3 * MOST] = { 0 }, at[MOST];
        uint64_t changed = 5, again = 5;
        fill(level, n, m, &seed);
        to_bytes(src, level, 3 * n, m);
        ((uint8_t *) dst)[size] = 77;
        const int32_t found = normalize(dst, src, n, at, &changed);
        doubts += check_result(dst, level, n, m, at, found, changed - 5);
        CHECK(((uint8_t *) dst)[size] == 77);
        CHECK(normalize(src, src, n, at, &again) == found); /* in place */
        CHECK(memcmp(src, dst, size) == 0 && again == changed);
    }
    CHECK(doubts > 0 && doubts < RUNS * MOST / 500);
}

int main(int argc, char **argv)
{
    (void) argc, (void) argv;
    const ntp__kernels_table *level = ntp__kernels(NTP__CPU_ALL);
    if (level->normalize_rgb8 == NULL)
        return SKIPPED;
    check_depth(level->normalize_rgb8, 255);
    check_depth(level->normalize_rgb16, 65535);
    return 0;
}
