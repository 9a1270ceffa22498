/* SPDX-License-Identifier: MIT */
/*
 * dense_row_avx2.c - adds rows of cells of which many hold counts to the sums, with AVX2
 *
 * All texels of a row have the same |x| and |y|.  Then each question about blue splits the 256 blues into a
 * few runs, which sums of all counts below a blue answer.  Lengths, angles and how far blue is off depend on
 * v = x(x + 1) + y(y + 1) alone.  Of rows on the disc three fifths have different ones, so those that have
 * the same are added up first.  How far blue is off is added as a whole, beginning at the derived one.
 * Z = 2u + 1 and -Z have the same length in the standard encoding, and so has a blue of Z in Z-zero.
 *
 * Notation is that of texel/judge_tmpl.h.  Other files judge color by color; all counts are the same.
 */
#include "measure/dense_row_avx2.h"

#include "base/inlining.h"
#include "texel/angle_series.h"

#include <immintrin.h>
#include <stdlib.h>
#include <string.h>

enum {
    M = 255,
    K = 128,
    AM = K * (K - 1),
    HALF = 128, /* blues on each side of the horizon, by u */
    /* Angles: of texels above the horizon, of those below it, and of these to the other z */
    ABOVE = 0,
    BELOW = HALF,
    MIRRORED = 2 * HALF,
    ANGLES = 3 * HALF,
    SPARE = 8
};

/* Rows on the disc of one v, or one row; and their counts. */
typedef struct dense_rows {
    int32_t k1, k2;     /* of one of them */
    int32_t v, e;       /* v = x(x + 1) + y(y + 1), e = A_M - 1 - v */
    int32_t root, want; /* of the derived blue: K + root, and in Z-zero; of e >= 0 */
    uint32_t common;    /* steepness * 256 + flags of red and green */
    bool on_disc, padding;
    bool pair; /* red and green are too long by more than rounding: all fail */
    uint32_t texels;
    uint32_t blue[256];             /* the counts */
    uint32_t failing[HALF + SPARE]; /* of blues above the horizon; and of the one next to it */
    uint32_t reversed[256];         /* from blue 255 down */
    uint32_t both[HALF];            /* of both signs of z, by u */
    int32_t ends[2], u_ends[2];     /* the first and the last blue, and u, with a count */
} dense_rows;

/* The first and the last of these that hold counts; some do. */
ONE_COPY static void find_ends(int32_t ends[2], const uint32_t *count, int32_t n)
{
    ends[0] = 0;
    ends[1] = n - 1;
    while (count[ends[0]] == 0)
        ends[0]++;
    while (count[ends[1]] == 0)
        ends[1]--;
}

/* Of no rows yet. */
ONE_COPY static void begin(dense_rows *d, int32_t k1, int32_t k2)
{
    const int32_t v = k1 * (k1 + 1) + k2 * (k2 + 1), e = AM - 1 - v, low = 16;
    const int32_t far = (int32_t) ((NTP__FAR_SQUARED * (M * M) - 2) / 4);
    uint32_t bin = 0;
    memset(d, 0, sizeof *d);
    d->k1 = k1;
    d->k2 = k2;
    d->v = v;
    d->e = e;
    d->on_disc = e >= 0;
    d->padding = k1 >= K - low && k2 >= K - low;
    d->pair = v - 2 * (k1 + k2) >= AM;
    while (bin + 1 < NTP__STEEPNESS_BINS && v >= (int32_t) ((bin + 1) * (bin + 1)) * (AM / 64))
        bin++;
    d->common = (d->padding ? NTP__PADDING_BIN : bin) * 256 | (v > far ? NTP__FAR : 0) |
                (v >= AM ? NTP_FLAG_XY_TOO_LONG : 0);
    if (d->on_disc) {
        d->root = (int32_t) sqrt((double) e);
        const int32_t rest = e - d->root * d->root;
        d->want = 2 * d->root + (2 * rest + 1 >= d->root) + (2 * rest >= 3 * d->root);
    }
}

