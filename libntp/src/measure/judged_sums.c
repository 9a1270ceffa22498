/* SPDX-License-Identifier: MIT */
/*
 * judged_sums.c - adds texels of one color, or a block of colors, to the sums of a measurement
 */
#include "texel/direction.h"
#include "texel/kernels.h"
#include "texel/level.h"
#include "measure/judged_sums.h"

#include <math.h>
#include <string.h>

void ntp__merge_counts(uint32_t *restrict into, const uint32_t *restrict from, size_t n)
{
    for (size_t i = 0; i < n; i++)
        into[i] += from[i];
}

/* Bits of texels that do harm, by index of ntp__sums.harm. */
enum {
    FAILS = 1,
    TOO_LONG = 2,
    NEGATIVE = 4,
    ANY_NEGATIVE = NEGATIVE | NEGATIVE << NTP__PADDING_HARM
};

/* Counts one texel for each count of 1. */
static const uint32_t ONES[NTP__BLOCK] = {
#define ONES_16 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1
    ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16,
    ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16, ONES_16,
};

void ntp__clean_long(int32_t *r, int32_t *g, int32_t *want, int32_t n, int32_t m, bool zzero)
{
    const ntp__kernels_table *kernels = ntp__kernels(NTP__CPU_ALL);
    int32_t at[NTP__BLOCK], to[3][NTP__BLOCK], doubt[NTP__BLOCK];
    const int32_t count = kernels->find(at, want, INT32_MIN, n);
    if (count == 0)
        return;
    for (int32_t i = 0; i < count; i++) {
        to[0][i] = r[at[i]];
        to[1][i] = g[at[i]];
    }
    for (int32_t i = count; i % NTP__KERNEL_LANES != 0; i++)
        to[0][i] = to[1][i] = 0;
    const bool any = kernels->pull(to[0], to[1], doubt, count, m);
    for (int32_t i = 0; any && i < count; i++) {
        if (doubt[i]) {
            to[0][i] = r[at[i]];
            to[1][i] = g[at[i]];
            ntp__pull_seldom(&to[0][i], &to[1][i], m);
        }
    }
    kernels->derive(to[2], to[0], to[1], count, m, zzero);
    for (int32_t i = 0; i < count; i++) {
        r[at[i]] = to[0][i];
        g[at[i]] = to[1][i];
        want[at[i]] = to[2][i];
    }
}

typedef struct planes {
    int32_t c[3][NTP__BLOCK];
} planes;

/* The angles between numerators over m. */
static void find_angles(int32_t *angle, planes *v, planes *w, int32_t n, int32_t m)
{
    const ntp__numbers a = { .c = { v->c[0], v->c[1], v->c[2] }, .m = m };
    const ntp__numbers b = { .c = { w->c[0], w->c[1], w->c[2] }, .m = m };
    ntp__kernels(NTP__CPU_ALL)->angles(angle, &a, &b, n);
}

/* Fills in the angles that the kernel left out. */
static void add_angles(ntp__judged *j, const ntp__block *block, int32_t n, int32_t m,
                       ntp_encoding encoding)
{
    const bool zzero = encoding == NTP_ENCODING_ZZERO;
    const int32_t twice = zzero ? 1 : 2, less = zzero ? 0 : m;
    int32_t at[NTP__BLOCK], r[NTP__BLOCK], g[NTP__BLOCK], want[NTP__BLOCK], angle[NTP__BLOCK];
    planes v, w;
    const int32_t count = ntp__kernels(NTP__CPU_ALL)->find(at, j->angle, INT32_MIN, n);
    if (count == 0)
        return;
    for (int32_t i = 0; i < count; i++) {
        r[i] = block->c[0][at[i]];
        g[i] = block->c[1][at[i]];
        want[i] = j->want[at[i]];
        v.c[0][i] = ntp__num(r[i], m);
        v.c[1][i] = ntp__num(g[i], m);
        v.c[2][i] = encoding == NTP_ENCODING_XY ? 0 : twice * block->c[2][at[i]] - less;
    }
    ntp__clean_long(r, g, want, count, m, zzero);
    for (int32_t i = 0; i < count; i++) {
        w.c[0][i] = ntp__num(r[i], m);
        w.c[1][i] = ntp__num(g[i], m);
        w.c[2][i] = twice * want[i] - less;
    }
    find_angles(angle, &v, &w, count, m);
    for (int32_t i = 0; i < count; i++)
        j->angle[at[i]] = angle[i];
}

