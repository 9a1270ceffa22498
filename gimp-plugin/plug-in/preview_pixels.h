/* SPDX-License-Identifier: MIT */
/*
 * preview_pixels.h - which texels a pixel of a preview shows
 */
#ifndef NTP_PLUGIN_PREVIEW_PIXELS_H
#define NTP_PLUGIN_PREVIEW_PIXELS_H

#include "preview.h"

#include <math.h>

static inline int32_t preview_texel_at(double start, double step, double i, int32_t size)
{
    const double at = start + i * step;
    return at < 0 ? 0 : at >= (double) size ? size - 1 : (int32_t) at;
}

/* How many texels a pixel averages on each axis. */
static inline int32_t preview_texels_in_pixel(const preview *p)
{
    const int32_t all = p->step > 1 ? (int32_t) ceil(p->step) : 1;
    return p->most > 0 && p->most < all ? p->most : all;
}

/* The texel under sample k of n of pixel i. */
static inline int32_t preview_column_of(const preview *p, int32_t i, int32_t k, int32_t n)
{
    return preview_texel_at(p->x, p->step, (double) i + ((double) k + 0.5) / (double) n,
                            p->layer->width);
}

static inline int32_t preview_row_of(const preview *p, int32_t j, int32_t k, int32_t n)
{
    return preview_texel_at(p->y, p->step, (double) j + ((double) k + 0.5) / (double) n,
                            p->layer->height);
}

/* The row behind the last one to be shown. */
static inline int32_t preview_end_of(const preview *p)
{
    return p->end > 0 ? p->end : p->height;
}

#endif
