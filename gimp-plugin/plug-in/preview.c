/* SPDX-License-Identifier: MIT */
/*
 * preview.c - texels of a result before it is made
 *
 * Only visible rows are computed.  The jobs are those of the procedures, with an 8-bit result that
 * keeps only these rows.
 */
#include "preview.h"
#include "height.h"
#include "preview_pixels.h"
#include "repair.h"
#include "texels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    RGBA = 4,
    RGB = 3,
    GROUP = 64 /* rows made at once, where they follow each other */
};

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

/* How texels of an area are made: 8-bit RGBA. */
typedef struct maker {
    const preview *p;
    enum { MAKE_NORMALS, MAKE_CLEAN, MAKE_NOTHING } what;
    bool colors;           /* mix them as colors; otherwise as normals of this encoding */
    ntp_encoding encoding; /* of what is made */
    normals_job normals;
    repair_job repair;
    const raster *from; /* what is repaired */
} maker;

static uint8_t to_byte(const unsigned char *at, ntp_type type)
{
    if (type == NTP_TYPE_U8)
        return *at;
    if (type == NTP_TYPE_U16) {
        uint16_t level;
        memcpy(&level, at, sizeof level);
        return (uint8_t) ((level + 128) / 257);
    }
    float value;
    memcpy(&value, at, sizeof value);
    return (uint8_t) (value > 0 ? value < 1 ? value * 255 + 0.5f : 255 : 0);
}

/* The layer as it is. */
static job_status copy(const raster *r, const ntp_rect *area, unsigned char *data)
{
    const size_t sample = raster_sample(r), step = r->channels < 3 ? 0 : sample;
    unsigned char *row = malloc(raster_row(r));
    bool ok = row != NULL;
    for (int32_t y = area->y0; ok && y < area->y1; y++) {
        ok = r->read(r->user, y, y + 1, row);
        for (int32_t x = area->x0; ok && x < area->x1; x++, data += RGBA) {
            const unsigned char *from = row + (size_t) x * raster_pixel(r);
            for (size_t c = 0; c < RGB; c++)
                data[c] = to_byte(from + c * step, r->type);
            data[RGB] = 255;
        }
    }
    const job_status status = row == NULL ? JOB_NO_MEMORY : ok ? JOB_DONE : JOB_NO_PIXELS;
    free(row);
    return status;
}

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
    if (m->what == MAKE_NOTHING)
        return copy(p->layer, area, data);
    if (m->what == MAKE_NORMALS)
        return normals_job_run(&m->normals, p->heights != NULL ? p->heights : p->layer, NULL, NULL,
                               &result, area, p->around);
    return repair_job_run(&m->repair, m->from, NULL, &result, area, p->around, NULL);
}

/* ------------------------------------------------------------------------------ averages */

/* What the texels under a pixel add up to. */
typedef struct sum {
    float across, up; /* slopes of normals */
    int32_t normals;  /* that they are of: unused texels have none */
    int32_t color[RGB], texels;
} sum;

static void add(sum *s, const unsigned char *texel, const maker *m)
{
    const int32_t r = texel[0], g = texel[1], b = texel[2];
    s->texels++;
    s->color[0] += r;
    s->color[1] += g;
    s->color[2] += b;
    if (m->colors || (r == g && g == b && (r == 0 || r == 255)))
        return;
    const int32_t x = 2 * r - 255, y = 2 * g - 255;
    const float rest = (float) (255 * 255 - x * x - y * y);
    const float z = m->encoding == NTP_ENCODING_XY      ? sqrtf(rest > 1 ? rest : 1)
                    : m->encoding == NTP_ENCODING_ZZERO ? (float) (b > 0 ? b : 1)
                                                        : (float) (b > 128 ? 2 * b - 255 : 1);
    s->across += (float) x / z;
    s->up += (float) y / z;
    s->normals++;
}

static uint8_t signed_level(double v)
{
    return (uint8_t) ((v + 1) * 127.5 + 0.5);
}

static void mix(const sum *s, const maker *m, uint8_t *rgb)
{
    for (int c = 0; c < RGB; c++)
        rgb[c] = (uint8_t) ((s->color[c] + s->texels / 2) / s->texels);
    if (s->normals == 0)
        return;
    const double x = (double) s->across / s->normals, y = (double) s->up / s->normals;
    const double z = 1 / sqrt(1 + x * x + y * y);
    rgb[0] = signed_level(x * z);
    rgb[1] = signed_level(y * z);
    if (m->encoding != NTP_ENCODING_XY)
        rgb[2] = m->encoding == NTP_ENCODING_ZZERO ? signed_level(2 * z - 1) : signed_level(z);
}

