/* SPDX-License-Identifier: MIT */
/*
 * pack.c - writes the result of heightfield -> normals into pixels
 */
#include "from_height/gradient.h"

#include "base/finite.h"
#include "texel/level.h"

static float unit_alpha(const ntp__gradient *g, int32_t x, int32_t y)
{
    if (g->alpha == NTP_ALPHA_HEIGHT || g->alpha == NTP_ALPHA_INVERSE_HEIGHT) {
        double h = ntp__height_value(g, x, y);
        if (!ntp__is_finite(h))
            return 0;
        return (float) (g->invert != (g->alpha == NTP_ALPHA_INVERSE_HEIGHT) ? 1 - h : h);
    }
    int32_t channels = g->src->channels;
    if (g->alpha == NTP_ALPHA_ONE || channels % 2 == 1)
        return 1;
    const void *p = ntp__at(g->src, x, y);
    double a = g->src->type == NTP_TYPE_U8    ? ((const uint8_t *) p)[channels - 1] / 255.0
               : g->src->type == NTP_TYPE_U16 ? ((const uint16_t *) p)[channels - 1] / 65535.0
                                              : (double) ((const float *) p)[channels - 1];
    return (float) (g->alpha == NTP_ALPHA_INVERSE ? 1 - a : a);
}

static int32_t level_alpha(const ntp__gradient *g, int32_t x, int32_t y)
{
    int32_t m = g->m, channels = g->src->channels;
    if (g->alpha == NTP_ALPHA_HEIGHT || g->alpha == NTP_ALPHA_INVERSE_HEIGHT) {
        bool inverse = g->invert != (g->alpha == NTP_ALPHA_INVERSE_HEIGHT);
        return ntp__height_level(g, x, y, inverse, m);
    }
    if (g->alpha == NTP_ALPHA_ONE || channels % 2 == 1)
        return m;
    const void *p = ntp__at(g->src, x, y);
    bool inverse = g->alpha == NTP_ALPHA_INVERSE;
    if (g->src->type == NTP_TYPE_F32)
        return ntp__share_level((double) ((const float *) p)[channels - 1], inverse, m);
    int32_t a;
    if (g->src->type == NTP_TYPE_U8) {
        a = ((const uint8_t *) p)[channels - 1] * (m / 255);
    } else {
        a = ((const uint16_t *) p)[channels - 1];
        a = m == 255 ? ntp__narrow(a) : a; /* without ties */
    }
    return inverse ? m - a : a;
}

void ntp__gradient_pack(const ntp__gradient *g, ntp__block *block, int32_t x, int32_t y, int32_t n)
{
    const ntp_image *dst = g->dst;
    if (dst->encoding == NTP_ENCODING_XY) {
        for (int32_t i = 0; i < n; i++)
            block->c[2][i] = g->m;
    }
    if (dst->channels == 4) {
        for (int32_t i = 0; i < n; i++)
            block->c[3][i] = level_alpha(g, x + i, y);
    }
    ntp__pack(dst, block, x, y, n, dst->channels);
}

void ntp__gradient_pack_floats(const ntp__gradient *g, const float *value, int32_t x, int32_t y,
                               int32_t n)
{
    const ntp_image *dst = g->dst;
    const int32_t channels = dst->channels;
    const bool xy = dst->encoding == NTP_ENCODING_XY;
    for (int32_t i = 0; i < n; i++, value += 3) {
        float *d = ntp__at_mut(dst, x + i, y);
        d[0] = value[0];
        d[1] = value[1];
        if (channels > 2)
            d[2] = xy ? 1.0f : value[2];
        if (channels > 3)
            d[3] = unit_alpha(g, x + i, y);
    }
}
