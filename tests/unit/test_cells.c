/* SPDX-License-Identifier: MIT */
/*
 * test_cells.c - packed colors of 8 bit are counted in their cells
 *
 * All colors but grays, 16 in a row that differ in blue, then 16 of one color; their cells are worked
 * out here without tables and roots.  Runs between guard pages, with a gray or translucent texel at
 * any place, end at its group.
 */
#include "guarded.h"
#include "texel/cells.h"
#include "texel/kernels.h"

#include <string.h>

enum { STEP = NTP__KERNEL_STEP, SKIPPED = 77, WIDEST = 100 };

static uint32_t cells[NTP__CELLS], want[NTP__CELLS];
static uint8_t seen[NTP__ROWS + 1], want_seen[NTP__ROWS + 1];

/* |X| = 2k + 1 */
static int32_t magnitude(int32_t level)
{
    return level < 128 ? 127 - level : level - 128;
}

/* The blue of the first near cell of k1 >= k2. */
static int32_t first_near(int32_t k1, int32_t k2)
{
    const int32_t x = 2 * k1 + 1, y = 2 * k2 + 1, rest = 255 * 255 - x * x - y * y;
    int32_t blue = 128;
    while (rest >= 0 && (2 * blue - 254) * (2 * blue - 254) <= rest)
        blue++;
    int32_t first = blue - 8 < 240 ? blue - 8 : 240;
    return k1 == k2 && 128 + k1 >= first && 128 + k1 < first + 16 ? 129 + k1 : first;
}

static void expect(int32_t r, int32_t g, int32_t b, uint32_t count)
{
    static int32_t first[128][128];
    const int32_t p = magnitude(r), q = magnitude(g), k1 = p > q ? p : q, k2 = p > q ? q : p;
    int32_t row = k2;
    for (int32_t i = 1; i <= k1; i++)
        row += i;
    if (k1 == 0)
        row = NTP__ROWS - 4 + (r == 128) + 2 * (g == 128);
    if (first[k1][k2] == 0)
        first[k1][k2] = first_near(k1, k2);
    const int32_t place = b - first[k1][k2];
    if (place >= 0 && place < 16) {
        want[16 * row + place] += count;
    } else {
        want[NTP__FIRST_FAR + NTP__FAR_CELLS * row + b] += count;
        want_seen[row] = NTP__SEEN_NEAR | NTP__SEEN_FAR;
    }
}

static void put(uint8_t *dst, int32_t channels, int32_t r, int32_t g, int32_t b)
{
    const uint8_t v[4] = { (uint8_t) r, (uint8_t) g, (uint8_t) b, 255 };
    memcpy(dst, v, (size_t) channels);
}

static void check_colors(const ntp__kernels_table *level, int32_t channels)
{
    uint8_t row[256 * 4], even[STEP * 4];
    memset(cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    memset(seen, 0, sizeof seen);
    memset(want_seen, 0, sizeof want_seen);
    for (int32_t pair = 0; pair < 65536; pair++) {
        const int32_t r = pair & 255, g = pair >> 8;
        for (int32_t b = 0; b < 256; b++) {
            const int32_t other = r == g && g == b ? b ^ 1 : b;
            put(row + channels * b, channels, r, g, other);
            expect(r, g, other, 1);
        }
        CHECK(level->count_cells(cells, seen, row, 256, channels) == 256);
        const int32_t b = r == g ? r ^ 255 : pair * 7 & 255;
        for (int32_t i = 0; i < STEP; i++)
            put(even + channels * i, channels, r, g, b);
        expect(r, g, b, STEP);
        CHECK(level->count_cells(cells, seen, even, STEP, channels) == STEP);
    }
    CHECK(memcmp(cells, want, sizeof cells) == 0);
    CHECK(memcmp(seen, want_seen, NTP__ROWS) == 0);
}

static uint64_t counted(void)
{
    uint64_t sum = 0;
    for (int32_t i = 0; i < NTP__CELLS; i++)
        sum += cells[i];
    return sum;
}

static void check_ends(const ntp__kernels_table *level, int32_t n, int32_t channels, uint64_t *seed)
{
    guarded src = guarded_alloc((size_t) n * (size_t) channels, random_bits(seed) & 1);
    uint8_t *p = src.data;
    for (int32_t i = 0; i < n; i++) {
        const int32_t r = (int32_t) random_level(seed, 255);
        put(p + channels * i, channels, r, r ^ (1 << random_bits(seed) % 8), r);
    }
    const int32_t at = (int32_t) (random_bits(seed) % (uint32_t) (2 * n));
    if (at < n && channels == 4 && random_bits(seed) & 1)
        p[4 * at + 3] = (uint8_t) (255 ^ 1 << random_bits(seed) % 8);
    else if (at < n)
        p[channels * at + 1] = p[channels * at];
    const int32_t done = (at < n ? at : n) / STEP * STEP;
    memset(cells, 0, sizeof cells);
    CHECK(level->count_cells(cells, seen, p, n, channels) == done);
    CHECK(counted() == (uint64_t) done);
    guarded_free(&src);
}

int main(void)
{
    const ntp__kernels_table *level = ntp__kernels(NTP__CPU_ALL);
    uint64_t seed = 54321;
    if (level->count_cells == NULL)
        return SKIPPED;
    for (int32_t channels = 3; channels <= 4; channels++) {
        check_colors(level, channels);
        for (int32_t n = 1; n <= WIDEST; n++)
            check_ends(level, n, channels, &seed);
    }
    return 0;
}
