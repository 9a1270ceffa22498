/* SPDX-License-Identifier: MIT */
/*
 * test_plugin_classic.c - the arguments of the old plug-in, in the GIMP plug-in's jobs
 */
#undef NDEBUG
#include "classic.h"
#include "rasters.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    memory *in = memory_new(33, 20, 4, NTP_TYPE_U8), *made = memory_new(33, 20, 4, NTP_TYPE_U8);
    for (int i = 0; i < 33 * 20; i++) {
        memset(in->data + 4 * i, 5 * (i % 33), 3);
        in->data[4 * i + 3] = 17;
    }
    for (int filter = 0; filter < 9; filter++) {
        settings s = classic();
        s.value[FO_FILTER] = filter;
        s.value[FO_SCALE] = 10;
        const classic_job job = classic_job_from(&s, 4, NTP_TYPE_U8);
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
    memory *in = memory_new(9, 3, 4, NTP_TYPE_U8), *made = memory_new(9, 3, 4, NTP_TYPE_U8);
    for (int i = 0; i < 27; i++)
        memset(in->data + 4 * i, 20 * (i % 9), 4);
    for (int format = DUDV_8_SIGNED; format <= DUDV_16_UNSIGNED; format++) {
        settings s = classic();
        s.value[FO_DUDV] = format;
        s.value[FO_SCALE] = 0.75 * 255 / 20;
        const classic_job job = classic_job_from(&s, 4, NTP_TYPE_U8);
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
    memory *in = memory_new(40, 8, 3, NTP_TYPE_U8), *made = memory_new(40, 8, 3, NTP_TYPE_U8);
    memory *heights = memory_new(40, 8, 1, NTP_TYPE_U8),
           *expected = memory_new(40, 8, 3, NTP_TYPE_U8);
    for (int i = 0; i < 40 * 8; i++) {
        memset(in->data + 3 * i, i % 40 < 20 ? 100 : 200, 3);
        heights->data[i] = i % 40 < 20 ? 0 : 50;
    }
    settings s = classic();
    s.value[FO_CONVERSION] = 1;
    s.value[FO_SCALE] = 4;
    s.value[FO_WRAP] = 1;
    const classic_job job = classic_job_from(&s, 3, NTP_TYPE_U8);
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
    memory *in = memory_new(64, 70, 4, NTP_TYPE_U8), *once = memory_new(64, 70, 4, NTP_TYPE_U8);
    memory *twice = memory_new(64, 70, 4, NTP_TYPE_U8);
    settings s = classic();
    fill(in);
    s.value[FO_CONVERSION] = 8; /* normalize only: a second time changes nothing */
    classic_job job = classic_job_from(&s, 4, NTP_TYPE_U8);
    assert(job.kind == CLASSIC_REPAIR);
    assert(repair_job_run(&job.repair, &in->raster, NULL, &once->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    assert(repair_job_run(&job.repair, &once->raster, NULL, &twice->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    assert(memcmp(once->data, twice->data, bytes_of(once)) == 0);
    s.value[FO_MIN_Z] = 0.9; /* is honored, to within half a level */
    job = classic_job_from(&s, 4, NTP_TYPE_U8);
    assert(repair_job_run(&job.repair, &in->raster, NULL, &once->raster, NULL, NULL, NULL) ==
           JOB_DONE);
    for (size_t i = 0; i < 64 * 70; i++)
        assert(once->data[4 * i + 2] >= 242 && once->data[4 * i + 3] == in->data[4 * i + 3]);
    s = classic();
    s.value[FO_CONVERSION] = 9; /* z = sqrt(1 - x^2 - y^2), with a plus it would be 1.02 */
    job = classic_job_from(&s, 4, NTP_TYPE_U8);
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

int main(void)
{
    test_classic_filters();
    test_classic_dudv();
    test_classic_bias();
    test_classic_normals();
    return 0;
}
