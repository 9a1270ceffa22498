/* SPDX-License-Identifier: MIT */
/*
 * resize_weights.c - the weights of a resizing filter along one axis, as integers
 *
 * A weight is an integer and means weight / (sum of the weights of its texel).  So nothing has to
 * be normalized, and the weights add up to exactly one.  The center of texel i of the source lies
 * |N| / D filter units from the center of texel j of the result, with the integers
 *     N = (2i + 1) dst - (2j + 1) src,    D = 2 max(src, dst).
 * A unit is a texel of the source, or of the result if the texture shrinks.  Weights of the box are
 * exact.  So are those of the triangle, unless max(src, dst) (max(src, dst) / dst + 1) > 2^29.
 * Lanczos weights are rounded to about 2^-30.  They come from our own sine in integers, so that
 * they are the same everywhere.
 */
#include "reshape/resize.h"
#include "stencil/border.h"

#include <string.h>

/*
 * Sums of |weight| stay below 1.6 * 2^30, because for Lanczos the sum of |weight| is at most 1.54
 * times the sum of the weights.  Then a column of 16-bit levels times 16-bit alphas adds up to less
 * than 2^63.
 */
enum { TOTAL_BITS = 30 };

static int32_t radius_of(ntp_filter filter)
{
    return filter == NTP_FILTER_LANCZOS3 ? 3 : 1;
}

