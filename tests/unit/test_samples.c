/* SPDX-License-Identifier: MIT */
/*
 * test_samples.c - packed texels of 8 bit are sampled, and their alpha is counted
 *
 * Runs of any length begin or end at a guard page.  They are added up here texel by texel; lengths after gamma
 * by the inequality of the documentation, over tables of random squares.  Unused texels have steps alone.  Padding
 * is added up besides, whichever way a tally takes.  Of alpha, all whole groups are counted before one with another
 * hidden color.
 */
#include "guarded.h"
#include "measure/tally.h"
#include "texel/kernels.h"

#include <stdlib.h>
#include <string.h>

enum { STEP = NTP__KERNEL_STEP, SKIPPED = 77, WIDEST = 150, TIMES = 40, LONG_RUN = 65536 };

static uint32_t squares[256];

static void fill_squares(uint64_t *seed)
{
    for (int32_t i = 0; i < 256; i++)
        squares[i] = random_bits(seed) % 900000000;
}

/* Levels from the middle, but for few that are padding or unused. */
static void fill(uint8_t *p, int32_t n, int32_t channels, uint64_t *seed)
{
    for (int32_t i = 0; i < n; i++, p += channels) {
        for (int32_t c = 0; c < channels; c++)
            p[c] = (uint8_t) (16 + random_bits(seed) % 224);
        if (random_bits(seed) % 4 == 0)
            p[0] = (uint8_t) (184 + random_bits(seed) % 9);
        if (random_bits(seed) % 4 == 0)
            p[1] = (uint8_t) (184 + random_bits(seed) % 9);
        if (random_bits(seed) % 8 == 0)
            p[random_bits(seed) % 3] = (uint8_t) random_level(seed, 255);
        if (channels == 4 && random_bits(seed) % 8 == 0)
            p[3] = 0;
        for (int32_t c = 0, both = random_bits(seed) % 64 == 0; both && c < 2; c++)
            p[c] = (uint8_t) (random_bits(seed) % 2 * 225 + 14 + random_bits(seed) % 3);
        if (random_bits(seed) % 16 == 0)
            memset(p, random_bits(seed) % 2 ? 255 : 0, 3);
        if (random_bits(seed) % 512 == 0)
            p[random_bits(seed) % 3] ^= 1;
    }
}

static bool is_near_end(int32_t level)
{
    return level <= 15 || level >= 240;
}

static bool is_unused(const uint8_t *p, int32_t channels, uint32_t touch)
{
    const bool gray = p[0] == p[1] && p[1] == p[2];
    return (channels == 4 && p[3] == 0 && !(touch & NTP_UNUSED_TRANSPARENT)) ||
           (gray && p[0] == 0 && !(touch & NTP_UNUSED_BLACK)) ||
           (gray && p[0] == 255 && !(touch & NTP_UNUSED_WHITE));
}

/* Adds a texel of column x, after another one. */
static void add(ntp__samples *to, uint64_t steps[3][2], const uint8_t *p, int32_t channels,
                int32_t x, uint32_t touch)
{
    const uint64_t unit = UINT64_C(65535) * 65535;
    uint64_t length = 3;
    for (int32_t c = 0; c < 3; c++) {
        const int32_t step = p[c] - p[c - channels];
        steps[c][x % 8 == 0] += (uint64_t) (step < 0 ? -step : step);
    }
    if (is_unused(p, channels, touch))
        return;
    for (int32_t c = 0; c < 3; c++) {
        to->sum[c] += p[c];
        to->square[c] += (uint64_t) p[c] * p[c];
        length += 4 * (uint64_t) squares[p[c]];
    }
    to->n++;
    to->product[0] += (uint64_t) p[0] * p[1];
    to->product[1] += (uint64_t) p[0] * p[2];
    to->product[2] += (uint64_t) p[1] * p[2];
    to->red_low += p[0] < 128;
    to->green_low += p[1] < 128;
    to->gamma_flat += p[0] >= 185 && p[0] <= 191 && p[1] >= 185 && p[1] <= 191;
    to->gamma_unit += 49 * unit <= 64 * length && 64 * length <= 81 * unit;
}

