/* SPDX-License-Identifier: MIT */
/*
 * test_sums.c - counts of 16-bit texels that are exact, close to exact or far from it, against judging each
 */
#include "guarded.h"
#include "odd_texel.h"
#include "without_avx512.h"
#include "base/view.h"
#include "measure/far_texels.h"
#include "measure/judged_sums.h"
#include "texel/judged.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <stdlib.h>
#include <string.h>

enum { SKIPPED = 77 };

/* Sums of texels by three ways: close ones or exact ones counted, and each judged. */
typedef struct close_check {
    const ntp__kernels_table *level;
    ntp__sums some, exact, each, found, want;
    ntp__close_counts close, close_exact;
    ntp__far_counts far;
    ntp__block block;
    int32_t n;
} close_check;

/* The exact ones of n packed texels; the others go to `others`, behind `left` that are there. */
static int32_t add_exact_part(close_check *k, const uint16_t *rgb, int32_t n, ntp__block *others,
                              int32_t left)
{
    enum { STEP = 16 };
    bool is_left[NTP__BLOCK] = { false };
    const int32_t before = left;
    ntp__exact_block found;
    const int32_t done = n < STEP ? 0 : k->level->count_exact(&found, &k->close_exact, rgb, n);
    CHECK(done == n / STEP * STEP);
    if (done > 0)
        ntp__add_exact(&k->exact, &found);
    for (int32_t i = 0; done > 0 && i < done - found.texels; i++)
        is_left[found.left[i]] = true;
    for (int32_t i = 0; i < n; i++) {
        const int32_t c[3] = { rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2] };
        const bool other = i >= done || is_left[i];
        CHECK(other || !is_odd(c));
        for (int32_t e = 0; other && e < 3; e++)
            others->c[e][left] = c[e];
        left += other;
    }
    CHECK(done == 0 || found.texels == n - (left - before));
    for (int32_t e = 0; done > 0 && e < 3; e++) {
        int32_t least = 65535, greatest = 0;
        uint32_t sum = 0;
        for (int32_t i = 0; i < done; i++) {
            least = rgb[3 * i + e] < least ? rgb[3 * i + e] : least;
            greatest = rgb[3 * i + e] > greatest ? rgb[3 * i + e] : greatest;
            sum += rgb[3 * i + e];
        }
        CHECK(found.survey.least[e] == (uint32_t) least && found.survey.sum[e] == sum);
        CHECK(found.survey.greatest[e] == (uint32_t) greatest);
    }
    return left;
}

/* The exact texels of the block, packed.  Neighbors among them are of different groups, and two parts are
 * counted one after the other: so of any kind, a part has any number. */
static void add_exact_texels(close_check *k, int32_t n)
{
    uint16_t rgb[3 * NTP__BLOCK];
    ntp__block others;
    for (int32_t i = 0; i < n; i++) {
        const int32_t from = n == NTP__BLOCK ? i % 8 * 32 + i / 8 : i;
        for (int32_t e = 0; e < 3; e++)
            rgb[3 * i + e] = (uint16_t) k->block.c[e][from];
    }
    const int32_t cut = n == NTP__BLOCK ? (rgb[0] + rgb[1]) % NTP__BLOCK : 0;
    const int32_t left = add_exact_part(k, rgb, cut, &others, 0);
    const int32_t all = add_exact_part(k, rgb + 3 * cut, n - cut, &others, left);
    ntp__add_block(&k->exact, &others, NULL, all, 65535, NTP_ENCODING_STANDARD);
}

#ifdef NTP_HAVE_AVX512
static int compare_colors(const void *a, const void *b)
{
    return memcmp(a, b, 3 * sizeof(uint16_t));
}

/* Those of the texels, sorted, that are odd but for gray, or neighbors in an encoding; returns how many. */
static int32_t find_others(uint16_t (*others)[3], const uint16_t *rgb, int32_t n)
{
    static uint32_t ones[NTP__BLOCK];
    static ntp__judged j;
    static int32_t c[3][NTP__BLOCK];
    int32_t count = 0;
    for (int32_t i = 0; i < n; i++) {
        ones[i] = 1;
        for (int32_t e = 0; e < 3; e++)
            c[e][i] = rgb[3 * i + e];
    }
    ntp__kernels(0)->judge_block(&j, c[0], c[1], c[2], ones, n, 65535, 0);
    for (int32_t i = 0; i < n; i++) {
        const int32_t color[3] = { c[0][i], c[1][i], c[2][i] };
        if (is_odd_beside_gray(color) ||
            ((j.fit[0].key[i] | j.fit[1].key[i]) & NTP_FLAG_NEIGHBOR) != 0)
            memcpy(others[count++], rgb + (ptrdiff_t) 3 * i, sizeof others[0]);
    }
    qsort(others, (size_t) count, sizeof others[0], compare_colors);
    return count;
}

