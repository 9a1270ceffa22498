/* SPDX-License-Identifier: MIT */
/*
 * test_plugin.c - the jobs of the GIMP plug-in on rasters in memory, against libntp on the whole
 */
#undef NDEBUG
#include "classic.h"
#include "height.h"
#include "normals.h"
#include "preview.h"
#include "repair.h"
#include "report.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------- rasters in memory */

typedef struct memory {
    raster raster;
    unsigned char *data;
    int reads_until_failure; /* negative: never */
} memory;

static bool read_memory(void *user, int32_t y0, int32_t y1, void *rows)
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

static bool write_memory(void *user, const ntp_rect *area, const void *pixels, ptrdiff_t row_bytes)
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

static memory *memory_new(int32_t width, int32_t height, int32_t channels, ntp_type type)
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

static void memory_free(memory *m)
{
    free(m->data);
    free(m);
}

static uint32_t state = 1;
static uint32_t draw(void)
{
    state = state * 1664525u + 1013904223u;
    return state >> 8;
}

static void fill(memory *m)
{
    const size_t samples =
        raster_row(&m->raster) * (size_t) m->raster.height / raster_sample(&m->raster);
    for (size_t i = 0; i < samples; i++) {
        if (m->raster.type == NTP_U8)
            m->data[i] = (unsigned char) draw();
        else if (m->raster.type == NTP_U16)
            ((uint16_t *) (void *) m->data)[i] = (uint16_t) draw();
        else
            ((float *) (void *) m->data)[i] = (float) draw() / 16777216.0f;
    }
}

static size_t bytes_of(const memory *m)
{
    return raster_row(&m->raster) * (size_t) m->raster.height;
}

/* ------------------------------------------------------------------- heights to normals */

/* The whole picture at once by libntp; alpha of 4 channels by how->alpha. */
static void expect_normals(memory *out, const memory *in, const normals_job *job)
{
    ntp_image dst = raster_view(&out->raster, out->data, out->raster.height);
    ntp_image src = raster_view(&in->raster, in->data, in->raster.height);
    const ntp_const_image seen = ntp_image_as_const(&src);
    dst.encoding = job->encoding;
    dst.y = job->y;
    assert(ntp_normals_from_height(&dst, &seen, &job->how, NULL, NULL) == NTP_OK);
}

static void test_bands(void)
{
    static const int32_t SIZES[][2] = { { 1, 1 },   { 3, 2 },    { 17, 127 }, { 5, 128 },
                                        { 7, 129 }, { 31, 260 }, { 64, 300 }, { 2, 513 } };
    const procedure *p = &procedures[PROCEDURE_NORMALS];
    for (int n = 0; n < 400; n++) {
        const int32_t *size = SIZES[draw() % 8];
        const ntp_type type = (ntp_type) (draw() % 3);
        const int32_t channels = 1 + (int32_t) (draw() % 4);
        memory *in = memory_new(size[0], size[1], channels, type);
        memory *made = memory_new(size[0], size[1], 3 + (channels % 2 == 0), type);
        memory *expected = memory_new(size[0], size[1], made->raster.channels, type);
        settings s;
        settings_reset(p, &s);
        s.value[FN_SCALE] = (double) (draw() % 2000) / 100 - 10;
        s.value[FN_KERNEL] = draw() % 10;
        s.value[FN_BORDER_X] = draw() % 5;
        s.value[FN_BORDER_Y] = draw() % 5;
        s.value[FN_SOURCE] = channels < 3 ? 0 : draw() % 11;
        s.value[FN_TO_Y] = draw() % 2;
        s.value[FN_TO] = draw() % 2;
        assert(settings_check(p, &s) == NULL);
        const normals_job job = normals_job_from(&s);
        if (job.how.source == NTP_SOURCE_ALPHA && channels % 2 == 1) {
            assert(normals_job_run(&job, &in->raster, &in->raster, NULL, &made->raster, NULL,
                                   NULL) == JOB_NO_ALPHA);
        } else {
            ntp_rect area = { 0, 0, size[0], size[1] };
            fill(in);
            if (n % 2 == 1) {
                area.x0 = (int32_t) (draw() % (uint32_t) size[0]);
                area.y0 = (int32_t) (draw() % (uint32_t) size[1]);
            }
            expect_normals(expected, in, &job);
            memcpy(made->data, expected->data, bytes_of(made)); /* what is outside stays */
            for (int32_t y = area.y0; y < area.y1; y++)
                memset(made->data + raster_row(&made->raster) * (size_t) y +
                           raster_pixel(&made->raster) * (size_t) area.x0,
                       77, raster_pixel(&made->raster) * (size_t) (area.x1 - area.x0));
            assert(normals_job_run(&job, &in->raster, &in->raster, NULL, &made->raster, &area,
                                   NULL) == JOB_DONE);
            assert(memcmp(made->data, expected->data, bytes_of(made)) == 0);
        }
        memory_free(in);
        memory_free(made);
        memory_free(expected);
    }
}