static void check_samples(const ntp__kernels_table *level, int32_t n, int32_t channels,
                          uint64_t *seed)
{
    guarded src = guarded_alloc((size_t) (n + 1) * (size_t) channels, random_bits(seed) & 1);
    const uint8_t *const p = (uint8_t *) src.data + channels;
    ntp__samples found[2] = { { .n = 5 } }, want[2] = { { .n = 5 } };
    uint64_t steps[3][2] = { { 1 } }, wanted[3][2] = { { 1 } }, again[3][2] = { { 0 } };
    const int32_t x = 1 + (int32_t) (random_bits(seed) % 100), end = n / STEP * STEP;
    const uint32_t touch = random_bits(seed) % 2 ? 0 : random_bits(seed) % (NTP_UNUSED_ALL + 1);
    fill(src.data, n + 1, channels, seed);
    for (int32_t i = 0; i < end; i++) {
        const uint8_t *const at = p + channels * i;
        add(&want[0], wanted, at, channels, x + i, touch);
        if (is_near_end(at[0]) && is_near_end(at[1]))
            add(&want[1], again, at, channels, x + i, touch);
    }
    CHECK(level->sample8(&found[0], &found[1], steps, squares, p, n, channels, x, touch) == end);
    CHECK(memcmp(&found, &want, sizeof found) == 0);
    CHECK(memcmp(steps, wanted, sizeof steps) == 0);
    guarded_free(&src);
}

/* The greatest sums of as many texels as one call may have. */
static void check_bright(const ntp__kernels_table *level)
{
    static uint8_t bright[3 * (LONG_RUN + 1)];
    ntp__samples found = { 0 }, want = { 0 }, padding = { 0 };
    uint64_t steps[3][2] = { { 0 } }, wanted[3][2] = { { 0 } };
    for (int32_t i = 0; i < 3 * (LONG_RUN + 1); i++)
        bright[i] = i % 3 != 1 && i / 3 % 2 == 0 ? 0 : i % 3 == 1 ? 239 : 255;
    for (int32_t i = 0; i < LONG_RUN; i++)
        add(&want, wanted, bright + 3 * (i + 1), 3, i, 0);
    CHECK(level->sample8(&found, &padding, steps, squares, bright + 3, LONG_RUN, 3, 0, 0) ==
          LONG_RUN);
    CHECK(memcmp(&found, &want, sizeof found) == 0);
    CHECK(memcmp(steps, wanted, sizeof steps) == 0);
}

/* Padding is summed besides: red and green both near an end, but neither black nor white. */
static void check_padding(uint64_t *seed)
{
    enum { WIDE = 700, HIGH = 3, TEXELS = WIDE * HIGH };
    static uint8_t texels[3 * (TEXELS + 1)]; /* the first one is before the others */
    uint8_t *const rgb = texels + 3;
    ntp_tally *const tally = calloc(1, ntp_tally_size());
    ntp__samples want = { 0 };
    uint64_t steps[3][2] = { { 0 } };
    CHECK(tally != NULL);
    for (int32_t i = 0; i < 3 * TEXELS; i++)
        rgb[i] = (uint8_t) random_level(seed, 255);
    for (int32_t i = 0; i < TEXELS; i++) {
        const uint8_t end = random_bits(seed) % 2 ? 255 : 0;
        if (random_bits(seed) % 3 != 0)
            rgb[3 * i] = rgb[3 * i + 1] = end ^ (uint8_t) (random_bits(seed) % 17);
        if (random_bits(seed) % 16 == 0)
            memset(rgb + 3 * i, end, 3);
    }
    const ntp_image image = ntp_image_packed(rgb, WIDE, HIGH, 3, NTP_TYPE_U8);
    const ntp_const_image view = ntp_image_as_const(&image);
    CHECK(ntp_tally_add(tally, &view, 0, NULL) == NTP_OK);
    memcpy(squares, tally->linear_square, sizeof squares);
    for (int32_t i = 0; i < TEXELS; i++) {
        const uint8_t *const p = rgb + 3 * i;
        const bool unused = p[0] == p[1] && p[1] == p[2] && (p[0] == 0 || p[0] == 255);
        if (is_near_end(p[0]) && is_near_end(p[1]) && !unused)
            add(&want, steps, p, 3, i, 0);
    }
    CHECK(want.n > 100);
    CHECK(memcmp(&tally->padding_samples, &want, sizeof want) == 0);
    free(tally);
}

