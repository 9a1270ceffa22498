/* SPDX-License-Identifier: MIT */
/*
 * occlusion.c - ambient occlusion for the blue channel that x and y leave free
 */
#include "occlusion.h"

#include "smooth.h"

#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64, BLUE = 2 };

static ntp_border border_of(ntp_border border)
{
    return border == NTP_BORDER_WRAP ? NTP_BORDER_WRAP : NTP_BORDER_CLAMP;
}

static ntp_status occlude(const ntp_image *plane, const ntp_const_image *heights,
                          const ntp_occlusion_options *how, const ntp_hooks *hooks)
{
    const int32_t parts = hooks != NULL ? hooks->parts : 1;
    const size_t size = ntp_occlusion_scratch_size(how, heights->width, heights->height, parts);
    unsigned char *memory = malloc(size + ALIGNMENT);
    if (memory == NULL)
        return NTP_ERR_SCRATCH;
    void *scratch = memory + (ALIGNMENT - (uintptr_t) memory % ALIGNMENT) % ALIGNMENT;
    const ntp_status status = ntp_occlusion(plane, heights, how, scratch, size, hooks);
    free(memory);
    return status;
}

/* Of flat heights. */
static void fill_open(const ntp_image *plane)
{
    const size_t texels = (size_t) plane->width * (size_t) plane->height;
    if (plane->type != NTP_TYPE_F32) {
        memset(plane->data, 255, texels * (size_t) plane->pixel_stride);
        return;
    }
    for (size_t i = 0; i < texels; i++)
        ((float *) plane->data)[i] = 1;
}

ntp_status occlusion_make(const ntp_image *plane, const ntp_const_image *heights,
                          const ntp_normals_options *how, const ntp_hooks *hooks)
{
    static const smoothing NONE = { 0, 1, 1, 1 };
    const ntp_occlusion_options options = { .scale = how->invert ? -how->scale : how->scale,
                                            .border_x = border_of(how->border_x),
                                            .border_y = border_of(how->border_y) };
    if (how->scale == 0) {
        fill_open(plane);
        return NTP_OK;
    }
    if (how->source == NTP_HEIGHT_SOURCE_RED)
        return occlude(plane, heights, &options, hooks);
    const size_t texels = (size_t) heights->width * (size_t) heights->height;
    float *data = malloc(texels * sizeof *data);
    ntp_image made = ntp_image_packed(data, heights->width, heights->height, 1, NTP_TYPE_F32);
    const ntp_status status =
        data != NULL ? smoothing_run(&NONE, &made, heights, how) : NTP_ERR_SCRATCH;
    const ntp_const_image seen = ntp_image_as_const(&made);
    const ntp_status done = status == NTP_OK ? occlude(plane, &seen, &options, hooks) : status;
    free(data);
    return done;
}

void occlusion_put(const ntp_image *view, const ntp_rect *area, const ntp_image *plane, int32_t x,
                   int32_t y)
{
    static const size_t BYTES[] = { 1, 2, 4 }; /* of a sample, by ntp_type */
    const size_t size = BYTES[view->type];
    for (int32_t row = area->y0; row < area->y1; row++) {
        unsigned char *to = (unsigned char *) view->data + row * view->row_stride +
                            area->x0 * view->pixel_stride + BLUE * size;
        const unsigned char *from = (const unsigned char *) plane->data +
                                    (y + row - area->y0) * plane->row_stride +
                                    x * plane->pixel_stride;
        for (int32_t column = area->x0; column < area->x1; column++) {
            memcpy(to, from, size);
            to += view->pixel_stride;
            from += size;
        }
    }
}