static void check_survey(const ntp__survey *survey, const uint16_t *rgb, int32_t n)
{
    for (int32_t e = 0; e < 3; e++) {
        uint32_t least = 65535, greatest = 0, sum = 0;
        for (int32_t i = 0; i < n; i++) {
            least = rgb[3 * i + e] < least ? rgb[3 * i + e] : least;
            greatest = rgb[3 * i + e] > greatest ? rgb[3 * i + e] : greatest;
            sum += rgb[3 * i + e];
        }
        CHECK(survey->least[e] == least && survey->greatest[e] == greatest &&
              survey->sum[e] == sum);
    }
    uint32_t gray = 0;
    for (int32_t i = 0; i < n; i++)
        gray += rgb[3 * i] == rgb[3 * i + 1] && rgb[3 * i] == rgb[3 * i + 2];
    CHECK(survey->gray == gray);
}

/* The same straight from packed pixels, between guard pages; the block becomes what is left. */
static int32_t add_packed(close_check *k, int32_t n)
{
    enum { GROUP = 16 };
    static uint16_t want[NTP__BLOCK][3], left[NTP__BLOCK][3];
    ntp__survey survey;
    guarded g = guarded_alloc((size_t) n * 6, n % (2 * GROUP) == 0);
    uint16_t *const rgb = g.data;
    for (int32_t i = 0; i < 3 * n; i++)
        rgb[i] = (uint16_t) k->block.c[i % 3][i / 3];
    int32_t done = n;
    const int32_t count =
        ntp__add_far_rgb_avx512(&k->some, &k->far, &survey, &k->block, rgb, &done);
    CHECK(done == n);
    check_survey(&survey, rgb, n);
    /* all others, and up to 15 more */
    const int32_t others = find_others(want, rgb, n);
    CHECK(count >= others && count < others + GROUP && (count == n || (n - count) % GROUP == 0));
    for (int32_t i = 0; i < count; i++) {
        for (int32_t e = 0; e < 3; e++)
            left[i][e] = (uint16_t) k->block.c[e][i];
    }
    qsort(left, (size_t) count, sizeof left[0], compare_colors);
    for (int32_t i = 0, at = 0; i < others; i++, at++) {
        while (at < count && memcmp(left[at], want[i], sizeof want[0]) != 0)
            at++;
        CHECK(at < count);
    }
    guarded_free(&g);
    return count;
}

#else
static int32_t add_packed(close_check *k, int32_t n)
{
    (void) k;
    return n;
}
#endif

static void end_close_block(close_check *k, int32_t n)
{
    if (k->level->count_exact != NULL)
        add_exact_texels(k, n);
    ntp__add_block(&k->each, &k->block, NULL, n, 65535, NTP_ENCODING_STANDARD);
    if (n % 16 == 0 && n > 0 && ntp__cpu_has_avx512(NTP__CPU_ALL))
        n = add_packed(k, n);
    k->far.skip = 0; /* look at all */
    ntp__add_close_block(&k->some, &k->close, &k->far, &k->block, n);
    k->n = 0;
}

/* Adds a group of texels (x, y, z) with any signs of x and y, whichever is which; z = b - K.  They
 * are close all together, or else none is counted as such. */
static void add_close_group(close_check *k, uint64_t *seed, int64_t x, int64_t y, int64_t z)
{
    enum { K = 32768, GROUP = 8 };
    if (z < -K || z >= K)
        return;
    const uint32_t all = random_bits(seed);
    for (int32_t i = 0; i < GROUP; i++) {
        const uint32_t bits = all >> i;
        const int32_t r = (int32_t) (bits & 1 ? K + x : K - 1 - x);
        const int32_t g = (int32_t) (bits & 2 ? K + y : K - 1 - y);
        k->block.c[0][k->n] = bits & 4 ? r : g;
        k->block.c[1][k->n] = bits & 4 ? g : r;
        k->block.c[2][k->n++] = (int32_t) (K + z);
    }
    if (k->n == NTP__BLOCK)
        end_close_block(k, all % 4 == 0 ? NTP__BLOCK - (int32_t) (all >> 16) % GROUP : NTP__BLOCK);
}

