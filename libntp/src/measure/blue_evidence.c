/* SPDX-License-Identifier: MIT */
/*
 * blue_evidence.c - how blue depends on red and green
 *
 * Standard and Z-zero ask for different blues only where a texel is tilted, so the two readings
 * are compared on tilted texels alone.  The regression of blue on the blue derived as standard has
 * slope 1 for standard and 2 for Z-zero.  It tells them apart even if blue is shifted or scaled.
 */
#include "texel/level.h"
#include "measure/tally.h"
#ifdef NTP_HAVE_AVX2
#  include "measure/dense_row_avx2.h"
#endif

/* In 8-bit levels. */
static const double GAP_THAT_TELLS = 1, OFF_MOST = 32, NEAR = 3, ABOVE = 4;

typedef struct blue_sums {
    double n, want, blue, want2, blue2, product;
    double tilted, gap, off[2], near[2], above;
} blue_sums;

static double magnitude(double v)
{
    return v < 0 ? -v : v;
}

/* What all texels share whose red and green leave the same z. */
typedef struct blue_row {
    double want[2], gap, n, blue, blue2;
} blue_row;

static blue_row row_of(double z)
{
    blue_row row = { .want = { 127.5 + 127.5 * z, 255 * z } };
    row.gap = row.want[0] - row.want[1];
    return row;
}

/* Adds `count` texels of a tilted row with this (mean) blue, at 8 bit. */
static inline void add_tilted(blue_sums *sums, const blue_row *row, double blue, double count)
{
    for (int32_t i = 0; i < 2; i++) {
        double off = magnitude(blue - row->want[i]);
        sums->off[i] += count * (off < OFF_MOST ? off : OFF_MOST);
        sums->near[i] += off <= NEAR ? count : 0;
    }
    sums->above += blue > row->want[0] + ABOVE ? count : 0;
}

static inline void add_row(blue_sums *sums, const blue_row *row)
{
    double want = row->want[0];
    sums->n += row->n;
    sums->want += row->n * want;
    sums->want2 += row->n * want * want;
    sums->blue += row->blue;
    sums->blue2 += row->blue2;
    sums->product += want * row->blue;
    if (row->gap <= GAP_THAT_TELLS)
        return;
    sums->tilted += row->n;
    sums->gap += row->n * row->gap;
}

#ifdef NTP_HAVE_AVX2
/* Adds a row of many colors.  Blues that do not occur add 0.  All sums but those of distances are of whole
 * numbers, so that their order does not matter. */
static void add_dense_row(blue_sums *sums, blue_row *row, const ntp_tally *t, int32_t i)
{
    ntp__dense_blues blues;
    const int32_t most = (int32_t) (row->want[0] + ABOVE);
    double off[2] = { sums->off[0], sums->off[1] };
    int64_t texels = 0, part = 0, part2 = 0, above = 0;
    ntp__dense_blues_avx2(&blues, &t->cells, i, row->want, OFF_MOST);
    for (int32_t b = 0; b < 256; b++) {
        const int64_t count = blues.count[b];
        off[0] += blues.off[0][b];
        off[1] += blues.off[1][b];
        texels += count;
        part += b * count;
        part2 += b * b * count;
        above += b > most ? count : 0;
    }
    row->n = (double) texels;
    row->blue = (double) part;
    row->blue2 = (double) part2;
    add_row(sums, row);
    if (row->gap <= GAP_THAT_TELLS)
        return;
    sums->above += (double) above;
    for (int32_t k = 0; k < 2; k++) {
        const double want = row->want[k];
        int64_t near = 0;
        for (int32_t b = (int32_t) want - 3; b < 256 && b - want <= NEAR; b++)
            near += b >= 0 && want - b <= NEAR ? blues.count[b] : 0;
        sums->off[k] = off[k];
        sums->near[k] += (double) near;
    }
}
#endif

