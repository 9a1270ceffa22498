/* SPDX-License-Identifier: MIT */
/*
 * rasters.h - rasters in memory, for the tests of the plug-in
 */
#ifndef NTP_TESTS_RASTERS_H
#define NTP_TESTS_RASTERS_H

#include "normals.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct memory {
    raster raster;
    unsigned char *data;
    int reads_until_failure; /* negative: never */
} memory;

static inline bool read_memory(void *user, int32_t y0, int32_t y1, void *rows)
{
    memory *m = user;
    assert(0 <= y0 && y0 < y1 && y1 <= m->raster.height);
    if (m->reads_until_failure == 0)
        return false;
    m->reads_until_failure -= m->reads_until_failure > 0;
    memcpy(rows, m->data + raster_row(&m->raster) * (size_t) y0,
           raster_row(&m->raster) * (size_t) (y1 - y0));
    return true;
}

static inline bool write_memory(void *user, const ntp_rect *area, const void *pixels,
                                ptrdiff_t row_bytes)
{
    memory *m = user;
    const size_t bytes = raster_pixel(&m->raster) * (size_t) (area->x1 - area->x0);
    assert(0 <= area->x0 && area->x1 <= m->raster.width && area->y1 <= m->raster.height);
    for (int32_t y = area->y0; y < area->y1; y++)
        memcpy(m->data + raster_row(&m->raster) * (size_t) y +
                   raster_pixel(&m->raster) * (size_t) area->x0,
               (const unsigned char *) pixels + (y - area->y0) * row_bytes, bytes);
    return true;
}

static inline memory *memory_new(int32_t width, int32_t height, int32_t channels, ntp_type type)
{
    memory *m = calloc(1, sizeof *m);
    assert(m != NULL);
    m->raster = (raster) { .user = m,
                           .read = read_memory,
                           .write = write_memory,
                           .width = width,
                           .height = height,
                           .channels = channels,
                           .type = type };
    m->reads_until_failure = -1;
    m->data = calloc((size_t) height, raster_row(&m->raster));
    assert(m->data != NULL);
    return m;
}

static inline void memory_free(memory *m)
{
    free(m->data);
    free(m);
}

static uint32_t state = 1;
static inline uint32_t draw(void)
{
    state = state * 1664525u + 1013904223u;
    return state >> 8;
}

static inline void fill(memory *m)
{
    const size_t samples =
        raster_row(&m->raster) * (size_t) m->raster.height / raster_sample(&m->raster);
    for (size_t i = 0; i < samples; i++) {
        if (m->raster.type == NTP_TYPE_U8)
            m->data[i] = (unsigned char) draw();
        else if (m->raster.type == NTP_TYPE_U16)
            ((uint16_t *) (void *) m->data)[i] = (uint16_t) draw();
        else
            ((float *) (void *) m->data)[i] = (float) draw() / 16777216.0f;
    }
}

static inline size_t bytes_of(const memory *m)
{
    return raster_row(&m->raster) * (size_t) m->raster.height;
}

/* The whole picture at once by libntp; alpha of 4 channels by how->alpha. */
static inline void expect_normals(memory *out, const memory *in, const normals_job *job)
{
    ntp_image dst = raster_view(&out->raster, out->data, out->raster.height);
    ntp_image src = raster_view(&in->raster, in->data, in->raster.height);
    const ntp_const_image seen = ntp_image_as_const(&src);
    dst.encoding = job->encoding;
    dst.y = job->y;
    assert(ntp_normals_from_height(&dst, &seen, &job->how, NULL, NULL) == NTP_OK);
}

/* Heights of a wave that tiles, 12 texels high, and its normals by that kernel; by none: its own. */
static inline void wave(memory *heights, memory *normals, int kernel)
{
    const int w = heights->raster.width, h = heights->raster.height;
    const double a = 2 * 3.14159265358979323846 / w, b = 2 * 3.14159265358979323846 / h;
    for (int i = 0; i < w * h; i++) {
        const int column = i % w, row = i / w;
        const double x = a * column, y = b * row;
        const double p = -6 * a * cos(x) * cos(y), q = 6 * b * sin(x) * sin(y);
        const double n[3] = { p, -q, 1 }, length = sqrt(p * p + q * q + 1); /* green up */
        ((uint16_t *) (void *) heights->data)[i] =
            (uint16_t) (65535 * (0.5 + 0.5 * sin(x) * cos(y)));
        for (int c = 0; c < 3; c++)
            ((uint16_t *) (void *) normals->data)[3 * i + c] =
                (uint16_t) ((n[c] / length + 1) * 32767.5 + 0.5);
    }
    if (kernel == NTP_KERNEL_BAKED)
        return;
    settings s;
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 12;
    s.value[FN_KERNEL] = kernel;
    const normals_job forth = normals_job_from(&s);
    assert(normals_job_run(&forth, &heights->raster, NULL, NULL, &normals->raster, NULL, NULL) ==
           JOB_DONE);
}

#endif