/* What is derived of the counts, once they are complete. */
ONE_COPY static void turn_around(dense_rows *d)
{
    for (int32_t b = 0; b < 256; b++)
        d->reversed[b] = d->blue[255 - b];
    for (int32_t u = 0; u < HALF; u++)
        d->both[u] = d->blue[K + u] + d->reversed[K + u];
    find_ends(d->ends, d->blue, 256);
    find_ends(d->u_ends, d->both, HALF);
}

/* Verdicts by u or by blue: neighbors, those of them that are rounded, and what is long.  The places where
 * each of these begins and ends, from 0 to all, in this order. */
typedef struct runs {
    int32_t ends[6], is_long;
} runs;

static inline int32_t at_least(int32_t v, int32_t least)
{
    return v > least ? v : least;
}

/* How many i of 0 <= i < n have i * i + c * i <= limit, for c from -2 to 3: these are the first ones, if the
 * limit is not -1 where c is -2. */
ONE_COPY static int32_t up_to(int32_t limit, int32_t c, int32_t n)
{
    const int32_t square = 4 * limit + c * c;
    if (square < 0)
        return 0;
    const int32_t count = ((int32_t) sqrt((double) square) - c + 2) / 2;
    return count < n ? count : n;
}

/* Limits of i * i + (c - less) * i: up to the first four no neighbor is left, nothing rounded is left, all is
 * rounded, and all are neighbors; up to the last one nothing is long. */
typedef int32_t limits[5];

ONE_COPY static void find_runs(runs *to, int32_t n, int32_t less, const limits limit)
{
    static const int8_t c[] = { 3, 2, 0, -1 };
    to->ends[0] = 0;
    for (int32_t i = 0; i < 4; i++)
        to->ends[i + 1] = at_least(up_to(limit[i], c[i] - less, n), to->ends[i]);
    to->ends[5] = n;
    to->is_long = up_to(limit[4], 1 - less, n);
}

static const uint8_t FLAGS_OF_RUNS[] = { 0, NTP_FLAG_NEIGHBOR, NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED,
                                         NTP_FLAG_NEIGHBOR, 0 };

/* The flags of one place. */
ONE_COPY static uint32_t flags_at(const runs *r, int32_t i)
{
    int32_t k = 0;
    while (i >= r->ends[k + 1])
        k++;
    return FLAGS_OF_RUNS[k] | (i >= r->is_long ? NTP__LONG : 0);
}

/* Adds the texels of each run, as of sums of counts that rise, or fall, by these steps. */
ONE_COPY static void add_runs(uint32_t *flags, const runs *r, const uint32_t *below, int32_t step)
{
    for (int32_t k = 0; k < 5; k++) {
        const int32_t from = r->ends[k], end = r->ends[k + 1];
        const int32_t most = r->is_long < end ? r->is_long : end, middle = at_least(most, from);
        const uint32_t short_ones = below[step * middle] - below[step * from];
        const uint32_t long_ones = below[step * end] - below[step * middle];
        uint32_t *const to = flags + FLAGS_OF_RUNS[k];
        to[0] += (uint32_t) step * short_ones;
        to[NTP__LONG] += (uint32_t) step * long_ones;
    }
}

static inline void mark(uint32_t *flags, uint32_t key, uint32_t more, uint32_t count)
{
    flags[key] -= count;
    flags[key | more] += count;
}

ONE_COPY static void add_counts(uint32_t *restrict into, const uint32_t *restrict from, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        into[i] += from[i];
}

/* Adds the verdicts of one row: the conditions of judge_levels, solved for u and b.  `below` says how many texels
 * have a blue below each one. */
