/* SPDX-License-Identifier: MIT */
/*
 * test_normalize.c - packed RGB over its lengths, and of 16 bit with a derived blue
 *
 * What the kernels do not leave is what the integers of level.h make of it.  What they leave stays as it
 * is, and is rare.  For 8 bit tests/test_exhaustive.py takes all
 * texels.
 */
#include "guarded.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { RUNS = 2000, MOST = 256, CLOSE = 64, SKIPPED = 77 };

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

/* Two odd numbers whose squares have this sum, as sizes p of 2p + 1; false if there are none. */
static bool two_squares(uint64_t sum, int32_t p[2])
{
    for (uint64_t a = 1; a * a <= sum / 2; a += 2) {
        const uint64_t b = ntp__isqrt(sum - a * a);
        if (a * a + b * b == sum && b < 65536) {
            p[0] = (int32_t) (a / 2);
            p[1] = (int32_t) (b / 2);
            return true;
        }
    }
    return false;
}

/*
 * A texel of 16 bit whose quotient lies above a boundary between two levels by so little that doubles
 * may find it below.  a/sqrt(S) is a boundary where it is q/M, q even: S is the whole part of
 * (aM)^2/q^2, of which less than a 2^14th is left.  That is 2^-32 of a level at most.
 */
static void fill_close(int32_t *c, uint64_t *seed)
{
    const uint64_t m = 65535;
    const int32_t first = random_level(seed, 2);
    for (;;) {
        const uint64_t a = 2 * (uint64_t) random_level(seed, 32767) + 1;
        const uint64_t q = 2 * (uint64_t) random_level(seed, 32766) + 2;
        const uint64_t am = a * m, sum = am * am / (q * q), left = am * am % (q * q);
        int32_t p[3] = { (int32_t) (a / 2), 0, 0 };
        if (left << 14 >= q * q || sum <= a * a || sum > 3 * m * m || sum % 8 != 3 ||
            !two_squares(sum - a * a, p + 1))
            continue;
        for (int32_t i = 0; i < 3; i++)
            c[(first + i) % 3] = random_level(seed, 1) ? 32768 + p[i] : 32767 - p[i];
        return;
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

/* Those next to a boundary are decided by the integers. */
static void check_close(ntp__normalize_rgb_fn *normalize)
{
    uint64_t seed = 99, changed = 0;
    int32_t level[3 * CLOSE] = { 0 }, at[CLOSE], kept[CLOSE] = { 0 };
    uint16_t src[3 * CLOSE], dst[3 * CLOSE];
    for (int32_t i = 0; i < CLOSE; i++)
        fill_close(level + 3 * i, &seed);
    to_bytes(src, level, 3 * CLOSE, 65535);
    const int32_t found = normalize(dst, src, CLOSE, 0, at, &changed);
    for (int32_t i = 0; i < found; i++)
        kept[at[i]] = 1;
    for (int32_t i = 0; i < 3 * CLOSE; i += 3) {
        if (!kept[i / 3])
            ntp__clean(level + i, 65535, NTP_ENCODING_STANDARD, NTP_CLEAN_NORMALIZE, false);
        CHECK(dst[i] == level[i] && dst[i + 1] == level[i + 1] && dst[i + 2] == level[i + 2]);
    }
}

/* Returns how many texels are left, as they are in doubt. */
static int32_t check_result(const void *dst, const int32_t *src, int32_t n, int32_t m,
                            const int32_t *at, int32_t found, uint64_t changed, uint32_t touch)
{
    int32_t kept[MOST] = { 0 }, want[3 * MOST], doubts = 0;
    uint16_t bytes[3 * MOST];
    for (int32_t i = 0; i < found; i++)
        kept[at[i]] = 1;
    memcpy(want, src, sizeof want);
    for (int32_t i = 0; i < n; i++) {
        int32_t *c = want + 3 * i;
        const bool unused = ntp__unused(c[0], c[1], c[2], m, m, touch);
        CHECK(!kept[i] || !unused);
        doubts += kept[i] && !((c[0] == 0 || c[0] == m) && (c[1] == 0 || c[1] == m));
        if (!kept[i] && !unused)
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
        guarded from = guarded_alloc(size, run & 1), to = guarded_alloc(size, run & 2);
        void *const src = from.data, *const dst = to.data;
        int32_t level[3 * MOST] = { 0 }, at[MOST];
        uint64_t changed = 5, again = 5;
        fill(level, n, m, &seed);
        to_bytes(src, level, 3 * n, m);
        const uint32_t touch = (uint32_t) run % (NTP_UNUSED_ALL + 1);
        const int32_t found = normalize(dst, src, n, touch, at, &changed);
        doubts += check_result(dst, level, n, m, at, found, changed - 5, touch);
        CHECK(normalize(src, src, n, touch, at, &again) == found); /* in place */
        CHECK(memcmp(src, dst, size) == 0 && again == changed);
        guarded_free(&from);
        guarded_free(&to);
    }
    CHECK(doubts > 0 && doubts < RUNS * MOST / 500);
}

/* What a texel of 16 bit becomes. */
static void derive_level(int32_t *c, bool zzero, uint32_t touch)
{
    if (!ntp__unused(c[0], c[1], c[2], 65535, 65535, touch))
        ntp__clean(c, 65535, zzero ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD, NTP_CLEAN_DERIVE,
                   false);
}

/* The kernel leaves few of the pairs that are too long, in their order, and no others. */
static void check_derived(ntp__derive16_fn *derive, bool zzero)
{
    uint64_t seed = 99;
    int32_t doubts = 0;
    for (int32_t run = 0; run < RUNS; run++) {
        const int32_t n = run % 7 ? MOST : NTP__KERNEL_STEP * (1 + run % 16);
        const size_t size = (size_t) 3 * (size_t) n * sizeof(uint16_t);
        const uint32_t touch = (uint32_t) run % (NTP_UNUSED_ALL + 1);
        guarded from = guarded_alloc(size, run & 1), to = guarded_alloc(size, run & 2);
        uint16_t *const src = from.data, *const dst = to.data;
        uint16_t want[3 * MOST];
        int32_t level[3 * MOST] = { 0 }, at[MOST], found = 0;
        uint64_t changed = 5, again = 5, others = 5;
        fill(level, n, 65535, &seed);
        to_bytes(src, level, 3 * n, 65535);
        const int32_t left = derive(dst, src, n, zzero, touch, at, &changed);
        for (int32_t i = 0; i < n; i++) {
            int32_t *c = level + 3 * i;
            if (found < left && at[found] == i) {
                CHECK(ntp__rest(c[0], c[1], 65535) < 0);
                CHECK(!ntp__unused(c[0], c[1], c[2], 65535, 65535, touch));
                found++;
                continue;
            }
            const int32_t was[3] = { c[0], c[1], c[2] };
            derive_level(c, zzero, touch);
            others += memcmp(was, c, sizeof was) != 0;
        }
        to_bytes(want, level, 3 * n, 65535);
        CHECK(found == left && others == changed);
        CHECK(memcmp(want, dst, size) == 0);
        CHECK(derive(src, src, n, zzero, touch, at, &again) == left); /* in place */
        CHECK(memcmp(src, dst, size) == 0 && again == changed);
        doubts += left;
        guarded_free(&from);
        guarded_free(&to);
    }
    CHECK(doubts < RUNS * MOST / 50);
}

int main(int argc, char **argv)
{
    const bool wide = argc > 1 && strcmp(argv[1], "avx512") == 0;
    ntp__kernels_table level;
    ntp__pick_kernels(&level, wide ? NTP__CPU_ALL : NTP__CPU_AVX2);
    if (level.normalize_rgb8 == NULL || (wide && !ntp__cpu_has_avx512(NTP__CPU_ALL)))
        return SKIPPED;
    check_depth(level.normalize_rgb8, 255);
    check_depth(level.normalize_rgb16, 65535);
    check_close(level.normalize_rgb16);
    check_derived(level.derive_rgb16, false);
    check_derived(level.derive_rgb16, true);
    return 0;
}
