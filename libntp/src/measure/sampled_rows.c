/* SPDX-License-Identifier: MIT */
/*
 * sampled_rows.c - what is measured on some rows only, because it costs more than a count
 *
 * These are the correlations of channels, signs of gamma, and the steps between columns that lossy
 * compression leaves.  All of them are integer sums, so parts merge exactly.
 */
#include "base/inlining.h"
#include "texel/kernels.h"
#include "texel/level.h"
#include "texel/srgb.h"
#include "texel/unused.h"
#include "measure/tally.h"

/* Samples at least 64 rows, or all of a small image.  In a large image it is one row in 32.  Their
 * distance varies (multiples of the golden section, less their whole part): else bars of a width
 * of 2^n texels would be seen at the same place each time. */
static bool is_sampled(const ntp_const_image *src, int32_t y)
{
    enum { ROWS = 64, SPARSEST = 32 };
    const uint32_t golden_section = 2654435769u; /* of 2^32 */
    int32_t step = 1;
    while (step < SPARSEST && src->height >= 2 * step * ROWS)
        step *= 2;
    uint32_t part = (uint32_t) (y / step) * golden_section;
    return y % step == (int32_t) ((uint64_t) part * (uint32_t) step >> 32);
}

/* Fills linear_square, once. */
static void prepare_squares(ntp_tally *t)
{
    if (t->linear_square[0] != 0)
        return;
    for (int32_t i = 0; i < 256; i++) {
        const int32_t a = NTP__LINEAR_OF_SRGB[i] - 32768;
        t->linear_square[i] = (uint32_t) (a * (a + 1));
    }
}

/* Counts of a block of colors of 8 bit. */
static void count_signs(ntp__samples *s, const uint32_t *linear, const int32_t *r, const int32_t *g,
                        const int32_t *b, int32_t n)
{
    enum { LEAST = NTP__GAMMA_FLAT_LEAST, RANGE = NTP__GAMMA_FLAT_RANGE };
    int32_t red = 0, green = 0, flat = 0, unit = 0;
    for (int32_t i = 0; i < n; i++) {
        red += r[i] < 128;
        green += g[i] < 128;
        flat +=
            (r[i] >= LEAST) & (r[i] <= LEAST + RANGE) & (g[i] >= LEAST) & (g[i] <= LEAST + RANGE);
    }
    for (int32_t i = 0; i < n; i++)
        unit += ntp__linear_near_unit(linear[r[i]] + linear[g[i]] + linear[b[i]]);
    s->red_low += (uint32_t) red;
    s->green_low += (uint32_t) green;
    s->gamma_flat += (uint32_t) flat;
    s->gamma_unit += (uint32_t) unit;
}

/* Adds a block of colors of 8 bit.  These are loops over planes, as compilers make vectors of them;
 * the sums of a block fit into 32 bits. */
static void add_planes(ntp__samples *s, const uint32_t *linear, const int32_t *const c[3],
                       int32_t n)
{
    for (int32_t k = 0; k < 3; k++) {
        const int32_t *const v = c[k], *const p = c[k == 2], *const q = c[k == 0 ? 1 : 2];
        int32_t sum = 0, square = 0, product = 0;
        for (int32_t i = 0; i < n; i++) {
            sum += v[i];
            square += (int16_t) v[i] * (int16_t) v[i]; /* one instruction for two of these */
            product += (int16_t) p[i] * (int16_t) q[i];
        }
        s->sum[k] += (uint32_t) sum;
        s->square[k] += (uint32_t) square;
        s->product[k] += (uint32_t) product;
    }
    count_signs(s, linear, c[0], c[1], c[2], n);
    s->n += (uint32_t) n;
}

/* An entry of `pairs` has no room for its number of texels, 4096. */
static void empty_pair(ntp_tally *t, uint32_t place)
{
    t->pairs_full = 1;
    t->pair_texels[place] += UINT32_MAX / NTP__PAIR_TEXEL + 1;
    t->pair_blue[place] += t->pairs[place];
    t->pairs[place] = 0;
}

static void add_pairs(ntp_tally *t, const int32_t *const c[3], int32_t n)
{
    uint32_t places[NTP__BLOCK];
    for (int32_t i = 0; i < n; i++) {
        places[i] = ntp__pair_place((uint32_t) c[0][i], (uint32_t) c[1][i]);
#ifdef __GNUC__
        /* those of noise are in none of the first caches */
        __builtin_prefetch(&t->pairs[places[i]], 1);
#endif
    }
    for (int32_t i = 0; i < n; i++) {
        const uint32_t place = places[i];
        if (!t->pair_seen[place / NTP__PAIR_GROUP])
            ntp__begin_pairs(t, place / NTP__PAIR_GROUP);
        const uint32_t more = NTP__PAIR_TEXEL + (uint32_t) c[2][i];
        t->pairs[place] += more;
        if (t->pairs[place] < more)
            empty_pair(t, place);
    }
}

SELDOM static void add_padding(ntp__samples *s, const uint32_t *linear, const int32_t *const c[3],
                               int32_t n)
{
    int32_t padding[3][NTP__BLOCK], count = 0;
    const int32_t *const planes[3] = { padding[0], padding[1], padding[2] };
    for (int32_t i = 0; i < n; i++) {
        for (int32_t k = 0; k < 3; k++)
            padding[k][count] = c[k][i]; /* over one that is none */
        count += ntp__is_padding(c[0][i], c[1][i], 255) ? 1 : 0;
    }
    add_planes(s, linear, planes, count);
}

