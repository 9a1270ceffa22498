/* SPDX-License-Identifier: MIT */
/*
 * normals.c - bands of heights into bands of normals
 *
 * A band is a picture of its own: its rows, and above and below the rows that its slopes reach.
 * Beyond an edge that wraps, these are the rows of the opposite end.  Beyond any other edge there
 * are none, so libntp gets the edge and applies the border.
 */
#include "../occlusion.h"
#include "../presets.h"
#include "heights.h"
#include "texels.h"

#include <stdlib.h>
#include <string.h>

enum { BAND = 128 }; /* rows: enough for threads, with little memory */

enum { /* what is no ntp_height_source */
       SOURCE_BIASED = NTP_HEIGHT_SOURCE_SCREEN + 1,
       SOURCE_LUMINANCE
};

/* The settings, as the preset has them. */
static recipe recipe_of(const double *v)
{
    const int source = (int) v[FN_SOURCE];
    recipe r = { .how = { .scale = v[FN_SCALE],
                          .dx = v[FN_DX],
                          .dy = v[FN_DY],
                          .min_z = v[FN_MIN_Z],
                          .kernel = (ntp_kernel) v[FN_KERNEL],
                          .border_x = (ntp_border) v[FN_BORDER_X],
                          .border_y = (ntp_border) v[FN_BORDER_Y],
                          .source = (ntp_height_source) source,
                          .blue = (ntp_blue) v[FN_BLUE],
                          .invert = v[FN_INVERT] != 0 },
                 .luminance = source == SOURCE_LUMINANCE,
                 .y = (ntp_y) v[FN_TO_Y],
                 .to = (ntp_encoding) v[FN_TO],
                 .channels = (int) v[FN_CHANNELS] };
    preset_apply((preset) v[FN_PRESET], &r);
    return r;
}

normals_job normals_job_from(const settings *s)
{
    const double *v = s->value;
    const recipe r = recipe_of(v);
    normals_job job = {
        .how = r.how,
        .forms = { v[FN_BLUR], v[FN_SMALL], v[FN_MIDDLE], v[FN_LARGE] },
        .y = r.y,
        .encoding = r.to,
        .alpha = r.how.alpha == NTP_ALPHA_HEIGHT ? ALPHA_HEIGHT : (alpha_rule) v[FN_ALPHA],
        .dudv = (dudv_format) v[FN_DUDV],
        .swap = v[FN_SWAP] != 0,
        .measures = v[FN_SCALE] == 0,
        .dithers = v[FN_DITHER] != 0,
        .occludes = v[FN_OCCLUSION] != 0 && r.to == NTP_ENCODING_XY && v[FN_DUDV] == DUDV_NONE,
        .flipped = v[FN_FLIP_X] != 0,
        .channels = (channel_order) r.channels,
        .luminance = r.luminance,
        .biased = r.how.source == (ntp_height_source) SOURCE_BIASED,
    };
    if (job.measures)
        job.how.scale = 1;
    job.how.scale *= v[FN_STRENGTH];
    if (job.luminance || job.biased)
        job.how.source = job.luminance ? NTP_HEIGHT_SOURCE_LUMA : NTP_HEIGHT_SOURCE_LUMA_GIMP;
    /* Red to the left negates both slopes and then green again, before any rounding. */
    if (v[FN_FLIP_X] != 0) {
        job.how.scale = -job.how.scale;
        job.y = job.y == NTP_Y_UP ? NTP_Y_DOWN : NTP_Y_UP;
    }
    if (job.dudv != DUDV_NONE)
        job.alpha = ALPHA_KEEP;
    if (job.alpha == ALPHA_HEIGHT)
        job.how.alpha = NTP_ALPHA_HEIGHT;
    else if (job.alpha == ALPHA_INVERSE_HEIGHT)
        job.how.alpha = NTP_ALPHA_INVERSE_HEIGHT;
    else
        job.how.alpha = NTP_ALPHA_KEEP;
    return job;
}

bool normals_job_needs_alpha(const normals_job *job, ntp_type type)
{
    if (job->dudv != DUDV_NONE)
        return type == NTP_TYPE_U8 && job->dudv >= DUDV_16_SIGNED;
    return job->channels == ORDER_DXT5NM ||
           (job->alpha != ALPHA_KEEP && job->alpha != ALPHA_INVERSE);
}

/* --------------------------------------------------------------------------------- bands */

enum { CHUNK = 16 }; /* rows of a task */

