/* SPDX-License-Identifier: MIT */
/*
 * test_colors.c - rows of cells that are read and judged with AVX-512 have the sums of their colors, one by one
 *
 * All colors whose red and green are not too long, each once; then random counts in each kind of cell, few and
 * many of them, from one color on.  The colors are judged by the loops in plain C.  Then tallies of noise.
 */
#include "alike_tallies.h"
#include "guarded.h"
#include "measure/tally.h"
#include "texel/level.h"
#include "without_avx2.h"
#include "without_avx512.h"
#ifdef NTP_HAVE_AVX512
#  include "measure/colors_avx512.h"
#  include "measure/dense_row_avx2.h"
#endif

#include <stdlib.h>
#include <string.h>

enum { SKIPPED = 77, WIDTH = 500, HEIGHT = 300 };

#ifdef NTP_HAVE_AVX512
static ntp__color_counts counts;
static ntp__sums rows, colors;
static uint64_t blues[2][256];

static void put_far(int32_t row, int32_t b, uint32_t n)
{
    const int32_t cell = row * NTP__ROW_CELLS + b;
    counts.at.far[cell] = (uint8_t) n;
    counts.at.carried[cell] = (uint8_t) (n >> 8);
    counts.at.often[cell] = (uint16_t) (n >> 16);
    counts.at.row_seen[row] |=
        (uint8_t) (NTP__SEEN_QUARTER << b / NTP__QUARTER | (n > 255 ? NTP__SEEN_CARRIED : 0) |
                   (n > 65535 ? NTP__SEEN_OFTEN : 0));
}

static void put_near(int32_t row, int32_t place, uint32_t n)
{
    counts.at.near[row * NTP__NEAR + place] = n;
    counts.at.row_seen[row] |= NTP__SEEN_NEAR;
}

/* Kind 0: all blues of a row; else one in that many cells, on the average. */
static void fill(int32_t row, uint32_t kind, uint64_t *seed)
{
    const uint32_t least = row % 32 == 0 ? 14 : 17; /* few rows have cells of 65536 texels */
    for (int32_t b = 0; b < 256; b++) {
        if (kind == 0)
            put_far(row, b, 1);
        else if (random_bits(seed) % kind == 0)
            put_far(row, b, 1 + (random_bits(seed) >> (least + random_bits(seed) % (32 - least))));
    }
    for (int32_t i = 0; kind != 0 && i < NTP__NEAR; i++) {
        if (random_bits(seed) % kind == 0)
            put_near(row, i, 1 + random_bits(seed) % 1000);
    }
    if (row % 3 == 0) /* as in a block of rows */
        counts.at.row_seen[row] |= NTP__SEEN_QUARTERS;
}

/* Quarters of a row that hold counts are noted, and no others, unless a cell of 0 may hold some. */
static void check_notes(int32_t row)
{
    const uint32_t seen = counts.at.row_seen[row];
    for (uint32_t k = 0; k < 4; k++) {
        bool any = false, some = (seen & NTP__SEEN_QUARTER << k) != 0;
        for (uint32_t i = 0; i < NTP__QUARTER; i++)
            any |= counts.at.far[(uint32_t) row * NTP__ROW_CELLS + k * NTP__QUARTER + i] != 0;
        CHECK(some || !any);
        CHECK(any || !some || seen & NTP__SEEN_CARRIED || !ntp__row_is_on_disc(&counts, row));
    }
}

static void clear(int32_t row)
{
    memset(&counts.at.far[row * NTP__ROW_CELLS], 0, 256);
    memset(&counts.at.carried[row * NTP__ROW_CELLS], 0, 256);
    memset(&counts.at.often[row * NTP__ROW_CELLS], 0, 256 * sizeof counts.at.often[0]);
    memset(&counts.at.near[row * NTP__NEAR], 0, NTP__NEAR * sizeof counts.at.near[0]);
    counts.at.row_seen[row] = 0;
}

static uint32_t count_of(int32_t row, int32_t b)
{
    const int32_t cell = row * NTP__ROW_CELLS + b;
    const uint32_t place = (uint32_t) (b - counts.row[row].first);
    const uint32_t near = place < NTP__NEAR ? counts.at.near[row * NTP__NEAR + (int32_t) place] : 0;
    return counts.at.far[cell] + ((uint32_t) counts.at.carried[cell] << 8) +
           ((uint32_t) counts.at.often[cell] << 16) + near;
}

