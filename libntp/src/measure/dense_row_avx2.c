/* SPDX-License-Identifier: MIT */
/*
 * dense_row_avx2.c - adds a row of cells of which many hold counts to the sums, with AVX2
 *
 * All texels of a row have the same |x| and |y|.  Then each question about blue splits the 256 blues into a
 * few runs, which sums of all counts below a blue answer.  How far blue is off is added as a whole,
 * beginning at the derived one.  Z = 2u + 1 and -Z have the same length in the standard encoding, and so
 * has a blue of Z in Z-zero.
 *
 * With t(u) = atan2(Z, rho), where rho = |(x, y)|, the angle to the derived vector is |t(u) - t(root)|
 * above the horizon and t(u) + t(root) below it; that to the vector with the other sign of z is 2 t(u).
 * So one arc tangent serves three angles.  Each t is off by at most 1e-5 micro-degrees
 * (texel/angles_tmpl.h).  Where the sum of two lies within MARGIN = 6e-5 of the middle between two whole
 * numbers, angle.c decides.
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

/* What is the same in a row, and its counts. */
typedef struct dense_row {
    int32_t k1, k2, v, e; /* v = x(x + 1) + y(y + 1), e = A_M - 1 - v */
    int32_t root, want;   /* of the derived blue: K + root, and in Z-zero; of e >= 0 */
    uint32_t common;      /* steepness * 256 + flags of red and green */
    bool on_disc, padding;
    uint32_t blue[256];         /* the counts */
    uint32_t reversed[256];     /* from blue 255 down */
    uint32_t both[HALF];        /* of both signs of z, by u */
    int32_t ends[2], u_ends[2]; /* the first and the last blue, and u, with a count */
    uint32_t below[256 + 1];    /* how many texels have a blue below this one */
    int32_t standard[HALF + SPARE], zzero[256 + SPARE]; /* flags, by u and by blue */
} dense_row;

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

ONE_COPY static void begin(dense_row *d, int32_t k1, int32_t k2)
{
    const int32_t v = k1 * (k1 + 1) + k2 * (k2 + 1), e = AM - 1 - v, low = 16;
    const int32_t far = (int32_t) ((NTP__FAR_SQUARED * (M * M) - 2) / 4);
    uint32_t bin = 0, sum = 0;
    d->k1 = k1;
    d->k2 = k2;
    d->v = v;
    d->e = e;
    d->on_disc = e >= 0;
    d->padding = k1 >= K - low && k2 >= K - low;
    while (bin + 1 < NTP__STEEPNESS_BINS && v >= (int32_t) ((bin + 1) * (bin + 1)) * (AM / 64))
        bin++;
    d->common = (d->padding ? NTP__PADDING_BIN : bin) * 256 | (v > far ? NTP__FAR : 0) |
                (v >= AM ? NTP_FLAG_XY_TOO_LONG : 0);
    d->root = d->want = 0;
    if (d->on_disc) {
        d->root = (int32_t) sqrt((double) e);
        const int32_t rest = e - d->root * d->root;
        d->want = 2 * d->root + (2 * rest + 1 >= d->root) + (2 * rest >= 3 * d->root);
    }
    for (int32_t b = 0; b < 256; b++)
        d->reversed[b] = d->blue[255 - b];
    for (int32_t u = 0; u < HALF; u++)
        d->both[u] = d->blue[K + u] + d->reversed[K + u];
    find_ends(d->ends, d->blue, 256);
    find_ends(d->u_ends, d->both, HALF);
    for (int32_t b = 0; b < 256; b++) {
        d->below[b] = sum;
        sum += d->blue[b];
    }
    d->below[256] = sum;
}

/* Limits of i * i + (c - less) * i, for c = -1, 3, 0, 2 and 1.  They hold where they are negative. */
typedef struct limits {
    int32_t neighbor[2], rounded[2], is_long; /* at most, at least */
} limits;

ONE_COPY static void judge_all(int32_t *restrict flags, int32_t n, int32_t less, const limits *l)
{
    const int32_t in = l->neighbor[0], out = l->neighbor[1], is_long = l->is_long;
    const int32_t q_in = l->rounded[0], q_out = l->rounded[1];
    for (int32_t i = 0; i < n; i++) {
        const int32_t v = i * i - less * i, v2 = v + i + i;
        flags[i] = ((v - i <= in) & (v2 + i >= out)) * NTP_FLAG_NEIGHBOR |
                   ((v <= q_in) & (v2 >= q_out)) * NTP_FLAG_ROUNDED |
                   (v + i >= is_long) * NTP__LONG;
    }
    memset(flags + n, 0, SPARE * sizeof flags[0]); /* what end_of_run may read */
}

