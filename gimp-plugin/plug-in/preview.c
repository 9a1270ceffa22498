/* SPDX-License-Identifier: MIT */
/*
 * preview.c - texels of a result before it is made
 *
 * Only visible rows are computed.  The jobs are those of the procedures, with an 8-bit result that
 * keeps only these rows.
 */
#include "preview.h"
#include "height.h"
#include "repair.h"
#include "texels.h"

#include <stdlib.h>
#include <string.h>

enum { RGBA = 4, RGB = 3 };

/* A result that is a piece of the layer's size, from (x, y) on. */
typedef struct piece {
    unsigned char *data;
    int32_t x, y, width;
} piece;

static bool keep(void *user, const ntp_rect *area, const void *pixels, ptrdiff_t row_bytes)
{
    const piece *to = user;
    for (int32_t y = area->y0; y < area->y1; y++) {
        const size_t at = (size_t) (y - to->y) * (size_t) to->width + (size_t) (area->x0 - to->x);
        memcpy(to->data + at * RGBA, (const unsigned char *) pixels + (y - area->y0) * row_bytes,
               (size_t) (area->x1 - area->x0) * RGBA);
    }
    return true;
}

/* How the procedure's texels of an area are made: 8-bit RGBA. */
typedef struct maker {
    const preview *p;
    normals_job normals;
    repair_job repair;
} maker;

static job_status make(const maker *m, const ntp_rect *area, unsigned char *data)
{
    const preview *p = m->p;
    piece to = { data, area->x0, area->y0, area->x1 - area->x0 };
    const raster result = { .user = &to,
                            .write = keep,
                            .width = p->layer->width,
                            .height = p->layer->height,
                            .channels = RGBA,
                            .type = NTP_TYPE_U8 };
    if (p->procedure == &procedures[PROCEDURE_NORMALS])
        return normals_job_run(&m->normals, p->heights != NULL ? p->heights : p->layer, NULL, NULL,
                               &result, area, NULL);
    return repair_job_run(&m->repair, p->layer, NULL, &result, area, NULL, NULL);
}

static int32_t texel_at(double start, double step, int32_t i, int32_t size)
{
    const double at = start + ((double) i + 0.5) * step;
    return at < 0 ? 0 : at >= (double) size ? size - 1 : (int32_t) at;
}

static void gather(const preview *p, int32_t j, int32_t first, const unsigned char *row,
                   uint8_t *out)
{
    for (int32_t i = 0; i < p->width; i++) {
        const int32_t x = texel_at(p->x, p->step, i, p->layer->width) - first;
        memcpy(out + ((size_t) j * (size_t) p->width + (size_t) i) * RGB, row + (size_t) x * RGBA,
               RGB);
    }
}

/* One texel under each pixel.  Rows that follow each other are made at once. */
static job_status sample(const maker *m, uint8_t *out)
{
    const preview *p = m->p;
    const int32_t x0 = texel_at(p->x, p->step, 0, p->layer->width);
    const int32_t x1 = texel_at(p->x, p->step, p->width - 1, p->layer->width) + 1;
    const int32_t last = texel_at(p->y, p->step, p->height - 1, p->layer->height);
    const bool dense = p->step <= 1;
    const int32_t first = texel_at(p->y, p->step, 0, p->layer->height);
    const size_t row = (size_t) (x1 - x0) * RGBA;
    unsigned char *data = malloc(row * (dense ? (size_t) (last - first) + 1 : 1));
    job_status status = data != NULL ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE && dense) {
        const ntp_rect area = { x0, first, x1, last + 1 };
        status = make(m, &area, data);
    }
    for (int32_t j = 0; status == JOB_DONE && j < p->height; j++) {
        const int32_t y = texel_at(p->y, p->step, j, p->layer->height);
        const ntp_rect area = { x0, y, x1, y + 1 };
        if (!dense)
            status = make(m, &area, data);
        if (status == JOB_DONE)
            gather(p, j, x0, data + (dense ? row * (size_t) (y - first) : 0), out);
    }
    free(data);
    return status;
}

