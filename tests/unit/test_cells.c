/* SPDX-License-Identifier: MIT */
/*
 * test_cells.c - packed colors of 8 bit are counted in their cells
 *
 * All colors but black and white, 16 in a row that differ in blue, then 16 of one color; their cells
 * are worked out here without tables.  Runs between guard pages, with a black, white or translucent
 * texel at any place, end at its group.  Counts that are too great for a byte are carried.
 */
#include "guarded.h"
#include "texel/cells.h"
#include "texel/kernels.h"

#include <string.h>

enum { STEP = NTP__KERNEL_STEP, SKIPPED = 77, WIDEST = 100 };

static ntp__cell_counts cells;
static uint32_t want[NTP__CELLS];

/* |X| = 2k + 1 */
static int32_t magnitude(int32_t level)
{
    return level < 128 ? 127 - level : level - 128;
}

static int32_t row_of(int32_t r, int32_t g)
{
    const int32_t p = magnitude(r), q = magnitude(g), k1 = p > q ? p : q;
    int32_t row = p > q ? q : p;
    for (int32_t i = 1; i <= k1; i++)
        row += i;
    return k1 == 0 ? NTP__ROWS - 4 + (r == 128) + 2 * (g == 128) : row;
}

static void put(uint8_t *dst, int32_t channels, int32_t r, int32_t g, int32_t b)
{
    const uint8_t v[4] = { (uint8_t) r, (uint8_t) g, (uint8_t) b, 255 };
    memcpy(dst, v, (size_t) channels);
}

/* The counts are those of `want`, and each is noted where it has to be. */
static void check_counts(void)
{
    for (int32_t row = 0; row < NTP__ROWS; row++) {
        bool any = false, carried = false;
        for (int32_t i = row * NTP__ROW_CELLS; i < (row + 1) * NTP__ROW_CELLS; i++) {
            CHECK(cells.far[i] + 256 * cells.carried[i] == want[i]);
            any |= want[i] != 0;
            carried |= want[i] > 255;
        }
        CHECK(cells.row_seen[row] == (any ? NTP__SEEN_FAR : 0) + (carried ? NTP__SEEN_CARRIED : 0));
    }
    for (int32_t i = 0; i < NTP__ROWS * NTP__NEAR; i++)
        CHECK(cells.near[i] == 0);
}

static void check_colors(const ntp__kernels_table *level, int32_t channels)
{
    uint8_t row[256 * 4], even[STEP * 4];
    uint64_t gray = 0, grays = 0;
    memset(&cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    for (int32_t pair = 0; pair < 65536; pair++) {
        const int32_t r = pair & 255, g = pair >> 8, first = row_of(r, g) * NTP__ROW_CELLS;
        for (int32_t b = 0; b < 256; b++) {
            const bool end = r == g && g == b && (b == 0 || b == 255);
            const int32_t other = end ? b ^ 1 : b;
            put(row + channels * b, channels, r, g, other);
            want[first + other]++;
        }
        CHECK(level->count_cells(&cells, row, 256, channels, &gray) == 256);
        const int32_t b = pair == 0 ? 1 : pair == 65535 ? 254 : pair * 7 & 255;
        for (int32_t i = 0; i < STEP; i++)
            put(even + channels * i, channels, r, g, b);
        want[first + b] += STEP;
        CHECK(level->count_cells(&cells, even, STEP, channels, &gray) == STEP);
        grays += r == g ? (r != 0 && r != 255) + STEP * (b == r) : 0;
        CHECK(gray == grays);
    }
    check_counts();
}

/* Two colors in turn, and one, more often than a byte holds. */
static void check_many(const ntp__kernels_table *level, int32_t channels)
{
    enum { TIMES = 1000 };
    uint8_t mixed[STEP * 4], even[STEP * 4];
    uint64_t gray = 0;
    memset(&cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    for (int32_t i = 0; i < STEP; i++) {
        put(mixed + channels * i, channels, i % 2 != 0 ? 3 : 5, 200, 17);
        put(even + channels * i, channels, 128, 127, 255);
    }
    want[row_of(3, 200) * NTP__ROW_CELLS + 17] = TIMES * STEP / 2;
    want[row_of(5, 200) * NTP__ROW_CELLS + 17] = TIMES * STEP / 2;
    want[row_of(128, 127) * NTP__ROW_CELLS + 255] = TIMES * STEP;
    for (int32_t i = 0; i < TIMES; i++) {
        CHECK(level->count_cells(&cells, mixed, STEP, channels, &gray) == STEP);
        CHECK(level->count_cells(&cells, even, STEP, channels, &gray) == STEP);
    }
    check_counts();
}

static uint64_t counted(void)
{
    uint64_t sum = 0;
    for (int32_t i = 0; i < NTP__CELLS; i++)
        sum += cells.far[i];
    return sum;
}

static void check_ends(const ntp__kernels_table *level, int32_t n, int32_t channels, uint64_t *seed)
{
    guarded src = guarded_alloc((size_t) n * (size_t) channels, random_bits(seed) & 1);
    uint64_t gray = 0;
    uint8_t *p = src.data;
    for (int32_t i = 0; i < n; i++) {
        const int32_t r = (int32_t) random_level(seed, 255);
        put(p + channels * i, channels, r, r ^ (1 << random_bits(seed) % 8), r);
    }
    const int32_t at = (int32_t) (random_bits(seed) % (uint32_t) (2 * n));
    if (at < n && channels == 4 && random_bits(seed) & 1)
        p[4 * at + 3] = (uint8_t) (255 ^ 1 << random_bits(seed) % 8);
    else if (at < n)
        memset(p + channels * at, at % 2 != 0 ? 255 : 0, 3);
    const int32_t done = (at < n ? at : n) / STEP * STEP;
    memset(&cells, 0, sizeof cells);
    CHECK(level->count_cells(&cells, p, n, channels, &gray) == done);
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
        check_many(level, channels);
        for (int32_t n = 1; n <= WIDEST; n++)
            check_ends(level, n, channels, &seed);
    }
    return 0;
}