/* Verdicts that are the same for blues side by side: the conditions of judge_levels, solved for u and b. */
ONE_COPY static void judge(dense_row *d)
{
    const int32_t e = d->e, kxy = d->k1 + d->k2 + 2;
    const limits standard = {
        { e + 2 * kxy - 4, e - 2 * kxy - 1 },
        { e + kxy - 1, e - kxy + 1 },
        e + 1,
    };
    const limits zzero = {
        { 4 * (e + 2 * (kxy - 2)) + 2, 4 * (e - 2 * kxy) + 2 },
        { 4 * (e + kxy - 1), 4 * (e + 1 - kxy) + 1 },
        4 * e + 4,
    };
    judge_all(d->standard, HALF, 0, &standard);
    judge_all(d->zzero, 256, 1, &zzero);
}

/* The end of the run of equal flags that begins at i. */
ONE_COPY static int32_t end_of_run(const int32_t *flags, int32_t i, int32_t n)
{
    const __m256i first = _mm256_set1_epi32(flags[i]);
    for (; i < n; i += 8) {
        const __m256i v = _mm256_loadu_si256((const __m256i *) (const void *) (flags + i));
        const __m256 same = _mm256_castsi256_ps(_mm256_cmpeq_epi32(v, first));
        const uint32_t other = (uint32_t) _mm256_movemask_ps(same) ^ 255;
        if (other != 0) {
            i += __builtin_ctz(other);
            break;
        }
    }
    return i < n ? i : n;
}

static inline void mark(uint32_t *flags, uint32_t key, uint32_t more, uint32_t count)
{
    flags[key] -= count;
    flags[key | more] += count;
}

ONE_COPY static void add_flags(ntp__sums *sums, const dense_row *d)
{
    uint32_t *const standard = sums->fit[0].flags, *const zzero = sums->fit[1].flags;
    const uint32_t *const above = d->below + K, common = d->common;
    for (int32_t u = 0, end; u < HALF; u = end) {
        const uint32_t key = common | (uint32_t) d->standard[u];
        end = end_of_run(d->standard, u, HALF);
        standard[key] += above[end] - above[u];
        standard[key | NTP_FLAG_Z_NEGATIVE] += above[-u] - above[-end];
    }
    for (int32_t b = 0, end; b < 256; b = end) {
        end = end_of_run(d->zzero, b, 256);
        zzero[common | (uint32_t) d->zzero[b]] += d->below[end] - d->below[b];
    }
    if (!d->on_disc)
        return;
    const uint32_t key = common | (uint32_t) d->standard[d->root];
    mark(standard, key, NTP_FLAG_EXACT, d->blue[K + d->root]);
    mark(standard, key | NTP_FLAG_Z_NEGATIVE, NTP__MIRRORED, d->reversed[K + d->root]);
    mark(zzero, common | (uint32_t) d->zzero[d->want], NTP_FLAG_EXACT, d->blue[d->want]);
}

/* Counts by how far their places are from `want`; `reversed` are the same from the last one down. */
ONE_COPY static void add_distances(uint32_t *levels_off, const uint32_t *count,
                                   const uint32_t *reversed, int32_t n, int32_t want)
{
    ntp__merge_counts(levels_off, count + want, (size_t) (n - want));
    ntp__merge_counts(levels_off + 1, reversed + n - want, (size_t) want);
}