static int64_t greater(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t floor_div(int64_t a, int64_t b)
{
    int64_t q = a / b;
    return a % b < 0 ? q - 1 : q;
}

int32_t ntp__axis_stride(ntp_filter filter, int32_t src, int32_t dst)
{
    int64_t most = greater(src, dst);
    if (filter == NTP_FILTER_BOX)
        return (src + dst - 1) / dst + 1;
    return (int32_t) ((2 * radius_of(filter) * most + dst - 1) / dst + 1);
}

/* sin(pi f) / (pi f), f <= 1/2, both in units of 2^-32, by a Taylor series good to 2^-36. */
static uint64_t sinc_near(uint64_t f)
{
    /* pi^2k / (2k + 1)! 2^32 */
    static const uint64_t COEFFICIENT[] = { 4294967296u, 7064938021u, 3486407169u, 819272846u,
                                            112304151u,  10076341u,   637497u,     29961u };
    uint64_t square = f * f >> 32, sum = COEFFICIENT[7];
    for (int32_t k = 6; k >= 0; k--)
        sum = COEFFICIENT[k] - (sum * square >> 32);
    return sum;
}

/* sinc(n / d) in units of 2^-32, n >= 0.  |sin(pi x)| depends only on the distance of x from the
 * nearest integer. */
static int64_t sinc(int64_t n, int64_t d)
{
    int64_t whole = (2 * n + d) / (2 * d), rest = n - whole * d;
    int64_t away = rest < 0 ? -rest : rest;
    int64_t near = (int64_t) sinc_near(((uint64_t) away << 32) / (uint64_t) d);
    if (whole == 0)
        return near;
    /* sin(pi x) = (-1)^whole sin(pi rest); away / n is rest over x. */
    int64_t value = near * away / n;
    return (whole % 2 != 0) != (rest < 0) ? -value : value;
}

/* The weight at distance n / d, n >= 0, shifted down and rounded. */
static int32_t weight_at(ntp_filter filter, int64_t n, int64_t d, int32_t shift)
{
    int64_t half = shift > 0 ? (int64_t) 1 << (shift - 1) : 0;
    if (filter == NTP_FILTER_TRIANGLE)
        return (int32_t) ((d - n + half) >> shift);
    int64_t a = sinc(n, d), b = sinc(n, 3 * d);
    /* Both are at most 2^32; halves keep their product in 64 bits. */
    int64_t magnitude = (int64_t) ((uint64_t) (a < 0 ? -a : a) * ((uint64_t) b / 2) >> 31);
    int32_t w = (int32_t) ((magnitude + half) >> shift);
    return a < 0 ? -w : w;
}

/* In units of 1/dst, texel j covers the source from j src to (j + 1) src.  Weights are the overlaps
 * with the texels there. */
static void box(ntp__axis *axis, int32_t j, int32_t *weight)
{
    int64_t low = (int64_t) j * axis->src, high = low + axis->src;
    int64_t first = low / axis->dst, last = (high - 1) / axis->dst;
    for (int64_t i = first; i <= last; i++) {
        int64_t begin = greater(i * axis->dst, low), end = (i + 1) * axis->dst;
        weight[i - first] = (int32_t) ((end < high ? end : high) - begin);
    }
    ntp__span_of_taps span = { (int32_t) first, (int32_t) (last - first + 1), axis->src };
    axis->span[j] = span;
}

/* Weights mean the same without a common divisor, and sums of small ones are exact in more ways. */
static void reduce(ntp__axis *axis)
{
    int32_t divisor = 0;
    for (int32_t j = 0; j < axis->dst; j++) {
        for (int32_t t = 0; t < axis->span[j].count && divisor != 1; t++) {
            int32_t a = axis->weight[(ptrdiff_t) j * axis->stride + t];
            a = a < 0 ? -a : a;
            while (a != 0) {
                const int32_t rest = divisor % a;
                divisor = a;
                a = rest;
            }
        }
    }
    for (int32_t j = 0; j < axis->dst && divisor > 1; j++) {
        for (int32_t t = 0; t < axis->span[j].count; t++)
            axis->weight[(ptrdiff_t) j * axis->stride + t] /= divisor;
        axis->span[j].total /= divisor;
    }
    if (divisor > 1)
        axis->most /= divisor;
    for (axis->scale = 1; axis->scale * (double) axis->most > 1;)
        axis->scale /= 2;
}

/* Weights of n texels, of which the first lies at `off`; returns their sum. */
static int32_t weigh(ntp__axis *axis, ntp_filter filter, int32_t *weight, int32_t n, int64_t off,
                     int32_t shift)
{
    const int64_t d = 2 * greater(axis->src, axis->dst);
    int64_t size = 0;
    int32_t total = 0;
    for (int32_t i = 0; i < n; i++, off += 2 * (int64_t) axis->dst) {
        const int32_t w = weight_at(filter, off < 0 ? -off : off, d, shift);
        weight[i] = w;
        total += w;
        size += w < 0 ? -w : w;
    }
    axis->most = greater(axis->most, size);
    return total;
}

void ntp__axis_init(ntp__axis *axis, ntp_filter filter)
{
    int64_t src = axis->src, dst = axis->dst, d = 2 * greater(src, dst);
    int64_t reach = radius_of(filter) * d;
    /* The weights of a texel add up to about d / (2 dst) times the one at the center. */
    int64_t center = filter == NTP_FILTER_TRIANGLE ? d : (int64_t) 1 << 32;
    int64_t total = center * (d / (2 * dst) + 1);
    int64_t before = 0; /* where the first texel of the last span was, from the center */
    int32_t shift = 0;
    axis->most = filter == NTP_FILTER_BOX ? src : 0;
    while (total >> shift > (int64_t) 1 << TOTAL_BITS)
        shift++;
    for (int32_t j = 0; j < axis->dst; j++) {
        int32_t *weight = axis->weight + (ptrdiff_t) j * axis->stride;
        if (filter == NTP_FILTER_BOX) {
            box(axis, j, weight);
            continue;
        }
        /* The i with -reach < N < reach. */
        int64_t at = (2 * (int64_t) j + 1) * src - dst;
        int64_t first = floor_div(at - reach, 2 * dst) + 1;
        int64_t last = floor_div(at + reach - 1, 2 * dst);
        ntp__span_of_taps span = { (int32_t) first, (int32_t) (last - first + 1), 0 };
        const int64_t off = 2 * first * dst - at;
        if (j > 0 && off == before) { /* as where sides are halved */
            memcpy(weight, weight - axis->stride, (size_t) span.count * sizeof *weight);
            span.total = axis->span[j - 1].total;
        } else {
            span.total = weigh(axis, filter, weight, span.count, off, shift);
        }
        before = off;
        axis->span[j] = span;
    }
    reduce(axis);
}

int32_t ntp__axis_map(const ntp__axis *axis, int32_t i)
{
    if (i >= 0 && i < axis->src)
        return i;
    return ntp__border_map(axis->border, i, axis->src).index[0];
}