/* How texels are wrong by more than rounding: a bit, or 0.  Returns those of all. */
static int32_t find_harm(int32_t *restrict kinds, const ntp__judged *restrict j,
                         const ntp__block *restrict block, int32_t n, int32_t m,
                         ntp_encoding encoding)
{
    const int32_t *keys = j->fit[encoding == NTP_ENCODING_ZZERO].key;
    const int32_t down = encoding == NTP_ENCODING_STANDARD ? (m - 1) / 2 : 0;
    const int32_t k0 = (m + 1) / 2, am = k0 * (k0 - 1);
    const int32_t fails = encoding == NTP_ENCODING_XY ? 0 : FAILS;
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t p = block->c[0][i] - k0, q = block->c[1][i] - k0;
        /* |X| - 2 = 2k - 1.  Are even such red and green too long? */
        const int32_t x = p < 0 ? ~p : p, y = q < 0 ? ~q : q;
        const int32_t pair = x * (x - 1) + y * (y - 1) >= am;
        const int32_t padding = keys[i] >= NTP__PADDING_BIN * 256;
        int32_t kind = keys[i] & NTP_FLAG_NEIGHBOR ? 0 : fails;
        kind = pair ? TOO_LONG : kind;
        kind = block->c[2][i] < down ? NEGATIVE : kind;
        kind = pair & padding ? kind << NTP__PADDING_HARM : kind;
        kinds[i] = kind;
        any |= kind;
    }
    return any;
}

/* Texels below the horizon, which may be too long besides: their angle is that to the vector with
 * the other sign of z. */
static void negative_angles(int32_t *restrict angle, const int32_t *restrict mirrored,
                            const int32_t *restrict kinds, const ntp__block *block, int32_t n,
                            int32_t m)
{
    int32_t doubt = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t negative = -((kinds[i] & ANY_NEGATIVE) != 0); /* without a branch */
        angle[i] = (mirrored[i] & negative) | (angle[i] & ~negative);
        doubt |= angle[i];
    }
    for (int32_t i = 0; doubt < 0 && i < n; i++) {
        const int32_t x = ntp__num(block->c[0][i], m), y = ntp__num(block->c[1][i], m);
        const int32_t z = ntp__num(block->c[2][i], m);
        if (angle[i] < 0)
            angle[i] = (int32_t) ntp__angle(x, y, z, x, y, -z);
    }
}

/* Without z there is no angle: how far x, y lie outside the circle stands for it. */
static void outside_angles(int32_t *angle, const int32_t *kinds, const ntp__block *block, int32_t n,
                           int32_t m)
{
    for (int32_t i = 0; i < n; i++) {
        const double x = ntp__num(block->c[0][i], m), y = ntp__num(block->c[1][i], m);
        if (kinds[i] != 0)
            angle[i] = (int32_t) ((sqrt(x * x + y * y) / m - 1.0) * (180e6 / NTP__PI) + 0.5);
    }
}

/* Of texels at n places; of one kind each time, as sums in memory would wait for each other. */
static void add_kind(ntp__harm_sums *harm, const int32_t *angles, const uint32_t *count,
                     const int32_t *at, int32_t n)
{
    uint64_t texels = 0, sum = 0, greatest = harm->max;
    for (int32_t i = 0; i < n; i++) {
        const uint32_t angle = (uint32_t) angles[at[i]], times = count[at[i]];
        texels += times;
        sum += (uint64_t) angle * times;
        harm->bins[ntp__harm_bin(angle)] += times;
        greatest = angle > greatest ? angle : greatest;
    }
    harm->texels += texels;
    harm->sum += sum;
    harm->max = greatest;
}

/* Changes the angles.  Only texels that are no neighbors, too long or negative do harm. */
static void add_harm(ntp__sums *sums, ntp__judged *j, const ntp__block *block,
                     const uint32_t *count, int32_t n, int32_t m, ntp_encoding encoding)
{
    const ntp__judged_fit *const fit = &j->fit[encoding == NTP_ENCODING_ZZERO];
    int32_t kinds[NTP__BLOCK], at[NTP__BLOCK];
    if ((fit->every & NTP_FLAG_NEIGHBOR) &&
        !(fit->some & (NTP_FLAG_XY_TOO_LONG | NTP_FLAG_Z_NEGATIVE)))
        return;
    int32_t any = find_harm(kinds, j, block, n, m, encoding);
    if (any & ANY_NEGATIVE)
        negative_angles(j->angle, j->mirrored, kinds, block, n, m);
    if (encoding == NTP_ENCODING_XY)
        outside_angles(j->angle, kinds, block, n, m);
    for (int32_t k = 0; any != 0; k++, any >>= 1) {
        if (any & 1)
            add_kind(&sums->harm[k], j->angle, count, at,
                     ntp__kernels(NTP__CPU_ALL)->find(at, kinds, 1 << k, n));
    }
}