ONE_COPY static void add_levels_off(ntp__sums *sums, const dense_row *d)
{
    const uint32_t *const blue = d->blue, *const reversed = d->reversed;
    if (!d->on_disc) {
        sums->fit[0].levels_off[NTP__NO_BLUE] += d->below[256];
        sums->fit[1].levels_off[NTP__NO_BLUE] += d->below[256];
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

/* Longer ones come later. */
ONE_COPY static void sum_lengths(ntp__fit_sums *fit, const int32_t *restrict length,
                                 const uint32_t *restrict count, int32_t n, const int32_t ends[2],
                                 const dense_row *d)
{
    uint64_t sum = 0, error = 0, error2 = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t more = length[i] - NTP__LENGTH_ONE;
        const uint32_t off = (uint32_t) (more < 0 ? -more : more);
        sum += (uint64_t) (uint32_t) length[i] * count[i];
        error += (uint64_t) off * count[i];
        error2 += (uint64_t) (off * off) * count[i];
    }
    fit->length_sum += sum;
    fit->length_error[d->common / 256] += error;
    fit->length_error2[d->padding] += error2;
    ntp__merge_max(&fit->length_inverted_min, ~(uint32_t) length[ends[0]]);
    ntp__merge_max(&fit->length_max, (uint32_t) length[ends[1]]);
}

ONE_COPY static void add_lengths(ntp__sums *sums, const dense_row *d, int32_t *restrict standard,
                                 int32_t *restrict zzero)
{
    for (int32_t b = 0; b < 256; b++)
        zzero[b] = ntp__fixed_length(4.0 * d->v + 2.0 + (double) (b * b), M);
    for (int32_t u = 0; u < HALF; u++)
        standard[u] = zzero[2 * u + 1];
    sum_lengths(&sums->fit[0], standard, d->both, HALF, d->u_ends, d);
    sum_lengths(&sums->fit[1], zzero, d->blue, 256, d->ends, d);
}

/* t(u), in micro-degrees; as in texel/angles_tmpl.h. */
ONE_COPY static void elevations(double *restrict t, double rho)
{
    for (int32_t u = 0; u < HALF; u++) {
        const double z = 2 * u + 1, low = z < rho ? z : rho, high = z < rho ? rho : z;
        const double less = low - high, more = low + high;
        const bool beyond = low > TAN_22_ * high;
        const double q = (beyond ? less : low) / (beyond ? more : high), w = q * q;
        const double w2 = w * w, w4 = w2 * w2;
        const double a = (C0 + C1 * w) + (C2 + C3 * w) * w2;
        const double c = (C4 + C5 * w) + (C6 + C7 * w) * w2;
        const double s = (a + c * w4) * q + (beyond ? 45e6 : 0.0);
        t[u] = z < rho ? s : 90e6 - s;
    }
}

/* Rounds |t(u) * times + more|; returns whether one is in doubt. */
ONE_COPY static int32_t round_sums(int32_t *restrict angle, int32_t *restrict doubt,
                                   const double *restrict t, double times, double more)
{
    int32_t any = 0;
    for (int32_t u = 0; u < HALF; u++) {
        const double up = fabs(t[u] * times + more) + (0.5 - MARGIN);
        angle[u] = (int32_t) up;
        doubt[u] = (int32_t) (up + 2 * MARGIN) - angle[u];
        any |= doubt[u];
    }
    return any;
}

/* Those of pairs that are too long, to the vector of the pulled pair. */
ONE_COPY static void pulled_angles(int32_t *angle, const dense_row *d)
{
    int32_t r = K + d->k1, g = K + d->k2, want = -1;
    double s2[256], along[256];
    const double x = 2 * d->k1 + 1, y = 2 * d->k2 + 1;
    ntp__clean_long(&r, &g, &want, 1, M, false);
    const double w = 2 * want - M, x2 = 2 * r - M, y2 = 2 * g - M, xy = x * x2 + y * y2;
    const double square = x * x + y * y, square2 = x2 * x2 + y2 * y2 + w * w;
    for (int32_t i = 0; i < MIRRORED; i++) {
        const int32_t up = 2 * (i % HALF) + 1;
        const double z = i < BELOW ? up : -up, dot = xy + z * w;
        s2[i] = (square + z * z) * square2 - dot * dot;
        along[i] = dot;
    }
    ntp__kernels(NTP__CPU_ALL)->angles_of(angle, s2, along, MIRRORED);
}

ONE_COPY static void find_angles(int32_t *angle, const dense_row *d)
{
    double t[HALF];
    int32_t doubt[ANGLES] = { 0 };
    const int32_t x = 2 * d->k1 + 1, y = 2 * d->k2 + 1, w = 2 * d->root + 1;
    elevations(t, sqrt(4.0 * d->v + 2.0));
    int32_t any = round_sums(angle + MIRRORED, doubt + MIRRORED, t, 2, 0);
    if (d->on_disc) {
        any |= round_sums(angle + ABOVE, doubt + ABOVE, t, 1, -t[d->root]);
        any |= round_sums(angle + BELOW, doubt + BELOW, t, 1, t[d->root]);
    } else {
        pulled_angles(angle, d);
    }
    for (int32_t i = 0; any != 0 && i < ANGLES; i++) {
        const int32_t z = 2 * (i % HALF) + 1;
        if (doubt[i] != 0)
            angle[i] = (int32_t) ntp__angle(x, y, i < BELOW ? z : -z, x, y, i < MIRRORED ? w : z);
    }
}

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
    uint32_t failing[HALF + SPARE];              /* texels */
} places;