static void test_flip_and_swap(void)
{
    memory *in = memory_new(9, 7, 1, NTP_U8), *made = memory_new(9, 7, 3, NTP_U8);
    memory *plain = memory_new(9, 7, 3, NTP_U8);
    settings s;
    fill(in);
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 3;
    /* heights of a picture mirrored left to right have the other slope to the right */
    memory *mirrored = memory_new(9, 7, 1, NTP_U8);
    for (int y = 0; y < 7; y++) {
        for (int x = 0; x < 9; x++)
            mirrored->data[y * 9 + x] = in->data[y * 9 + 8 - x];
    }
    normals_job job = normals_job_from(&s);
    assert(normals_job_run(&job, &mirrored->raster, NULL, NULL, &plain->raster, NULL, NULL) ==
           JOB_DONE);
    s.value[FN_FLIP_X] = 1;
    s.value[FN_SWAP] = 1;
    job = normals_job_from(&s);
    assert(normals_job_run(&job, &in->raster, NULL, NULL, &made->raster, NULL, NULL) == JOB_DONE);
    for (int y = 0; y < 7; y++) {
        for (int x = 0; x < 9; x++) {
            const unsigned char *a = made->data + (y * 9 + x) * 3;
            const unsigned char *b = plain->data + (y * 9 + 8 - x) * 3;
            assert(a[0] == b[2] && a[1] == b[1] && a[2] == b[0]);
        }
    }
    memory_free(in);
    memory_free(made);
    memory_free(plain);
    memory_free(mirrored);
}

static void test_alpha_rules(void)
{
    static const int EXPECTED[] = { 40, 255, 0, 215, 200, 55, 90 }; /* in the order of alphas */
    for (int rule = ALPHA_KEEP; rule <= ALPHA_LAYER; rule++) {
        memory *in = memory_new(5, 4, 2, NTP_U8), *made = memory_new(5, 4, 4, NTP_U8);
        memory *mask = memory_new(2, 2, 1, NTP_U16);
        settings s;
        for (int i = 0; i < 20; i++) {
            in->data[2 * i] = 200;
            in->data[2 * i + 1] = 40;
        }
        for (int i = 0; i < 4; i++)
            ((uint16_t *) (void *) mask->data)[i] = 90 * 257;
        settings_reset(&procedures[PROCEDURE_NORMALS], &s);
        s.value[FN_ALPHA] = rule;
        const normals_job job = normals_job_from(&s);
        assert(normals_job_run(&job, &in->raster, &in->raster, &mask->raster, &made->raster, NULL,
                               NULL) == JOB_DONE);
        for (int i = 0; i < 20; i++)
            assert(made->data[4 * i + 3] == EXPECTED[rule] && made->data[4 * i] == 128);
        memory_free(in);
        memory_free(made);
        memory_free(mask);
    }
}

static bool stop(void *user, double share)
{
    (void) user;
    return share < 0.5;
}

static void test_failures(void)
{
    memory *in = memory_new(8, 600, 1, NTP_U8), *made = memory_new(8, 600, 3, NTP_U8);
    memory *small = memory_new(8, 599, 1, NTP_U8);
    const surroundings impatient = { .progress = stop };
    settings s;
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    const normals_job job = normals_job_from(&s);
    assert(normals_job_run(&job, &in->raster, NULL, NULL, &made->raster, NULL, &impatient) ==
           JOB_CANCELLED);
    assert(normals_job_run(&job, &small->raster, NULL, NULL, &made->raster, NULL, NULL) ==
           JOB_WRONG_SIZE);
    in->reads_until_failure = 2;
    assert(normals_job_run(&job, &in->raster, NULL, NULL, &made->raster, NULL, NULL) ==
           JOB_NO_PIXELS);
    memory_free(in);
    memory_free(made);
    memory_free(small);
}

/* ------------------------------------------------------------------------ old arguments */