ONE_COPY static void add_verdicts(ntp__sums *sums, dense_rows *d, int32_t kxy,
                                  const uint32_t *count, const uint32_t *below)
{
    uint32_t *const standard = sums->fit[0].flags + d->common, *const zzero =
                                                                   sums->fit[1].flags + d->common;
    const int32_t e = d->e;
    const limits standard_limits = { e - 2 * kxy - 2, e - kxy, e + kxy - 1, e + 2 * kxy - 4, e };
    const limits zzero_limits = { 4 * (e - 2 * kxy) + 1, 4 * (e + 1 - kxy), 4 * (e + kxy - 1),
                                  4 * (e + 2 * (kxy - 2)) + 2, 4 * e + 3 };
    runs r[2];
    find_runs(&r[0], HALF, 0, standard_limits);
    find_runs(&r[1], 256, 1, zzero_limits);
    add_runs(standard, &r[0], below + K, 1);
    add_runs(standard + NTP_FLAG_Z_NEGATIVE, &r[0], below + K, -1);
    add_runs(zzero, &r[1], below, 1);
    if (d->on_disc) {
        const uint32_t key = flags_at(&r[0], d->root);
        mark(standard, key, NTP_FLAG_EXACT, count[K + d->root]);
        mark(standard, key | NTP_FLAG_Z_NEGATIVE, NTP__MIRRORED, count[K - 1 - d->root]);
        mark(zzero, flags_at(&r[1], d->want), NTP_FLAG_EXACT, count[d->want]);
    }
    const int32_t first = d->pair ? 0 : r[0].ends[1], end = d->pair ? 0 : r[0].ends[4];
    add_counts(d->failing, count + K, first);
    add_counts(d->failing + end, count + K + end, HALF - end);
    /* The blue next to the horizon is not negative, and may fail like those above it. */
    d->failing[HALF] += first == 0 && end > 0 ? 0 : count[K - 1];
}

/* Counts by how far their places are from `want`; `reversed` are the same from the last one down. */
ONE_COPY static void add_distances(uint32_t *levels_off, const uint32_t *count,
                                   const uint32_t *reversed, int32_t n, int32_t want)
{
    add_counts(levels_off, count + want, n - want);
    add_counts(levels_off + 1, reversed + n - want, want);
}

ONE_COPY static void add_levels_off(ntp__sums *sums, const dense_rows *d)
{
    const uint32_t *const blue = d->blue, *const reversed = d->reversed;
    if (!d->on_disc) {
        sums->fit[0].levels_off[NTP__NO_BLUE] += d->texels;
        sums->fit[1].levels_off[NTP__NO_BLUE] += d->texels;
        return;
    }
    add_distances(sums->fit[0].levels_off, blue + K, reversed, HALF, d->root);
    add_distances(sums->fit[0].levels_off, reversed + K, blue, HALF, d->root);
    add_distances(sums->fit[1].levels_off, blue, reversed, 256, d->want);
    for (int32_t i = 0; i < 2; i++) {
        ntp__merge_max(&sums->fit[0].levels_off_max, (uint32_t) abs(d->u_ends[i] - d->root));
        ntp__merge_max(&sums->fit[1].levels_off_max, (uint32_t) abs(d->ends[i] - d->want));
    }
}

/* v + w * count, of 64 bits; what is in the odd lanes of w and count is added too. */
static inline __m256i add_products(__m256i v, __m256i w, __m256i count)
{
    const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(w, 32), _mm256_srli_epi64(count, 32));
    return _mm256_add_epi64(_mm256_add_epi64(v, odd), _mm256_mul_epu32(w, count));
}

ONE_COPY static uint64_t sum_of_four(const __m256i *v)
{
    uint64_t part[4];
    memcpy(part, v, sizeof part);
    return part[0] + part[1] + part[2] + part[3];
}

