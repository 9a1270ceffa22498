/* SPDX-License-Identifier: MIT */
/*
 * resize.c - resizing in the space of vectors
 *
 * For a row of the result, the source rows are summed first: each column adds up the vectors of its
 * texels, times alpha, times the weight of the row, in 64 bits.  Then the columns are summed, in 96
 * bits.  No sum is rounded, so neither the order of sums nor the way an image is cut into areas
 * matters.  Only the direction of the result is rounded, once.  The columns are summed last because
 * then no sum outlives a row of the result: each call stands alone, and a caller can stream rows.
 *
 * Sums of columns below 2^53 are doubles, which are exact then (resize_columns.c).  Sums of all columns are doubles
 * too, and it is known how far they are off.  What may be 0 is summed again in 32 bits for RGB (resize_strip.c), and
 * the few results that these cannot decide are computed again with the sums above.
 */
#include "base/inlining.h"
#include "texel/direction.h"
#include "texel/unused.h"
#include "texel/level.h"
#include "reshape/resize_job.h"

#include <math.h>
#include <string.h>

typedef ntp__resize_job job;

static size_t columns_size(const ntp_resize_plan *plan)
{
    return SUMS * ntp__align16((size_t) plan->x.src * sizeof(int64_t));
}

size_t ntp_resize_scratch_size(const ntp_resize_plan *plan)
{
    return plan == NULL ? 0 : columns_size(plan) + ntp__strip_size(plan);
}

/* The place of column i of the source in the sums. */
static int32_t place_of(const job *j, int32_t i)
{
    return j->rows != NULL ? i - j->first : ntp__axis_map(&j->plan->x, i);
}

static int64_t column_of(const job *j, int32_t k, int32_t i)
{
    return j->quickly ? (int64_t) j->quick[k][i] : j->sum[k][i];
}

/* The sum over the columns of texel x.  Columns of 63 bits are summed in two halves. */
static SELDOM ntp__i128 across(const job *j, int32_t k, int32_t x)
{
    const ntp__axis *axis = &j->plan->x;
    const int32_t *weight = axis->weight + (ptrdiff_t) x * axis->stride;
    int64_t high = 0, low = 0;
    for (int32_t t = 0; t < axis->span[x].count; t++) {
        int64_t c = column_of(j, k, place_of(j, axis->span[x].first + t));
        int64_t rest = (int64_t) ((uint64_t) c & 0xffffffffu);
        low += weight[t] * rest;
        high += weight[t] * ((c - rest) / 4294967296);
    }
    return ntp__i128_add(ntp__i128_shift(ntp__i128_of(high), 32), ntp__i128_of(low));
}

/* Is sum k of a column of texel x other than 0? */
static SELDOM bool any_other(const job *j, int32_t k, int32_t x)
{
    const ntp__axis *axis = &j->plan->x;
    for (int32_t t = 0; t < axis->span[x].count; t++) {
        if (column_of(j, k, place_of(j, axis->span[x].first + t)) != 0)
            return true;
    }
    return false;
}

/* Is a negative z of texel x no z of a source?  Only Lanczos overshoots. */
static bool overshot(const job *j, int32_t x)
{
    return j->sum[SUM_NEGATIVE] != NULL && !any_other(j, SUM_NEGATIVE, x);
}

/* The third sample of NTP_ENCODING_XY, and alpha. */
static SELDOM void resize_samples_exactly(const job *j, ntp__block *out, int32_t i, int32_t x,
                                          int32_t y)
{
    const ntp__axis *axis = &j->plan->x;
    ntp__i128 weight = across(j, SUM_WEIGHT, x);
    const bool none = ntp__i128_is_zero(weight) || ntp__i128_negative(weight);
    if (j->sum[SUM_EXTRA] != NULL && !none)
        out->c[2][i] = ntp__i128_ratio(across(j, SUM_EXTRA, x), weight, j->m);
    if (j->sum[SUM_ALPHA] == NULL)
        return;
    int64_t one = (int64_t) axis->span[x].total * j->plan->y.span[y].total;
    bool clear = none && !(j->plan->how.touch_unused & NTP_UNUSED_TRANSPARENT);
    out->c[3][i] = clear ? 0 : ntp__i128_ratio(across(j, SUM_ALPHA, x), ntp__i128_of(one), j->m);
}

static void put_direction(const job *j, ntp__block *out, int32_t i, const ntp__i128 v[3])
{
    int32_t c[3] = { 0, 0, j->m };
    ntp__direction_levels(c, v, j->m, j->src->encoding);
    for (int32_t k = 0; k < 3; k++)
        out->c[k][i] = c[k];
}