/* Near t = x(x + 1) + y(y + 1) + z(z + 1) - A_M + 1 = add + of_z * z + of_k * k, k being the sum
 * that neighbors are found by: one verdict or another changes there. */
static void add_near_edge(close_check *c, uint64_t *seed, int64_t add, int64_t of_z, int64_t of_k)
{
    enum { K = 32768, TRIED = 250 };
    const int64_t am = (int64_t) K * (K - 1), x = (int64_t) (random_bits(seed) % (K - 1));
    const int64_t z = (int64_t) ntp__isqrt((uint64_t) (am - 1 - x * (x + 1))) + 2 -
                      (int64_t) (random_bits(seed) % 5);
    int64_t best = -1, off = INT64_MAX;
    for (int64_t y = 0; y < TRIED; y++) {
        const int64_t t = x * (x + 1) + y * (y + 1) + z * (z + 1) - am + 1;
        const int64_t from = t - (add + of_z * z + of_k * (x + y + z + 3));
        if ((from < 0 ? -from : from) < off) {
            off = from < 0 ? -from : from;
            best = y;
        }
    }
    add_close_group(c, seed, x, best, z);
}

static void add_edges(close_check *k, uint64_t *seed)
{
    static const int32_t LENGTHS[] = { 0, -16382, 16384, -49150, 49150 };
    static const int32_t TIMES[][2] = { { -3, 0 }, { -1, 0 }, { 1, 0 }, { 3, 0 },
                                        { 0, -2 }, { 0, -1 }, { 0, 1 }, { 0, 2 } };
    for (int32_t i = 0; i < 20000; i++) {
        const int64_t more = (int64_t) (random_bits(seed) % 5) - 2;
        const int32_t *const times = TIMES[i % 8];
        add_near_edge(k, seed, LENGTHS[i % 5] + more, 0, 0);
        add_near_edge(k, seed, more * 2, times[0], times[1]);
    }
    /* squares of x, y where steepness is another one */
    for (int64_t i = 1; i < 8; i++) {
        for (int64_t x = 0; x < 32768; x++) {
            const int64_t rest = i * i * (32768 * 32767 / 64) - x * (x + 1);
            const int64_t y = rest >= 0 ? (int64_t) ntp__isqrt((uint64_t) rest) : 0;
            if (rest < 0 || rest - y * (y + 1) > 2 || rest - y * (y + 1) < -2)
                continue;
            const int64_t s = ntp__rest((int32_t) (32768 + x), (int32_t) (32768 + y), 65535);
            add_close_group(k, seed, x, y, (int64_t) ntp__isqrt((uint64_t) s) / 2);
        }
    }
}

