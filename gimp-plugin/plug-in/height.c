/* SPDX-License-Identifier: MIT */
/*
 * height.c - heights from the normals of a whole layer, stretched to the range of the samples
 */
#include "height.h"
#include "texels.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 }; /* of what the library works with */

bool height_finds_out(const settings *s)
{
    return (int) s->value[FH_FROM] > NTP_ENCODING_XY;
}

height_job height_job_from(const settings *s)
{
    const double *v = s->value;
    return (height_job) {
        .how = { .method = (ntp_height_method) v[FH_METHOD],
                 .kernel = (ntp_kernel) v[FH_KERNEL],
                 .border_x = (ntp_border) v[FH_BORDER_X],
                 .border_y = (ntp_border) v[FH_BORDER_Y],
                 .decode = (ntp_decode) v[FH_DECODE],
                 .z = v[FH_Z] != 0 ? NTP_Z_DERIVED : NTP_Z_STORED },
        .y = (ntp_y) v[FH_FROM_Y],
        .encoding = height_finds_out(s) ? NTP_ENCODING_STANDARD : (ntp_encoding) v[FH_FROM],
        .invert = v[FH_INVERT] != 0,
        .contrast = v[FH_CONTRAST],
    };
}

static void stretch(const height_job *job, float *plane, size_t texels, double low, double high)
{
    const double range = high - low, gain = 1 + job->contrast;
    for (size_t i = 0; i < texels; i++) {
        double h = range > 0 ? ((double) plane[i] - low) / range : 0.5;
        h = job->invert ? 1 - h : h;
        h = 0.5 + (h - 0.5) * gain;
        plane[i] = (float) (h < 0 ? 0 : h > 1 ? 1 : h);
    }
}

job_status height_job_run(const height_job *job, const raster *normals, float **plane,
                          double *range, const surroundings *around)
{
    const size_t texels = (size_t) normals->width * (size_t) normals->height;
    const ntp_hooks hooks = surroundings_hooks(around);
    ntp_height_options how = job->how;
    size_t size = ntp_height_scratch_size(&how, normals->width, normals->height, hooks.parts);
    if (size == 0 && how.method == NTP_HEIGHT_AUTO) { /* supports every kernel and border */
        how.method = NTP_HEIGHT_WEIGHTED;
        size = ntp_height_scratch_size(&how, normals->width, normals->height, hooks.parts);
    }
    *plane = NULL;
    if (size == 0)
        return JOB_NO_METHOD;
    unsigned char *rows = malloc(raster_row(normals) * (size_t) normals->height);
    unsigned char *memory = malloc(size + ALIGNMENT); /* Windows has no aligned_alloc */
    float *heights = malloc(texels * sizeof *heights);
    ntp_height_result found = { 0 };
    job_status status = JOB_NO_MEMORY;
    if (rows != NULL && memory != NULL && heights != NULL) {
        void *scratch = memory + (ALIGNMENT - (uintptr_t) memory % ALIGNMENT);
        ntp_image source = raster_view(normals, rows, normals->height);
        ntp_image made =
            ntp_image_packed(heights, normals->width, normals->height, 1, NTP_TYPE_F32);
        source.encoding = job->encoding;
        source.y = job->y;
        const ntp_const_image seen = ntp_image_as_const(&source);
        ntp_status done = NTP_ERR_CANCELLED;
        status = JOB_NO_PIXELS;
        if (normals->read(normals->user, 0, normals->height, rows)) {
            done = ntp_height_from_normals(&made, &seen, &how, scratch, size, &hooks, &found);
            status = done == NTP_OK              ? JOB_DONE
                     : done == NTP_ERR_CANCELLED ? JOB_CANCELLED
                                                 : JOB_WRONG;
        }
    }
    free(rows);
    free(memory);
    if (status != JOB_DONE) {
        free(heights);
        return status;
    }
    stretch(job, heights, texels, found.min, found.max);
    *range = found.max - found.min;
    *plane = heights;
    return JOB_DONE;
}

static void fill_row(const ntp_image *row, const ntp_const_image *heights, bool alpha_too)
{
    const int32_t colors = row->channels < 3 ? 1 : 3;
    const bool alpha = alpha_too && row->channels % 2 == 0;
    for (int32_t c = 0; c < colors + alpha; c++) {
        const ntp_image channel = texels_channel(row, c);
        ntp_convert(&channel, heights, NULL, NULL, NULL);
    }
}

job_status height_write(const float *plane, const raster *layer, const raster *result,
                        const ntp_rect *area, bool alpha_too)
{
    const bool keeps = result->channels % 2 == 0 && result->channels == layer->channels;
    unsigned char *row = malloc(raster_row(result));
    job_status status = row != NULL ? JOB_DONE : JOB_NO_MEMORY;
    for (int32_t y = area->y0; status == JOB_DONE && y < area->y1; y++) {
        const ntp_rect part = { area->x0, y, area->x1, y + 1 };
        const ntp_image view = raster_view(result, row, 1);
        ntp_image heights =
            ntp_image_packed((float *) (uintptr_t) plane + (size_t) y * (size_t) result->width,
                             result->width, 1, 1, NTP_TYPE_F32);
        const ntp_const_image seen = ntp_image_as_const(&heights);
        bool ok = !keeps || layer->read(layer->user, y, y + 1, row);
        fill_row(&view, &seen, alpha_too);
        ok =
            ok && result->write(result->user, &part, row + raster_pixel(result) * (size_t) area->x0,
                                (ptrdiff_t) raster_row(result));
        status = ok ? JOB_DONE : JOB_NO_PIXELS;
    }
    free(row);
    return status;
}
