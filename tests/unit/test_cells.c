/* SPDX-License-Identifier: MIT */
/*
 * test_cells.c - packed colors of 8 bit are counted in their cells
 *
 * All colors, 16 or 32 in a row that differ in blue, then 32 of one color; their cells are worked out here
 * without tables.  Runs between guard pages, with black, white and translucent texels at any place, leave
 * those out of the cells that are unused.  Counts that are too great for a byte are carried.
 *
 * Of all colors those with the derived blue are counted by their rows, and the others left, also in small
 * blocks of few kinds of colors, with their sums and extremes.  A tally of many texels at
 * once has the sums of one that was made of narrow columns, which looks them up.  A gray picture has those of
 * one whose texels do not lie side by side.
 */
#include "guarded.h"
#include "libntp.h"
#include "texel/cells.h"
#include "texel/kernels_avx512.h"
#include "without_avx512.h"

#include <stdlib.h>
#include <string.h>

enum { STEP = NTP__KERNEL_STEP, EVEN = NTP__KERNEL_LANES, SKIPPED = 77, WIDEST = 100, MANY = 3000 };

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
    memcpy(dst, v, channels == 4 ? 4 : 3);
}

/* The counts are those of `want`, and each is noted where it has to be. */
static void check_counts(void)
{
    for (int32_t row = 0; row < NTP__ROWS; row++) {
        bool any = false, carried = false, often = false;
        for (int32_t i = row * NTP__ROW_CELLS; i < (row + 1) * NTP__ROW_CELLS; i++) {
            CHECK(cells.far[i] + 256u * cells.carried[i] + 65536u * cells.often[i] == want[i]);
            any |= want[i] != 0;
            carried |= want[i] > 255;
            often |= want[i] > 65535;
        }
        const int32_t block = ntp__row_block(row);
        const bool noted = (cells.noted[block / 8] >> block % 8 & 1) != 0;
        CHECK(allowed_512 || !noted);
        CHECK(cells.row_seen[row] == (any || noted ? NTP__SEEN_QUARTERS : 0) +
                                         (carried ? NTP__SEEN_CARRIED : 0) +
                                         (often ? NTP__SEEN_OFTEN : 0));
    }
    for (int32_t i = 0; i < NTP__ROWS * NTP__NEAR; i++)
        CHECK(cells.near[i] == 0);
}

