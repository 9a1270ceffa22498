/* SPDX-License-Identifier: MIT */
/*
 * repair.c - rows of texels, each repaired or converted independently
 */
#include "repair.h"
#include "texels.h"

#include <math.h>
#include <stdlib.h>

enum { BAND = 128, CHUNK = 16 };

enum { FROM_AUTO = 0, METHOD_AUTO = 2 };

bool repair_finds_out(const settings *s, settings *question)
{
    *question = (settings) { { 0 } };
    question->value[FK_FROM] = s->value[FC_FROM];
    question->value[FK_KEEP_NEGATIVE_Z] = s->value[FC_KEEP_NEGATIVE_Z];
    return (int) s->value[FC_FROM] == FROM_AUTO || (int) s->value[FC_METHOD] == METHOD_AUTO;
}

static ntp_encoding encoding_of(const settings *s, const report *found)
{
    if (found != NULL && found->judged)
        return found->encoding;
    return (int) s->value[FC_FROM] == FROM_AUTO ? NTP_ENCODING_STANDARD
                                                : (ntp_encoding) ((int) s->value[FC_FROM] - 1);
}

repair_job repair_job_from(const settings *s, const report *found)
{
    const double *v = s->value;
    const bool suits = (int) v[FC_METHOD] == METHOD_AUTO;
    return (repair_job) {
        .from = encoding_of(s, found),
        .clean = true,
        .how = { .method = !suits          ? (ntp_clean_method) v[FC_METHOD]
                           : found != NULL ? found->method
                                           : NTP_CLEAN_DERIVE,
                 .keep_negative_z = v[FC_KEEP_NEGATIVE_Z] != 0,
                 .only_failing = v[FC_ONLY_FAILING] != 0,
                 .verdict = (ntp_verdict) v[FC_VERDICT],
                 .touch_unused = v[FC_UNUSED] != 0 ? NTP_UNUSED_ALL
                                 : found != NULL   ? found->touch
                                                   : 0 },
    };
}

/* --------------------------------------------------------------------------- one texel */

static double component(const void *sample, ntp_type type)
{
    if (type == NTP_TYPE_U8)
        return (2.0 * *(const uint8_t *) sample - 255) / 255;
    if (type == NTP_TYPE_U16)
        return (2.0 * *(const uint16_t *) sample - 65535) / 65535;
    return 2 * (double) *(const float *) sample - 1;
}

static void set_component(void *sample, ntp_type type, double v)
{
    if (type == NTP_TYPE_U8)
        *(uint8_t *) sample = (uint8_t) ((v + 1) * 127.5 + 0.5);
    else if (type == NTP_TYPE_U16)
        *(uint16_t *) sample = (uint16_t) ((v + 1) * 32767.5 + 0.5);
    else
        *(float *) sample = (float) ((v + 1) / 2);
}

static size_t sample_size(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 1 : type == NTP_TYPE_U16 ? 2 : 4;
}

/* A normal that is steeper than min_z is raised to it and keeps its direction in x and y. */
static void turn_up(unsigned char *texel, ntp_type type, double min_z)
{
    const size_t size = sample_size(type);
    const double x = component(texel, type), y = component(texel + size, type);
    const double length = sqrt(x * x + y * y);
    if (!(component(texel + 2 * size, type) < min_z) || !(length > 0))
        return;
    const double factor = sqrt(1 - min_z * min_z) / length;
    set_component(texel, type, x * factor);
    set_component(texel + size, type, y * factor);
    set_component(texel + 2 * size, type, min_z);
}

static void flip(unsigned char *sample, ntp_type type)
{
    if (type == NTP_TYPE_U8)
        *sample = (uint8_t) (255 - *sample);
    else if (type == NTP_TYPE_U16)
        *(uint16_t *) (void *) sample = (uint16_t) (65535 - *(uint16_t *) (void *) sample);
    else
        *(float *) (void *) sample = 1 - *(float *) (void *) sample;
}

static void change_texels(const repair_job *job, const ntp_image *rows)
{
    const size_t size = sample_size(rows->type);
    if (!(job->min_z > 0) && !job->flip_x && !job->flip_y)
        return;
    for (int32_t y = 0; y < rows->height; y++) {
        for (int32_t x = 0; x < rows->width; x++) {
            unsigned char *texel =
                (unsigned char *) rows->data + y * rows->row_stride + x * rows->pixel_stride;
            if (job->min_z > 0)
                turn_up(texel, rows->type, job->min_z);
            if (job->flip_x)
                flip(texel, rows->type);
            if (job->flip_y)
                flip(texel + size, rows->type);
        }
    }
}