static settings classic(void)
{
    settings s;
    settings_reset(&procedures[PROCEDURE_CLASSIC], &s);
    return s;
}

/* A ramp of 5 levels a texel to the right: n.x = -5 s / sqrt(1 + 25 s^2), s = scale / 255. */
static void test_classic_filters(void)
{
    static const double GAIN[] = { 1, 8, 128, 6, 40, 1, 36.0 / 29, 124.0 / 69, 170.0 / 77 };
    memory *in = memory_new(33, 20, 4, NTP_U8), *made = memory_new(33, 20, 4, NTP_U8);
    for (int i = 0; i < 33 * 20; i++) {
        memset(in->data + 4 * i, 5 * (i % 33), 3);
        in->data[4 * i + 3] = 17;
    }
    for (int filter = 0; filter < 9; filter++) {
        settings s = classic();
        s.value[FO_FILTER] = filter;
        s.value[FO_SCALE] = 10;
        const classic_job job = classic_job_from(&s, 4, NTP_U8);
        assert(job.kind == CLASSIC_NORMALS);
        assert(normals_job_run(&job.normals, &in->raster, &in->raster, NULL, &made->raster, NULL,
                               NULL) == JOB_DONE);
        const double slope = 5.0 / 255 * 10 * GAIN[filter];
        const int red = (int) floor((1 - slope / sqrt(1 + slope * slope)) * 127.5 + 0.5);
        const unsigned char *texel = made->data + 4 * (10 * 33 + 16);
        /* red 0 beside green 128 is longer than 1, and pulled to red 1 */
        assert(texel[0] == (red == 0 ? 1 : red) && texel[1] == 128 && texel[3] == 17);
    }
    memory_free(in);
    memory_free(made);
}

static void test_classic_dudv(void)
{
    static const double X = -0.6; /* of a ramp with slope 0.75 */
    memory *in = memory_new(9, 3, 4, NTP_U8), *made = memory_new(9, 3, 4, NTP_U8);
    for (int i = 0; i < 27; i++)
        memset(in->data + 4 * i, 20 * (i % 9), 4);
    for (int format = DUDV_8_SIGNED; format <= DUDV_16_UNSIGNED; format++) {
        settings s = classic();
        s.value[FO_DUDV] = format;
        s.value[FO_SCALE] = 0.75 * 255 / 20;
        const classic_job job = classic_job_from(&s, 4, NTP_U8);
        assert(normals_job_run(&job.normals, &in->raster, &in->raster, NULL, &made->raster, NULL,
                               NULL) == JOB_DONE);
        const unsigned char *texel = made->data + 4 * (9 + 4);
        if (format == DUDV_8_SIGNED)
            assert(texel[0] == (unsigned char) (int) floor(X * 127 + 0.5) && texel[1] == 0);
        if (format == DUDV_8_UNSIGNED)
            assert(texel[0] == (int) floor((X + 1) * 127.5 + 0.5) && texel[1] == 128);
        if (format <= DUDV_8_UNSIGNED)
            assert(texel[2] == 0 && texel[3] == 80);
        const int du = texel[0] + 256 * texel[1], dv = texel[2] + 256 * texel[3];
        if (format == DUDV_16_SIGNED)
            assert(du == (int) floor(X * 32767 + 0.5) + 65536 && dv == 0);
        if (format == DUDV_16_UNSIGNED)
            assert(du == (int) floor((X + 1) * 32767.5 + 0.5) && dv == 32768);
    }
    memory_free(in);
    memory_free(made);
}

/* "Above the mean color": half the picture at 200, half at 100, the mean 150. */
static void test_classic_bias(void)
{
    memory *in = memory_new(40, 8, 3, NTP_U8), *made = memory_new(40, 8, 3, NTP_U8);
    memory *heights = memory_new(40, 8, 1, NTP_U8), *expected = memory_new(40, 8, 3, NTP_U8);
    for (int i = 0; i < 40 * 8; i++) {
        memset(in->data + 3 * i, i % 40 < 20 ? 100 : 200, 3);
        heights->data[i] = i % 40 < 20 ? 0 : 50;
    }
    settings s = classic();
    s.value[FO_CONVERSION] = 1;
    s.value[FO_SCALE] = 4;
    s.value[FO_WRAP] = 1;
    const classic_job job = classic_job_from(&s, 3, NTP_U8);
    assert(normals_job_run(&job.normals, &in->raster, NULL, NULL, &made->raster, NULL, NULL) ==
           JOB_DONE);
    normals_job plain = job.normals;
    plain.biased = false;
    expect_normals(expected, heights, &plain);
    assert(memcmp(made->data, expected->data, bytes_of(made)) == 0);
    memory_free(in);
    memory_free(made);
    memory_free(heights);
    memory_free(expected);
}

