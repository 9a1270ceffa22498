/* SPDX-License-Identifier: MIT */
/*
 * raster.c - views of rows, and a layer's brightness as a plane of another size
 */
#include "raster.h"

#include <stdlib.h>

#define N_(TEXT) TEXT

const char *job_status_text(job_status status)
{
    switch (status) {
    case JOB_DONE:
        return N_("Done.");
    case JOB_CANCELLED:
        return N_("Cancelled. Nothing was changed.");
    case JOB_NO_MEMORY:
        return N_("There is not enough memory. Nothing was changed.");
    case JOB_NO_PIXELS:
        return N_("The layer's pixels could not be read or written.");
    case JOB_NO_ALPHA:
        return N_("The layer has no alpha channel that could be the height. Choose another height, "
                  "or add one: Layer > Transparency > Add Alpha Channel.");
    case JOB_WRONG_SIZE:
        return N_("The layer with the height has another size than the layer that the normals go "
                  "to. Bring them to one size: Layer > Scale Layer.");
    case JOB_GRAY:
        return N_("This layer is gray: it cannot hold normals. To make normals of a height, choose "
                  "Normals from Height.");
    case JOB_NO_LAYER:
        return N_("Alpha is to come from another layer, but none is chosen. Choose the layer for "
                  "alpha, or another alpha.");
    case JOB_BEYOND:
        return N_("The layer's effects reach beyond its edges. First merge them: the fx icon in "
                  "the Layers dialog, Merge filters.");
    case JOB_IS_HEIGHT:
        return N_("This looks like a heightfield (bump map), not like normals. To make normals of "
                  "it, choose Normals from Height. If these are normals all the same, set \"Range "
                  "of blue\".");
    case JOB_IS_NORMALS:
        return N_(
            "This shows normals already, not heights: normals of their colors would be wrong. "
            "If one channel is a height, choose it under \"Height\". To insist, answer the "
            "question of the dialog, or set \"force\" in a script.");
    case JOB_NO_NORMALS:
        return N_(
            "This does not look like a normals texture. If it is one all the same, set \"Range "
            "of blue\".");
    case JOB_MISPLACED:
        return N_("Channels are exchanged or were converted: this would make it worse. Export "
                  "again, or undo it: Check Normals has a button for that, and Clean Normals the "
                  "option \"Put channels right first\". If all is as it should be, set \"Range of "
                  "blue\".");
    case JOB_NO_METHOD:
        return N_("This method does not take this kernel with these edges. Choose the method \"As "
                  "the edges say\", or edges that wrap or mirror.");
    default:
        return N_("A value is out of range.");
    }
}

ntp_image raster_view(const raster *r, void *rows, int32_t height)
{
    ntp_image view = ntp_image_packed(rows, r->width, height, r->channels, r->type);
    view.encoding = NTP_ENCODING_HEIGHT;
    return view;
}

bool surroundings_progress(const surroundings *s, double share)
{
    return s == NULL || s->progress == NULL || s->progress(s->user, share);
}

void surroundings_parallel(const surroundings *s, int32_t count,
                           void (*task)(void *work, int32_t index), void *work)
{
    if (s != NULL && s->parallel != NULL && count > 1) {
        s->parallel(s->user, count, task, work);
        return;
    }
    for (int32_t i = 0; i < count; i++)
        task(work, i);
}

static int32_t tell_progress(void *user, double share)
{
    return !surroundings_progress(user, share);
}

static void run_parts(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    surroundings_parallel(user, count, task, work);
}

ntp_hooks surroundings_hooks(const surroundings *s)
{
    return (ntp_hooks) { .user = (void *) (uintptr_t) s,
                         .progress = tell_progress,
                         .parallel_for = run_parts,
                         .parts = s != NULL && s->threads > 1 ? s->threads : 1 };
}

/* ------------------------------------------------------------------------------- scaling */