/* ------------------------------------------------------------------------------- rows */

static job_status strengthen(const ntp_image *rows, double strength)
{
    const size_t texels = (size_t) rows->width * (size_t) rows->height;
    void *memory = malloc(texels * 3 * sample_size(rows->type));
    if (memory == NULL)
        return JOB_NO_MEMORY;
    ntp_image made = ntp_image_packed(memory, rows->width, rows->height, 3, rows->type);
    made.encoding = rows->encoding;
    const ntp_transform_options how = { .use_strength = 1, .strength = strength };
    const ntp_const_image seen = ntp_image_as_const(rows);
    ntp_status status = ntp_transform(&made, &seen, &how, NULL);
    for (int32_t c = 0; status == NTP_OK && c < 3; c++) {
        const ntp_image to = texels_channel(rows, c), from = texels_channel(&made, c);
        const ntp_const_image channel = ntp_image_as_const(&from);
        status = ntp_convert(&to, &channel, NULL, NULL, NULL);
    }
    free(memory);
    return status == NTP_OK ? JOB_DONE : JOB_WRONG;
}

static job_status store_dudv(const ntp_image *rows, const ntp_image *normals, dudv_format format)
{
    const size_t texels = (size_t) rows->width * (size_t) rows->height;
    float *memory = malloc(texels * 3 * sizeof *memory);
    if (memory == NULL)
        return JOB_NO_MEMORY;
    ntp_image vectors = ntp_image_packed(memory, rows->width, rows->height, 3, NTP_TYPE_F32);
    vectors.encoding = NTP_ENCODING_VECTOR;
    const ntp_const_image seen = ntp_image_as_const(normals);
    const ntp_const_image found = ntp_image_as_const(&vectors);
    const ntp_convert_options all = { .touch_unused = NTP_UNUSED_ALL };
    const ntp_status status = ntp_convert(&vectors, &seen, &all, NULL, NULL);
    if (status == NTP_OK)
        texels_dudv(rows, &found, format);
    free(memory);
    return status == NTP_OK ? JOB_DONE : JOB_WRONG;
}

/* In place; the view is then that of the result. */
static bool convert(const repair_job *job, ntp_image *view)
{
    const ntp_convert_options how = { .touch_unused = job->how.touch_unused };
    const ntp_const_image seen = ntp_image_as_const(view);
    view->encoding = job->to;
    if (job->turn_green)
        view->y = view->y == NTP_Y_UP ? NTP_Y_DOWN : NTP_Y_UP;
    return ntp_convert(view, &seen, &how, NULL, NULL) == NTP_OK;
}

job_status repair_rows(const repair_job *job, const ntp_image *rows, uint64_t *changed)
{
    ntp_image view = *rows;
    ntp_clean_counts counts = { 0 };
    job_status status = JOB_DONE;
    view.encoding = job->from;
    view.channels = job->alpha_is_data ? 3 : rows->channels;
    const ntp_const_image seen = ntp_image_as_const(&view);
    if (job->clean && ntp_clean(&view, &seen, &job->how, NULL, &counts, NULL) != NTP_OK)
        return JOB_WRONG;
    if (changed != NULL)
        *changed += counts.changed;
    if (job->convert && !convert(job, &view))
        return JOB_WRONG;
    view.channels = 3;
    if (job->strengthen)
        status = strengthen(&view, job->strength);
    if (status == JOB_DONE && job->derive) {
        const ntp_const_image xy = ntp_image_as_const(&view);
        view.encoding = NTP_ENCODING_STANDARD;
        if (ntp_convert(&view, &xy, NULL, NULL, NULL) != NTP_OK)
            return JOB_WRONG;
    }
    if (status != JOB_DONE)
        return status;
    change_texels(job, &view);
    if (job->dudv != DUDV_NONE)
        return store_dudv(rows, &view, job->dudv);
    if (job->swap)
        texels_swap(&view);
    return JOB_DONE;
}

/* ------------------------------------------------------------------------------- bands */

typedef struct work {
    const repair_job *job;
    const raster *layer, *result;
    ntp_rect area;
    unsigned char *rows, *made, *alpha;
    int32_t y0, y1;
    job_status status[BAND / CHUNK];
    uint64_t changed[BAND / CHUNK];
} work;