/* Compares sums of two ways.  Of Z-zero, steepness is not told apart. */
static void check_same_sums(close_check *k, const ntp__sums *some, ntp__close_counts *close,
                            ntp__far_counts *far)
{
    static const ntp__close_counts none;
    static const ntp__far_counts none_far;
    ntp__clear_sums(&k->found);
    ntp__merge_sums(&k->found, some);
    ntp__take_close(&k->found, close);
    ntp__merge_far(&k->found, far, some);
    ntp__clear_far(far, some);
    CHECK(memcmp(&none, close, sizeof none) == 0);
    /* NOLINTNEXTLINE: it was zero-filled, padding included */
    CHECK(memcmp(&none_far, far, sizeof none_far) == 0);
    const ntp__sums *const f = &k->found, *const w = &k->want;
    const ntp__fit_sums *const a = &f->fit[1], *const b = &w->fit[1];
    CHECK(f->texels == w->texels);
    CHECK(memcmp(&f->fit[0], &w->fit[0], sizeof f->fit[0]) == 0);
    CHECK(f->angles.texels == w->angles.texels && f->angles.sum == w->angles.sum);
    CHECK(f->angles.max == w->angles.max);
    CHECK(memcmp(f->angles.bins, w->angles.bins, sizeof f->angles.bins) == 0);
    for (int32_t i = 0; i < NTP__ALL_HARM; i++) {
        const ntp__harm_sums *const one = &f->harm[i], *const other = &w->harm[i];
        CHECK(one->texels == other->texels && one->sum == other->sum && one->max == other->max);
        CHECK(memcmp(one->bins, other->bins, sizeof one->bins) == 0);
    }
    for (int32_t i = 0; i < 256; i++) {
        uint32_t more = 0;
        for (int32_t bin = 0; bin < NTP__ALL_BINS; bin++)
            more += a->flags[bin * 256 + i] - b->flags[bin * 256 + i];
        CHECK(more == 0);
    }
    CHECK(memcmp(a->lengths, b->lengths, sizeof a->lengths) == 0);
    CHECK(memcmp(a->levels_off, b->levels_off, sizeof a->levels_off) == 0);
    CHECK(a->length_sum == b->length_sum && a->levels_off_max == b->levels_off_max);
    CHECK(a->length_error2[0] == b->length_error2[0] && a->length_error2[1] == b->length_error2[1]);
    CHECK(a->length_max == b->length_max && a->length_inverted_min == b->length_inverted_min);
}

static void check_close(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { NEAR_FLAT = 400, NEARLY_FLAT = 1100, RANDOM = 100000 };
    static close_check k;
    k.level = level;
    for (int32_t x = 0; x < NEAR_FLAT; x++) {
        for (int32_t y = 0; y <= x; y++) {
            for (int32_t z = 32763; z < 32768; z++)
                add_close_group(&k, seed, x, y, z);
        }
    }
    /* all that are exact, and where blue is at least 65535 - 17 */
    for (int32_t x = 0; x < NEARLY_FLAT; x++) {
        for (int32_t y = 0; y <= x; y++) {
            const int64_t s = ntp__rest(x + 32768, y + 32768, 65535);
            add_close_group(&k, seed, x, y, ntp__blue_of_rest(s, 65535, false) - 32768);
        }
    }
    /* and where red and green are those of 8 bit, times 257 */
    for (int32_t x = 128; x < 32768; x += 257) {
        for (int32_t y = 128; y <= x; y += 257) {
            const int64_t s = ntp__rest(x + 32768, y + 32768, 65535);
            if (s >= 0)
                add_close_group(&k, seed, x, y, ntp__blue_of_rest(s, 65535, false) - 32768);
        }
    }
    add_edges(&k, seed);
    /* first most are exact, then few */
    for (int32_t i = 0; i < 4 * RANDOM; i++) {
        const int32_t x = (int32_t) (random_bits(seed) % 32768),
                      y = (int32_t) (random_bits(seed) % 32768);
        const int64_t s = ntp__rest(x + 32768, y + 32768, 65535);
        const bool other = i < RANDOM ? random_bits(seed) % 256 == 0 : random_bits(seed) % 4 > 0;
        if (s >= 0)
            add_close_group(&k, seed, x, y, ntp__blue_of_rest(s, 65535, false) - 32768 + other);
        else if (other)
            add_close_group(&k, seed, x, y, -x);
    }
    end_close_block(&k, k.n);
    ntp__merge_sums(&k.want, &k.each);
    check_same_sums(&k, &k.some, &k.close, &k.far);
    if (level->count_exact == NULL)
        return;
    static ntp__close_counts merged, none;
    ntp__merge_close(&merged, &k.close_exact, &k.exact);
    CHECK(memcmp(&merged, &k.close_exact, offsetof(ntp__close_counts, exact)) == 0);
    check_same_sums(&k, &k.exact, &merged, &k.far);
    ntp__clear_close(&k.close_exact, &k.exact);
    CHECK(memcmp(&none, &k.close_exact, sizeof none) == 0);
}

/* Of red or green: any level, or one near an end, zero, or where padding begins. */
static int32_t edgy_level(uint64_t *seed)
{
    static const int32_t NEAR[] = { 1, 16 * 257 - 128, 32767, 65535 - 16 * 257 + 128, 65534 };
    const uint32_t kind = random_bits(seed) % 16;
    const int32_t level =
        kind < 5 ? NEAR[kind] - 2 + (int32_t) (random_bits(seed) % 5) : random_level(seed, 65535);
    return level < 0 ? 0 : level > 65535 ? 65535 : level;
}

