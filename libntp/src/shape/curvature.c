/* SPDX-License-Identifier: MIT */
/*
 * curvature.c - the curvature of a surface, from its heights or its normals
 *
 * The room of maps about the shape of a surface.  Both operations know nothing of colors: they read
 * one channel of heights, or x and y of normals.
 *   curvature.c   curvature and cavity, of the 3 x 3 texels around each
 *   occlusion.c   ambient occlusion: the sum over directions (horizon.c: the horizon of a line)
 *
 * Everything is in doubles with + - * / and sqrt only, in a fixed order.  y runs down the picture
 * here; curvature does not depend on that.
 */
#include "base/finite.h"
#include "base/view.h"
#include "texel/sample.h"

#include <math.h>
#include <string.h>

/* The texels around one: columns and rows, and where the middle is. */
typedef struct around {
    int32_t x[3], y[3];
} around;

/* The derivatives of (x, y) of the normal; y is down. */
typedef struct bend {
    double mean, gaussian;
} bend;

/* i - 1, i, i + 1 of an axis of n texels. */
static void neighbors(int32_t at[3], int32_t i, int32_t n, ntp_border border)
{
    if (border == NTP_BORDER_CLAMP && n >= 3)
        i = i < 1 ? 1 : i > n - 2 ? n - 2 : i;
    at[0] = i > 0 ? i - 1 : border == NTP_BORDER_WRAP ? n - 1 : 0;
    at[1] = i;
    at[2] = i < n - 1 ? i + 1 : border == NTP_BORDER_WRAP ? 0 : n - 1;
}

static bend of_heights(const ntp_const_image *src, const around *a, double scale)
{
    double h[3][3];
    for (int32_t j = 0; j < 3; j++)
        for (int32_t i = 0; i < 3; i++)
            h[j][i] = ntp__sample(src, a->x[i], a->y[j], 0);
    const double p = (h[1][2] - h[1][0]) / 2 * scale, q = (h[2][1] - h[0][1]) / 2 * scale;
    const double xx = (h[1][2] - h[1][1] - (h[1][1] - h[1][0])) * scale;
    const double yy = (h[2][1] - h[1][1] - (h[1][1] - h[0][1])) * scale;
    const double xy = (h[2][2] + h[0][0] - (h[2][0] + h[0][2])) / 4 * scale;
    const double w2 = 1 + (p * p + q * q);
    const double bent = (1 + q * q) * xx + (1 + p * p) * yy - 2 * (p * q * xy);
    return (bend) { -bent / (2 * w2 * sqrt(w2)), (xx * yy - xy * xy) / (w2 * w2) };
}

static bool is_unused(const ntp_const_image *src, int32_t x, int32_t y)
{
    const double m = src->type == NTP_TYPE_F32 ? 1 : ntp__max(src->type),
                 r = ntp__sample(src, x, y, 0);
    for (int32_t c = 1; c < src->channels && c < 3; c++)
        if (ntp__sample(src, x, y, c) != r)
            return src->channels == 4 && ntp__sample(src, x, y, 3) == 0;
    return r == 0 || r == m || (src->channels == 4 && ntp__sample(src, x, y, 3) == 0);
}

static bend of_normals(const ntp_const_image *src, const around *a)
{
    /* The middle of a difference is 2 texels wide; levels are 2/M apart, floats 1 or 2. */
    const double unit = src->encoding == NTP_ENCODING_VECTOR ? 1
                        : src->type == NTP_TYPE_F32          ? 2
                                                             : 2.0 / ntp__max(src->type);
    const double up = src->y == NTP_Y_UP ? -1 : 1;
    double d[2][2];
    for (int32_t c = 0; c < 2; c++) {
        const double factor = (c == 0 ? 1 : up) * unit / 2;
        d[c][0] = (ntp__sample(src, a->x[2], a->y[1], c) - ntp__sample(src, a->x[0], a->y[1], c)) *
                  factor;
        d[c][1] = (ntp__sample(src, a->x[1], a->y[2], c) - ntp__sample(src, a->x[1], a->y[0], c)) *
                  factor;
    }
    const bend none = { 0, 0 };
    for (int32_t i = 0; i < 3; i++)
        if (is_unused(src, a->x[i], a->y[1]) || is_unused(src, a->x[1], a->y[i]))
            return none;
    return (bend) { (d[0][0] + d[1][1]) / 2, d[0][0] * d[1][1] - d[0][1] * d[1][0] };
}