/* The layer's samples, and its alpha by the rule, into the result's rows. */
static void begin_rows(const work *w, const ntp_image *made, const ntp_rect *part)
{
    const ntp_image rows = raster_view(w->layer, w->rows, w->y1 - w->y0);
    const ntp_image from = texels_crop(&rows, part);
    ntp_image plane = { 0 };
    for (int32_t c = 0; c < 3; c++) {
        const ntp_image to = texels_channel(made, c), channel = texels_channel(&from, c);
        const ntp_const_image seen = ntp_image_as_const(&channel);
        ntp_convert(&to, &seen, NULL, NULL, NULL);
    }
    if (made->channels < 4)
        return;
    if (w->alpha != NULL) {
        const ntp_rect at = { part->x0, w->y0 + part->y0, part->x1, w->y0 + part->y1 };
        const ntp_image all =
            ntp_image_packed(w->alpha, w->layer->width, w->layer->height, 1, w->result->type);
        plane = texels_crop(&all, &at);
    } else if (w->layer->channels == 4) {
        plane = texels_channel(&from, 3);
    }
    const ntp_const_image alpha = ntp_image_as_const(&plane);
    texels_alpha(made, w->job->alpha, &alpha);
}

static void make_chunk(void *data, int32_t index)
{
    work *w = data;
    const int32_t first = index * CHUNK, end = w->y1 - w->y0;
    const ntp_rect part = { w->area.x0, first, w->area.x1,
                            first + CHUNK < end ? first + CHUNK : end };
    const ntp_image rows = raster_view(w->result, w->made, w->y1 - w->y0);
    const ntp_image made = texels_crop(&rows, &part);
    begin_rows(w, &made, &part);
    w->status[index] = repair_rows(w->job, &made, &w->changed[index]);
}

static job_status make_band(work *w, const surroundings *around)
{
    const int32_t chunks = (w->y1 - w->y0 + CHUNK - 1) / CHUNK;
    const ntp_rect area = { w->area.x0, w->y0, w->area.x1, w->y1 };
    if (!w->layer->read(w->layer->user, w->y0, w->y1, w->rows))
        return JOB_NO_PIXELS;
    surroundings_parallel(around, chunks, make_chunk, w);
    for (int32_t i = 0; i < chunks; i++) {
        if (w->status[i] != JOB_DONE)
            return w->status[i];
    }
    return w->result->write(w->result->user, &area,
                            w->made + raster_pixel(w->result) * (size_t) w->area.x0,
                            (ptrdiff_t) raster_row(w->result))
               ? JOB_DONE
               : JOB_NO_PIXELS;
}

static job_status make_bands(work *w, const surroundings *around)
{
    job_status status = JOB_DONE;
    for (int32_t y = w->area.y0; status == JOB_DONE && y < w->area.y1; y += BAND) {
        const double share = (double) (y - w->area.y0) / (double) (w->area.y1 - w->area.y0);
        if (!surroundings_progress(around, share))
            return JOB_CANCELLED;
        w->y0 = y;
        w->y1 = w->area.y1 - y > BAND ? y + BAND : w->area.y1;
        status = make_band(w, around);
    }
    return status;
}

job_status repair_job_run(const repair_job *job, const raster *layer, const raster *alpha,
                          const raster *result, const ntp_rect *area, const surroundings *around,
                          uint64_t *changed)
{
    const bool plane = job->alpha == ALPHA_LAYER && alpha != NULL && result->channels == 4;
    const size_t texels = (size_t) layer->width * (size_t) layer->height;
    work w = {
        .job = job, .layer = layer, .result = result, .area = { 0, 0, layer->width, layer->height }
    };
    if (area != NULL)
        w.area = *area;
    w.rows = malloc(raster_row(layer) * BAND);
    w.made = malloc(raster_row(result) * BAND);
    w.alpha = plane ? malloc(texels * raster_sample(result)) : NULL;
    job_status status = JOB_NO_MEMORY;
    if (w.rows != NULL && w.made != NULL && (!plane || w.alpha != NULL))
        status = plane ? raster_plane(alpha, w.alpha, layer->width, layer->height, result->type)
                       : JOB_DONE;
    if (status == JOB_DONE)
        status = make_bands(&w, around);
    for (int i = 0; changed != NULL && i < BAND / CHUNK; i++)
        *changed += w.changed[i];
    free(w.rows);
    free(w.made);
    free(w.alpha);
    return status;
}