/* Longer ones come later. */
ONE_COPY static void sum_lengths(ntp__fit_sums *fit, const int32_t *length, const uint32_t *count,
                                 int32_t n, const int32_t ends[2], const dense_rows *d)
{
    __m256i sum = _mm256_setzero_si256(), error = sum, error2 = sum;
    for (int32_t i = 0; i < n; i += 8) {
        const __m256i v = _mm256_loadu_si256((const __m256i *) (const void *) (length + i));
        const __m256i times = _mm256_loadu_si256((const __m256i *) (const void *) (count + i));
        const __m256i off =
            _mm256_abs_epi32(_mm256_sub_epi32(v, _mm256_set1_epi32(NTP__LENGTH_ONE)));
        sum = add_products(sum, v, times);
        error = add_products(error, off, times);
        error2 = add_products(error2, _mm256_mullo_epi32(off, off), times);
    }
    fit->length_sum += sum_of_four(&sum);
    fit->length_error[d->common / 256] += sum_of_four(&error);
    fit->length_error2[d->padding] += sum_of_four(&error2);
    ntp__merge_max(&fit->length_inverted_min, ~(uint32_t) length[ends[0]]);
    ntp__merge_max(&fit->length_max, (uint32_t) length[ends[1]]);
}

ONE_COPY static void add_lengths(ntp__sums *sums, const dense_rows *d, int32_t *restrict standard,
                                 int32_t *restrict zzero)
{
    for (int32_t b = 0; b < 256; b++)
        zzero[b] = ntp__fixed_length(4.0 * d->v + 2.0 + (double) (b * b), M);
    for (int32_t u = 0; u < HALF; u++)
        standard[u] = zzero[2 * u + 1];
    sum_lengths(&sums->fit[0], standard, d->both, HALF, d->u_ends, d);
    sum_lengths(&sums->fit[1], zzero, d->blue, 256, d->ends, d);
}

#include "measure/dense_angles_avx2_tmpl.h"

typedef struct turns {
    uint64_t sum, texels;
    int32_t greatest;
} turns;

ONE_COPY static void sum_turns(turns *t, const int32_t *restrict angle,
                               const uint32_t *restrict count, int32_t n)
{
    int32_t greatest = 0;
    uint64_t sum = 0;
    uint32_t texels = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t one = angle[i] & -(count[i] != 0);
        greatest = one > greatest ? one : greatest;
        sum += (uint64_t) (uint32_t) angle[i] * count[i];
        texels += count[i];
    }
    t->sum = sum;
    t->texels = texels;
    t->greatest = greatest;
}

ONE_COPY static void add_harm(ntp__harm_sums *harm, const int32_t *angle, const uint32_t *count,
                              int32_t n)
{
    turns t;
    sum_turns(&t, angle, count, n);
    harm->texels += t.texels;
    harm->sum += t.sum;
    harm->max = (uint32_t) t.greatest > harm->max ? (uint32_t) t.greatest : harm->max;
}

/* The whole parts of (angle + more) * per.  1e-3 and 1e-4 are above a thousandth and a ten-thousandth, by
 * less than makes the next whole number of one of these. */
ONE_COPY static void find_bins(int32_t *restrict bins, const int32_t *restrict angle, int32_t n,
                               double more, double per)
{
    for (int32_t i = 0; i < n; i++)
        bins[i] = (int32_t) ((angle[i] + more) * per);
}

/* Counts at scattered places. */
typedef struct places {
    int32_t standard[HALF], zzero[256]; /* lengths */
    int32_t angle[MIRRORED];
    int32_t fails[HALF + SPARE], negative[HALF]; /* harm */
} places;

/* Neighbors of one length or angle are counted far from each other: a count waits for the one before it in
 * the same place. */
ONE_COPY static void count_places(ntp__sums *sums, const dense_rows *d, const places *p,
                                  uint32_t *fails, uint32_t *negative)
{
    enum { PART = 64, BIN = NTP__LENGTH_ONE / 128 };
    uint32_t *const standard = sums->fit[0].lengths, *const zzero = sums->fit[1].lengths;
    uint32_t *const bins = sums->angles.bins;
    const uint32_t *const blue = d->blue, *const down = d->reversed + K;
    for (int32_t i = 0; i < PART; i++) {
        for (int32_t u = i; u < HALF; u += PART) {
            standard[(uint32_t) p->standard[u] / BIN] += d->both[u];
            bins[p->angle[ABOVE + u]] += blue[K + u];
            bins[p->angle[BELOW + u]] += down[u];
            fails[p->fails[u]] += d->failing[u];
            negative[p->negative[u]] += down[u];
            zzero[(uint32_t) p->zzero[u] / BIN] += blue[u];
            zzero[(uint32_t) p->zzero[K + u] / BIN] += blue[K + u];
        }
    }
}