/* A row of pixels from the rows of texels that they cover; one texel is shown as it is. */
static void gather(const maker *m, int32_t first, const unsigned char *const *rows, int32_t n,
                   uint8_t *out)
{
    const preview *p = m->p;
    for (int32_t i = 0; i < p->width; i++, out += RGB) {
        sum s = { 0 };
        if (n == 1) {
            memcpy(out, rows[0] + (size_t) (preview_column_of(p, i, 0, 1) - first) * RGBA, RGB);
            continue;
        }
        for (int32_t c = 0; c < n; c++) {
            const size_t at = (size_t) (preview_column_of(p, i, c, n) - first) * RGBA;
            for (int32_t k = 0; k < n; k++)
                add(&s, rows[k] + at, m);
        }
        mix(&s, m, out);
    }
}

/* The rows of pixels j .. end - 1.  Texel rows that follow each other are made at once. */
static job_status sample_group(const maker *m, int32_t j, int32_t end, unsigned char *data,
                               const unsigned char **rows, uint8_t *out)
{
    const preview *p = m->p;
    const int32_t n = preview_texels_in_pixel(p);
    const int32_t x0 = preview_column_of(p, 0, 0, n),
                  x1 = preview_column_of(p, p->width - 1, n - 1, n) + 1;
    const size_t row = (size_t) (x1 - x0) * RGBA;
    const bool dense = n >= p->step;
    const int32_t first = preview_row_of(p, j, 0, n);
    job_status status = JOB_DONE;
    if (dense) {
        const ntp_rect area = { x0, first, x1, preview_row_of(p, end - 1, n - 1, n) + 1 };
        status = make(m, &area, data);
    }
    for (; status == JOB_DONE && j < end; j++) {
        for (int32_t k = 0; status == JOB_DONE && k < n; k++) {
            const int32_t y = preview_row_of(p, j, k, n);
            unsigned char *at = data + row * (size_t) (dense ? y - first : k);
            const ntp_rect area = { x0, y, x1, y + 1 };
            if (!dense)
                status = make(m, &area, at);
            rows[k] = at;
        }
        if (status == JOB_DONE)
            gather(m, x0, rows, n, out + (size_t) j * (size_t) p->width * RGB);
    }
    return status;
}

static job_status sample(const maker *m, uint8_t *out)
{
    const preview *p = m->p;
    const int32_t end = preview_end_of(p);
    const int32_t n = preview_texels_in_pixel(p);
    const double covered = (double) GROUP / p->step;
    const int32_t group = covered < 1 ? 1 : covered > p->height ? p->height : (int32_t) covered;
    const size_t most = (size_t) ceil((double) group * p->step) + (size_t) n + 2;
    unsigned char *data = malloc(most * (size_t) p->layer->width * RGBA);
    const unsigned char **rows = malloc((size_t) n * sizeof *rows);
    job_status status = data != NULL && rows != NULL ? JOB_DONE : JOB_NO_MEMORY;
    for (int32_t j = p->first; status == JOB_DONE && j < end; j += group)
        status = sample_group(m, j, j + group < end ? j + group : end, data, rows, out);
    free(rows);
    free(data);
    return status;
}

/* ---------------------------------------------------------------------------- procedures */

static void light_up(const preview *p, ntp_encoding encoding, ntp_y y, uint8_t *normals,
                     uint8_t *lit)
{
    ntp_image view = ntp_image_packed(normals, p->width, p->height, RGB, NTP_TYPE_U8);
    ntp_image out = ntp_image_packed(lit, p->width, p->height, RGB, NTP_TYPE_U8);
    view.encoding = encoding;
    view.y = y;
    out.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image seen = ntp_image_as_const(&view);
    const ntp_rect rows = { 0, p->first, p->width, preview_end_of(p) };
    ntp_shade(&out, &seen, p->light, &rows);
}

static bool same_heights(const ntp_normals_options *a, const ntp_normals_options *b)
{
    return a->source == b->source && a->border_x == b->border_x && a->border_y == b->border_y;
}

static bool same_slopes(const preview_scale *s, const normals_job *job)
{
    const ntp_normals_options *a = &s->of, *b = &job->how;
    return s->known && same_heights(a, b) && a->kernel == b->kernel && a->dx == b->dx &&
           a->dy == b->dy && s->biased == job->biased;
}

