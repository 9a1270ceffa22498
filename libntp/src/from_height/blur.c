/* SPDX-License-Identifier: MIT */
/*
 * blur.c - Gaussian blur of a heightfield with integer weights
 *
 * A ring holds rows that are blurred horizontally, and each row of the result is a weighted sum of
 * them.  Sums are doubles, added in the same order at every place.  So a texture that tiles still
 * does, and the result is the same on every machine.
 */
#include "from_height/gradient.h"

#include <string.h>

enum {
    UNIT = 65536, /* sum of the weights of an axis */
    REACH = 3,    /* standard deviations on each side; 0.3 % of a Gaussian lies beyond */
    MAX_WEIGHTS = REACH * NTP_MAX_SIGMA + 1
};

typedef struct blur {
    ntp__gradient g; /* the part that reads heights */
    int32_t radius;
    int32_t weight[MAX_WEIGHTS]; /* of the texels at distance 0, 1, ... */
    double *ring, *line;
} blur;

/* exp(-x), x >= 0, in basic operations, so that its bits are the same everywhere. */
static double decay(double x)
{
    int32_t squarings = 0;
    while (x > 0.125) {
        x /= 2;
        squarings++;
    }
    double term = 1, sum = 1;
    for (int32_t k = 1; k < 16; k++) {
        term *= -x / k;
        sum += term;
    }
    for (; squarings > 0; squarings--)
        sum *= sum;
    return sum;
}

/* Rounds the Gaussian to integers.  The weight in the middle makes up for the rounding. */
static void set_weights(blur *b, double sigma)
{
    double value[MAX_WEIGHTS], sum = 1;
    b->radius = (int32_t) (REACH * sigma);
    b->radius += b->radius < REACH * sigma;
    value[0] = 1;
    for (int32_t k = 1; k <= b->radius; k++) {
        value[k] = decay(k * (k / (2 * sigma * sigma)));
        sum += 2 * value[k];
    }
    b->weight[0] = UNIT;
    for (int32_t k = 1; k <= b->radius; k++) {
        b->weight[k] = (int32_t) (value[k] / sum * UNIT + 0.5);
        b->weight[0] -= 2 * b->weight[k];
    }
}

static bool options_good(const ntp_blur_options *how)
{
    return how != NULL && how->sigma >= 0 && how->sigma <= NTP_MAX_SIGMA &&
           how->weight - how->weight == 0 && (int) how->border_x >= 0 &&
           (int) how->border_x <= NTP_BORDER_REPEAT_SLOPE && (int) how->border_y >= 0 &&
           (int) how->border_y <= NTP_BORDER_REPEAT_SLOPE && (int) how->source >= 0 &&
           (int) how->source <= NTP_HEIGHT_SOURCE_SCREEN;
}

/* The rows of the ring, a row of heights with what lies beyond the edges, and one more row. */
static size_t scratch_doubles(int32_t radius, int32_t width)
{
    return (size_t) (2 * radius + 1) * (size_t) width + 2 * (size_t) width + 2 * (size_t) radius;
}

size_t ntp_height_blur_scratch_size(const ntp_blur_options *how, int32_t width)
{
    if (!options_good(how) || width < 1 || width > NTP_MAX_SIDE)
        return 0;
    blur b;
    set_weights(&b, how->sigma);
    return scratch_doubles(b.radius, width) * sizeof(double);
}

/* One row inside the image, blurred along x. */
static void blur_row(const blur *b, double *out, int32_t y)
{
    const ntp__gradient *g = &b->g;
    int32_t width = g->src->width, radius = b->radius;
    for (int32_t x = -radius; x < width + radius; x++) {
        ntp__mapped map = ntp__border_map(g->border_x, x, width);
        double h = 0;
        for (int32_t k = 0; k < map.count; k++)
            h += map.weight[k] * ntp__height_value(g, map.index[k], y);
        b->line[x + radius] = h;
    }
    for (int32_t x = 0; x < width; x++) {
        const double *at = b->line + x + radius;
        double sum = b->weight[0] * at[0];
        for (int32_t k = 1; k <= radius; k++)
            sum += b->weight[k] * (at[-k] + at[k]);
        out[x] = sum;
    }
}

/* Row y of the ring.  y runs from -radius to height + radius - 1, beyond both edges. */
static void fill_ring_row(const blur *b, int32_t y)
{
    int32_t width = b->g.src->width, rows = 2 * b->radius + 1;
    double *out = b->ring + (size_t) ((y + rows) % rows) * (size_t) width;
    ntp__mapped map = ntp__border_map(b->g.border_y, y, b->g.src->height);
    blur_row(b, out, map.index[0]);
    if (map.count == 1)
        return;
    for (int32_t x = 0; x < width; x++)
        out[x] *= map.weight[0];
    double *other = b->line + width + 2 * b->radius;
    blur_row(b, other, map.index[1]);
    for (int32_t x = 0; x < width; x++)
        out[x] += map.weight[1] * other[x];
}

static void write_row(const blur *b, const ntp_image *dst, const ntp_blur_options *how, int32_t y)
{
    int32_t width = b->g.src->width, rows = 2 * b->radius + 1;
    for (int32_t x = 0; x < width; x++) {
        const double *ring = b->ring + x;
        double sum = 0;
        for (int32_t k = b->radius; k >= 0; k--) {
            size_t above = (size_t) ((y - k + rows) % rows) * (size_t) width;
            size_t below = (size_t) ((y + k + rows) % rows) * (size_t) width;
            sum += b->weight[k] * (k == 0 ? ring[above] : ring[above] + ring[below]);
        }
        float *d = ntp__at_mut(dst, x, y);
        double h = sum / ((double) UNIT * UNIT) * how->weight;
        *d = (float) (how->add ? (double) *d + h : h);
    }
}

ntp_status ntp_height_blur(const ntp_image *dst, const ntp_const_image *src,
                           const ntp_blur_options *how, void *scratch, size_t scratch_size)
{
    if (dst == NULL || src == NULL || !options_good(how))
        return NTP_ERR_ARGUMENT;
    ntp_const_image view = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_view(&view));
    NTP__TRY(ntp__check_view(src));
    if (src->encoding != NTP_ENCODING_HEIGHT || dst->encoding != NTP_ENCODING_HEIGHT ||
        dst->type != NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&view, src))
        return NTP_ERR_SHAPE;
    if (dst->data == src->data)
        return NTP_ERR_OVERLAP;
    blur b;
    memset(&b.g, 0, sizeof b.g);
    b.g.src = src;
    NTP__TRY(ntp__gradient_source(&b.g, how->source));
    if (scratch == NULL || (uintptr_t) scratch % sizeof(double) != 0 ||
        scratch_size < ntp_height_blur_scratch_size(how, src->width))
        return NTP_ERR_SCRATCH;
    set_weights(&b, how->sigma);
    b.g.border_x = ntp__border_beyond(how->border_x);
    b.g.border_y = ntp__border_beyond(how->border_y);
    b.ring = scratch;
    b.line = b.ring + (size_t) (2 * b.radius + 1) * (size_t) src->width;
    for (int32_t y = -b.radius; y < b.radius; y++)
        fill_ring_row(&b, y);
    for (int32_t y = 0; y < src->height; y++) {
        fill_ring_row(&b, y + b.radius);
        write_row(&b, dst, how, y);
    }
    return NTP_OK;
}