/* Angles and harm, and all that is counted at scattered places.  Changes the counts. */
ONE_COPY static void add_angles(ntp__sums *sums, dense_rows *d, places *p)
{
    uint32_t *const down = d->reversed + K;
    int32_t angle[ANGLES];
    ntp__harm_sums *const harm = &sums->harm[d->pair && d->padding ? NTP__PADDING_HARM : 0];
    ntp__harm_sums *const fails = harm + (d->pair ? 1 : 0), *const negative = harm + 2;
    turns above, below;
    find_angles(angle, d);
    sum_turns(&above, angle + ABOVE, d->blue + K, HALF);
    sum_turns(&below, angle + BELOW, down, HALF);
    const uint64_t greatest = (uint32_t) (above.greatest > below.greatest ? above : below).greatest;
    sums->angles.texels += d->texels;
    sums->angles.sum += above.sum + below.sum;
    sums->angles.max = greatest > sums->angles.max ? greatest : sums->angles.max;
    find_bins(p->angle, angle, MIRRORED, 500, 1e-3);
    find_bins(p->fails, angle + ABOVE, HALF + SPARE, 9999, 1e-4);
    find_bins(p->negative, angle + MIRRORED, HALF, 9999, 1e-4);
    fails->bins[p->fails[HALF]] += d->failing[HALF];
    sums->angles.bins[p->angle[BELOW]] += down[0];
    down[0] = 0;
    add_harm(fails, angle + ABOVE, d->failing, HALF + SPARE);
    add_harm(negative, angle + MIRRORED, down, HALF);
    count_places(sums, d, p, fails->bins, negative->bins);
}