/* Neighbors of one length or angle are counted far from each other: a count waits for the one before it in
 * the same place. */
ONE_COPY static void count_places(ntp__sums *sums, const dense_row *d, const places *p,
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
            fails[p->fails[u]] += p->failing[u];
            negative[p->negative[u]] += down[u];
            zzero[(uint32_t) p->zzero[u] / BIN] += blue[u];
            zzero[(uint32_t) p->zzero[K + u] / BIN] += blue[K + u];
        }
    }
}

/* Angles and harm, and all that is counted at scattered places.  Changes the row. */
ONE_COPY static void add_angles(ntp__sums *sums, dense_row *d, places *p)
{
    uint32_t *const down = d->reversed + K;
    int32_t angle[ANGLES];
    const bool pair = d->k1 * (d->k1 - 1) + d->k2 * (d->k2 - 1) >= AM;
    ntp__harm_sums *const harm = &sums->harm[pair && d->padding ? NTP__PADDING_HARM : 0];
    ntp__harm_sums *const fails = harm + (pair ? 1 : 0), *const negative = harm + 2;
    const int32_t harmless = pair ? 0 : NTP_FLAG_NEIGHBOR;
    turns above, below;
    find_angles(angle, d);
    sum_turns(&above, angle + ABOVE, d->blue + K, HALF);
    sum_turns(&below, angle + BELOW, down, HALF);
    const uint64_t greatest = (uint32_t) (above.greatest > below.greatest ? above : below).greatest;
    sums->angles.texels += d->below[256];
    sums->angles.sum += above.sum + below.sum;
    sums->angles.max = greatest > sums->angles.max ? greatest : sums->angles.max;
    find_bins(p->angle, angle, MIRRORED, 500, 1e-3);
    find_bins(p->fails, angle + ABOVE, HALF + SPARE, 9999, 1e-4);
    find_bins(p->negative, angle + MIRRORED, HALF, 9999, 1e-4);
    /* The blue next to the horizon is not negative, and may fail like those above it. */
    for (int32_t u = 0; u < SPARE; u++)
        p->failing[HALF + u] = 0;
    for (int32_t u = 0; u < HALF; u++)
        p->failing[u] = d->standard[u] & harmless ? 0 : d->blue[K + u];
    p->failing[HALF] = d->standard[0] & harmless ? 0 : down[0];
    fails->bins[p->fails[HALF]] += p->failing[HALF];
    sums->angles.bins[p->angle[BELOW]] += down[0];
    down[0] = 0;
    add_harm(fails, angle + ABOVE, p->failing, HALF + SPARE);
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

bool ntp__add_dense_row_avx2(ntp__sums *sums, uint64_t blues[256], const ntp__color_counts *counts,
                             int32_t row, int32_t least)
{
    const int32_t pair = counts->row[row].pair;
    dense_row d;
    places p;
    if (counts->at.row_seen[row] & NTP__SEEN_OFTEN ||
        !is_dense(&counts->at.far[row * NTP__ROW_CELLS], least))
        return false;
    read_row(d.blue, counts, row);
    for (int32_t b = 0; b < 256; b++)
        blues[b] += d.blue[b];
    begin(&d, (pair & 255) - K, (pair >> 8) - K);
    judge(&d);
    sums->texels += d.below[256];
    add_flags(sums, &d);
    add_levels_off(sums, &d);
    add_lengths(sums, &d, p.standard, p.zzero);
    add_angles(sums, &d, &p);
    return true;
}

void ntp__dense_cells_avx2(ntp__cells *cells, const ntp__color_counts *counts, int32_t row)
{
    for (int32_t b = 0; b < 256; b++)
        cells->blue[b] = b;
    read_row(cells->count, counts, row);
}