typedef struct work {
    const normals_job *job;
    const raster *heights, *layer, *result;
    const surroundings *around;
    ntp_rect area; /* of the layer */
    bias bias;
    int32_t margin; /* rows above and below a band that its slopes may depend on */
    unsigned char *heights_rows, *layer_rows, *alpha_plane;
    unsigned char *made, *vectors; /* the result's rows; for DU/DV */
    void *errors;                  /* of dithering, from band to band; NULL: none */
    ntp_image open;                /* ambient occlusion of the layer; without data: none */
    /* the current band */
    int32_t y0, y1;       /* its rows */
    int32_t above, count; /* rows read above y0, and in all */
    ntp_status status[BAND / CHUNK];
} work;

static bool read_band(work *w)
{
    const raster *r = w->heights;
    const bool wraps = w->job->how.border_y == NTP_BORDER_WRAP;
    int32_t first = w->y0 - w->margin, end = w->y1 + w->margin;
    if (r->height <= BAND) { /* all of it: libntp wraps by itself */
        first = 0;
        end = r->height;
    } else if (!wraps) {
        first = first < 0 ? 0 : first;
        end = end > r->height ? r->height : end;
    }
    w->above = w->y0 - first;
    w->count = end - first;
    if (!heights_read(r, first, w->count, w->heights_rows))
        return false;
    if (w->job->biased)
        bias_take_off(&w->bias, r, w->heights_rows, w->count);
    return w->layer_rows == NULL || w->layer->read(w->layer->user, w->y0, w->y1, w->layer_rows);
}

/* The alpha from which some rows of the layer start; without data: opaque. */
static ntp_const_image alpha_of(const work *w, int32_t y0, int32_t y1)
{
    ntp_rect part = { w->area.x0, y0, w->area.x1, y1 };
    ntp_image view = { 0 };
    if (w->alpha_plane != NULL) {
        view = ntp_image_packed(w->alpha_plane, w->result->width, w->result->height, 1,
                                w->result->type);
    } else if (w->layer_rows != NULL) {
        const ntp_image rows = raster_view(w->layer, w->layer_rows, w->y1 - w->y0);
        view = texels_channel(&rows, w->layer->channels - 1);
        part.y0 -= w->y0;
        part.y1 -= w->y0;
    }
    if (view.data != NULL)
        view = texels_crop(&view, &part);
    return ntp_image_as_const(&view);
}

static ntp_status make_dudv(work *w, const ntp_image *part, const ntp_const_image *heights,
                            const ntp_rect *area)
{
    ntp_image vectors = ntp_image_packed(w->vectors, heights->width, w->count, 3, NTP_TYPE_F32);
    vectors.encoding = NTP_ENCODING_VECTOR;
    vectors.y = w->job->y;
    const ntp_status status = ntp_normals_from_height(&vectors, heights, &w->job->how, NULL, area);
    const ntp_image made = texels_crop(&vectors, area);
    const ntp_const_image seen = ntp_image_as_const(&made);
    if (status == NTP_OK)
        texels_dudv(part, &seen, w->job->dudv);
    return status;
}

/* Makes the rows of an area whose row 0 is the first row that was read. */
static ntp_status make_rows(work *w, const ntp_rect *area)
{
    const normals_job *job = w->job;
    const bool alpha_is_height = job->how.alpha != NTP_ALPHA_KEEP;
    const ntp_image rows = raster_view(w->heights, w->heights_rows, w->count);
    const ntp_const_image heights = ntp_image_as_const(&rows);
    ntp_image made = raster_view(w->result, w->made, w->count);
    const ntp_image part = texels_crop(&made, area);
    if (made.channels == 4 && !alpha_is_height) {
        const int32_t first = w->y0 - w->above;
        const ntp_const_image alpha = alpha_of(w, first + area->y0, first + area->y1);
        texels_alpha(&part, job->alpha, &alpha);
        made.channels = 3;
    }
    if (job->dudv != DUDV_NONE)
        return make_dudv(w, &part, &heights, area);
    made.encoding = job->encoding;
    made.y = job->y;
    const ntp_status status =
        w->errors != NULL
            ? ntp_normals_dithered(&made, &heights, &job->how, w->errors,
                                   ntp_normals_dithered_scratch_size(made.width), NULL, area)
            : ntp_normals_from_height(&made, &heights, &job->how, NULL, area);
    if (status != NTP_OK)
        return status;
    made.channels = w->result->channels;
    if (w->open.data != NULL)
        occlusion_put(&made, area, &w->open, area->x0, w->y0 - w->above + area->y0);
    channels_arrange(&made, job->channels, area);
    if (job->swap)
        texels_swap(&part);
    return NTP_OK;
}