/* A green with which x(x + 1) + y(y + 1) is near this, or where `inner` is, that of x - 1 and y - 1. */
static int32_t green_near(uint64_t *seed, int32_t r, int64_t square, int32_t inner)
{
    const int64_t x = (r < 32768 ? 32767 - r : r - 32768) - inner;
    const int64_t rest = square - x * (x + 1) + (int64_t) (random_bits(seed) % 3) - 1;
    const int64_t y = rest < 0 ? 0 : (int64_t) ntp__isqrt((uint64_t) rest);
    const int32_t more = inner + (int32_t) (random_bits(seed) % 3) - 1;
    const int32_t up = y + more > 32767 ? 32767 : y + more < 0 ? 0 : (int32_t) y + more;
    return random_bits(seed) & 1 ? 32768 + up : 32767 - up;
}

/* Texels that are far from exact: noise, and such where steepness or a verdict changes. */
static void check_far(uint64_t *seed)
{
    enum { AM = 32768 * 32767, TEXELS = 4000000, STEEP = 200000 };
    const int64_t limit = (int64_t) ((NTP__FAR_SQUARED * (65535.0 * 65535.0) - 2) / 4);
    static close_check k, whole;
    k.level = ntp__kernels(0);
    for (int32_t i = 0; i < TEXELS; i++) {
        const uint32_t kind = i < TEXELS / 2 ? 0 : random_bits(seed) % 16;
        int32_t r = random_level(seed, 65535), g = random_level(seed, 65535);
        int32_t b = random_level(seed, 65535);
        if (kind > 0)
            r = edgy_level(seed);
        if (kind > 7)
            g = edgy_level(seed);
        else if (kind > 1)
            g = green_near(seed, r, (int64_t) kind * kind * (AM / 64), 0);
        else if (kind > 0)
            g = green_near(seed, r, random_bits(seed) & 1 ? AM : limit, random_bits(seed) & 1);
        if (kind % 4 == 1)
            b = edgy_level(seed);
        k.block.c[0][k.n] = r;
        k.block.c[1][k.n] = g;
        k.block.c[2][k.n++] = b;
        if (k.n == NTP__BLOCK || (k.n > 100 && random_bits(seed) % 256 == 0))
            end_close_block(&k, k.n);
    }
    end_close_block(&k, k.n);
    /* steep ones where neighbors in Z-zero begin and end: groups of eight, as add_close_group takes them */
    for (int32_t i = 0; i < STEEP; i++) {
        const int64_t x = (int64_t) (random_bits(seed) % 32767), rest = AM - 1 - x * (x + 1);
        const int64_t y = (int64_t) ntp__isqrt((uint64_t) rest) - (int64_t) (random_bits(seed) % 8);
        const int64_t inner = rest - y * (y + 1) + 2 * (x + y), outer = inner - 4 * (x + y) - 4;
        const int64_t square = outer >= 0 && i % 2 == 0 ? outer : inner;
        if (y >= 0 && square >= 0)
            add_close_group(&k, seed, x, y,
                            2 * (int64_t) ntp__isqrt((uint64_t) square) + i / 2 % 4 - 32768);
    }
    /* where pairs are too long even one level further in, or just not */
    for (int64_t x = 1; x < 32768; x++) {
        const int64_t rest = AM - x * (x - 1), y = (int64_t) ntp__isqrt((uint64_t) rest) + 1;
        const int64_t from = y * (y - 1) - rest;
        if (y < 32768 && from >= -2 && from <= 2)
            add_close_group(&k, seed, x, y, (int64_t) random_level(seed, 65535) - 32768);
    }
    end_close_block(&k, k.n);
    ntp__merge_sums(&k.want, &k.each);
    ntp__merge_sums(&whole.want, &k.each);
    /* what merging adds is not lost by clearing */
    ntp__merge_sums(&whole.some, &k.some);
    ntp__merge_far(&whole.some, &k.far, &k.some);
    ntp__merge_close(&whole.close, &k.close, &k.some);
    check_same_sums(&whole, &whole.some, &whole.close, &whole.far);
    check_same_sums(&k, &k.some, &k.close, &k.far);
}

