/* SPDX-License-Identifier: MIT */
/*
 * preview_heatmap.c - where the layer is wrong: a pixel shows the worst texel under it
 */
#include "preview_pixels.h"
#include "texels.h"

#include <stdlib.h>
#include <string.h>

enum { RGB = 3 };

/* The stronger a fault, the brighter its color; texels without one are gray. */
static int32_t weight_of(const uint8_t *rgb)
{
    const bool gray = rgb[0] == rgb[1] && rgb[1] == rgb[2];
    return gray ? 0 : 1 + rgb[0] + rgb[1] + rgb[2];
}

typedef struct heater {
    const preview *p;
    ntp_palette palette;
    unsigned char *texels; /* rows of the layer */
    uint8_t *heat;         /* the same rows */
    int32_t n;             /* texels that a pixel shows on each axis */
} heater;

static job_status heat_rows(const heater *h, int32_t y0, int32_t y1)
{
    const preview *p = h->p;
    if (!p->layer->read(p->layer->user, y0, y1, h->texels))
        return JOB_NO_PIXELS;
    ntp_image view = raster_view(p->layer, h->texels, y1 - y0);
    ntp_image heat = ntp_image_packed(h->heat, p->layer->width, y1 - y0, RGB, NTP_TYPE_U8);
    view.encoding = p->found->encoding;
    heat.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image seen = ntp_image_as_const(&view);
    return ntp_heatmap(&heat, &seen, h->palette, p->found->touch, NULL) == NTP_OK ? JOB_DONE
                                                                                  : JOB_WRONG;
}

/* Adds a row of texels to a row of pixels, which begins black. */
static void keep_worst(const heater *h, const uint8_t *row, uint8_t *out)
{
    const preview *p = h->p;
    for (int32_t i = 0; i < p->width; i++, out += RGB) {
        for (int32_t k = 0; k < h->n; k++) {
            const uint8_t *texel = row + (size_t) preview_column_of(p, i, k, h->n) * RGB;
            const int32_t weight = weight_of(texel), before = weight_of(out);
            if (weight > before || (weight == 0 && before == 0 && texel[0] > out[0]))
                memcpy(out, texel, RGB);
        }
    }
}

job_status preview_heatmap(const preview *p, ntp_palette palette, uint8_t *heat)
{
    const int32_t n = preview_texels_in_pixel(p);
    heater h = { .p = p, .palette = palette, .n = n };
    h.texels = malloc(raster_row(p->layer));
    h.heat = malloc((size_t) p->layer->width * RGB);
    job_status status = h.texels != NULL && h.heat != NULL ? JOB_DONE : JOB_NO_MEMORY;
    for (int32_t j = p->first; status == JOB_DONE && j < preview_end_of(p); j++) {
        uint8_t *out = heat + (size_t) j * (size_t) p->width * RGB;
        memset(out, 0, (size_t) p->width * RGB);
        for (int32_t k = 0; status == JOB_DONE && k < n; k++) {
            const int32_t y = preview_row_of(p, j, k, n);
            status = heat_rows(&h, y, y + 1);
            if (status == JOB_DONE)
                keep_worst(&h, h.heat, out);
        }
    }
    free(h.texels);
    free(h.heat);
    return status;
}