static SELDOM void resize_texel(const job *j, ntp__block *out, int32_t i, int32_t x)
{
    ntp__i128 v[3], weight = across(j, SUM_WEIGHT, x);
    /* Negative weights of Lanczos can outweigh the others where many texels are unused. */
    bool none = ntp__i128_is_zero(weight) || ntp__i128_negative(weight);
    for (int32_t k = 0; k < 3; k++)
        v[k] = none ? ntp__i128_of(0) : across(j, k, x);
    /* A texel must not get a negative z when its sources have none. */
    if (ntp__i128_negative(v[2]) && overshot(j, x))
        v[2] = ntp__i128_of(0);
    put_direction(j, out, i, v);
}

/* Sum k over the columns of n texels from texel x on, in doubles. */
static void across_quickly(const job *j, double *to, int32_t k, int32_t x, int32_t n)
{
    const ntp__axis *axis = &j->plan->x;
    const int32_t *weight = axis->weight + (ptrdiff_t) x * axis->stride;
    for (int32_t i = 0; i < n; i++, weight += axis->stride) {
        const ntp__span_of_taps span = axis->span[x + i];
        const int32_t first = span.first - j->first;
        const bool inside = j->rows != NULL || (first >= 0 && first + span.count <= axis->src);
        double sum = 0, other = 0; /* two sums, so that none waits for the other */
        int32_t t = 0;
        if (j->quickly && inside) {
            const double *column = j->quick[k] + first;
            for (; t + 1 < span.count; t += 2) {
                sum += weight[t] * column[t];
                other += weight[t + 1] * column[t + 1];
            }
            if (t < span.count)
                sum += weight[t] * column[t];
            t = span.count;
        }
        for (; t < span.count; t++) {
            const int32_t at = place_of(j, span.first + t);
            sum += weight[t] * (j->quickly ? j->quick[k][at] : (double) j->sum[k][at]);
        }
        sum += other;
        to[i] = sum;
    }
}

/*
 * ntp__i128_ratio of a and b > 0 that are off by `error` at most; false if it is not known.  a / b is off by
 * (1 + |a / b|) error / b and by its own rounding.  A quotient beyond the levels is not near one of them, unless that
 * is more than a half.  Exact integers have quotients that are halves, or 1 / (2b) away from these: that
 * is more than the roundings, which are monotone.
 */
static bool ratio_quickly(int32_t *level, double a, double b, double error, int32_t max)
{
    const double off = error == 0 && b < 0x1p34 ? 0 : (max + 3) * error / b + 0x1p-30;
    const double q = a / b, held = q > -1 ? q < max + 1 ? q : max + 1 : -1;
    const double above = held + 1.5; /* positive, so that a cast is a floor */
    const int32_t whole = (int32_t) above;
    *level = whole < 1 ? 0 : whole > max + 1 ? max : whole - 1;
    return above - whole >= off && 1 - (above - whole) > off;
}

/*
 * How far a sum in doubles over so many columns is off.  Columns of 63 bits are rounded, and so are their products
 * and, but for the first, their sums: that is count + 1 times 2^-53 of the greatest sum there can be.
 */
static double error_of(const job *j, int32_t count)
{
    return j->most < 0x1p53 ? 0 : j->most * (count + 1) * 0x1p-52;
}

/* Decides what may be 0 in vector i, that of texel x, and the total of its weights; is it too inexact? */
static bool judge(const job *j, ntp__vectors *v, double *total, int32_t i, int32_t x)
{
    const double error = error_of(j, j->plan->x.span[x].count);
    if (fabs(total[i]) <= error && !any_other(j, SUM_WEIGHT, x))
        total[i] = -INFINITY;
    const bool none = total[i] <= 0;
    for (int32_t k = 0; k < 3 && none; k++)
        v->c[k][i] = 0;
    const double a = v->c[0][i], b = v->c[1][i], c = v->c[2][i];
    if (c < 0 && overshot(j, x))
        v->c[2][i] = 0;
    /* A component over the length is off by 2^-33, as kernels.h says. */
    return error > 0 && total[i] != -INFINITY &&
           (fabs(total[i]) <= error ||
            (!none && (fabs(c) <= error || a * a + b * b + c * c <= error * error * 0x1p68)));
}