static void add_sums(ntp__fit_sums *sums, const ntp__judged_fit *fit)
{
    sums->length_sum += fit->length_sum;
    for (int32_t i = 0; i < 2; i++)
        sums->length_error2[i] += fit->length_error2[i];
    ntp__merge_max(&sums->levels_off_max, fit->levels_off_max);
    ntp__merge_max(&sums->length_max, fit->greatest);
    ntp__merge_max(&sums->length_inverted_min, ~fit->least);
}

static inline void count_fit(ntp__fit_sums *sums, uint64_t *errors, const ntp__judged_fit *fit,
                             int32_t i, uint32_t count)
{
    const uint32_t key = (uint32_t) fit->key[i];
    sums->flags[key] += count;
    sums->levels_off[fit->levels_off[i]] += count;
    sums->lengths[(uint32_t) fit->length[i] / (NTP__LENGTH_ONE / 128)] += count;
    errors[key / 256] += (uint64_t) fit->off[i] * count;
}

/* Angles fall into more memory than the caches near the processor hold: their bins are fetched while other
 * things are counted. */
static void fetch_angles(const ntp__angle_sums *sums, const int32_t *angle, int32_t n)
{
#ifdef __GNUC__
    for (int32_t i = 0; i < n; i++)
        __builtin_prefetch(&sums->bins[((uint32_t) angle[i] + 500) / 1000], 1);
#else
    (void) sums, (void) angle, (void) n;
#endif
}

/* Of colors that occur any number of times. */
static void count_colors(ntp__sums *sums, const ntp__judged *j, const uint32_t *count, int32_t n)
{
    uint64_t errors[2][NTP__ALL_BINS] = { { 0 } }, texels = 0, sum = 0;
    uint32_t greatest = 0;
    fetch_angles(&sums->angles, j->angle, n);
    for (int32_t i = 0; i < n; i++) {
        count_fit(&sums->fit[0], errors[0], &j->fit[0], i, count[i]);
        count_fit(&sums->fit[1], errors[1], &j->fit[1], i, count[i]);
    }
    for (int32_t i = 0; i < n; i++) {
        const uint32_t angle = (uint32_t) j->angle[i];
        sums->angles.bins[(angle + 500) / 1000] += count[i];
        greatest = angle > greatest ? angle : greatest;
        texels += count[i];
        sum += (uint64_t) angle * count[i];
    }
    sums->texels += texels;
    sums->angles.texels += texels;
    sums->angles.sum += sum;
    sums->angles.max = greatest > sums->angles.max ? greatest : sums->angles.max;
    for (int32_t i = 0; i < NTP__ALL_BINS; i++) {
        sums->fit[0].length_error[i] += errors[0][i];
        sums->fit[1].length_error[i] += errors[1][i];
    }
}

/*
 * Of colors that occur once each.  A count waits for the one before it if both are in one place, as
 * they mostly are.  So every second texel is counted elsewhere: distances below NEAR in counts of the
 * block.  Runs of zeros, the distances and angles of exact texels, are one count.  Lanes are whole,
 * so that runs may be looked at beyond n.
 */
enum { NEAR = 16, RUN = 16 };

static inline bool is_run_of_zeros(const int32_t *value)
{
    int32_t any = 0;
    for (int32_t i = 0; i < RUN; i++)
        any |= value[i];
    return any == 0;
}

static void count_distances(uint32_t *counts, const int32_t *value, int32_t n)
{
    uint32_t near[NEAR] = { 0 };
    for (int32_t i = 0; i < n; i += RUN) {
        const int32_t end = i + RUN < n ? i + RUN : n;
        if (is_run_of_zeros(value + i)) {
            near[0] += (uint32_t) (end - i);
            continue;
        }
        for (int32_t k = i; k + 1 < end; k += 2) {
            uint32_t *const place = value[k + 1] < NEAR ? near : counts;
            counts[value[k]]++;
            place[value[k + 1]]++;
        }
        if ((end - i) % 2 != 0)
            counts[value[end - 1]]++;
    }
    ntp__merge_counts(counts, near, NEAR);
}