/* Both functions that read a row find its colors. */
static void check_reading(int32_t row)
{
    static ntp__cells cells[2];
    const int32_t n = ntp__row_cells(&cells[0], &counts, row);
    int32_t found = 0;
    CHECK(ntp__row_cells_avx512(&cells[1], &counts, row) == n);
    for (int32_t b = 0; b < 256; b++) {
        if (count_of(row, b) == 0)
            continue;
        for (int32_t i = 0; i < 2; i++)
            CHECK(found < n && cells[i].blue[found] == b &&
                  cells[i].count[found] == count_of(row, b));
        found++;
    }
    CHECK(found == n);
}

/* The colors of a row, from its cells, if those are to be added; returns how many they are. */
static int32_t add_colors(ntp__color_batch *batch, int32_t row)
{
    const int32_t r = counts.row[row].pair & 255, g = counts.row[row].pair >> 8;
    const bool often = (counts.at.row_seen[row] & NTP__SEEN_OFTEN) != 0;
    int32_t found = 0;
    for (int32_t b = 0; b < 256 && ntp__rest(r, g, 255) >= 0 && !often; b++) {
        const int32_t c[] = { r, g, b };
        const uint32_t n = count_of(row, b);
        if (n == 0)
            continue;
        blues[1][b] += n;
        found++;
        ntp__put_color(&colors, batch, c, n, 255, NTP_ENCODING_STANDARD);
    }
    return found;
}

/* `step` rows at a time. */
static int32_t check_rows(uint32_t kind, int32_t step, uint64_t *seed)
{
    ntp__color_batch batch;
    int32_t found = 0;
    batch.n = 0;
    memset(&rows, 0, sizeof rows);
    memset(&colors, 0, sizeof colors);
    memset(blues, 0, sizeof blues);
    for (int32_t first = 0; first < NTP__ROWS; first += step) {
        const int32_t end = first + step < NTP__ROWS ? first + step : NTP__ROWS;
        for (int32_t row = first; row < end; row++)
            fill(row, kind, seed);
        allowed = false;
        for (int32_t row = first; row < end; row++) {
            check_reading(row);
            found += add_colors(&batch, row);
        }
        ntp__end_batch(&colors, &batch, 255, NTP_ENCODING_STANDARD);
        allowed = true;
        counts.grouped = (uint32_t) (first / step % 2); /* some rows are dense then */
        ntp__add_colors_avx512(&rows, blues[0], &counts);
        ntp__add_dense_rows_avx2(&rows, blues[0], &counts);
        for (int32_t row = first; row < end; row++) {
            check_notes(row);
            clear(row);
        }
        /* Both were zero-filled, padding included.  NOLINTNEXTLINE */
        CHECK(memcmp(&rows, &colors, sizeof rows) == 0);
        CHECK(memcmp(blues[0], blues[1], sizeof blues[0]) == 0);
    }
    return found;
}

static void check_tallies(uint64_t *seed)
{
    uint8_t *const texels = malloc((size_t) WIDTH * HEIGHT * 3);
    CHECK(texels != NULL);
    for (int32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
        texels[i] = (uint8_t) (random_level(seed, 255) / (1 + i / (WIDTH * HEIGHT)));
    alike_tallies(texels, WIDTH, HEIGHT, &allowed_512);
    free(texels);
}
#endif

int main(void)
{
    allowed = allowed_512 = true;
#ifdef NTP_HAVE_AVX512
    uint64_t seed = 1357;
    if (!ntp__cpu_has_avx512(NTP__CPU_ALL))
        return SKIPPED;
    ntp__rows_prepare(&counts);
    CHECK(check_rows(0, 100, &seed) > 1500000);
    for (uint32_t kind = 2; kind < 12; kind++)
        CHECK(check_rows(kind, 300, &seed) > 100000);
    CHECK(check_rows(3, 70, &seed) > 500000);
    CHECK(check_rows(40, 7, &seed) > 40000);
    CHECK(check_rows(400, 5, &seed) > 4000);
    check_tallies(&seed);
    return 0;
#else
    return ntp__cpu_has_avx512(NTP__CPU_ALL) ? 1 : SKIPPED;
#endif
}