static void check_colors(const ntp__kernels_table *level, int32_t channels)
{
    uint8_t row[256 * 4], even[EVEN * 4];
    ntp__packed_survey survey = { .texels = 0 };
    ntp__found8 found = { .used = NTP__BLACK8, .survey = &survey };
    uint64_t grays = 0;
    memset(&cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    for (int32_t pair = 0; pair < 65536; pair++) {
        const int32_t r = pair & 255, g = pair >> 8, first = row_of(r, g) * NTP__ROW_CELLS;
        for (int32_t b = 0; b < 256; b++) {
            put(row + channels * b, channels, r, g, b);
            want[first + b] += (r & g & b) != 255;
        }
        CHECK(level->count_cells(&cells, &found, row, 256, channels, 0) == 256);
        const int32_t b = pair * 7 & 255;
        for (int32_t i = 0; i < EVEN; i++)
            put(even + channels * i, channels, r, g, b);
        want[first + b] += (r & g & b) != 255 ? EVEN : 0;
        CHECK(level->count_cells(&cells, &found, even, EVEN, channels, 0) == EVEN);
        grays += r == g ? 1 + EVEN * (b == r) : 0;
        CHECK(found.gray == grays && found.black == 0);
        CHECK(found.white == (pair == 65535 ? 1 + (b == 255 ? EVEN : 0) : 0));
    }
    check_counts();
}

/* Two colors in turn, and one, more often than a byte holds. */
static void check_many(const ntp__kernels_table *level, int32_t channels)
{
    enum { TIMES = 4096 }; /* bytes are 0 in the end, of the even ones all of them but one */
    uint8_t mixed[EVEN * 4], even[EVEN * 4];
    ntp__packed_survey survey = { .texels = 0 };
    ntp__found8 found = { .survey = &survey };
    memset(&cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    for (int32_t i = 0; i < EVEN; i++) {
        put(mixed + channels * i, channels, i % 2 != 0 ? 3 : 5, 200, 17);
        put(even + channels * i, channels, 128, 127, 255);
    }
    want[row_of(3, 200) * NTP__ROW_CELLS + 17] = TIMES * EVEN / 2;
    want[row_of(5, 200) * NTP__ROW_CELLS + 17] = TIMES * EVEN / 2;
    want[row_of(128, 127) * NTP__ROW_CELLS + 255] = TIMES * EVEN;
    for (int32_t i = 0; i < TIMES; i++) {
        CHECK(level->count_cells(&cells, &found, mixed, EVEN, channels, 0) == EVEN);
        CHECK(level->count_cells(&cells, &found, even, EVEN, channels, 0) == EVEN);
    }
    check_counts();
}

/* Is a texel hidden by its alpha? */
static bool is_hidden(const uint8_t *p, int32_t channels, bool hides)
{
    return channels == 4 && hides && p[3] == 0;
}

/* What count_cells has to find, texel by texel. */
static void look(ntp__found8 *to, const uint8_t *p, int32_t n, int32_t channels)
{
    for (int32_t i = 0; i < n; i++, p += channels) {
        const bool gray = p[0] == p[1] && p[1] == p[2];
        const bool black = gray && p[0] == 0 && !(to->used & NTP__BLACK8);
        const bool white = gray && p[0] == 255 && !(to->used & NTP__WHITE8);
        if (is_hidden(p, channels, !(to->used & NTP__CLEAR8)))
            continue;
        to->gray += gray;
        to->black += black;
        to->white += white;
        if (!black && !white)
            want[row_of(p[0], p[1]) * NTP__ROW_CELLS + p[2]]++;
    }
}

/* Is a survey that of n texels? */
static void check_survey(const ntp__packed_survey *survey, const uint8_t *p, int32_t n,
                         int32_t channels)
{
    bool translucent = false;
    for (int32_t i = 0; channels == 4 && i < n; i++)
        translucent |= p[4 * i + 3] != 255;
    CHECK(survey->texels == (uint64_t) n);
    CHECK(channels == 3 || (survey->translucent != 0) == translucent);
    for (int32_t c = 0; c < 3; c++) {
        uint64_t sum = 0;
        uint8_t low = 255, high = 0, least = 255, greatest = 0;
        for (int32_t i = 0; i < n; i++) {
            const uint8_t v = p[channels * i + c];
            sum += v;
            low = v < low ? v : low;
            high = v > high ? v : high;
        }
        for (int32_t i = c; i < 32 * 4; i += 4) {
            const uint8_t up_to = (uint8_t) (255 - survey->extremes[0][i]);
            least = up_to < least ? up_to : least;
            greatest = survey->extremes[1][i] > greatest ? survey->extremes[1][i] : greatest;
        }
        CHECK(survey->sum[c] == sum && least == low && greatest == high);
    }
}

static void fill_mixed(uint8_t *p, int32_t n, int32_t channels, uint64_t *seed)
{
    for (int32_t i = 0; i < n; i++, p += channels) {
        const uint32_t kind = random_bits(seed) % 8;
        const int32_t r = (int32_t) random_level(seed, 255), g = (int32_t) random_level(seed, 255);
        put(p, channels, r, kind % 2 == 0 ? r : g, r);
        if (kind < 4)
            memset(p, kind == 0 ? 255 : 0, kind < 2 ? 3 : 2);
        if (channels == 4 && random_bits(seed) % 2 == 0)
            p[3] = (uint8_t) (random_level(seed, 255) | (random_bits(seed) % 16 != 0));
    }
}

static void check_mixed(const ntp__kernels_table *level, int32_t n, int32_t channels,
                        uint64_t *seed)
{
    guarded src = guarded_alloc((size_t) n * (size_t) channels, random_bits(seed) & 1);
    ntp__packed_survey survey = { .texels = 0 };
    ntp__found8 found = { .survey = &survey }, other = { .survey = NULL };
    const int32_t whole = n / STEP * STEP;
    memset(&cells, 0, sizeof cells);
    memset(want, 0, sizeof want);
    fill_mixed(src.data, n, channels, seed);
    found.used = other.used = random_bits(seed) % 8;
    look(&other, src.data, whole, channels);
    CHECK(level->count_cells(&cells, &found, src.data, n, channels, 64) == whole);
    CHECK(found.gray == other.gray && found.black == other.black && found.white == other.white);
    check_survey(&survey, src.data, whole, channels);
    check_counts();
    guarded_free(&src);
}

/* Is blue the derived one, and no gray?  The root is found by counting. */
static bool is_exact(int32_t r, int32_t g, int32_t b)
{
    const int32_t x = 2 * r - 255, y = 2 * g - 255, z = 2 * b - 255, rest = 65025 - x * x - y * y;
    /* half up: (z - 1)^2 <= rest < (z + 1)^2 */
    return rest >= 0 && z > 0 && (z - 1) * (z - 1) <= rest && rest < (z + 1) * (z + 1) &&
           (r != g || g != b);
}

/* Is it counted among close texels?  Exact ones are; grays are not. */
static bool is_close(int32_t r, int32_t g, int32_t b)
{
    const int32_t x = 2 * r - 255, y = 2 * g - 255, z = 2 * b - 255, rest = 65025 - x * x - y * y;
    /* 4 e is at most the rest, and u = (z + 1) / 2 */
    const int32_t low = z - 7, high = z + 9;
    return z > 0 && rest >= 0 && low * low <= rest && rest < high * high && (r != g || g != b);
}

static ntp__close8_counts close8;
static uint32_t close_texels[NTP__ROWS][256];

/* A row is the same for up to eight pairs, so its counts are looked at in the end. */
static void check_close_counts(void)
{
    for (int32_t row = 0; row < NTP__ROWS; row++) {
        const bool flat = row >= NTP__ROWS - NTP__FLAT_ROWS;
        uint32_t by_place[NTP__CLOSE8_BLUES] = { 0 }, blues[NTP__CLOSE8_BLUES] = { 0 };
        for (int32_t b = 0; b < 256; b++) {
            by_place[b % NTP__CLOSE8_BLUES] += close_texels[row][b];
            blues[b % NTP__CLOSE8_BLUES] += close_texels[row][b] > 0;
        }
        for (uint32_t i = 0; i < NTP__CLOSE8_BLUES; i++) {
            CHECK(blues[i] <= 1);
            if (!flat && row >= NTP__CLOSE8_ROWS) {
                CHECK(by_place[i] == 0);
                continue;
            }
            const uint32_t *const c = close8[ntp__close8_of((uint32_t) row, i)];
            CHECK((uint32_t) c[0] + c[1] + c[2] + c[3] == by_place[i]);
        }
    }
}

/* Each of n texels is counted, or its place or color is there, in order; but grays may be unused. */
static void check_block(const ntp__close8_block *block, const uint8_t *texels, int32_t n,
                        int32_t channels)
{
    const ntp__found8 *const found = &block->found;
    int32_t others = 0, colors = 0, hidden = 0;
    uint64_t gray = 0, black = 0, white = 0;
    for (int32_t i = 0; i < n; i++) {
        const uint8_t *const p = texels + channels * i;
        const int32_t row = row_of(p[0], p[1]);
        const bool is_gray = p[0] == p[1] && p[1] == p[2];
        CHECK(is_close(p[0], p[1], p[2]) || !is_exact(p[0], p[1], p[2]));
        if (is_hidden(p, channels, block->visible != 0)) {
            hidden++;
            continue;
        }
        gray += is_gray;
        if (is_gray && p[0] == 0 && !(found->used & NTP__BLACK8)) {
            black++;
        } else if (is_gray && p[0] == 255 && !(found->used & NTP__WHITE8)) {
            white++;
        } else if (is_close(p[0], p[1], p[2])) {
            close_texels[row][p[2]]++;
        } else if (others < block->others && block->left[others] == i) {
            CHECK(block->row[i] == row);
            others++;
        } else {
            CHECK(colors < block->colors);
            CHECK(block->color[colors++] == ((uint32_t) row | (uint32_t) p[2] << 16));
        }
    }
    CHECK(others == block->others && colors == block->colors && hidden == block->hidden);
    CHECK(gray == found->gray && black == found->black && white == found->white);
}

/* Counts as many texels as the kernel takes, but for the survey. */
static int32_t count_some(ntp__count_close8_fn *count, ntp__close8_block *block,
                          const uint8_t *texels, int32_t n, int32_t channels, size_t ahead)
{
    block->found.gray = block->found.black = block->found.white = 0;
    const int32_t done = count(block, close8, texels, n, channels, ahead);
    CHECK(done <= n && done % NTP__KERNEL_LANES == 0 && (done == n || done >= 128));
    check_block(block, texels, done, channels);
    return done;
}

static void check_close(ntp__count_close8_fn *count, int32_t channels)
{
    uint8_t texels[256 * 4];
    ntp__packed_survey survey = { .texels = 0 };
    ntp__close8_block block = { .found.survey = &survey };
    memset(close8, 0, sizeof close8);
    memset(close_texels, 0, sizeof close_texels);
    for (int32_t pair = 0; pair < 65536; pair++) {
        const int32_t r = pair & 255, g = pair >> 8;
        for (int32_t b = 0; b < 256; b++) {
            put(texels + channels * b, channels, r, g, b);
            if (channels == 4 && pair % 3 == 0)
                texels[4 * b + 3] = (uint8_t) ((pair * 13 + b) & (pair % 2 == 0 ? 255 : 1));
        }
        block.visible = pair % 5 != 0;
        block.found.used = (uint32_t) pair % 7;
        for (int32_t i = 0; i < 256;)
            i += count_some(count, &block, texels + channels * i, 256 - i, channels, 256);
    }
    check_close_counts();
}

/* A color of one of these kinds: gray, often black, of any blue, nearly flat, flat, one, or close. */
static void put_kind(uint8_t *p, int32_t channels, int32_t kind, uint64_t *seed)
{
    const int32_t r = kind == 0   ? (int32_t) (random_level(seed, 255) * (random_bits(seed) % 2))
                      : kind == 1 ? (int32_t) random_level(seed, 255)
                                  : 126 + (int32_t) (random_bits(seed) % 4);
    const int32_t g = kind == 0 ? r : kind == 1 ? (int32_t) random_level(seed, 255) : 127;
    int32_t b = kind == 0   ? r
                : kind == 1 ? (int32_t) random_level(seed, 255)
                            : 252 + (int32_t) (random_bits(seed) % 4);
    if (kind == 3)
        put(p, channels, 127 + r % 2, 127 + b % 2, 255);
    else if (kind == 4)
        put(p, channels, 100, 140, 250);
    else
        put(p, channels, r, g, b);
}

/* Blocks of all sizes between guard pages, of one kind, mixed or of plain areas, and their surveys. */
static void check_sizes(ntp__count_close8_fn *count, int32_t channels, uint64_t *seed)
{
    enum { TIMES = 100, KINDS = 7, PLAIN = 6 };
    ntp__packed_survey survey;
    ntp__close8_block block = { .visible = 1, .found.survey = &survey };
    memset(close8, 0, sizeof close8);
    memset(close_texels, 0, sizeof close_texels);
    for (int32_t i = 0; i < TIMES * KINDS; i++) {
        const int32_t many = i % 11 == 0 ? NTP__CLOSE8_AT_ONCE : 256, kind = i % KINDS;
        const int32_t n = many - i * NTP__KERNEL_LANES % 256;
        guarded src = guarded_alloc((size_t) n * (size_t) channels, i & 1);
        uint8_t *const p = src.data;
        for (int32_t k = 0; k < n; k++) {
            uint8_t *const to = p + channels * k;
            const bool again = kind == PLAIN && k > 0 && random_bits(seed) % 128 != 0;
            put_kind(to, channels, kind < 5 ? kind : (int32_t) (random_bits(seed) % 5), seed);
            if (channels == 4 && kind == PLAIN)
                to[3] = (uint8_t) (random_bits(seed) % 3);
            if (again)
                memcpy(to, to - channels, (size_t) channels);
        }
        if (channels == 4 && i % 4 == 0)
            p[4 * (random_bits(seed) % (uint32_t) n) + 3] = (uint8_t) (random_bits(seed) % 3);
        block.found.used = i % 3 == 0 ? NTP__BLACK8 | NTP__WHITE8 : 0;
        for (int32_t at = 0, done; at < n; at += done) {
            memset(&survey, 0, sizeof survey);
            done = count_some(count, &block, p + channels * at, n - at, channels, 0);
            check_survey(&survey, p + channels * at, done, channels);
        }
        guarded_free(&src);
    }
    check_close_counts();
}

/* All pairs with their derived blues; then the first ones more often than a count holds, some of them
 * black, damaged or translucent; and noise, which is counted in groups. */
static void fill(uint8_t *texels, int32_t n, int32_t channels, uint64_t *seed)
{
    for (int32_t i = 0; i < n; i++) {
        const int32_t pair = i < 65536 ? i : 127 + 127 * 256, r = pair & 255, g = pair >> 8;
        int32_t b = 128;
        while (b < 255 && !is_exact(r, g, b))
            b++;
        put(texels + channels * i, channels, r, g, b);
        if (i >= 65536 && random_bits(seed) % 16 == 0)
            put(texels + channels * i, channels, (int32_t) random_level(seed, 255),
                (int32_t) random_level(seed, 255), (int32_t) random_level(seed, 255));
        if (i >= 65536 && random_bits(seed) % 16 == 0)
            memset(texels + channels * i, 0, 3);
        if (channels == 4 && random_bits(seed) % 16 == 0)
            texels[4 * i + 3] = (uint8_t) random_level(seed, 255);
        /* then all but each fourth one of these, so that other fourths have more than their share */
        if (i >= n / 2 && i < n / 4 * 3)
            put(texels + channels * i, channels, 127, 127, i % 4 != 3 ? 255 : 200);
        if (i >= n / 8 * 7)
            put(texels + channels * i, channels, (int32_t) random_level(seed, 255),
                (int32_t) random_level(seed, 255), (int32_t) random_level(seed, 255));
    }
}

static void check_tallies(int32_t channels, uint32_t touch, uint64_t *seed)
{
    enum { WIDTH = 4000, HEIGHT = 300, FEW = 8 }; /* more far cells in a row than wait at once */
    uint8_t *texels = malloc((size_t) WIDTH * HEIGHT * 4);
    ntp_tally *many = calloc(1, ntp_tally_size()), *few = calloc(1, ntp_tally_size()),
              *merged = calloc(1, ntp_tally_size());
    static uint64_t levels[2][65536];
    ntp_stats stats[4];
    memset(stats, 0, sizeof stats);
    CHECK(texels != NULL && many != NULL && few != NULL && merged != NULL);
    fill(texels, WIDTH * HEIGHT, channels, seed);
    const ntp_image image = ntp_image_packed(texels, WIDTH, HEIGHT, channels, NTP_TYPE_U8);
    const ntp_const_image view = ntp_image_as_const(&image);
    const ntp_rect halves[2] = { { 0, 0, WIDTH, HEIGHT / 2 }, { 0, HEIGHT / 2, WIDTH, HEIGHT } };
    for (int32_t i = 0; i < 2; i++) { /* the sums of one do not hinder the other */
        CHECK(ntp_tally_add(many, &view, touch, &halves[i]) == NTP_OK);
        CHECK(ntp_tally_summarize(&stats[0], many, NTP_ENCODING_STANDARD) == NTP_OK);
    }
    for (int32_t x = 0; x < WIDTH; x += FEW) { /* columns that are too narrow for a group */
        const ntp_rect area = { x, 0, x + FEW, HEIGHT };
        CHECK(ntp_tally_add(few, &view, touch, &area) == NTP_OK);
    }
    CHECK(ntp_tally_merge(merged, many) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[0], many, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[1], few, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[2], merged, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_clear(merged) == NTP_OK && ntp_tally_add(merged, &view, touch, NULL) == NTP_OK);
    /* one that was cleared with what it had not put into its cells */
    CHECK(ntp_tally_clear(merged) == NTP_OK && ntp_tally_add(merged, &view, touch, NULL) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[3], merged, NTP_ENCODING_STANDARD) == NTP_OK);
    for (int32_t i = 1; i < 4; i++)
        /* All were zero-filled, padding included.  NOLINTNEXTLINE */
        CHECK(memcmp(&stats[0], &stats[i], sizeof stats[0]) == 0);
    CHECK(ntp_tally_merge(merged, few) == NTP_OK &&
          ntp_tally_add(many, &view, touch, NULL) == NTP_OK);
    CHECK(ntp_tally_add(few, &view, touch, NULL) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[0], many, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_summarize(&stats[1], merged, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(memcmp(&stats[0], &stats[1], sizeof stats[0]) == 0); /* NOLINT */
    CHECK(ntp_tally_levels_off(levels[0], 65536, many, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_levels_off(levels[1], 65536, few, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(memcmp(levels[0], levels[1], sizeof levels[0]) == 0);
    free(merged);
    free(few);
    free(many);
    free(texels);
}

/* Two rows; the first one is of one level at times. */
static void check_gray(int32_t width, uint64_t *seed)
{
    uint8_t packed[2 * WIDEST], apart[2 * 2 * WIDEST] = { 0 };
    ntp_stats stats[2];
    const bool even = random_bits(seed) % 2 != 0;
    memset(stats, 0, sizeof stats);
    for (int32_t i = 0; i < 2 * width; i++) {
        const uint32_t level = random_level(seed, 255);
        packed[i] = apart[2 * i] = (uint8_t) (even && i < width ? 200 : level);
    }
    for (int32_t i = 0; i < 2; i++) {
        ntp_image image = ntp_image_packed(i == 0 ? packed : apart, width, 2, 1 + i, NTP_TYPE_U8);
        image.channels = 1; /* of two, whose strides are kept */
        image.encoding = NTP_ENCODING_HEIGHT;
        const ntp_const_image view = ntp_image_as_const(&image);
        const ntp_rect rows[2] = { { 0, 0, width, 1 }, { width / 3, 1, width, 2 } };
        ntp_tally *const tally = calloc(1, ntp_tally_size());
        CHECK(tally != NULL && ntp_tally_add(tally, &view, 0, &rows[0]) == NTP_OK);
        CHECK(ntp_tally_add(tally, &view, 0, &rows[1]) == NTP_OK);
        CHECK(ntp_tally_summarize(&stats[i], tally, NTP_ENCODING_STANDARD) == NTP_OK);
        free(tally);
    }
    /* All were zero-filled, padding included.  NOLINTNEXTLINE */
    CHECK(memcmp(&stats[0], &stats[1], sizeof stats[0]) == 0);
    CHECK(stats[0].gray == stats[0].texels && stats[0].channel[0].max > 0);
}

int main(int argc, char **argv)
{
    ntp__kernels_table level;
    uint64_t seed = 54321;
    allowed_512 = argc > 1 && strcmp(argv[1], "avx512") == 0;
    ntp__pick_kernels(&level, NTP__CPU_ALL);
    if (level.count_cells == NULL || (allowed_512 && !ntp__cpu_has_avx512(NTP__CPU_ALL)))
        return SKIPPED;
    for (int32_t channels = 3; channels <= 4; channels++) {
        check_close(level.count_close8, channels);
        check_sizes(level.count_close8, channels, &seed);
        check_tallies(channels, 0, &seed);
        check_tallies(channels, NTP_UNUSED_TRANSPARENT | NTP_UNUSED_WHITE, &seed);
        check_colors(&level, channels);
        check_many(&level, channels);
        for (int32_t n = 1; n <= WIDEST; n++)
            check_mixed(&level, n, channels, &seed);
        check_mixed(&level, MANY, channels, &seed);
    }
    for (int32_t width = 1; width <= WIDEST; width++)
        check_gray(width, &seed);
    return 0;
}