/* The third sample of NTP_ENCODING_XY, and alpha, of n texels of row y. */
static void resize_samples(const job *j, ntp__block *out, const double *total, int32_t x, int32_t y,
                           int32_t n)
{
    const double level = j->weighted ? j->m : 1; /* which sums of alpha are not multiplied by */
    double alpha[NTP__BLOCK], extra[NTP__BLOCK];
    if (j->sum[SUM_ALPHA] != NULL)
        across_quickly(j, alpha, SUM_ALPHA, x, n);
    if (j->sum[SUM_EXTRA] != NULL)
        across_quickly(j, extra, SUM_EXTRA, x, n);
    for (int32_t i = 0; i < n; i++) {
        const ntp__span_of_taps span = j->plan->x.span[x + i];
        const double error = error_of(j, span.count);
        const double one = (double) span.total * j->plan->y.span[y].total;
        const bool none = total[i] <= 0;
        bool known = error == 0 || fabs(total[i]) > error;
        if (j->sum[SUM_EXTRA] != NULL && !none)
            known &= ratio_quickly(&out->c[2][i], extra[i], total[i], error, j->m);
        if (j->sum[SUM_ALPHA] != NULL)
            known &= ratio_quickly(&out->c[3][i], alpha[i], one, error / level, j->m);
        if (!known)
            resize_samples_exactly(j, out, i, x + i, y);
        else if (none && j->sum[SUM_ALPHA] != NULL &&
                 !(j->plan->how.touch_unused & NTP_UNUSED_TRANSPARENT))
            out->c[3][i] = 0;
    }
}

/* n texels of row y of the result, from the sums of the columns. */
static void resize_run(const job *j, ntp__block *out, int32_t x, int32_t y, int32_t n)
{
    int32_t doubt[NTP__BLOCK];
    bool inexact[NTP__BLOCK];
    double total[NTP__BLOCK];
    ntp__vectors v;
    across_quickly(j, total, SUM_WEIGHT, x, n);
    for (int32_t k = 0; k < 3; k++)
        across_quickly(j, &v.c[k][0], k, x, n);
    for (int32_t i = 0; i < n; i++) {
        out->c[2][i] = j->m;
        inexact[i] = judge(j, &v, total, i, x + i);
    }
    const bool any =
        ntp__block_directions(out, doubt, &v, n, j->m, j->src->encoding, j->most < 0x1p53);
    for (int32_t i = 0; i < n; i++) {
        if (inexact[i] || (any && doubt[i]))
            resize_texel(j, out, i, x + i);
    }
    if (j->sum[SUM_EXTRA] != NULL || j->sum[SUM_ALPHA] != NULL)
        resize_samples(j, out, total, x, y, n);
}

/* The source columns of columns x0..x1 - 1 of the result: all columns if some lie outside. */
static void columns_of(const job *j, int32_t *first, int32_t *end, int32_t x0, int32_t x1)
{
    const ntp__axis *axis = &j->plan->x;
    *first = axis->span[x0].first;
    *end = axis->span[x1 - 1].first + axis->span[x1 - 1].count;
    if (j->rows != NULL) {
        *first = 0;
        *end = j->columns;
    } else if (*first < 0 || *end > axis->src) {
        *first = 0;
        *end = axis->src;
    }
}

/* Does texels in doubt again, from their vectors if these are integers, or from exact ones.  The n texels are
 * at[0].. of the strip (NULL: all). */
static void settle_strip(const job *j, ntp__block *out, const ntp__vectors *v, const int32_t *doubt,
                         const int32_t *inexact, const int32_t *at, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        ntp__i128 sum[3];
        if ((doubt[i] | inexact[i]) == 0)
            continue;
        for (int32_t k = 0; k < 3 && j->most < 0x1p53; k++)
            sum[k] = ntp__i128_of((int64_t) v->c[k][i]);
        if (j->most >= 0x1p53)
            ntp__strip_exactly(j, sum, v, i, at == NULL ? i : at[i]);
        put_direction(j, out, i, sum);
    }
}

static void resize_strip_row(const job *j, const ntp_rect *strip, int32_t y)
{
    int32_t doubt[NTP__BLOCK], inexact[NTP__BLOCK], places[NTP__BLOCK];
    const int32_t *at = places, x0 = strip->x0, width = strip->x1 - x0;
    ntp__block out;
    ntp__vectors v;
    int32_t n = ntp__strip_packed(j, &v, inexact, places, y);
    bool any = true;
    if (n == 0)
        return;
    if (n < 0)
        any = ntp__strip_vectors(j, &v, inexact, y) > 0;
    if (n < 0 || n == width) {
        n = width;
        at = NULL;
    }
    if (ntp__block_directions(&out, doubt, &v, n, j->m, j->src->encoding, true) || any)
        settle_strip(j, &out, &v, doubt, inexact, at, n);
    if (at == NULL)
        ntp__store_levels(j->dst, &out, x0, y, n);
    for (int32_t i = 0; at != NULL && i < n; i++) {
        void *d = ntp__at_mut(j->dst, x0 + at[i], y);
        for (int32_t k = 0; k < 3; k++) {
            if (j->m > 255)
                ((uint16_t *) d)[k] = (uint16_t) out.c[k][i];
            else
                ((uint8_t *) d)[k] = (uint8_t) out.c[k][i];
        }
    }
}