static double value_of(const bend *b, ntp_curvature_kind kind)
{
    if (!ntp__is_finite(b->mean) || !ntp__is_finite(b->gaussian))
        return 0;
    if (kind == NTP_CURVATURE_MEAN)
        return b->mean;
    if (kind == NTP_CURVATURE_GAUSSIAN)
        return b->gaussian;
    /* Below 0 by rounding, or where normals are not those of a surface. */
    const double half = b->mean * b->mean - b->gaussian;
    const double apart = half > 0 ? sqrt(half) : 0;
    const double k = kind == NTP_CURVATURE_CONVEX ? b->mean + apart : apart - b->mean;
    return k > 0 ? k : 0;
}

static void store(const ntp_image *dst, int32_t x, int32_t y, double v,
                  const ntp_curvature_options *how)
{
    void *at = ntp__at_mut(dst, x, y);
    if (how->range > 0) {
        v /= how->range;
        v = how->kind == NTP_CURVATURE_CONVEX   ? v
            : how->kind == NTP_CURVATURE_CAVITY ? 1 - v
                                                : (v + 1) / 2;
        v = v < 0 ? 0 : v > 1 ? 1 : v;
    }
    const double m = ntp__max(dst->type);
    if (dst->type == NTP_TYPE_U8)
        *(uint8_t *) at = (uint8_t) (v * m + 0.5);
    else if (dst->type == NTP_TYPE_U16)
        *(uint16_t *) at = (uint16_t) (v * m + 0.5);
    else
        *(float *) at = (float) v;
}

static bool border_good(ntp_border border)
{
    return border == NTP_BORDER_WRAP || border == NTP_BORDER_CLAMP;
}

ntp_status ntp_curvature(const ntp_image *dst, const ntp_const_image *src,
                         const ntp_curvature_options *how, const ntp_rect *area)
{
    static const ntp_curvature_options DEFAULTS;
    ntp_rect r;
    around a;
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    how = how != NULL ? how : &DEFAULTS;
    const ntp_const_image view = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_view(&view));
    NTP__TRY(ntp__check_view(src));
    if ((int) how->kind < NTP_CURVATURE_MEAN || (int) how->kind > NTP_CURVATURE_CAVITY ||
        !ntp__is_finite(how->scale) || !ntp__is_finite(how->range) || how->range < 0 ||
        !border_good(how->border_x) || !border_good(how->border_y))
        return NTP_ERR_ARGUMENT;
    if (dst->encoding != NTP_ENCODING_HEIGHT || (dst->type != NTP_TYPE_F32 && !(how->range > 0)))
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&view, src))
        return NTP_ERR_SHAPE;
    if (dst->data == src->data)
        return NTP_ERR_OVERLAP;
    NTP__TRY(ntp__check_area(&r, src, area));
    const bool heights = src->encoding == NTP_ENCODING_HEIGHT;
    const double unit = src->type == NTP_TYPE_F32 ? 1 : 1.0 / ntp__max(src->type);
    const double scale = (how->scale != 0 ? how->scale : 1) * unit;
    for (int32_t y = r.y0; y < r.y1; y++) {
        neighbors(a.y, y, src->height, how->border_y);
        for (int32_t x = r.x0; x < r.x1; x++) {
            neighbors(a.x, x, src->width, how->border_x);
            const bend b = heights ? of_heights(src, &a, scale) : of_normals(src, &a);
            store(dst, x, y, value_of(&b, how->kind), how);
        }
    }
    return NTP_OK;
}

/* ------------------------------------------------------------------------------ range */

enum {
    BIN_BITS = 4, /* of the mantissa: 16 bins in an octave */
    BIN_SHIFT = 23 - BIN_BITS,
    BINS = 1 << (8 + BIN_BITS),
    LEFT_OUT = 100 /* one in so many values lies outside of the range */
};

/* The least float above a bin of the bits of floats. */
static double end_of(uint32_t bin)
{
    const uint32_t bits = (bin + 1) << BIN_SHIFT;
    float v;
    memcpy(&v, &bits, sizeof v);
    return (double) v;
}

ntp_status ntp_curvature_range(double *range, const ntp_const_image *values)
{
    uint32_t count[BINS] = { 0 };
    uint64_t all = 0, outside = 0;
    if (range == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_view(values));
    if (values->type != NTP_TYPE_F32 || values->encoding != NTP_ENCODING_HEIGHT)
        return NTP_ERR_FORMAT;
    for (int32_t y = 0; y < values->height; y++) {
        for (int32_t x = 0; x < values->width; x++) {
            const float *at = ntp__at(values, x, y);
            uint32_t bits;
            memcpy(&bits, at, sizeof bits);
            bits &= INT32_MAX;
            if (bits == 0 || !ntp__is_finite((double) *at))
                continue;
            count[bits >> BIN_SHIFT]++;
            all++;
        }
    }
    *range = 0;
    for (uint32_t bin = BINS; bin-- > 0 && all > 0;) {
        outside += count[bin];
        if (outside * LEFT_OUT > all) {
            *range = end_of(bin);
            break;
        }
    }
    return NTP_OK;
}
