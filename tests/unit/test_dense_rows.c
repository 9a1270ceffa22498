/* SPDX-License-Identifier: MIT */
/*
 * test_dense_rows.c - rows of cells that are added as a whole have the sums of their colors, one by one
 *
 * All rows: each with all blues once; with random counts, some of them 0, in each kind of cell; and with a
 * sixth to a half of all blues, at any place.  The colors are judged by the loops without AVX2.  Rows of few
 * colors are left to others.  Then tallies of noise, and what classify/ asks of them, with and without AVX2.
 */
#include "alike_tallies.h"
#include "guarded.h"
#include "measure/tally.h"
#include "without_avx2.h"
#ifdef NTP_HAVE_AVX2
#  include "measure/dense_row_avx2.h"
#endif

#include <stdlib.h>
#include <string.h>

enum { SKIPPED = 77, WIDTH = 1000, HEIGHT = 700 };

#ifdef NTP_HAVE_AVX2
enum { LEAST = NTP__DENSE };
static ntp__color_counts counts;
static ntp__sums rows, colors;
static uint64_t blues[2][256];

static void put(int32_t row, int32_t b, uint32_t n)
{
    counts.at.far[row * NTP__ROW_CELLS + b] = (uint8_t) n;
    counts.at.carried[row * NTP__ROW_CELLS + b] = (uint8_t) (n >> 8);
    counts.at.row_seen[row] |= NTP__SEEN_QUARTERS | (n > 255 ? NTP__SEEN_CARRIED : 0);
}

static void fill(int32_t row, int32_t kind, uint64_t *seed)
{
    memset(&counts.at.far[row * NTP__ROW_CELLS], 0, 256);
    memset(&counts.at.carried[row * NTP__ROW_CELLS], 0, 256);
    memset(&counts.at.near[row * NTP__NEAR], 0, NTP__NEAR * sizeof counts.at.near[0]);
    counts.at.row_seen[row] = 0;
    for (int32_t b = 0; b < 256; b++) {
        const uint32_t any = random_bits(seed) % 4;
        if (kind == 0)
            put(row, b, 1);
        else if (kind == 1)
            put(row, b, any == 0 ? 0 : 1 + (random_bits(seed) >> (16 + 4 * any)));
        else if (any < 2 && b % (row % 3 + 1) == 0)
            put(row, b, 1 + row % 2);
    }
    for (int32_t i = 0; kind == 1 && i < NTP__NEAR; i++)
        counts.at.near[row * NTP__NEAR + i] = i % 3 == 0 ? 0 : random_bits(seed) % 1000;
}

/* The same colors, one by one; returns how many have a byte that is not 0. */
static int32_t add_colors(int32_t row, bool dense)
{
    ntp__color_batch batch;
    ntp__cells cells;
    int32_t far = 0;
    batch.n = 0;
    for (int32_t b = 0; b < 256; b++)
        far += counts.at.far[row * NTP__ROW_CELLS + b] != 0;
    const int32_t n = ntp__row_cells(&cells, &counts, row);
    for (int32_t i = 0; dense && i < n; i++) {
        const int32_t c[] = { counts.row[row].pair & 255, counts.row[row].pair >> 8,
                              cells.blue[i] };
        blues[1][cells.blue[i]] += cells.count[i];
        ntp__put_color(&colors, &batch, c, cells.count[i], 255, NTP_ENCODING_STANDARD);
    }
    ntp__end_batch(&colors, &batch, 255, NTP_ENCODING_STANDARD);
    return far;
}

static void check_rows(int32_t kind, uint64_t *seed)
{
    int32_t left = 0, done = 0;
    memset(&rows, 0, sizeof rows);
    memset(&colors, 0, sizeof colors);
    memset(blues, 0, sizeof blues);
    for (int32_t row = 0; row < NTP__ROWS; row++) {
        fill(row, kind, seed);
        const bool added = ntp__add_dense_row_avx2(&rows, blues[0], &counts, row, LEAST);
        const int32_t far = add_colors(row, added);
        CHECK(added == (far >= LEAST));
        done += added;
        left += !added;
        if (row % 64 == 0 || row == NTP__ROWS - 1) {
            /* Both were zero-filled, padding included.  NOLINTNEXTLINE */
            CHECK(memcmp(&rows, &colors, sizeof rows) == 0);
            CHECK(memcmp(blues[0], blues[1], sizeof blues[0]) == 0);
        }
    }
    CHECK(done > 2000 && (left > 2000) == (kind == 2));
}

static void check_tallies(uint64_t *seed)
{
    uint8_t *const texels = malloc((size_t) WIDTH * HEIGHT * 3);
    CHECK(texels != NULL);
    for (int32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
        texels[i] = (uint8_t) random_level(seed, 255);
    const ntp__evidence *const evidence = alike_tallies(texels, WIDTH, HEIGHT, &allowed);
    CHECK(evidence->tilted > WIDTH * HEIGHT / 2 && evidence->tilted_off[0] > 0);
    free(texels);
}
#endif

int main(void)
{
    allowed = true;
#ifdef NTP_HAVE_AVX2
    uint64_t seed = 2468;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    ntp__rows_prepare(&counts);
    for (int32_t kind = 0; kind < 3; kind++)
        check_rows(kind, &seed);
    check_tallies(&seed);
    return 0;
#else
    return ntp__cpu_has_avx2(NTP__CPU_ALL) ? 1 : SKIPPED;
#endif
}