static void make_chunk(void *data, int32_t index)
{
    work *w = data;
    const int32_t first = w->above + index * CHUNK, end = w->above + w->y1 - w->y0;
    const bool all = w->errors != NULL;
    const ntp_rect area = { all ? 0 : w->area.x0, first, all ? w->result->width : w->area.x1,
                            first + CHUNK < end ? first + CHUNK : end };
    w->status[index] = make_rows(w, &area);
}

static job_status make_band(work *w)
{
    const int32_t chunks = (w->y1 - w->y0 + CHUNK - 1) / CHUNK;
    if (!read_band(w))
        return JOB_NO_PIXELS;
    surroundings_parallel(w->errors != NULL ? NULL : w->around, chunks, make_chunk, w);
    for (int32_t i = 0; i < chunks; i++) {
        if (w->status[i] != NTP_OK)
            return w->status[i] == NTP_ERR_FORMAT ? JOB_NO_ALPHA : JOB_WRONG;
    }
    const int32_t skipped = w->y0 < w->area.y0 ? w->area.y0 - w->y0 : 0; /* made for those below */
    if (skipped >= w->y1 - w->y0)
        return JOB_DONE;
    const ntp_rect area = { w->area.x0, w->y0 + skipped, w->area.x1, w->y1 };
    const unsigned char *pixels = w->made + raster_row(w->result) * (size_t) (w->above + skipped) +
                                  raster_pixel(w->result) * (size_t) w->area.x0;
    if (!w->result->write(w->result->user, &area, pixels, (ptrdiff_t) raster_row(w->result)))
        return JOB_NO_PIXELS;
    return JOB_DONE;
}

/* ------------------------------------------------------------------------------ the scale */

/* Counts the slopes of a row, read with its surroundings. */
static bool measure_row(work *w, ntp_relief *relief)
{
    int32_t first = 0;
    const int32_t step = ntp_relief_row(w->heights->width, w->heights->height, w->y0, &first);
    if (step == 0)
        return true;
    if (!read_band(w))
        return false;
    const ntp_image rows = raster_view(w->heights, w->heights_rows, w->count);
    const ntp_const_image seen = ntp_image_as_const(&rows);
    ntp_relief_add(relief, &seen, &w->job->how, first, w->above, step);
    return true;
}

job_status normals_job_find_scale(normals_job *job, const raster *heights)
{
    const int32_t reach = ntp_normals_reach(&job->how);
    if (!job->measures || reach < 0)
        return JOB_DONE;
    if (job->how.source == NTP_HEIGHT_SOURCE_ALPHA && heights->channels % 2 == 1)
        return JOB_NO_ALPHA;
    work w = { .job = job, .heights = heights, .margin = 2 * reach + 1 };
    ntp_relief *relief = calloc(1, sizeof *relief);
    w.heights_rows = malloc(raster_row(heights) * (BAND + 2 * (size_t) w.margin));
    job_status status = relief != NULL && w.heights_rows != NULL ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE && job->biased)
        status = bias_find(&w.bias, heights);
    for (int32_t y = 0; status == JOB_DONE && y < heights->height; y++) {
        w.y0 = y;
        w.y1 = y + 1;
        status = measure_row(&w, relief) ? JOB_DONE : JOB_NO_PIXELS;
    }
    if (status == JOB_DONE) {
        job->how.scale *= ntp_relief_scale(relief); /* of 1, or -1 where red is flipped */
        job->measures = false;
    }
    free(relief);
    free(w.heights_rows);
    return status;
}

job_status normals_job_smooth(normals_job *job, smoothed *made, const raster *heights,
                              const surroundings *around)
{
    if (!smoothing_acts(&job->forms))
        return JOB_DONE;
    const job_status status =
        smoothed_make(made, &job->forms, &job->how, job->biased, heights, around);
    job->forms = (smoothing) { 0, 1, 1, 1 };
    job->how.source = NTP_HEIGHT_SOURCE_RED; /* the only one */
    job->biased = false;
    return status;
}

/* ------------------------------------------------------------------------------- the job */

static bool reserve(work *w, bool alpha_plane)
{
    const raster *result = w->result;
    const bool dudv = w->job->dudv != DUDV_NONE;
    const size_t rows = BAND + 2 * (size_t) w->margin;
    const size_t texels = (size_t) result->width * (size_t) result->height;
    w->heights_rows = malloc(raster_row(w->heights) * rows);
    w->made = malloc(raster_row(result) * rows);
    w->vectors = dudv ? malloc(sizeof(float) * 3 * (size_t) result->width * rows) : NULL;
    w->layer_rows = w->layer != NULL ? malloc(raster_row(w->layer) * BAND) : NULL;
    w->errors = w->job->dithers && !dudv && result->type != NTP_TYPE_F32
                    ? calloc(1, ntp_normals_dithered_scratch_size(result->width))
                    : NULL;
    w->alpha_plane = alpha_plane ? malloc(raster_sample(result) * texels) : NULL;
    return w->heights_rows != NULL && w->made != NULL && (!dudv || w->vectors != NULL) &&
           (w->layer == NULL || w->layer_rows != NULL) && (!alpha_plane || w->alpha_plane != NULL);
}