/* A strip: columns from rect->x0 on; returns where it ends. */
static int32_t resize_strip(const job *j, const ntp_rect *rect)
{
    ntp_rect strip = *rect;
    strip.x1 = ntp__strip_begin(j, rect->x0, rect->x1);
    for (int32_t y = rect->y0; y < rect->y1; y++)
        resize_strip_row(j, &strip, y);
    return strip.x1;
}

static void resize_area(const job *j, const ntp_rect *rect)
{
    int32_t first, end;
    columns_of(j, &first, &end, rect->x0, rect->x1);
    ntp__block out;
    for (int32_t y = rect->y0; y < rect->y1; y++) {
        ntp__sum_columns(j, y, first, end);
        for (int32_t x = rect->x0; x < rect->x1; x += NTP__BLOCK) {
            int32_t n = rect->x1 - x < NTP__BLOCK ? rect->x1 - x : NTP__BLOCK;
            resize_run(j, &out, x, y, n);
            ntp__store_levels(j->dst, &out, x, y, n);
        }
    }
}

/* As resize_strip, with rows that are kept. */
static int32_t resize_kept(job *j, const ntp_rect *rect)
{
    ntp_rect strip = *rect;
    strip.x1 = ntp__keep_rows(j, rect->x0, rect->x1);
    resize_area(j, &strip);
    return strip.x1;
}

/* Strips as high as the image would touch a memory page for each row.  What one has read of a line
 * of the cache is to be there when the next one wants the rest. */
static void resize_strips(job *j, const ntp_rect *rect)
{
    enum { LEAST = 64, MOST = 256, BYTES = 1536 /* in a column of the source */ };
    const ntp__axis *y = &j->plan->y;
    const int64_t rows =
        BYTES * (int64_t) y->dst / (y->src * (int64_t) ntp__sample_size(j->src->type) * 3);
    const int32_t most = rows < LEAST ? LEAST : rows > MOST ? MOST : (int32_t) rows;
    for (ntp_rect band = *rect; band.y0 < rect->y1; band.y0 = band.y1) {
        band.y1 = rect->y1 - band.y0 < most ? rect->y1 : band.y0 + most;
        for (band.x0 = rect->x0; band.x0 < rect->x1;)
            band.x0 = j->strip != NULL ? resize_strip(j, &band) : resize_kept(j, &band);
    }
}

ntp_status ntp_resize(const ntp_image *dst, const ntp_const_image *src, const ntp_resize_plan *plan,
                      void *scratch, size_t scratch_size, const ntp_rect *area)
{
    if (dst == NULL || plan == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_normals(&target));
    if (src->width != plan->x.src || src->height != plan->y.src || dst->width != plan->x.dst ||
        dst->height != plan->y.dst)
        return NTP_ERR_SHAPE;
    if (dst->type != src->type || dst->encoding != src->encoding ||
        dst->channels != src->channels || dst->y != src->y)
        return NTP_ERR_FORMAT;
    if (dst->data == src->data)
        return NTP_ERR_OVERLAP;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, &target, area));
    if (scratch == NULL || (uintptr_t) scratch % 16 != 0 ||
        scratch_size < ntp_resize_scratch_size(plan))
        return NTP_ERR_SCRATCH;

    job j = { .dst = dst, .src = src, .plan = plan, .m = ntp__max(src->type) };
    bool alpha = src->channels == 4;
    j.weighted = alpha && !(plan->how.touch_unused & NTP_UNUSED_TRANSPARENT);
    size_t plane = columns_size(plan) / SUMS;
    const double level = (double) j.m * (j.weighted ? j.m : 1);
    j.quickly = (double) plan->y.most * level < 0x1p53;
    j.most = (double) plan->y.most * (double) plan->x.most * level;
    for (size_t k = 0; k < SUMS; k++) {
        const bool needed = k == SUM_ALPHA      ? alpha
                            : k == SUM_NEGATIVE ? plan->how.filter == NTP_FILTER_LANCZOS3
                            : k == SUM_EXTRA ? src->encoding == NTP_ENCODING_XY && src->channels > 2
                                             : true;
        j.sum[k] = needed ? (int64_t *) (void *) ((char *) scratch + k * plane) : NULL;
        j.quick[k] = (double *) (void *) j.sum[k];
    }
    if (ntp__strip_size(plan) > 0) {
        char *strip = (char *) scratch + columns_size(plan);
        strip += -(uintptr_t) strip % NTP__LINE;
        if (j.quickly && src->channels == 3 && src->encoding != NTP_ENCODING_XY)
            j.strip = (ntp__strip *) (void *) strip;
        else
            ntp__find_room(&j, strip, ntp__strip_size(plan) - NTP__LINE);
    }
    if (j.strip != NULL || j.rows != NULL)
        resize_strips(&j, &rect);
    else
        resize_area(&j, &rect);
    return NTP_OK;
}