static job_status find_scale(const preview *p, normals_job *job)
{
    preview_scale own = { 0 }, *s = p->scale != NULL ? p->scale : &own;
    const double strength = job->how.scale;
    if (!job->measures)
        return JOB_DONE;
    if (!same_slopes(s, job)) {
        const preview_scale asked = { .known = true, .of = job->how, .biased = job->biased };
        job->how.scale = 1;
        const job_status status =
            normals_job_find_scale(job, p->heights != NULL ? p->heights : p->layer);
        if (status != JOB_DONE)
            return status;
        *s = asked;
        s->value = job->how.scale;
    }
    job->how.scale = s->value * strength;
    job->measures = false;
    return JOB_DONE;
}

void preview_heights_forget(preview_heights *h)
{
    smoothed_free(&h->made);
}

/* Smooths the heights of the whole layer, or takes those of the last call. */
static job_status find_heights(const preview *p, preview_heights *h, normals_job *job)
{
    const smoothing *a = &h->forms, *b = &job->forms;
    const preview_heights asked = { .forms = job->forms, .of = job->how, .biased = job->biased };
    if (!smoothing_acts(b))
        return JOB_DONE;
    if (h->made.data != NULL && a->blur == b->blur && a->small == b->small &&
        a->middle == b->middle && a->large == b->large && same_heights(&h->of, &job->how) &&
        h->biased == job->biased) {
        job->forms = (smoothing) { 0, 1, 1, 1 };
        job->how.source = NTP_HEIGHT_SOURCE_RED;
        job->biased = false;
        return JOB_DONE;
    }
    preview_heights_forget(h);
    *h = asked;
    return normals_job_smooth(job, &h->made, p->heights != NULL ? p->heights : p->layer, p->around);
}

/* Both pictures, of heights that are ready. */
static job_status paint_normals(maker m, uint8_t *map, uint8_t *lit)
{
    const preview *p = m.p;
    job_status status = sample(&m, map);
    if (status != JOB_DONE)
        return status;
    if (m.colors) {
        m.normals.swap = m.colors = false;
        m.normals.channels = ORDER_XYZ;
        m.normals.dudv = DUDV_NONE;
        status = sample(&m, lit);
        if (status == JOB_DONE)
            light_up(p, m.encoding, m.normals.y, lit, lit);
        return status;
    }
    light_up(p, m.encoding, m.normals.y, map, lit);
    return JOB_DONE;
}

static job_status show_normals(const preview *p, uint8_t *map, uint8_t *lit)
{
    preview with = *p; /* the smoothed heights */
    preview_heights own = { 0 }, *h = p->smoothed != NULL ? p->smoothed : &own;
    maker m = { .p = &with, .what = MAKE_NORMALS, .normals = normals_job_from(p->settings) };
    m.normals.alpha = ALPHA_KEEP;
    m.normals.how.alpha = NTP_ALPHA_KEEP;
    m.normals.dithers = false;  /* it needs every row above, for at most a level */
    m.normals.occludes = false; /* it would take seconds for each change */
    m.encoding = m.normals.encoding;
    m.colors = m.normals.swap || m.normals.channels != ORDER_XYZ || m.normals.dudv != DUDV_NONE;
    const bool smooths = smoothing_acts(&m.normals.forms);
    job_status status = find_scale(p, &m.normals);
    if (status == JOB_DONE)
        status = find_heights(p, h, &m.normals);
    if (status == JOB_DONE && smooths)
        with.heights = &h->made.raster;
    if (status == JOB_DONE)
        status = paint_normals(m, map, lit);
    preview_heights_forget(&own);
    return status;
}

static job_status show_clean(const preview *p, uint8_t *map, uint8_t *lit)
{
    const bool check = p->procedure == &procedures[PROCEDURE_CHECK];
    const bool as_it_is = p->waiting || (check && p->repair == NULL);
    undone right;
    maker m = { .p = p, .what = as_it_is ? MAKE_NOTHING : MAKE_CLEAN, .from = p->layer };
    if (as_it_is) {
        m.encoding =
            p->found != NULL && p->found->judged ? p->found->encoding : NTP_ENCODING_STANDARD;
    } else {
        /* What was found of a layer does not hold for that without its accident. */
        const report *found = p->accident == UNDO_NOTHING ? p->found : NULL;
        m.repair = check ? *p->repair : repair_job_from(p->settings, found);
        m.encoding = m.repair.convert ? m.repair.to : m.repair.from;
    }
    if (p->accident != UNDO_NOTHING) {
        undone_open(&right, p->layer, p->accident);
        m.from = &right.raster;
    }
    const job_status status = sample(&m, map);
    if (status != JOB_DONE)
        return status;
    light_up(p, m.encoding, p->green, map, lit);
    if (p->found == NULL || check || p->accident != UNDO_NOTHING)
        return JOB_DONE;
    return !p->found->judged ? JOB_NO_NORMALS : p->found->misplaced ? JOB_MISPLACED : JOB_DONE;
}

