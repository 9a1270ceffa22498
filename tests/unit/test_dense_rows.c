/* SPDX-License-Identifier: MIT */
/*
 * test_dense_rows.c - rows of cells that are added as a whole have the sums of their colors, one by one
 *
 * All rows, together and some at a time: each with all blues once; with random counts, some of them 0, in each
 * kind of cell; and with a sixth to a half of all blues, at any place.  The colors are judged by the loops
 * without AVX2.  Rows of few colors are left to others.  Then how blues of a row, of any number and count, are off from those derived; and
 * tallies of noise, and what classify/ asks of them, with and without AVX2.
 */
#include "alike_tallies.h"
#include "guarded.h"
#include "measure/tally.h"
#include "without_avx2.h"
#ifdef NTP_HAVE_AVX2
#  include "measure/blue_row.h"
#  include "measure/dense_row_avx2.h"
#endif

#include <stdlib.h>
#include <string.h>

enum { SKIPPED = 77, WIDTH = 1000, HEIGHT = 700 };

#ifdef NTP_HAVE_AVX2
enum { LEAST = NTP__DENSE, PARTS = 61 };
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

/* The colors of a row, one by one. */
static void add_colors(int32_t row)
{
    ntp__color_batch batch;
    ntp__cells cells;
    batch.n = 0;
    const int32_t n = ntp__row_cells(&cells, &counts, row);
    for (int32_t i = 0; i < n; i++) {
        const int32_t c[] = { counts.row[row].pair & 255, counts.row[row].pair >> 8,
                              cells.blue[i] };
        blues[1][cells.blue[i]] += cells.count[i];
        ntp__put_color(&colors, &batch, c, cells.count[i], 255, NTP_ENCODING_STANDARD);
    }
    ntp__end_batch(&colors, &batch, 255, NTP_ENCODING_STANDARD);
}

/* So many bytes of a row are not 0. */
static int32_t far_cells(int32_t row)
{
    int32_t far = 0;
    for (int32_t b = 0; b < 256; b++)
        far += counts.at.far[row * NTP__ROW_CELLS + b] != 0;
    return far;
}

/* Each row whose number leaves this rest; the others hold nothing. */
static void check_rows(int32_t kind, int32_t rest, int32_t of, uint64_t *seed)
{
    const int32_t least = kind == 2 ? LEAST + rest % 9 : LEAST;
    int32_t left = 0, done = 0;
    memset(&rows, 0, sizeof rows);
    memset(&colors, 0, sizeof colors);
    memset(blues, 0, sizeof blues);
    memset(counts.at.row_seen, 0, sizeof counts.at.row_seen);
    for (int32_t row = rest; row < NTP__ROWS; row += of)
        fill(row, kind, seed);
    ntp__note_dense_rows_avx2(&counts, least);
    ntp__add_dense_rows_avx2(&rows, blues[0], &counts);
    for (int32_t row = rest; row < NTP__ROWS; row += of) {
        const int32_t enough = ntp__row_is_on_disc(&counts, row) ? least : NTP__DENSE;
        const bool added = (counts.at.row_seen[row] & NTP__SEEN_DENSE) != 0;
        CHECK(added == (far_cells(row) >= enough));
        if (added)
            add_colors(row);
        done += added;
        left += !added;
    }
    /* Both were zero-filled, padding included.  NOLINTNEXTLINE */
    CHECK(memcmp(&rows, &colors, sizeof rows) == 0);
    CHECK(memcmp(blues[0], blues[1], sizeof blues[0]) == 0);
    CHECK(of > 1 || (done > 2000 && (left > 2000) == (kind == 2)));
}

static double absolute(double v)
{
    return v < 0 ? -v : v;
}

/* One blue after the other. */
static void add_blues(ntp__blue_sums *sums, ntp__blue_row *row, const ntp__cells *cells, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        const double count = cells->count[i], blue = cells->blue[i];
        row->n += count;
        row->blue += count * blue;
        row->blue2 += count * blue * blue;
        for (int32_t k = 0; row->is_tilted && k < 2; k++) {
            const double off = absolute(blue - row->want[k]);
            sums->off[k] += count * (off < 32 ? off : 32);
            sums->near[k] += off <= 3 ? count : 0;
        }
        sums->above += row->is_tilted && blue > row->want[0] + 4 ? count : 0;
    }
}

static void check_blues(uint64_t *seed)
{
    ntp__blue_sums sums[2];
    ntp__cells cells;
    uint32_t above = 0, near = 0;
    for (int32_t i = 0; i < 20000; i++) {
        const int32_t n = i % 257, step = n > 0 ? 256 / n : 1;
        const uint32_t less = n > 1 ? 8 + random_bits(seed) % 24 : 0; /* together below 2^32 */
        ntp__blue_row row[2];
        memset(row, 0, sizeof row);
        memset(sums, 0, sizeof sums);
        sums[0].off[0] = sums[1].off[0] = random_level(seed, 255) / 3.0;
        /* some are a whole number off, so that 3 and 4 levels occur */
        row[0].want[0] = i % 2 == 0 ? random_level(seed, 255) : random_level(seed, 65535) / 257.0;
        row[0].want[1] = 2 * row[0].want[0] - 255;
        row[0].is_tilted = i % 3 != 0;
        row[1] = row[0];
        for (int32_t k = 0; k < 256 + NTP__NEAR; k++) { /* also what is behind the last one */
            cells.blue[k] = k * step & 255;
            cells.count[k] = random_bits(seed) >> less;
        }
        add_blues(&sums[0], &row[0], &cells, n);
        ntp__add_blues_avx2(&sums[1], &row[1], &cells, n);
        CHECK(row[0].n == row[1].n && row[0].blue == row[1].blue && row[0].blue2 == row[1].blue2);
        CHECK(sums[0].above == sums[1].above);
        for (int32_t k = 0; k < 2; k++)
            CHECK(sums[0].off[k] == sums[1].off[k] && sums[0].near[k] == sums[1].near[k]);
        above += sums[0].above > 0;
        near += sums[0].near[0] > 0 && sums[0].near[1] > 0;
    }
    CHECK(above > 1000 && near > 1000);
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
    for (int32_t kind = 0; kind < 3; kind++) {
        check_rows(kind, 0, 1, &seed);
        for (int32_t rest = 0; rest < PARTS; rest++)
            check_rows(kind, rest, PARTS, &seed);
    }
    check_blues(&seed);
    check_tallies(&seed);
    return 0;
#else
    return ntp__cpu_has_avx2(NTP__CPU_ALL) ? 1 : SKIPPED;
#endif
}
