/* SPDX-License-Identifier: MIT */
/*
 * raster.h - a layer as the jobs see it: rows that can be read, an area that can be written
 *
 * The functions are what a job needs from its environment: pixels, progress and threads.  In GIMP
 * they read and write drawables, in tests memory.  Samples are those of the layer, never converted.
 */
#ifndef NTP_PLUGIN_RASTER_H
#define NTP_PLUGIN_RASTER_H

#include "libntp.h"

#include <stdbool.h>

typedef struct raster {
    void *user;
    /* Reads the rows y0..y1-1, in full and without gaps. */
    bool (*read)(void *user, int32_t y0, int32_t y1, void *rows);
    /* Writes an area; pixels is its first, row_bytes leads to the next row. */
    bool (*write)(void *user, const ntp_rect *area, const void *pixels, ptrdiff_t row_bytes);
    int32_t width, height;
    int32_t channels; /* 1 gray, 2 with alpha, 3 RGB, 4 with alpha */
    ntp_type type;
} raster;

typedef struct surroundings {
    void *user;
    /* Gets the share done; returns false to stop the job.  May be NULL. */
    bool (*progress)(void *user, double share);
    /* Calls task(work, i) for each i from 0 to count - 1 on any threads.  May be NULL. */
    void (*parallel)(void *user, int32_t count, void (*task)(void *work, int32_t index),
                     void *work);
    int32_t threads; /* the number of threads, at least 1 */
} surroundings;

typedef enum job_status {
    JOB_DONE,
    JOB_CANCELLED,
    JOB_NO_MEMORY,
    JOB_NO_PIXELS,  /* reading or writing failed */
    JOB_NO_ALPHA,   /* the height is in alpha, and the layer has none */
    JOB_WRONG_SIZE, /* the other layer has a different size */
    JOB_GRAY,       /* normals are required, but the layer is gray */
    JOB_NO_LAYER,   /* alpha is to come from another layer, and there is none */
    JOB_BEYOND,     /* the layer's effects reach beyond it */
    JOB_NO_NORMALS, /* the layer is not a normals texture */
    JOB_IS_HEIGHT,  /* it is a heightfield */
    JOB_IS_NORMALS, /* heights are required, but it shows normals */
    JOB_MISPLACED,  /* its channels are exchanged or were converted */
    JOB_NO_METHOD,  /* the method does not support this kernel with these borders */
    JOB_WRONG       /* an argument; should not happen with checked settings */
} job_status;

/* The error message, in English, to be translated. */
const char *job_status_text(job_status status);

static inline size_t raster_sample(const raster *r)
{
    return r->type == NTP_TYPE_U8 ? 1 : r->type == NTP_TYPE_U16 ? 2 : 4;
}
static inline size_t raster_pixel(const raster *r)
{
    return raster_sample(r) * (size_t) r->channels;
}
static inline size_t raster_row(const raster *r)
{
    return raster_pixel(r) * (size_t) r->width;
}

/* A view of packed rows of that shape, with encoding NTP_ENCODING_HEIGHT. */
ntp_image raster_view(const raster *r, void *rows, int32_t height);

bool surroundings_progress(const surroundings *s, double share);
void surroundings_parallel(const surroundings *s, int32_t count,
                           void (*task)(void *work, int32_t index), void *work);

/* The same as libntp takes them; s NULL: none. */
ntp_hooks surroundings_hooks(const surroundings *s);

/*
 * The brightness of a layer as a plane of width x height samples of this type: gray as it is, or
 * the Rec. 709 luma of a color.  A layer of another size is scaled: triangle filter, widened where
 * it shrinks.
 */
job_status raster_plane(const raster *r, void *plane, int32_t width, int32_t height, ntp_type type);

#endif