static void light_up(const preview *p, ntp_encoding encoding, ntp_y y, uint8_t *normals,
                     uint8_t *lit)
{
    ntp_image view = ntp_image_packed(normals, p->width, p->height, RGB, NTP_TYPE_U8);
    ntp_image out = ntp_image_packed(lit, p->width, p->height, RGB, NTP_TYPE_U8);
    view.encoding = encoding;
    view.y = y;
    out.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image seen = ntp_image_as_const(&view);
    ntp_shade(&out, &seen, p->light, NULL);
}

static job_status show_normals(const preview *p, uint8_t *map, uint8_t *lit, double *scale)
{
    maker m = { .p = p, .normals = normals_job_from(p->settings) };
    const bool stored_otherwise = m.normals.swap || m.normals.dudv != DUDV_NONE;
    m.normals.alpha = ALPHA_KEEP;
    m.normals.how.alpha = NTP_ALPHA_KEEP;
    const bool measures = m.normals.measures;
    job_status status =
        normals_job_find_scale(&m.normals, p->heights != NULL ? p->heights : p->layer);
    if (measures)
        *scale = m.normals.how.scale < 0 ? -m.normals.how.scale : m.normals.how.scale;
    if (status == JOB_DONE)
        status = sample(&m, map);
    if (status != JOB_DONE)
        return status;
    if (stored_otherwise) {
        m.normals.swap = false;
        m.normals.dudv = DUDV_NONE;
        status = sample(&m, lit);
        if (status == JOB_DONE)
            light_up(p, m.normals.encoding, m.normals.y, lit, lit);
        return status;
    }
    light_up(p, m.normals.encoding, (ntp_y) p->settings->value[FN_TO_Y], map, lit);
    return JOB_DONE;
}

static job_status show_clean(const preview *p, uint8_t *map, uint8_t *lit)
{
    const maker m = { .p = p, .repair = repair_job_from(p->settings, p->found) };
    const job_status status = sample(&m, map);
    if (status != JOB_DONE)
        return status;
    light_up(p, m.repair.from, NTP_Y_UP, map, lit);
    if (p->found == NULL)
        return JOB_DONE;
    return !p->found->judged ? JOB_NO_NORMALS : p->found->misplaced ? JOB_MISPLACED : JOB_DONE;
}

/* --------------------------------------------------------------------------------- heights */

static bool read_small(void *user, int32_t y0, int32_t y1, void *rows)
{
    const piece *from = user;
    memcpy(rows, from->data + (size_t) y0 * (size_t) from->width * RGB,
           (size_t) (y1 - y0) * (size_t) from->width * RGB);
    return true;
}

static job_status show_height(const preview *p, uint8_t *map, uint8_t *lit)
{
    const height_job job = height_job_from(p->settings);
    const maker m = { .p = p, .repair = { .from = NTP_ENCODING_STANDARD } };
    float *plane = NULL;
    double range = 0;
    job_status status = sample(&m, map);
    if (status != JOB_DONE)
        return status;
    piece texels = { map, 0, 0, p->width };
    const raster small = { .user = &texels,
                           .read = read_small,
                           .width = p->width,
                           .height = p->height,
                           .channels = RGB,
                           .type = NTP_TYPE_U8 };
    status = height_job_run(&job, &small, &plane, &range, NULL);
    light_up(p, job.encoding, job.y, map, lit);
    const size_t count = (size_t) p->width * (size_t) p->height;
    for (size_t i = 0; status == JOB_DONE && i < count; i++)
        memset(map + i * RGB, (int) (plane[i] * 255 + 0.5f), RGB);
    free(plane);
    return status;
}

job_status preview_render(const preview *p, uint8_t *map, uint8_t *lit, double *scale)
{
    if (p->procedure == &procedures[PROCEDURE_NORMALS])
        return show_normals(p, map, lit, scale);
    if (p->layer->channels < 3)
        return JOB_GRAY;
    return p->procedure == &procedures[PROCEDURE_HEIGHT] ? show_height(p, map, lit)
                                                         : show_clean(p, map, lit);
}
