/* SPDX-License-Identifier: MIT */
/*
 * test_compare.c - two textures are compared alike with and without AVX2 and AVX-512
 *
 * All widths up to two blocks and some, and about as many as one call of a kernel takes, between guard
 * pages, of 8 and 16 bit: what ntp_diff_add keeps
 * is the same to the byte, and levels are those of a plain loop.  without_avx2.h leaves out the
 * instructions.
 */
#include "guarded.h"
#include "without_avx2.h"
#include "without_avx512.h"
#include "libntp.h"

#include <string.h>

enum { WIDEST = 540, SETS = 3 /* of instructions */, SKIPPED = 77 };

static int32_t level_at(const void *data, int32_t i, ntp_type type)
{
    return type == NTP_TYPE_U8 ? ((const uint8_t *) data)[i] : ((const uint16_t *) data)[i];
}

static void put(void *data, int32_t i, ntp_type type, int32_t level)
{
    if (type == NTP_TYPE_U8)
        ((uint8_t *) data)[i] = (uint8_t) level;
    else
        ((uint16_t *) data)[i] = (uint16_t) level;
}

/* The pairs: random ones; levels that are close; runs of equal texels; corners of the cube against the
 * opposite ones, as black against white; vectors that are nearly opposite; right angles, nearly; grays,
 * whose vectors are parallel or opposite; a few that are random among equal or close ones; runs of the same
 * pair, whose angles fall into one bin; black, white and gray against each other. */
enum { RANDOM, CLOSE, RUNS, CORNERS, OPPOSITE, ACROSS, GRAYS, FEW, STEADY, DOTS, KINDS };

static void change_other(int32_t other[3], int32_t level[3], int kind, int32_t m)
{
    for (int k = 0; k < 3 && kind == OPPOSITE; k++)
        other[k] = m - other[k];
    if (kind == ACROSS) {
        other[0] = level[1];
        other[1] = m - level[0];
        other[2] = m / 2;
    }
    if (kind == DOTS) {
        const int32_t grays[] = { 0, m / 2, m };
        other[0] = grays[other[0] % 3];
        level[0] = grays[level[0] % 3];
    }
    for (int k = 1; k < 3 && (kind == GRAYS || kind == DOTS); k++) {
        other[k] = other[0];
        level[k] = level[0];
    }
}

static void make_pair(void *a, void *b, int32_t n, ntp_type type, int kind, uint64_t *seed)
{
    const int32_t m = type == NTP_TYPE_U8 ? 255 : 65535;
    bool run = false;
    for (int32_t i = 0; i < n; i++) {
        run = i % 24 == 0 ? (random_bits(seed) & 1) != 0 : run;
        const bool corner = kind == CORNERS && random_bits(seed) % 64 == 0;
        const bool any = kind == RANDOM || kind == GRAYS || kind >= STEADY ||
                         (kind == FEW && random_bits(seed) % 8 == 0);
        const uint64_t which = random_bits(seed);
        int32_t level[3], other[3];
        for (int k = 0; k < 3; k++) {
            level[k] = random_level(seed, m);
            other[k] = random_level(seed, m);
            if (!any)
                other[k] = level[k] + (int32_t) (random_bits(seed) % 9) - 4;
            if (!any && run && (kind == RUNS || kind == FEW))
                other[k] = level[k];
        }
        change_other(other, level, kind, m);
        for (int k = 0; k < 3 && kind == STEADY && i % 40 > 0; k++) {
            level[k] = level_at(a, 3 * (i - 1) + k, type);
            other[k] = level_at(b, 3 * (i - 1) + k, type);
        }
        for (int k = 0; k < 3; k++) {
            const int32_t o = other[k];
            const int32_t end = (which >> k & 1) != 0 ? m : 0;
            put(a, 3 * i + k, type, corner ? end : level[k]);
            put(b, 3 * i + k, type, corner ? m - end : o < 0 ? 0 : o > m ? m : o);
        }
    }
}

static void check_levels(const ntp_diff *diff, const void *a, const void *b, int32_t n,
                         ntp_type type)
{
    ntp_diff_stats stats;
    uint64_t different = 0, sum[3] = { 0 };
    uint32_t most[3] = { 0 };
    for (int32_t i = 0; i < n; i++) {
        bool same = true;
        for (int32_t k = 0; k < 3; k++) {
            const int32_t off = level_at(a, 3 * i + k, type) - level_at(b, 3 * i + k, type);
            const uint32_t size = (uint32_t) (off < 0 ? -off : off);
            sum[k] += size;
            most[k] = size > most[k] ? size : most[k];
            same = same && size == 0;
        }
        different += !same;
    }
    CHECK(ntp_diff_summarize(&stats, diff) == NTP_OK);
    CHECK(stats.texels == (uint64_t) n && stats.different == different);
    for (int32_t k = 0; k < 3; k++) {
        const double off = stats.levels_mean[k] * n - (double) sum[k];
        CHECK(stats.levels_max[k] == most[k] && off < 1e-6 * n && off > -1e-6 * n);
    }
}

static void compare(int32_t n, ntp_type type, int kind, ntp_diff *diffs[SETS], uint64_t *seed)
{
    const size_t bytes = (size_t) n * (type == NTP_TYPE_U8 ? 3 : 6);
    guarded one = guarded_alloc(bytes, n & 1), two = guarded_alloc(bytes, n & 2);
    const ntp_image first = ntp_image_packed(one.data, n, 1, 3, type);
    const ntp_image second = ntp_image_packed(two.data, n, 1, 3, type);
    const ntp_const_image a = ntp_image_as_const(&first), b = ntp_image_as_const(&second);
    make_pair(one.data, two.data, n, type, kind, seed);
    for (int k = 0; k < SETS; k++) {
        allowed = k > 0;
        allowed_512 = k == 2;
        memset(diffs[k], 0, ntp_diff_size());
        CHECK(ntp_diff_add(diffs[k], NULL, &a, &b, NULL) == NTP_OK);
        check_levels(diffs[k], one.data, two.data, n, type);
    }
    CHECK(memcmp(diffs[0], diffs[1], ntp_diff_size()) == 0);
    CHECK(memcmp(diffs[0], diffs[2], ntp_diff_size()) == 0);
    guarded_free(&one);
    guarded_free(&two);
}

int main(void)
{
    uint64_t seed = 1;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    ntp_diff *diffs[SETS];
    for (int k = 0; k < SETS; k++) {
        diffs[k] = malloc(ntp_diff_size());
        CHECK(diffs[k] != NULL);
    }
    const int32_t wide[] = { 2047, 2048, 2049, 2063, 6200 };
    for (int32_t i = 1; i <= WIDEST + 5; i++) {
        const int32_t n = i <= WIDEST ? i : wide[i - WIDEST - 1];
        for (int kind = 0; kind < KINDS; kind++) {
            compare(n, NTP_TYPE_U8, kind, diffs, &seed);
            compare(n, NTP_TYPE_U16, kind, diffs, &seed);
        }
    }
    for (int k = 0; k < SETS; k++)
        free(diffs[k]);
    return 0;
}