static void count_angles(ntp__angle_sums *sums, const int32_t *angle, int32_t n)
{
    uint64_t sum = 0;
    uint32_t greatest = 0, zeros = 0;
    for (int32_t i = 0; i < n; i += RUN) {
        const int32_t end = i + RUN < n ? i + RUN : n;
        if (is_run_of_zeros(angle + i)) {
            zeros += (uint32_t) (end - i);
            continue;
        }
        for (int32_t k = i; k < end; k++) {
            const uint32_t a = (uint32_t) angle[k];
            sum += a;
            greatest = a > greatest ? a : greatest;
            sums->bins[(a + 500) / 1000]++;
        }
    }
    sums->texels += (uint32_t) n;
    sums->bins[0] += zeros;
    sums->sum += sum;
    sums->max = greatest > sums->max ? greatest : sums->max;
}

static inline void count_key(ntp__fit_sums *sums, const ntp__judged_fit *fit, int32_t i, bool other)
{
    const uint32_t key = (uint32_t) fit->key[i];
    const uint32_t length = (uint32_t) fit->length[i] / (NTP__LENGTH_ONE / 128);
    if (other) {
        sums->other_flags[key]++;
        sums->other_lengths[length]++;
    } else {
        sums->flags[key]++;
        sums->lengths[length]++;
    }
}

/* `errors` are those of standard, and of Z-zero 32 bits above. */
static inline void count_texel(ntp__sums *sums, uint64_t *errors, const ntp__judged *j, int32_t i,
                               bool other)
{
    const uint64_t off = j->fit[0].off[i] | (uint64_t) j->fit[1].off[i] << 32;
    errors[(uint32_t) j->fit[0].key[i] / 256] += off;
    count_key(&sums->fit[0], &j->fit[0], i, other);
    count_key(&sums->fit[1], &j->fit[1], i, other);
}

static void count_texels(ntp__sums *sums, const ntp__judged *j, int32_t n)
{
    uint64_t errors[2][NTP__ALL_BINS] = { { 0 } };
    ntp__fit_sums *const std = &sums->fit[0], *const zz = &sums->fit[1];
    for (int32_t i = 0; i + 1 < n; i += 2) {
        count_texel(sums, errors[0], j, i, false);
        count_texel(sums, errors[1], j, i + 1, true);
    }
    if (n % 2 != 0)
        count_texel(sums, errors[0], j, n - 1, false);
    for (int32_t i = 0; i < NTP__ALL_BINS; i++) {
        std->length_error[i] += (uint32_t) errors[0][i] + (uint64_t) (uint32_t) errors[1][i];
        zz->length_error[i] += (errors[0][i] >> 32) + (errors[1][i] >> 32);
    }
    count_distances(std->levels_off, j->fit[0].levels_off, n);
    count_distances(zz->levels_off, j->fit[1].levels_off, n);
    count_angles(&sums->angles, j->angle, n);
    sums->texels += (uint32_t) n;
}

void ntp__add_block(ntp__sums *sums, const ntp__block *block, const uint32_t *count, int32_t n,
                    int32_t m, ntp_encoding encoding)
{
    ntp__judged j;
    if (n == 0)
        return;
    const uint32_t *const times = count != NULL ? count : ONES;
    ntp__kernels(NTP__CPU_ALL)
        ->judge_block(&j, block->c[0], block->c[1], block->c[2], times, n, m,
                      encoding == NTP_ENCODING_XY ? 2 : encoding == NTP_ENCODING_ZZERO);
    for (int32_t i = 0; encoding == NTP_ENCODING_XY && i < n; i++)
        j.angle[i] = j.want[i] < 0 ? -1 : 0;
    add_angles(&j, block, n, m, encoding);
    for (int32_t i = 0; i < 2; i++)
        add_sums(&sums->fit[i], &j.fit[i]);
    if (count != NULL)
        count_colors(sums, &j, count, n);
    else
        count_texels(sums, &j, n);
    add_harm(sums, &j, block, times, n, m, encoding);
}

void ntp__end_batch(ntp__sums *sums, ntp__color_batch *batch, int32_t m, ntp_encoding encoding)
{
    ntp__add_block(sums, &batch->block, batch->count, batch->n, m, encoding);
    batch->n = 0;
}

void ntp__add(ntp__sums *sums, const int32_t c[3], uint32_t count, int32_t m, ntp_encoding encoding)
{
    ntp__block one;
    for (int32_t k = 0; k < 3; k++)
        one.c[k][0] = c[k];
    ntp__add_block(sums, &one, &count, 1, m, encoding);
}