static bool read_small(void *user, int32_t y0, int32_t y1, void *rows)
{
    const piece *from = user;
    memcpy(rows, from->data + (size_t) y0 * (size_t) from->width * RGB,
           (size_t) (y1 - y0) * (size_t) from->width * RGB);
    return true;
}

/* Heights of a small texture; free them. */
static job_status solve(const preview *p, uint8_t *normals, float **plane)
{
    height_job job = height_job_from(p->settings);
    piece texels = { normals, 0, 0, p->width };
    const raster small = { .user = &texels,
                           .read = read_small,
                           .width = p->width,
                           .height = p->height,
                           .channels = RGB,
                           .type = NTP_TYPE_U8 };
    double range = 0;
    /* A mean of slopes is no stencil's, and at the edge of a part nothing wraps.  A stencil such as
     * the central difference leaves its two or four grids of texels unconnected here: dots. */
    job.how.method = NTP_HEIGHT_AUTO;
    job.how.kernel = NTP_KERNEL_BAKED;
    if ((double) p->width * p->step < (double) p->layer->width - 0.5)
        job.how.border_x = NTP_BORDER_EXTRAPOLATE;
    if ((double) p->height * p->step < (double) p->layer->height - 0.5)
        job.how.border_y = NTP_BORDER_EXTRAPOLATE;
    return height_job_run(&job, &small, plane, &range, NULL);
}

static job_status show_height(const preview *p, uint8_t *map, uint8_t *lit)
{
    const height_job job = height_job_from(p->settings);
    preview small = *p; /* a texel for each pixel, if pixels are smaller */
    maker m = { .p = &small, .what = MAKE_NOTHING, .encoding = job.encoding };
    const int32_t x0 = preview_column_of(p, 0, 0, 1), y0 = preview_row_of(p, 0, 0, 1);
    if (p->step < 1) {
        small.step = 1;
        small.first = small.end = 0; /* all of its rows, which are fewer */
        small.x = x0;
        small.y = y0;
        small.width = preview_column_of(p, p->width - 1, 0, 1) - x0 + 1;
        small.height = preview_row_of(p, p->height - 1, 0, 1) - y0 + 1;
    }
    const size_t count = (size_t) small.width * (size_t) small.height;
    uint8_t *normals = malloc(count * RGB);
    float *plane = NULL;
    job_status status = normals != NULL ? sample(&m, normals) : JOB_NO_MEMORY;
    if (status == JOB_DONE)
        status = solve(&small, normals, &plane);
    for (int32_t j = 0; status == JOB_DONE && j < p->height; j++) {
        const int32_t y = p->step < 1 ? preview_row_of(p, j, 0, 1) - y0 : j;
        for (int32_t i = 0; i < p->width; i++, map += RGB, lit += RGB) {
            const int32_t x = p->step < 1 ? preview_column_of(p, i, 0, 1) - x0 : i;
            const size_t at = (size_t) y * (size_t) small.width + (size_t) x;
            memset(map, (int) (plane[at] * 255 + 0.5f), RGB);
            memcpy(lit, normals + at * RGB, RGB);
        }
    }
    if (status == JOB_DONE) {
        lit -= (size_t) p->width * (size_t) p->height * RGB;
        light_up(p, job.encoding, job.y, lit, lit);
    }
    free(plane);
    free(normals);
    return status;
}

job_status preview_render(const preview *p, uint8_t *map, uint8_t *lit, uint8_t *before)
{
    const bool normals = p->procedure == &procedures[PROCEDURE_NORMALS];
    const maker plain = { .p = p,
                          .what = MAKE_NOTHING,
                          .colors = normals || p->layer->channels < 3,
                          .encoding = NTP_ENCODING_STANDARD };
    const job_status status = before != NULL ? sample(&plain, before) : JOB_DONE;
    if (status != JOB_DONE)
        return status;
    if (normals)
        return show_normals(p, map, lit);
    if (p->layer->channels < 3 && p->procedure == &procedures[PROCEDURE_CHECK]) {
        memset(lit, 0, (size_t) p->width * (size_t) p->height * RGB);
        return sample(&plain, map);
    }
    if (p->layer->channels < 3)
        return JOB_GRAY;
    return p->procedure == &procedures[PROCEDURE_HEIGHT] ? show_height(p, map, lit)
                                                         : show_clean(p, map, lit);
}