/* Finds the ambient occlusion of all heights. */
static job_status find_open(work *w)
{
    const raster *r = w->heights;
    ntp_normals_options how = w->job->how;
    bias off = { { 0 } };
    unsigned char *rows = malloc(raster_row(r) * (size_t) r->height);
    void *plane = malloc(raster_sample(w->result) * (size_t) w->result->width * (size_t) r->height);
    w->open = ntp_image_packed(plane, r->width, r->height, 1, w->result->type);
    if (rows == NULL || plane == NULL) {
        free(rows);
        return JOB_NO_MEMORY;
    }
    how.scale = w->job->flipped ? -how.scale : how.scale;
    job_status status = r->read(r->user, 0, r->height, rows) ? JOB_DONE : JOB_NO_PIXELS;
    if (status == JOB_DONE && w->job->biased)
        status = bias_find(&off, r);
    if (status == JOB_DONE && w->job->biased)
        bias_take_off(&off, r, rows, r->height);
    if (status == JOB_DONE) {
        const ntp_image read = raster_view(r, rows, r->height);
        const ntp_const_image seen = ntp_image_as_const(&read);
        const ntp_hooks hooks = surroundings_hooks(w->around);
        const ntp_status made = occlusion_make(&w->open, &seen, &how, &hooks);
        status = made == NTP_OK              ? JOB_DONE
                 : made == NTP_ERR_FORMAT    ? JOB_NO_ALPHA
                 : made == NTP_ERR_SCRATCH   ? JOB_NO_MEMORY
                 : made == NTP_ERR_CANCELLED ? JOB_CANCELLED
                                             : JOB_WRONG;
    }
    free(rows);
    return status;
}

static void release(work *w)
{
    free(w->open.data);
    free(w->heights_rows);
    free(w->errors);
    free(w->made);
    free(w->vectors);
    free(w->layer_rows);
    free(w->alpha_plane);
}

static job_status make_bands(work *w)
{
    const int32_t rows = w->area.y1 - w->area.y0;
    job_status status = w->job->biased ? bias_find(&w->bias, w->heights) : JOB_DONE;
    for (int32_t y = w->errors != NULL ? 0 : w->area.y0; status == JOB_DONE && y < w->area.y1;
         y += BAND) {
        w->y0 = y;
        w->y1 = w->area.y1 - y > BAND ? y + BAND : w->area.y1;
        if (!surroundings_progress(w->around,
                                   y < w->area.y0 ? 0 : (double) (y - w->area.y0) / (double) rows))
            return JOB_CANCELLED;
        status = make_band(w);
    }
    return status;
}

job_status normals_job_run(const normals_job *job, const raster *heights, const raster *layer,
                           const raster *alpha, const raster *result, const ntp_rect *area,
                           const surroundings *around)
{
    const int32_t reach = ntp_normals_reach(&job->how);
    const bool keeps = job->alpha == ALPHA_KEEP || job->alpha == ALPHA_INVERSE;
    const bool plane = job->alpha == ALPHA_LAYER && alpha != NULL;
    if (reach < 0)
        return JOB_WRONG;
    if (heights->width != result->width || heights->height != result->height)
        return JOB_WRONG_SIZE;
    normals_job scaled = *job;
    smoothed forms = { 0 };
    job_status status = normals_job_find_scale(&scaled, heights);
    if (status == JOB_DONE)
        status = normals_job_smooth(&scaled, &forms, heights, around);
    if (status != JOB_DONE)
        return status;
    if (forms.data != NULL)
        heights = &forms.raster;
    work w = { .job = &scaled,
               .heights = heights,
               .layer = keeps && result->channels == 4 && layer != NULL && layer->channels % 2 == 0
                            ? layer
                            : NULL,
               .result = result,
               .around = around,
               .area = { 0, 0, result->width, result->height },
               /* so that a stencil fits in between an edge and the far end of its margin */
               .margin = 2 * reach + 1 };
    if (area != NULL)
        w.area = *area;
    status = reserve(&w, plane) ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE && scaled.occludes)
        status = find_open(&w);
    if (status == JOB_DONE && plane)
        status = raster_plane(alpha, w.alpha_plane, result->width, result->height, result->type);
    if (status == JOB_DONE)
        status = make_bands(&w);
    release(&w);
    smoothed_free(&forms);
    return status;
}
