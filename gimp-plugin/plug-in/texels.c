/* SPDX-License-Identifier: MIT */
/*
 * texels.c - alpha, DU/DV and channel order of finished texels
 */
#include "texels.h"

static size_t sample_size(const ntp_image *view)
{
    return view->type == NTP_TYPE_U8 ? 1 : view->type == NTP_TYPE_U16 ? 2 : 4;
}

static unsigned char *at(const ntp_image *view, int32_t x, int32_t y)
{
    return (unsigned char *) view->data + y * view->row_stride + x * view->pixel_stride;
}

ntp_image texels_crop(const ntp_image *view, const ntp_rect *area)
{
    ntp_image part = *view;
    part.data = at(view, area->x0, area->y0);
    part.width = area->x1 - area->x0;
    part.height = area->y1 - area->y0;
    return part;
}

ntp_image texels_channel(const ntp_image *view, int32_t channel)
{
    ntp_image one = *view;
    one.data = (unsigned char *) view->data + (size_t) channel * sample_size(view);
    one.channels = 1;
    one.encoding = NTP_ENCODING_HEIGHT;
    return one;
}

/* The number of a level: v is 0..1 of the type's range. */
static void store_share(unsigned char *to, ntp_type type, uint32_t level, uint32_t max)
{
    if (type == NTP_TYPE_U8)
        *to = (uint8_t) (max == 255 ? level : (level + 128) / 257);
    else if (type == NTP_TYPE_U16)
        *(uint16_t *) (void *) to = (uint16_t) (max == 255 ? level * 257 : level);
    else
        *(float *) (void *) to = (float) ((double) level / (double) max);
}

static void fill_alpha(const ntp_image *alpha, uint32_t level)
{
    for (int32_t y = 0; y < alpha->height; y++) {
        for (int32_t x = 0; x < alpha->width; x++)
            store_share(at(alpha, x, y), alpha->type, level, 255);
    }
}

static void invert_alpha(const ntp_image *alpha)
{
    for (int32_t y = 0; y < alpha->height; y++) {
        for (int32_t x = 0; x < alpha->width; x++) {
            unsigned char *a = at(alpha, x, y);
            if (alpha->type == NTP_TYPE_U8)
                *a = (uint8_t) (255 - *a);
            else if (alpha->type == NTP_TYPE_U16)
                *(uint16_t *) (void *) a = (uint16_t) (65535 - *(uint16_t *) (void *) a);
            else
                *(float *) (void *) a = 1 - *(float *) (void *) a;
        }
    }
}

void texels_alpha(const ntp_image *view, alpha_rule rule, const ntp_const_image *plane)
{
    const ntp_image alpha = texels_channel(view, 3);
    if (rule == ALPHA_ONE || rule == ALPHA_ZERO || plane->data == NULL) {
        fill_alpha(&alpha, rule == ALPHA_ZERO ? 0 : 255);
        return;
    }
    ntp_convert(&alpha, plane, NULL, NULL, NULL);
    if (rule == ALPHA_INVERSE)
        invert_alpha(&alpha);
}

void texels_swap(const ntp_image *view)
{
    const size_t size = sample_size(view);
    for (int32_t y = 0; y < view->height; y++) {
        for (int32_t x = 0; x < view->width; x++) {
            unsigned char *red = at(view, x, y), *blue = red + 2 * size;
            for (size_t i = 0; i < size; i++) {
                const unsigned char kept = red[i];
                red[i] = blue[i];
                blue[i] = kept;
            }
        }
    }
}

/* -------------------------------------------------------------------------------- DU/DV */

static double floor_of(double v) /* |v| far below 2^31 */
{
    const double cut = (double) (int32_t) v;
    return cut > v ? cut - 1 : cut;
}

/* The bit pattern of a component: rounded half up. */
static uint32_t pattern(double v, dudv_format format)
{
    const bool wide = format == DUDV_16_SIGNED || format == DUDV_16_UNSIGNED;
    const double half = wide ? 32767.5 : 127.5;
    if (format == DUDV_8_UNSIGNED || format == DUDV_16_UNSIGNED)
        return (uint32_t) floor_of((v + 1) * half + 0.5);
    const int32_t number = (int32_t) floor_of(v * (half - 0.5) + 0.5);
    return (uint32_t) number & (wide ? 65535 : 255);
}

void texels_dudv(const ntp_image *view, const ntp_const_image *vectors, dudv_format format)
{
    const bool wide = format == DUDV_16_SIGNED || format == DUDV_16_UNSIGNED;
    const size_t size = sample_size(view);
    for (int32_t y = 0; y < view->height; y++) {
        for (int32_t x = 0; x < view->width; x++) {
            const float *v = (const float *) (const void *) ((const unsigned char *) vectors->data +
                                                             y * vectors->row_stride +
                                                             x * vectors->pixel_stride);
            const uint32_t du = pattern((double) v[0], format), dv = pattern((double) v[1], format);
            unsigned char *to = at(view, x, y);
            if (wide && view->type == NTP_TYPE_U8) { /* the caller ensures four channels */
                to[0] = (uint8_t) (du & 255);
                to[1] = (uint8_t) (du >> 8);
                to[2] = (uint8_t) (dv & 255);
                to[3] = (uint8_t) (dv >> 8);
                continue;
            }
            store_share(to, view->type, du, wide ? 65535 : 255);
            store_share(to + size, view->type, dv, wide ? 65535 : 255);
            store_share(to + 2 * size, view->type, 0, 255);
        }
    }
}
