/* SPDX-License-Identifier: MIT */
/*
 * heights.c - the heights of a layer: read, made relative to the mean color, smoothed
 */
#include "heights.h"

#include <stdlib.h>
#include <string.h>

/* ---------------------------------------------------------------------------- mean color */

static void add_samples(const raster *r, const void *row, double sums[3])
{
    const int32_t colors = r->channels < 3 ? 1 : 3;
    for (int32_t x = 0; x < r->width; x++) {
        for (int32_t c = 0; c < colors; c++) {
            const int64_t i = (int64_t) x * r->channels + c;
            sums[c] += r->type == NTP_TYPE_U8    ? ((const uint8_t *) row)[i]
                       : r->type == NTP_TYPE_U16 ? ((const uint16_t *) row)[i]
                                                 : (double) ((const float *) row)[i];
        }
    }
}

job_status bias_find(bias *b, const raster *r)
{
    void *row = malloc(raster_row(r));
    bool ok = row != NULL;
    *b = (bias) { 0 };
    for (int32_t y = 0; ok && y < r->height; y++) {
        double sums[3] = { 0 };
        ok = r->read(r->user, y, y + 1, row);
        if (!ok)
            break;
        add_samples(r, row, sums);
        for (int c = 0; c < 3; c++)
            b->mean[c] += sums[c] / ((double) r->width * (double) r->height);
    }
    const job_status status = row == NULL ? JOB_NO_MEMORY : ok ? JOB_DONE : JOB_NO_PIXELS;
    free(row);
    return status;
}

#define SUBTRACT(TYPE, ROUND)                                                                      \
    {                                                                                              \
        TYPE *s = (TYPE *) rows;                                                                   \
        for (size_t i = 0; i < texels; i++, s += r->channels) {                                    \
            for (int32_t c = 0; c < colors; c++) {                                                 \
                const TYPE off = (TYPE) (b->mean[c] + (ROUND));                                    \
                s[c] = s[c] > off ? (TYPE) (s[c] - off) : (TYPE) 0;                                \
            }                                                                                      \
        }                                                                                          \
    }

void bias_take_off(const bias *b, const raster *r, void *rows, int32_t count)
{
    const size_t texels = (size_t) r->width * (size_t) count;
    const int32_t colors = r->channels < 3 ? 1 : 3;
    if (r->type == NTP_TYPE_U8)
        SUBTRACT(uint8_t, 0.5)
    else if (r->type == NTP_TYPE_U16)
        SUBTRACT(uint16_t, 0.5)
    else
        SUBTRACT(float, 0)
}

/* ----------------------------------------------------------------------------- smoothing */

static int32_t wrapped(int32_t y, int32_t height)
{
    const int32_t rest = y % height;
    return rest < 0 ? rest + height : rest;
}

bool heights_read(const raster *r, int32_t first, int32_t count, unsigned char *to)
{
    while (count > 0) {
        const int32_t y = wrapped(first, r->height);
        const int32_t run = r->height - y < count ? r->height - y : count;
        if (!r->read(r->user, y, y + run, to))
            return false;
        to += raster_row(r) * (size_t) run;
        first += run;
        count -= run;
    }
    return true;
}

static bool read_smoothed(void *user, int32_t y0, int32_t y1, void *rows)
{
    const smoothed *from = user;
    const size_t row = raster_row(&from->raster);
    memcpy(rows, (const unsigned char *) from->data + row * (size_t) y0, row * (size_t) (y1 - y0));
    return true;
}

/* Rows of the layer, with those around them, and the parts of them that threads smooth. */
typedef struct strip {
    const smoothing *forms;
    const ntp_normals_options *how;
    const raster *heights;
    smoothed *made;
    unsigned char *rows; /* from `first` on, `count` of them */
    int32_t first, count;
    int32_t y0, y1, step, reach; /* the rows to make; of each part; around it */
    job_status *status;          /* of each part */
} strip;

