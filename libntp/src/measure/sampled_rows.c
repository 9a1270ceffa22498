/* SPDX-License-Identifier: MIT */
/*
 * sampled_rows.c - what is measured on some rows only, because it costs more than a count
 *
 * These are the correlations of channels, signs of gamma, and the steps between columns that lossy
 * compression leaves.  All of them are integer sums, so parts merge exactly.
 */
#include "texel/level.h"
#include "texel/srgb.h"
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

/* Is the length within 1/8 of 1 if the levels are decoded from sRGB first? */
static bool linear_near_unit(int32_t r, int32_t g, int32_t b)
{
    enum { M = 65535 };
    int64_t x = 2 * (int64_t) NTP__LINEAR_OF_SRGB[r] - M;
    int64_t y = 2 * (int64_t) NTP__LINEAR_OF_SRGB[g] - M;
    int64_t z = 2 * (int64_t) NTP__LINEAR_OF_SRGB[b] - M;
    int64_t square = x * x + y * y + z * z, unit = (int64_t) M * M;
    return 64 * square >= 49 * unit && 64 * square <= 81 * unit;
}

static bool near_gamma_flat(int32_t level)
{
    return level >= 185 && level <= 191;
}

static inline void add_color(ntp__samples *s, int32_t r, int32_t g, int32_t b)
{
    const uint32_t v[3] = { (uint32_t) r, (uint32_t) g, (uint32_t) b };
    s->n++;
    for (int32_t k = 0; k < 3; k++) {
        s->sum[k] += v[k];
        s->square[k] += v[k] * v[k];
    }
    s->product[0] += v[0] * v[1];
    s->product[1] += v[0] * v[2];
    s->product[2] += v[1] * v[2];
    s->red_low += r < 128;
    s->green_low += g < 128;
    s->gamma_flat += near_gamma_flat(r) && near_gamma_flat(g);
    s->gamma_unit += linear_near_unit(r, g, b);
}

static void add_samples(ntp__samples *a, const ntp__samples *b)
{
    a->n += b->n;
    for (int32_t k = 0; k < 3; k++) {
        a->sum[k] += b->sum[k];
        a->square[k] += b->square[k];
        a->product[k] += b->product[k];
    }
    a->red_low += b->red_low;
    a->green_low += b->green_low;
    a->gamma_flat += b->gamma_flat;
    a->gamma_unit += b->gamma_unit;
}

void ntp__merge_samples(ntp_tally *into, const ntp_tally *from)
{
    add_samples(&into->samples, &from->samples);
    add_samples(&into->padding_samples, &from->padding_samples);
    if (from->depth == 8)
        return;
    for (int32_t group = 0; group < 65536 / NTP__PAIR_GROUP; group++) {
        if (from->pair_seen[group] == 0)
            continue;
        into->pair_seen[group] = 1;
        for (int32_t i = group * NTP__PAIR_GROUP; i < (group + 1) * NTP__PAIR_GROUP; i++) {
            into->pair_texels[i] += from->pair_texels[i];
            into->pair_blue[i] += from->pair_blue[i];
        }
    }
}

void ntp__clear_samples(ntp_tally *t)
{
    memset(&t->samples, 0, sizeof t->samples);
    memset(&t->padding_samples, 0, sizeof t->padding_samples);
    if (t->depth == 8)
        return;
    for (int32_t group = 0; group < 65536 / NTP__PAIR_GROUP; group++) {
        int32_t first = group * NTP__PAIR_GROUP;
        if (t->pair_seen[group] == 0)
            continue;
        memset(&t->pair_texels[first], 0, NTP__PAIR_GROUP * sizeof t->pair_texels[0]);
        memset(&t->pair_blue[first], 0, NTP__PAIR_GROUP * sizeof t->pair_blue[0]);
    }
    memset(t->pair_seen, 0, sizeof t->pair_seen);
}

static void add_colors(ntp_tally *t, const ntp__block *block, int32_t first, int32_t n, int32_t m)
{
    bool picture = t->encoding == NTP_ENCODING_HEIGHT;
    ntp__samples sum = { 0 }; /* a local one can stay in registers */
    for (int32_t i = first; i < first + n; i++) {
        int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i], a = block->c[3][i];
        if ((block->any_broken && block->broken[i]) ||
            (!picture && ntp__unused(r, g, b, a, m, t->touched)))
            continue;
        if (m != 255) {
            r = ntp__narrow(r);
            g = ntp__narrow(g);
            b = ntp__narrow(b);
            int32_t pair = r | g << 8;
            t->pair_seen[pair / NTP__PAIR_GROUP] = 1;
            t->pair_texels[pair]++;
            t->pair_blue[pair] += (uint32_t) b;
        }
        add_color(&sum, r, g, b);
        if (ntp__is_padding(r, g, 255))
            add_color(&t->padding_samples, r, g, b);
    }
    add_samples(&t->samples, &sum);
}

/* Steps between neighboring columns are summed twice: inside blocks of 8 x 8, and across their
 * borders.  The texel before x0 is read where there is one. */
void ntp__sample_row(ntp_tally *t, const ntp_const_image *src, int32_t x0, int32_t x1, int32_t y)
{
    if (!is_sampled(src, y))
        return;
    ntp__block block;
    for (int32_t x = x0; x < x1; x += NTP__BLOCK - 1) {
        int32_t n = x1 - x < NTP__BLOCK - 1 ? x1 - x : NTP__BLOCK - 1, before = x > 0;
        ntp__unpack(&block, src, x - before, y, n + before);
        add_colors(t, &block, before, n, ntp__max(src->type));
        for (int32_t i = before == 0; i < n; i++) {
            int32_t across = (x + i) % 8 == 0, right = i + before;
            t->block_count[across]++;
            for (int32_t k = 0; k < 3; k++)
                t->block_steps[k][across] +=
                    (uint64_t) ntp__abs(block.c[k][right] - block.c[k][right - 1]);
        }
    }
}