static bool any_padding(const int32_t *const c[3], int32_t n)
{
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++)
        any |= ntp__is_padding(c[0][i], c[1][i], 255);
    return any != 0;
}

/* Which of n texels from `first` on are used, at the front of `at`; returns how many. */
SELDOM static int32_t find_used(uint8_t at[NTP__BLOCK], const ntp_tally *t, const ntp__block *block,
                                int32_t first, int32_t n, int32_t m)
{
    const uint32_t touched =
        t->encoding == NTP_ENCODING_HEIGHT ? (uint32_t) NTP_UNUSED_ALL : t->touched;
    int32_t count = 0;
    for (int32_t i = 0; i < n; i++) {
        if (!ntp__texel_unused(block, first + i, m, touched))
            at[count++] = (uint8_t) i;
    }
    return count;
}

static void add_colors(ntp_tally *t, const ntp__block *block, int32_t first, int32_t n, int32_t m)
{
    int32_t used[3][NTP__BLOCK];
    const int32_t *c[3];
    for (int32_t k = 0; k < 3; k++) {
        c[k] = block->c[k] + first;
        for (int32_t i = 0; m != 255 && i < n; i++)
            used[k][i] = ntp__narrow(c[k][i]);
        c[k] = m != 255 ? used[k] : c[k];
    }
    if (ntp__any_suspect(block, first + n, m)) {
        uint8_t at[NTP__BLOCK];
        n = find_used(at, t, block, first, n, m);
        for (int32_t k = 0; k < 3; k++) {
            for (int32_t i = 0; i < n; i++)
                used[k][i] = c[k][at[i]]; /* not behind i */
            c[k] = used[k];
        }
    }
    if (m != 255)
        add_pairs(t, c, n);
    add_planes(&t->samples, t->linear_square, c, n);
    if (any_padding(c, n))
        add_padding(&t->padding_samples, t->linear_square, c, n);
}

/* Adds the steps to texels [first, n) of a block from the ones before; `x` is the column of texel 0. */
static void add_steps(ntp_tally *t, const ntp__block *block, int32_t first, int32_t n, int32_t x)
{
    for (int32_t k = 0; k < 3; k++) {
        const int32_t *const c = block->c[k];
        uint32_t all = 0, across = 0; /* less than 256 * 65535 */
        for (int32_t i = first; i < n; i++)
            all += (uint32_t) ntp__abs(c[i] - c[i - 1]);
        for (int32_t i = first + (-(x + first) & 7); i < n; i += 8)
            across += (uint32_t) ntp__abs(c[i] - c[i - 1]);
        t->block_steps[k][0] += all - across;
        t->block_steps[k][1] += across;
    }
    const int32_t border = first + (-(x + first) & 7);
    const int32_t count = border < n ? (n - border + 7) / 8 : 0;
    t->block_count[0] += (uint32_t) (n > first ? n - first - count : 0);
    t->block_count[1] += (uint32_t) count;
}

/* Adds packed texels, which have one before them, as far as that is quick; returns how many. */
static int32_t add_packed(ntp_tally *t, const uint8_t *p, int32_t n, int32_t channels, int32_t x)
{
    enum { MOST = 65536 };
    const uint32_t touched =
        t->encoding == NTP_ENCODING_HEIGHT ? (uint32_t) NTP_UNUSED_ALL : t->touched;
    const int32_t done =
        ntp__kernels(NTP__CPU_ALL)
            ->sample8(&t->samples, &t->padding_samples, t->block_steps, t->linear_square, p,
                      n < MOST ? n : MOST, channels, x, touched);
    t->block_count[0] += (uint32_t) (done - done / 8); /* whole groups */
    t->block_count[1] += (uint32_t) (done / 8);
    return done;
}

/* Steps between neighboring columns are summed twice: inside blocks of 8 x 8, and across their
 * borders.  The texel before x0 is read where there is one.  Of packed texels whole groups are left to the end. */
void ntp__sample_row(ntp_tally *t, const ntp_const_image *src, int32_t x0, int32_t x1, int32_t y)
{
    enum { MOST = NTP__BLOCK - 1, GROUP = NTP__KERNEL_STEP };
    if (!is_sampled(src, y))
        return;
    ntp__block block;
    prepare_squares(t);
    const bool packed = src->type == NTP_TYPE_U8 && src->channels >= 3 && ntp__is_packed(src) &&
                        ntp__kernels(NTP__CPU_ALL)->sample8 != NULL;
    for (int32_t x = x0, n; x < x1; x += n) {
        if (packed && x > 0 &&
            (n = add_packed(t, ntp__at(src, x, y), x1 - x, src->channels, x)) > 0)
            continue;
        n = x1 - x < MOST ? x1 - x : MOST;
        if (packed && x == 0)
            n = (x1 - 1) % GROUP + 1;
        const int32_t before = x > 0;
        ntp__unpack(&block, src, x - before, y, n + before);
        add_colors(t, &block, before, n, ntp__max(src->type));
        add_steps(t, &block, 1, n + before, x - before);
    }
}
