/* SPDX-License-Identifier: MIT */
/*
 * resize.c - a normals texture in another size: the layer in memory, bands of the result on threads
 */
#include "resize.h"

#include <stdlib.h>

enum { BAND = 16 };

typedef struct work {
    const ntp_resize_plan *plan;
    ntp_const_image layer;
    ntp_image made;
    size_t scratch_size;
    job_status *status; /* of each band */
} work;

resize_job resize_job_from(const settings *s)
{
    return (resize_job) { .how = { .filter = (ntp_filter) s->value[FZ_FILTER],
                                   .border_x = (ntp_border) s->value[FZ_BORDER_X],
                                   .border_y = (ntp_border) s->value[FZ_BORDER_Y] } };
}

/* Rounded as `ntp resize` does. */
int32_t resize_side(const settings *s, double given, int32_t side)
{
    const double scaled = given >= 0.5 ? given + 0.5 : side * s->value[FZ_PERCENT] / 100 + 0.5;
    return scaled >= NTP_MAX_SIDE + 1.0 ? 0 : scaled < 1 ? 1 : (int32_t) scaled;
}

/* malloc aligns as ntp_resize wants it. */
static void make_band(void *data, int32_t index)
{
    const work *w = data;
    const int32_t y0 = index * BAND, height = w->made.height;
    const ntp_rect area = { 0, y0, w->made.width, y0 + BAND < height ? y0 + BAND : height };
    void *scratch = malloc(w->scratch_size);
    w->status[index] = JOB_NO_MEMORY;
    if (scratch != NULL)
        w->status[index] =
            ntp_resize(&w->made, &w->layer, w->plan, scratch, w->scratch_size, &area) == NTP_OK
                ? JOB_DONE
                : JOB_WRONG;
    free(scratch);
}

static job_status make_bands(work *w, const surroundings *around)
{
    const int32_t bands = (w->made.height + BAND - 1) / BAND;
    job_status status = JOB_DONE;
    w->status = calloc((size_t) bands, sizeof *w->status);
    if (w->status == NULL)
        return JOB_NO_MEMORY;
    surroundings_parallel(around, bands, make_band, w);
    for (int32_t i = 0; i < bands && status == JOB_DONE; i++)
        status = w->status[i];
    free(w->status);
    return status;
}

/* Both pictures are in memory. */
static job_status resize(const resize_job *job, const raster *layer, void *samples, void *made,
                         const surroundings *around)
{
    const raster result = {
        .width = job->width, .height = job->height, .channels = layer->channels, .type = layer->type
    };
    ntp_image from = raster_view(layer, samples, layer->height);
    work w = { .made = raster_view(&result, made, job->height) };
    from.encoding = w.made.encoding = job->encoding;
    w.layer = ntp_image_as_const(&from);
    const size_t size =
        ntp_resize_plan_size(&job->how, layer->width, layer->height, job->width, job->height);
    void *memory = malloc(size);
    ntp_resize_plan *plan = NULL;
    job_status status = memory != NULL ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE &&
        ntp_resize_plan_init(&plan, memory, size, &job->how, layer->width, layer->height,
                             job->width, job->height) != NTP_OK)
        status = JOB_WRONG;
    if (status == JOB_DONE) {
        w.plan = plan;
        w.scratch_size = ntp_resize_scratch_size(plan);
        status = make_bands(&w, around);
    }
    free(memory);
    return status;
}

job_status resize_job_run(const resize_job *job, const raster *layer, void **made,
                          const surroundings *around)
{
    void *samples = malloc(raster_row(layer) * (size_t) layer->height);
    *made = malloc(raster_pixel(layer) * (size_t) job->width * (size_t) job->height);
    job_status status = samples != NULL && *made != NULL ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE && !layer->read(layer->user, 0, layer->height, samples))
        status = JOB_NO_PIXELS;
    if (status == JOB_DONE)
        status = resize(job, layer, samples, *made, around);
    free(samples);
    if (status != JOB_DONE) {
        free(*made);
        *made = NULL;
    }
    return status;
}