#ifdef NTP_HAVE_AVX512
/* Packed rows of noise, one exact texel in `one_in`: where these are rare, thousands are added at once.  Or none
 * (0), and all point down, so angles are the greatest that there are.  Returns how many at most. */
static int32_t check_long_row(uint64_t *seed, int32_t n, uint32_t one_in)
{
    static close_check k;
    guarded g = guarded_alloc((size_t) n * 6, n % 2 == 0);
    uint16_t *const rgb = g.data;
    memset(&k, 0, sizeof k);
    for (int32_t i = 0; i < n; i++) {
        const uint32_t rg = random_bits(seed);
        int32_t c[3] = { (int32_t) (rg & 65535), (int32_t) (rg >> 16),
                         (int32_t) (random_bits(seed) >> 16) };
        const int64_t s = ntp__rest(c[0], c[1], 65535);
        if (one_in > 0 && s >= 0 && random_bits(seed) % one_in == 0)
            c[2] = ntp__blue_of_rest(s, 65535, false);
        else if (n % 2 == 0 && c[0] % 4 != 0)
            c[0] = c[1] = c[2];
        for (int32_t e = 0; e < 3; e++)
            rgb[3 * i + e] = (uint16_t) (one_in > 0 ? c[e]
                                         : e < 2    ? 32768 + c[e] / 256
                                                    : c[2] / 1024);
    }
    int32_t at = 0, most = 0;
    while (n - at >= 16) {
        ntp__survey survey;
        int32_t done = n - at;
        const int32_t left =
            ntp__add_far_rgb_avx512(&k.some, &k.far, &survey, &k.block, rgb + 3 * at, &done);
        CHECK(done > 0 && done <= n - at && done % 16 == 0 && left <= NTP__BLOCK);
        CHECK(done >= (n - at < NTP__BLOCK ? (n - at) / 16 * 16 : NTP__BLOCK));
        check_survey(&survey, rgb + 3 * at, done);
        ntp__add_block(&k.some, &k.block, NULL, left, 65535, NTP_ENCODING_STANDARD);
        most = done > most ? done : most;
        at += done;
    }
    for (int32_t x = 0; x < n; x += NTP__BLOCK) {
        const int32_t part = n - x < NTP__BLOCK ? n - x : NTP__BLOCK;
        for (int32_t i = 0; i < 3 * part; i++)
            k.block.c[i % 3][i / 3] = rgb[3 * x + i];
        ntp__add_block(&k.each, &k.block, NULL, part, 65535, NTP_ENCODING_STANDARD);
        if (x + part > at) { /* the last few */
            for (int32_t i = 0; i < 3 * (n - at); i++)
                k.block.c[i % 3][i / 3] = rgb[3 * at + i];
            ntp__add_block(&k.some, &k.block, NULL, n - at, 65535, NTP_ENCODING_STANDARD);
        }
    }
    ntp__merge_sums(&k.want, &k.each);
    check_same_sums(&k, &k.some, &k.close, &k.far);
    guarded_free(&g);
    return most;
}
#endif

int main(int argc, char **argv)
{
    allowed_512 = argc > 1 && strcmp(argv[1], "avx512") == 0;
    const bool avx2 = allowed_512 || (argc > 1 && strcmp(argv[1], "avx2") == 0);
    if ((avx2 && !ntp__cpu_has_avx2(NTP__CPU_ALL)) ||
        (allowed_512 && !ntp__cpu_has_avx512(NTP__CPU_ALL)))
        return SKIPPED;
    ntp__kernels_table level;
    ntp__pick_kernels(&level, allowed_512 ? NTP__CPU_ALL : avx2 ? NTP__CPU_AVX2 : 0);
    uint64_t seed = 2026;
    printf("level %s\n", allowed_512 ? "avx512" : level.name);
    check_close(&level, &seed);
    if (avx2)
        check_far(&seed);
#ifdef NTP_HAVE_AVX512
    int32_t most = 0;
    for (int32_t n = 16; allowed_512 && n < 20000; n += n / 3) {
        const int32_t down = check_long_row(&seed, n, 0), rare = check_long_row(&seed, n, 4000);
        CHECK(check_long_row(&seed, n, 12) > 0);
        most = rare > most ? rare : down > most ? down : most;
    }
    CHECK(!allowed_512 || most >= 1024);
#endif
    return 0;
}