static void test_classic_normals(void)
{
    memory *in = memory_new(64, 70, 4, NTP_U8), *once = memory_new(64, 70, 4, NTP_U8);
    memory *twice = memory_new(64, 70, 4, NTP_U8);
    settings s = classic();
    fill(in);
    s.value[FO_CONVERSION] = 8; /* normalize only: a second time changes nothing */
    classic_job job = classic_job_from(&s, 4, NTP_U8);
    assert(job.kind == CLASSIC_REPAIR);
    assert(repair_job_run(&job.repair, &in->raster, NULL, &once->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    assert(repair_job_run(&job.repair, &once->raster, NULL, &twice->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    assert(memcmp(once->data, twice->data, bytes_of(once)) == 0);
    s.value[FO_MIN_Z] = 0.9; /* is honored, to within half a level */
    job = classic_job_from(&s, 4, NTP_U8);
    assert(repair_job_run(&job.repair, &in->raster, NULL, &once->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    for (size_t i = 0; i < 64 * 70; i++)
        assert(once->data[4 * i + 2] >= 242 && once->data[4 * i + 3] == in->data[4 * i + 3]);
    s = classic();
    s.value[FO_CONVERSION] = 9; /* z = sqrt(1 - x^2 - y^2), with a plus it would be 1.02 */
    job = classic_job_from(&s, 4, NTP_U8);
    in->data[0] = 40;
    in->data[1] = 80;
    assert(repair_job_run(&job.repair, &in->raster, NULL, &once->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    const double x = (2 * 40 - 255) / 255.0, y = (2 * 80 - 255) / 255.0;
    assert(once->data[0] == 40 && once->data[1] == 80);
    assert(once->data[2] == (int) floor((sqrt(1 - x * x - y * y) + 1) * 127.5 + 0.5));
    memory_free(in);
    memory_free(once);
    memory_free(twice);
}

/* ------------------------------------------------------------------------------- heights */

static void test_height(void)
{
    enum { W = 40, H = 33 };
    memory *in = memory_new(W, H, 1, NTP_U16), *normals = memory_new(W, H, 3, NTP_U16);
    settings s;
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 12;
    s.value[FN_BORDER_X] = s.value[FN_BORDER_Y] = NTP_BORDER_EXTRAPOLATE;
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        ((uint16_t *) (void *) in->data)[i] =
            (uint16_t) (65535 * (0.5 + 0.5 * sin(x * 0.3) * cos(y * 0.2)));
    }
    const normals_job forth = normals_job_from(&s);
    assert(normals_job_run(&forth, &in->raster, NULL, NULL, &normals->raster, NULL, NULL) ==
           JOB_DONE);
    settings_reset(&procedures[PROCEDURE_HEIGHT], &s);
    float *plane = NULL;
    double range = 0;
    height_job back = height_job_from(&s);
    assert(height_job_run(&back, &normals->raster, &plane, &range, NULL) == JOB_DONE);
    double worst = 0;
    for (int i = 0; i < W * H; i++) {
        const double h = ((uint16_t *) (void *) in->data)[i] / 65535.0;
        worst = fmax(worst, fabs((double) plane[i] * range / 12 - h + 0.0));
    }
    assert(worst < 0.01 && fabs(range - 12) < 0.2);
    free(plane);
    for (int i = 0; i < W * H; i++) { /* flat is no gradient, but one gray */
        uint16_t *n = (uint16_t *) (void *) normals->data + 3 * i;
        n[0] = n[1] = 32768;
        n[2] = 65535;
    }
    back.how.decode = NTP_DECODE_NEUTRAL;
    assert(height_job_run(&back, &normals->raster, &plane, &range, NULL) == JOB_DONE);
    for (int i = 0; i < W * H; i++)
        assert(plane[i] == 0.5f);
    free(plane);
    memory_free(in);
    memory_free(normals);
}

/* Heights of a wave that tiles, 12 texels high, and its normals by that kernel; by none: its own. */
static void wave(memory *heights, memory *normals, int kernel)
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

/* Every kernel leads back, tiling and open, by some method. */
static void test_height_kernels(void)
{
    enum { W = 26, H = 21 };
    memory *in = memory_new(W, H, 1, NTP_U16), *normals = memory_new(W, H, 3, NTP_U16);
    const field *kernel = &procedures[PROCEDURE_HEIGHT].fields[FH_KERNEL];
    float *plane = NULL;
    double range = 0;
    settings s;
    assert(choice_find(kernel, "baked") == NTP_KERNEL_BAKED);
    for (int k = 0; k < choice_count(kernel); k++) {
        wave(in, normals, k);
        settings_reset(&procedures[PROCEDURE_HEIGHT], &s);
        s.value[FH_KERNEL] = k;
        for (int border = NTP_BORDER_WRAP; border <= NTP_BORDER_EXTRAPOLATE; border += 3) {
            s.value[FH_BORDER_X] = s.value[FH_BORDER_Y] = border;
            const height_job back = height_job_from(&s);
            assert(height_job_run(&back, &normals->raster, &plane, &range, NULL) == JOB_DONE);
            double worst = 0;
            for (int i = 0; i < W * H; i++) {
                const double h = ((uint16_t *) (void *) in->data)[i] / 65535.0;
                worst = fmax(worst, fabs((double) plane[i] - h));
            }
            assert(border != NTP_BORDER_WRAP || (worst < 0.02 && fabs(range - 12) < 0.3));
            free(plane);
        }
    }
    s.value[FH_KERNEL] = NTP_KERNEL_SOBEL5;
    s.value[FH_METHOD] = NTP_HEIGHT_POISSON_DCT;
    s.value[FH_BORDER_X] = s.value[FH_BORDER_Y] = NTP_BORDER_EXTRAPOLATE;
    const height_job back = height_job_from(&s);
    assert(height_job_run(&back, &normals->raster, &plane, &range, NULL) == JOB_NO_METHOD);
    memory_free(in);
    memory_free(normals);
}

/* ------------------------------------------------------------------- preview and report */

static void test_preview(void)
{
    memory *in = memory_new(300, 200, 1, NTP_U8), *whole = memory_new(300, 200, 3, NTP_U8);
    settings s;
    fill(in);
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    const normals_job job = normals_job_from(&s);
    expect_normals(whole, in, &job);
    static const double STEPS[] = { 3.7, 1, 0.25 };
    for (int k = 0; k < 3; k++) {
        uint8_t map[50 * 40 * 3], lit[50 * 40 * 3];
        const preview p = { .procedure = &procedures[PROCEDURE_NORMALS],
                            .settings = &s,
                            .layer = &in->raster,
                            .width = 50,
                            .height = 40,
                            .x = 20.3,
                            .y = 11.8,
                            .step = STEPS[k] };
        assert(preview_render(&p, map, lit) == JOB_DONE);
        for (int j = 0; j < 40; j++) {
            for (int i = 0; i < 50; i++) {
                const int x = (int) (20.3 + (i + 0.5) * STEPS[k]);
                const int y = (int) (11.8 + (j + 0.5) * STEPS[k]);
                assert(memcmp(map + (j * 50 + i) * 3, whole->data + (y * 300 + x) * 3, 3) == 0);
            }
        }
    }
    memory_free(in);
    memory_free(whole);
}

/* What is shown of cleaning is what cleaning writes, by the method that the report found. */
static void test_preview_of_cleaning(void)
{
    enum { W = 60, H = 50 };
    memory *in = memory_new(W, H, 3, NTP_U16), *wave_height = memory_new(W, H, 1, NTP_U16);
    memory *bytes = memory_new(W, H, 3, NTP_U8), *made = memory_new(W, H, 3, NTP_U8);
    static report found;
    static uint8_t map[W * H * 3], lit[W * H * 3];
    settings s, question;
    wave(wave_height, in, NTP_KERNEL_BAKED);
    for (int i = 0; i < W * H * 3; i++)
        bytes->data[i] = (unsigned char) (((uint16_t *) (void *) in->data)[i] >> 8);
    for (int i = 0; i < W * H; i += 7) /* blue that red and green do not agree with */
        bytes->data[3 * i + 2] = (unsigned char) (bytes->data[3 * i + 2] - 40);
    for (int how = 0; how < 3; how++) {
        settings_reset(&procedures[PROCEDURE_CLEAN], &s);
        s.value[FC_METHOD] = how;
        assert(repair_finds_out(&s, &question));
        assert(report_run(&found, &question, &bytes->raster, NULL, NULL) == JOB_DONE);
        assert(found.judged && found.encoding == NTP_STANDARD);
        const repair_job job = repair_job_from(&s, &found);
        assert(how > 1 || job.how.method == (ntp_method) how);
        assert(repair_job_run(&job, &bytes->raster, NULL, &made->raster, NULL, NULL, NULL) ==
               JOB_DONE);
        const preview p = { .procedure = &procedures[PROCEDURE_CLEAN],
                            .settings = &s,
                            .layer = &bytes->raster,
                            .found = &found,
                            .width = W,
                            .height = H,
                            .step = 1 };
        assert(preview_render(&p, map, lit) == JOB_DONE);
        assert(memcmp(map, made->data, sizeof map) == 0);
    }
    memory_free(in);
    memory_free(wave_height);
    memory_free(bytes);
    memory_free(made);
}

static void test_report(void)
{
    enum { W = 256, H = 200 };
    memory *in = memory_new(W, H, 1, NTP_U16), *normals = memory_new(W, H, 3, NTP_U8);
    static report r;
    settings s, check = { { 0 } };
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 20;
    s.value[FN_TO_Y] = NTP_Y_DOWN;
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        ((uint16_t *) (void *) in->data)[i] =
            (uint16_t) (32767 + 15000 * sin(x * 0.31) * cos(y * 0.23) +
                        9000 * sin(0.11 * x + 0.17 * y));
    }
    const normals_job job = normals_job_from(&s);
    assert(normals_job_run(&job, &in->raster, NULL, NULL, &normals->raster, NULL, NULL) ==
           JOB_DONE);
    assert(report_run(&r, &check, &normals->raster, NULL, NULL) == JOB_DONE);
    assert(r.judged && r.right && r.failing == 0 && r.inexact == 0 &&
           r.type.type == NTP_CLASS_STANDARD);
    assert(r.green.decided && r.green.y == NTP_Y_DOWN);
    for (int i = 0; i < 100; i++)
        normals->data[3 * (i * 7) + 2] = 140;
    assert(report_run(&r, &check, &normals->raster, NULL, NULL) == JOB_DONE);
    assert(!r.right && r.failing == 100);
    assert(report_run(&r, &check, &in->raster, NULL, NULL) == JOB_DONE);
    assert(!r.judged && r.type.type == NTP_CLASS_HEIGHT);
    memory_free(in);
    memory_free(normals);
}

static bool same_settings(const settings *a, const settings *b)
{
    for (int i = 0; i < MAX_FIELDS; i++) {
        if (a->value[i] != b->value[i])
            return false;
    }
    return true;
}

static void test_settings(void)
{
    const procedure *p = procedure_find("plug-in-ntp-normals-from-height");
    char text[2000];
    settings s, back;
    assert(p == &procedures[PROCEDURE_NORMALS] && procedure_find("plug-in-ntp") == NULL);
    settings_reset(p, &s);
    s.value[FN_SCALE] = 0.1 + 0.2;
    s.value[FN_KERNEL] = NTP_KERNEL_SCHARR3;
    s.value[FN_INVERT] = 1;
    assert(settings_write(p, &s, NULL, 0) == settings_write(p, &s, text, sizeof text));
    settings_reset(p, &back);
    settings_read(p, &back, text);
    assert(same_settings(&s, &back));
    settings_read(p, &back, "scale = 12,5\nkernel = none\nfoo = 1\ninvert = 7\nmin-z=0.5");
    assert(back.value[FN_MIN_Z] == 0.5);
    back.value[FN_MIN_Z] = 0;
    assert(same_settings(&s, &back));
    s.value[FN_MIN_Z] = 3;
    assert(settings_check(p, &s) == &p->fields[FN_MIN_Z] && s.value[FN_MIN_Z] == 1);
    s.value[FN_SCALE] = NAN;
    assert(settings_check(p, &s) == &p->fields[FN_SCALE] && s.value[FN_SCALE] == 10);
}

int main(void)
{
    test_settings();
    test_bands();
    test_flip_and_swap();
    test_alpha_rules();
    test_failures();
    test_classic_filters();
    test_classic_dudv();
    test_classic_bias();
    test_classic_normals();
    test_height();
    test_height_kernels();
    test_preview();
    test_preview_of_cleaning();
    test_report();
    return 0;
}