static void smooth_part(void *data, int32_t index)
{
    const strip *s = data;
    const int32_t y0 = s->y0 + index * s->step, y1 = y0 + s->step < s->y1 ? y0 + s->step : s->y1;
    const int32_t top = y0 - s->reach > s->first ? y0 - s->reach : s->first;
    const int32_t end = s->first + s->count;
    const int32_t bottom = y1 + s->reach < end ? y1 + s->reach : end;
    const size_t row = raster_row(&s->made->raster);
    float *made = malloc(row * (size_t) (bottom - top));
    const ntp_image read = raster_view(
        s->heights, s->rows + raster_row(s->heights) * (size_t) (top - s->first), bottom - top);
    const ntp_const_image seen = ntp_image_as_const(&read);
    const ntp_image out = raster_view(&s->made->raster, made, bottom - top);
    const ntp_status status =
        made != NULL ? smoothing_run(s->forms, &out, &seen, s->how) : NTP_ERR_SCRATCH;
    if (status == NTP_OK)
        memcpy((unsigned char *) s->made->data + row * (size_t) y0,
               (const unsigned char *) made + row * (size_t) (y0 - top), row * (size_t) (y1 - y0));
    s->status[index] = status == NTP_OK            ? JOB_DONE
                       : status == NTP_ERR_SCRATCH ? JOB_NO_MEMORY
                       : status == NTP_ERR_FORMAT  ? JOB_NO_ALPHA
                                                   : JOB_WRONG;
    free(made);
}

/* Reads the strip's rows; what lies beyond an edge that does not wrap is left out. */
static bool read_strip(strip *s, const bias *off)
{
    const raster *r = s->heights;
    int32_t first = s->y0 - s->reach, end = s->y1 + s->reach;
    if (s->how->border_y != NTP_BORDER_WRAP) {
        first = first < 0 ? 0 : first;
        end = end > r->height ? r->height : end;
    }
    s->first = first;
    s->count = end - first;
    if (!heights_read(r, first, s->count, s->rows))
        return false;
    if (off != NULL)
        bias_take_off(off, r, s->rows, s->count);
    return true;
}

static job_status smooth_strips(strip *s, const bias *off, int32_t parts,
                                const surroundings *around)
{
    const int32_t height = s->heights->height;
    for (int32_t y = 0; y < height; y += parts * s->step) {
        s->y0 = y;
        s->y1 = height - y > parts * s->step ? y + parts * s->step : height;
        if (!surroundings_progress(around, 0))
            return JOB_CANCELLED;
        if (!read_strip(s, off))
            return JOB_NO_PIXELS;
        const int32_t count = (s->y1 - y + s->step - 1) / s->step;
        surroundings_parallel(around, count, smooth_part, s);
        for (int32_t i = 0; i < count; i++) {
            if (s->status[i] != JOB_DONE)
                return s->status[i];
        }
    }
    return JOB_DONE;
}

job_status smoothed_make(smoothed *made, const smoothing *forms, const ntp_normals_options *how,
                         bool biased, const raster *heights, const surroundings *around)
{
    enum { LEAST = 64 }; /* rows of a part */
    const int32_t threads = around != NULL && around->threads > 1 ? around->threads : 1;
    const int32_t reach = smoothing_reach(forms), step = 2 * reach > LEAST ? 2 * reach : LEAST;
    strip s = { forms, how, heights, made, NULL, 0, 0, 0, 0, step, reach, NULL };
    bias off = { { 0 } };
    *made = (smoothed) { .raster = { .user = made,
                                     .read = read_smoothed,
                                     .width = heights->width,
                                     .height = heights->height,
                                     .channels = smoothing_channels(heights->channels),
                                     .type = NTP_TYPE_F32 } };
    made->data = malloc(raster_row(&made->raster) * (size_t) heights->height);
    s.rows = malloc(raster_row(heights) * ((size_t) threads * (size_t) step + 2 * (size_t) reach));
    s.status = calloc((size_t) threads, sizeof *s.status);
    job_status status =
        made->data != NULL && s.rows != NULL && s.status != NULL ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE && biased)
        status = bias_find(&off, heights);
    if (status == JOB_DONE)
        status = smooth_strips(&s, biased ? &off : NULL, threads, around);
    free(s.rows);
    free(s.status);
    if (status != JOB_DONE)
        smoothed_free(made);
    return status;
}

void smoothed_free(smoothed *made)
{
    free(made->data);
    made->data = NULL;
}