/* Do so many cells of a row hold counts? */
static bool is_dense(const uint8_t *far, int32_t least)
{
    const __m256i zero = _mm256_setzero_si256();
    __m256i unused = zero; /* as negative numbers, of -8 at most */
    for (int32_t b = 0; b < 256; b += 32) {
        const __m256i v = _mm256_loadu_si256((const __m256i *) (const void *) (far + b));
        unused = _mm256_add_epi8(unused, _mm256_cmpeq_epi8(v, zero));
    }
    const __m256i sum = _mm256_sad_epu8(_mm256_sub_epi8(zero, unused), zero);
    const __m128i half =
        _mm_add_epi64(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    return _mm_cvtsi128_si32(_mm_add_epi64(half, _mm_unpackhi_epi64(half, half))) <= 256 - least;
}

ONE_COPY static void read_row(uint32_t count[256], const ntp__color_counts *counts, int32_t row)
{
    const uint8_t *const far = &counts->at.far[row * NTP__ROW_CELLS];
    const uint8_t *const carried = &counts->at.carried[row * NTP__ROW_CELLS];
    for (int32_t b = 0; b < 256; b++)
        count[b] = far[b];
    for (int32_t b = 0; counts->at.row_seen[row] & NTP__SEEN_CARRIED && b < 256; b++)
        count[b] += (uint32_t) carried[b] << 8;
    ntp__merge_counts(count + counts->row[row].first, &counts->at.near[row * NTP__NEAR], NTP__NEAR);
}

/* How many of these are below each place, of 256 and behind them. */
ONE_COPY static void sum_below(uint32_t below[256 + 1], const uint32_t count[256])
{
    __m256i sum = _mm256_setzero_si256();
    below[0] = 0;
    for (int32_t b = 0; b < 256; b += 8) {
        __m256i v = _mm256_loadu_si256((const __m256i *) (const void *) (count + b));
        v = _mm256_add_epi32(v, _mm256_slli_si256(v, 4));
        v = _mm256_add_epi32(v, _mm256_slli_si256(v, 8));
        /* the last one of the low half, to all of the high half */
        v = _mm256_add_epi32(v, _mm256_shuffle_epi32(_mm256_permute2x128_si256(v, v, 8), 0xff));
        _mm256_storeu_si256((__m256i *) (void *) (below + b + 1), _mm256_add_epi32(sum, v));
        sum = _mm256_add_epi32(sum, _mm256_permutevar8x32_epi32(v, _mm256_set1_epi32(7)));
    }
}

ONE_COPY static void add_row(ntp__sums *sums, dense_rows *d, const ntp__color_counts *counts,
                             int32_t row)
{
    const int32_t pair = counts->row[row].pair;
    uint32_t count[256], below[256 + 1];
    read_row(count, counts, row);
    sum_below(below, count);
    add_verdicts(sums, d, (pair & 255) + (pair >> 8) - 2 * K + 2, count, below);
    add_counts(d->blue, count, 256);
    d->texels += below[256];
}

/* Adds the row, and on the disc those that follow it in a list: their numbers and 1; 0: none do. */
ONE_COPY static void add_list(ntp__sums *sums, uint64_t blues[256], const ntp__color_counts *counts,
                              int32_t row, const uint16_t *next)
{
    const int32_t pair = counts->row[row].pair;
    dense_rows d;
    places p;
    begin(&d, (pair & 255) - K, (pair >> 8) - K);
    add_row(sums, &d, counts, row);
    while (d.on_disc && next[row] != 0) {
        row = next[row] - 1;
        add_row(sums, &d, counts, row);
    }
    for (int32_t b = 0; b < 256; b++)
        blues[b] += d.blue[b];
    turn_around(&d);
    sums->texels += d.texels;
    add_levels_off(sums, &d);
    add_lengths(sums, &d, p.standard, p.zzero);
    add_angles(sums, &d, &p);
}

void ntp__note_dense_rows_avx2(ntp__color_counts *counts, int32_t least)
{
    for (int32_t row = 0; (row = ntp__next_row(counts->at.row_seen, row)) < NTP__ROWS; row++) {
        const int32_t enough = ntp__row_is_on_disc(counts, row) ? least : NTP__DENSE;
        uint8_t *const seen = &counts->at.row_seen[row];
        *seen &= (uint8_t) ~NTP__SEEN_DENSE; /* it may be noted for an encoding before */
        if (enough > 0 && *seen & NTP__SEEN_QUARTERS && !(*seen & NTP__SEEN_OFTEN) &&
            is_dense(&counts->at.far[row * NTP__ROW_CELLS], enough))
            *seen |= NTP__SEEN_DENSE;
    }
}

void ntp__add_dense_rows_avx2(ntp__sums *sums, uint64_t blues[256], const ntp__color_counts *counts)
{
    /* of lists of rows: by v / 2, and by row */
    uint16_t first[AM / 2] = { 0 }, next[NTP__ROWS];
    for (int32_t row = 0; (row = ntp__next_row(counts->at.row_seen, row)) < NTP__ROWS; row++) {
        const int32_t pair = counts->row[row].pair, k1 = (pair & 255) - K, k2 = (pair >> 8) - K;
        const int32_t half = (k1 * (k1 + 1) + k2 * (k2 + 1)) / 2;
        if (!(counts->at.row_seen[row] & NTP__SEEN_DENSE))
            continue;
        if (half < AM / 2) { /* on the disc */
            next[row] = first[half];
            first[half] = (uint16_t) (row + 1);
        } else {
            add_list(sums, blues, counts, row, next);
        }
    }
    for (int32_t i = 0; i < AM / 2; i++) {
        if (first[i] != 0)
            add_list(sums, blues, counts, first[i] - 1, next);
    }
}

void ntp__dense_cells_avx2(ntp__cells *cells, const ntp__color_counts *counts, int32_t row)
{
    for (int32_t b = 0; b < 256; b++)
        cells->blue[b] = b;
    read_row(cells->count, counts, row);
}