static double sample(const void *at, ntp_type type)
{
    if (type == NTP_TYPE_U8)
        return *(const uint8_t *) at / 255.0;
    if (type == NTP_TYPE_U16)
        return *(const uint16_t *) at / 65535.0;
    const float value = *(const float *) at;
    return value > 0 ? value < 1 ? (double) value : 1 : 0; /* NaN is 0 */
}

static void store(void *at, ntp_type type, double value)
{
    if (type == NTP_TYPE_U8)
        *(uint8_t *) at = (uint8_t) (value * 255 + 0.5);
    else if (type == NTP_TYPE_U16)
        *(uint16_t *) at = (uint16_t) (value * 65535 + 0.5);
    else
        *(float *) at = (float) value;
}

static double brightness(const unsigned char *pixel, const raster *r)
{
    const size_t step = raster_sample(r);
    const double red = sample(pixel, r->type);
    if (r->channels < 3)
        return red;
    return 0.2126 * red + 0.7152 * sample(pixel + step, r->type) +
           0.0722 * sample(pixel + 2 * step, r->type);
}

/* Where a sample of the result gets its values from, on one axis. */
typedef struct taps {
    double center, reach;
    int32_t first, last;
} taps;

static taps taps_at(int32_t i, int32_t from, int32_t to)
{
    const double ratio = (double) from / (double) to;
    taps t = { .center = ((double) i + 0.5) * ratio - 0.5, .reach = ratio > 1 ? ratio : 1 };
    const double low = t.center - t.reach, high = t.center + t.reach;
    t.first = low < 0 ? 0 : (int32_t) low;
    t.last = high > (double) (from - 1) ? from - 1 : (int32_t) high;
    return t;
}

static double weight(const taps *t, int32_t at)
{
    const double distance =
        (double) at > t->center ? (double) at - t->center : t->center - (double) at;
    return distance < t->reach ? 1 - distance / t->reach : 0;
}

static void scale_row(double *out, int32_t width, const double *in, int32_t from)
{
    for (int32_t x = 0; x < width; x++) {
        const taps t = taps_at(x, from, width);
        double sum = 0, weights = 0;
        for (int32_t i = t.first; i <= t.last; i++) {
            sum += weight(&t, i) * in[i];
            weights += weight(&t, i);
        }
        out[x] = sum / weights;
    }
}

/* Adds the row `i` of the layer, scaled to the width, times its weight. */
static bool add_row(const raster *r, int32_t i, double factor, unsigned char *row, double *wide,
                    double *narrow, double *sums, int32_t width)
{
    if (!r->read(r->user, i, i + 1, row))
        return false;
    for (int32_t x = 0; x < r->width; x++)
        wide[x] = brightness(row + (size_t) x * raster_pixel(r), r);
    scale_row(narrow, width, wide, r->width);
    for (int32_t x = 0; x < width; x++)
        sums[x] += factor * narrow[x];
    return true;
}

job_status raster_plane(const raster *r, void *plane, int32_t width, int32_t height, ntp_type type)
{
    const raster result = { .width = width, .height = height, .channels = 1, .type = type };
    unsigned char *row = malloc(raster_row(r)), *out = plane;
    double *wide = malloc(sizeof *wide * ((size_t) r->width + 2 * (size_t) width));
    if (row == NULL || wide == NULL) {
        free(row);
        free(wide);
        return JOB_NO_MEMORY;
    }
    double *narrow = wide + r->width, *sums = narrow + width;
    bool ok = true;
    for (int32_t y = 0; ok && y < height; y++) {
        const taps t = taps_at(y, r->height, height);
        double weights = 0;
        for (int32_t x = 0; x < width; x++)
            sums[x] = 0;
        for (int32_t i = t.first; ok && i <= t.last; i++) {
            if (!(weight(&t, i) > 0))
                continue;
            weights += weight(&t, i);
            ok = add_row(r, i, weight(&t, i), row, wide, narrow, sums, width);
        }
        for (int32_t x = 0; x < width; x++, out += raster_sample(&result))
            store(out, type, sums[x] / weights);
    }
    free(row);
    free(wide);
    return ok ? JOB_DONE : JOB_NO_PIXELS;
}
