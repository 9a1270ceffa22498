/* SPDX-License-Identifier: MIT */
/*
 * blue_evidence.c - how blue depends on red and green
 *
 * Standard and Z-zero ask for different blues only where a texel is tilted, so the two readings
 * are compared on tilted texels alone.  The regression of blue on the blue derived as standard has
 * slope 1 for standard and 2 for Z-zero.  It tells them apart even if blue is shifted or scaled.
 */
#include "texel/level.h"
#include "base/cpu.h"
#include "measure/blue_row.h"
#include "measure/tally.h"
#ifdef NTP_HAVE_AVX2
#  include "measure/dense_row_avx2.h"
#endif

static const double GAP_THAT_TELLS = 1; /* levels of 8 bit */

typedef ntp__blue_sums blue_sums;
typedef ntp__blue_row blue_row;

/* What is wanted of a row; what is added up of it is not set.  It is filled in place: code that is made small
 * clears and copies structs by instructions that take longer than all the rest. */
static inline void begin_row(blue_row *row, int64_t rest)
{
    const double z = sqrt((double) rest) / 255;
    row->want[0] = 127.5 + 127.5 * z;
    row->want[1] = 255 * z;
    row->gap = row->want[0] - row->want[1];
    row->is_tilted = row->gap > GAP_THAT_TELLS;
}

/* Adds `count` texels of a tilted row with this (mean) blue, at 8 bit.  Without branches, which are hard to
 * foresee. */
static inline void add_tilted(blue_sums *sums, const blue_row *row, double blue, double count)
{
    for (int32_t i = 0; i < 2; i++) {
        double off = fabs(blue - row->want[i]);
        sums->off[i] += count * (off < NTP__BLUE_OFF_MOST ? off : NTP__BLUE_OFF_MOST);
        sums->near[i] += count * (off <= NTP__BLUE_NEAR);
    }
    sums->above += count * (blue > row->want[0] + NTP__BLUE_ABOVE);
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
    if (!row->is_tilted)
        return;
    sums->tilted += row->n;
    sums->gap += row->n * row->gap;
}

/* The cells of a row. */
static void add_blues(blue_sums *sums, blue_row *row, const ntp__cells *cells, int32_t n)
{
    uint64_t texels = 0, blue = 0, blue2 = 0;
    for (int32_t k = 0; k < n; k++) {
        const uint64_t b = (uint64_t) cells->blue[k], part = b * cells->count[k];
        texels += cells->count[k];
        blue += part;
        blue2 += b * part;
        if (row->is_tilted)
            add_tilted(sums, row, cells->blue[k], cells->count[k]);
    }
    row->n = (double) texels;
    row->blue = (double) blue;
    row->blue2 = (double) blue2;
}

typedef void add_blues_fn(blue_sums *sums, blue_row *row, const ntp__cells *cells, int32_t n);

static add_blues_fn *blues_adder(void)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        return ntp__add_blues_avx2;
#endif
    return add_blues;
}

/* The cells of a row; of a dense one also those of no texels. */
static inline int32_t read_cells(ntp__cells *cells, const ntp_tally *t, int32_t row,
                                 ntp__row_cells_fn *read_row)
{
#ifdef NTP_HAVE_AVX2
    if (t->cells.at.row_seen[row] & NTP__SEEN_DENSE) {
        ntp__dense_cells_avx2(cells, &t->cells, row);
        return 256;
    }
#endif
    return read_row(cells, &t->cells, row);
}

static void add_cells(blue_sums *sums, const ntp_tally *t)
{
    ntp__row_cells_fn *const read_row = ntp__row_reader();
    add_blues_fn *const add = blues_adder();
    ntp__cells cells;
    for (int32_t i = 0; (i = ntp__next_row(t->cells.at.row_seen, i)) < NTP__ROWS; i++) {
        int64_t rest = ntp__rest(t->cells.row[i].pair & 255, t->cells.row[i].pair >> 8, 255);
        if (rest < 0)
            continue;
        blue_row row;
        begin_row(&row, rest);
        add(sums, &row, &cells, read_cells(&cells, t, i, read_row));
        add_row(sums, &row);
    }
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
    blue_row row;
    begin_row(&row, rest);
    const double texels = (double) (int64_t) pair.texels;
    const double blue = (double) (int64_t) pair.blue / texels;
    row.n = texels;
    row.blue = row.n * blue;
    row.blue2 = row.n * blue * blue;
    if (row.is_tilted)
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