static void add_cells(blue_sums *into, const ntp_tally *t)
{
    ntp__row_cells_fn *const read_row = ntp__row_reader();
    ntp__cells cells;
    blue_sums sums = { 0 }; /* in registers */
    for (int32_t i = 0; (i = ntp__next_row(t->cells.at.row_seen, i)) < NTP__ROWS; i++) {
        int64_t rest = ntp__rest(t->cells.row[i].pair & 255, t->cells.row[i].pair >> 8, 255);
        if (rest < 0)
            continue;
        blue_row row = row_of(sqrt((double) rest) / 255);
#ifdef NTP_HAVE_AVX2
        if (t->cells.at.row_seen[i] & NTP__SEEN_DENSE) {
            add_dense_row(&sums, &row, t, i);
            continue;
        }
#endif
        const int32_t n = read_row(&cells, &t->cells, i);
        /* Of a row that is not tilted, nothing is added to the sums of tilted ones. */
        const double part_of = row.gap > GAP_THAT_TELLS ? 1 : 0;
        uint64_t texels = 0, blue = 0, blue2 = 0;
        for (int32_t k = 0; k < n; k++) {
            const uint64_t b = (uint64_t) cells.blue[k], part = b * cells.count[k];
            texels += cells.count[k];
            blue += part;
            blue2 += b * part;
            add_tilted(&sums, &row, cells.blue[k], part_of * cells.count[k]);
        }
        row.n = (double) texels;
        row.blue = (double) blue;
        row.blue2 = (double) blue2;
        add_row(&sums, &row);
    }
    *into = sums;
}

/* A bit for each pair of a run that has texels. */
static inline uint32_t pairs_in_use(const ntp_tally *t, uint32_t place)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < NTP__PAIR_RUN; i += 16) {
        bits |= ntp__in_use16(&t->pairs[place + i]) << i;
        if (t->pairs_full)
            bits |= ntp__in_use16(&t->pair_texels[place + i]) << i;
    }
    return bits;
}

static inline void add_pair(blue_sums *sums, const ntp_tally *t, int32_t r, int32_t g)
{
    const int64_t rest = ntp__rest(r, g, 255);
    if (rest < 0)
        return;
    const ntp__pair pair = ntp__pair_at(t, ntp__pair_place((uint32_t) r, (uint32_t) g));
    blue_row row = row_of(sqrt((double) rest) / 255);
    const double texels = (double) (int64_t) pair.texels;
    const double blue = (double) (int64_t) pair.blue / texels;
    row.n = texels;
    row.blue = row.n * blue;
    row.blue2 = row.n * blue * blue;
    if (row.gap > GAP_THAT_TELLS)
        add_tilted(sums, &row, blue, row.n);
    add_row(sums, &row);
}

static void add_samples(blue_sums *into, const ntp_tally *t)
{
    blue_sums sums = { 0 }; /* in registers */
    for (int32_t i = 0; i < 65536; i += NTP__PAIR_RUN) {
        const int32_t r = i & 255, g = i >> 8;
        const uint32_t place = ntp__pair_place((uint32_t) r, (uint32_t) g);
        if (!t->pair_seen[place / NTP__PAIR_GROUP])
            continue;
        for (uint32_t bits = pairs_in_use(t, place); bits != 0; bits &= bits - 1)
            add_pair(&sums, t, r + __builtin_ctz(bits), g);
    }
    *into = sums;
}

static void describe_regression(ntp__evidence *e, const blue_sums *sums)
{
    double n = sums->n, want = sums->want / n, blue = sums->blue / n;
    double want_variance = sums->want2 / n - want * want;
    double blue_variance = sums->blue2 / n - blue * blue;
    double covariance = sums->product / n - want * blue;
    const double gentlest = 0.05; /* levels; below this there are hardly any slopes */
    if (255 - want > gentlest)
        e->blue_drop = (255 - blue) / (255 - want);
    const double least = 1e-6; /* below this only rounding of doubles is left */
    if (want_variance > least)
        e->blue_slope = covariance / want_variance;
    if (want_variance > least && blue_variance > least)
        e->blue_correlation = covariance / sqrt(want_variance * blue_variance);
}

void ntp__describe_blue(ntp__evidence *e, const ntp_tally *t)
{
    blue_sums sums = { 0 };
    e->blue_drop = 1;
    if (t->encoding == NTP_ENCODING_HEIGHT)
        return;
    if (ntp__tally_max(t) == 255)
        add_cells(&sums, t);
    else
        add_samples(&sums, t);
    if (sums.n > 0)
        describe_regression(e, &sums);
    e->tilted = (uint64_t) sums.tilted;
    if (sums.tilted == 0)
        return;
    e->tilted_gap = sums.gap / sums.tilted;
    e->tilted_above = sums.above / sums.tilted;
    for (int32_t i = 0; i < 2; i++) {
        e->tilted_off[i] = sums.off[i] / sums.tilted;
        e->tilted_near[i] = sums.near[i] / sums.tilted;
    }
}