/* Texels of alpha 0, 255 and others, in runs; most of the former have one color. */
static void fill_alphas(uint8_t *p, int32_t n, uint64_t *seed)
{
    const uint32_t kinds = 1 + random_bits(seed) % 7, change = 1 + random_bits(seed) % 40;
    uint32_t kind = 0, color = 0;
    for (int32_t i = 0; i < n; i++) {
        if (random_bits(seed) % change == 0)
            kind = random_bits(seed) % 3;
        if (random_bits(seed) % 200 == 0)
            color = random_bits(seed) & 0xffffff;
        const uint32_t any = random_bits(seed), is_clear = kinds >> kind & 1 && kind == 0;
        for (int32_t k = 0; k < 3; k++)
            p[4 * i + k] = (uint8_t) ((is_clear ? color : any) >> 8 * k);
        p[4 * i + 3] = (uint8_t) (is_clear ? 0 : kinds >> kind & 1 ? 255 : any >> 24);
    }
}

static uint32_t rgb_of(const uint8_t *p)
{
    return p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16;
}

/* Adds a group, if all of its hidden colors are the one so far. */
static bool add_alphas(ntp__alphas8 *to, const uint8_t *p, int32_t visible)
{
    ntp__alphas8 more = *to;
    for (int32_t i = 0; i < STEP; i++, p += 4) {
        const int32_t a = 2 * p[3] - 255, g = 2 * p[1] - 255;
        more.count[0][p[3]]++;
        more.in_disc += a * a + g * g <= 255 * 255;
        if (p[3] >= visible)
            continue;
        if (more.clear > 0 && more.color != rgb_of(p))
            return false;
        more.color = rgb_of(p);
        more.clear++;
    }
    *to = more;
    return true;
}

static void check_alphas(const ntp__kernels_table *level, int32_t n, uint64_t *seed)
{
    guarded src = guarded_alloc((size_t) n * 4, random_bits(seed) & 1);
    uint8_t *const p = src.data;
    static ntp__alphas8 found, want;
    const int32_t visible = (int32_t) (random_bits(seed) % 2);
    int32_t end = 0;
    memset(&found, 0, sizeof found);
    memset(&want, 0, sizeof want);
    fill_alphas(p, n, seed);
    if (n > 0 && random_bits(seed) % 4 == 0) { /* some were counted before */
        found.clear = want.clear = 1;
        found.color = want.color = random_bits(seed) % 2 == 0 ? rgb_of(p) : 7;
    }
    while (end + STEP <= n && add_alphas(&want, p + 4 * end, visible))
        end += STEP;
    CHECK(level->count_alpha8(&found, p, n, visible) == end);
    for (int32_t a = 0; a < 256; a++)
        CHECK(found.count[0][a] + found.count[1][a] + found.count[2][a] + found.count[3][a] ==
              want.count[0][a]);
    CHECK(found.in_disc == want.in_disc && found.clear == want.clear);
    CHECK(found.clear == 0 || found.color == want.color);
    guarded_free(&src);
}

/* All pairs of alpha and green, each of one group. */
static void check_disc(const ntp__kernels_table *level)
{
    static ntp__alphas8 found;
    uint8_t texels[4 * STEP] = { 0 };
    for (int32_t pair = 0; pair < 65536; pair++) {
        const int32_t green = pair & 255, alpha = pair >> 8;
        const int32_t a = 2 * alpha - 255, g = 2 * green - 255;
        for (int32_t i = 0; i < STEP; i++) {
            texels[4 * i + 1] = (uint8_t) green;
            texels[4 * i + 3] = (uint8_t) alpha;
        }
        found.in_disc = 0;
        CHECK(level->count_alpha8(&found, texels, STEP, 0) == STEP);
        CHECK(found.in_disc == (a * a + g * g <= 255 * 255 ? STEP : 0));
    }
}

int main(void)
{
    const ntp__kernels_table *const level = ntp__kernels(NTP__CPU_ALL);
    uint64_t seed = 2718281828;
    if (level->sample8 == NULL)
        return SKIPPED;
    for (int32_t i = 0; i < TIMES; i++) {
        fill_squares(&seed);
        for (int32_t n = 0; n <= WIDEST; n++) {
            check_samples(level, n, 3 + i % 2, &seed);
            check_alphas(level, n, &seed);
        }
    }
    check_bright(level);
    check_disc(level);
    check_padding(&seed);
    return 0;
}
