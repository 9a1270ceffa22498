/* SPDX-License-Identifier: MIT */
/*
 * test_plugin.c - jobs of the plug-in on rasters in memory, against libntp on the whole; settings
 */
#undef NDEBUG
#include "../../gimp-plugin/presets.h"
#include "normals.h"
#include "rasters.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------- heights to normals */

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
        if (job.how.source == NTP_HEIGHT_SOURCE_ALPHA && channels % 2 == 1) {
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

/* Heights blurred by libntp on the whole: the octaves 0.5, 0, 1.5, 0, -0.75 of a blur by 1.5. */
static void blur_whole(memory *out, const memory *in, const normals_job *job)
{
    static const double SIGMA2[] = { 2.25, 6.25, 66.25 }, WEIGHT[] = { 0.5, 1.5, -0.75 };
    const ntp_image dst = raster_view(&out->raster, out->data, out->raster.height);
    const ntp_image src = raster_view(&in->raster, in->data, in->raster.height);
    const ntp_const_image seen = ntp_image_as_const(&src);
    for (int i = 0; i < 3; i++) {
        const ntp_blur_options how = { .sigma = sqrt(SIGMA2[i]),
                                       .weight = WEIGHT[i],
                                       .add = i > 0,
                                       .border_x = job->how.border_x,
                                       .border_y = job->how.border_y,
                                       .source = job->how.source };
        const size_t size = ntp_height_blur_scratch_size(&how, src.width);
        void *scratch = malloc(size);
        assert(scratch != NULL);
        assert(ntp_height_blur(&dst, &seen, &how, scratch, size) == NTP_OK);
        free(scratch);
    }
}

/* Also of a part, and with the error of dithering from the first row on. */
static void test_forms_and_dither(void)
{
    static const int32_t SIZES[][2] = { { 1, 1 }, { 17, 131 }, { 9, 300 } };
    const procedure *p = &procedures[PROCEDURE_NORMALS];
    for (int n = 0; n < 60; n++) {
        const int32_t *size = SIZES[n % 3];
        const ntp_type type = n % 2 == 0 ? NTP_TYPE_U8 : NTP_TYPE_U16;
        const bool forms = n % 4 < 2, dithers = n % 5 < 3;
        memory *in = memory_new(size[0], size[1], 3, type);
        memory *made = memory_new(size[0], size[1], 3, type);
        memory *expected = memory_new(size[0], size[1], 3, type);
        memory *heights = memory_new(size[0], size[1], 1, NTP_TYPE_F32);
        ntp_rect area = { 0, 0, size[0], size[1] };
        settings s;
        fill(in);
        settings_reset(p, &s);
        s.value[FN_SCALE] = 2;
        s.value[FN_STRENGTH] = 0.75;
        s.value[FN_KERNEL] = draw() % 10;
        s.value[FN_BORDER_X] = draw() % 5;
        s.value[FN_BORDER_Y] = draw() % 5;
        s.value[FN_SOURCE] = NTP_HEIGHT_SOURCE_GREEN;
        s.value[FN_CHANNELS] = ORDER_XZY;
        s.value[FN_DITHER] = dithers;
        if (forms) {
            s.value[FN_BLUR] = 1.5;
            s.value[FN_SMALL] = 0.5;
            s.value[FN_MIDDLE] = 2;
            s.value[FN_LARGE] = 1.25;
        }
        const normals_job job = normals_job_from(&s);
        assert(settings_check(p, &s) == NULL && job.how.scale == 1.5);
        ntp_normals_options how = job.how;
        ntp_image src = raster_view(&in->raster, in->data, size[1]);
        ntp_image dst = raster_view(&expected->raster, expected->data, size[1]);
        dst.encoding = NTP_ENCODING_STANDARD;
        if (forms) {
            blur_whole(heights, in, &job);
            src = raster_view(&heights->raster, heights->data, size[1]);
            how.source = NTP_HEIGHT_SOURCE_RED;
        }
        const ntp_const_image seen = ntp_image_as_const(&src);
        if (dithers) {
            const size_t bytes = ntp_normals_dithered_scratch_size(size[0]);
            void *errors = calloc(1, bytes);
            assert(errors != NULL);
            assert(ntp_normals_dithered(&dst, &seen, &how, errors, bytes, NULL, NULL) == NTP_OK);
            free(errors);
        } else {
            assert(ntp_normals_from_height(&dst, &seen, &how, NULL, NULL) == NTP_OK);
        }
        const size_t sample = raster_sample(&made->raster);
        for (unsigned char *at = expected->data; at < expected->data + bytes_of(expected);
             at += 3 * sample) {
            unsigned char kept[2];
            memcpy(kept, at + sample, sample);
            memcpy(at + sample, at + 2 * sample, sample);
            memcpy(at + 2 * sample, kept, sample);
        }
        if (n % 3 > 0) {
            area = (ntp_rect) { 3, 100, 8, 130 };
            memcpy(made->data, expected->data, bytes_of(made));
            for (int32_t y = 100; y < 130; y++)
                memset(made->data + raster_row(&made->raster) * (size_t) y +
                           raster_pixel(&made->raster) * 3,
                       77, raster_pixel(&made->raster) * 5);
        }
        assert(normals_job_run(&job, &in->raster, &in->raster, NULL, &made->raster, &area, NULL) ==
               JOB_DONE);
        assert(memcmp(made->data, expected->data, bytes_of(made)) == 0);
        memory_free(in);
        memory_free(made);
        memory_free(expected);
        memory_free(heights);
    }
}

/* Blue of x and y alone, also of a part, and with red turned around. */
static void test_occlusion(void)
{
    memory *in = memory_new(33, 300, 3, NTP_TYPE_U8), *made = memory_new(33, 300, 3, NTP_TYPE_U8);
    memory *open = memory_new(33, 300, 1, NTP_TYPE_U8);
    const ntp_rect area = { 5, 140, 20, 290 };
    const ntp_occlusion_options how = { .scale = 7, .border_y = NTP_BORDER_CLAMP };
    const size_t size = ntp_occlusion_scratch_size(&how, 33, 300, 1);
    unsigned char *memory_of = malloc(size + 64);
    assert(memory_of != NULL);
    unsigned char *scratch = memory_of + (64 - (uintptr_t) memory_of % 64) % 64;
    fill(in);
    const ntp_image src = raster_view(&in->raster, in->data, 300);
    const ntp_image dst = raster_view(&open->raster, open->data, 300);
    const ntp_const_image seen = ntp_image_as_const(&src);
    assert(ntp_occlusion(&dst, &seen, &how, scratch, size, NULL) == NTP_OK);
    for (int i = 0; i < 2; i++) {
        settings s;
        settings_reset(&procedures[PROCEDURE_NORMALS], &s);
        s.value[FN_SCALE] = 7;
        s.value[FN_BORDER_Y] = NTP_BORDER_EXTRAPOLATE;
        s.value[FN_FLIP_X] = i;
        s.value[FN_PRESET] = PRESET_LABPBR;
        s.value[FN_OCCLUSION] = 1;
        normals_job job = normals_job_from(&s);
        assert(job.occludes);
        job.alpha = ALPHA_KEEP;
        job.how.alpha = NTP_ALPHA_KEEP;
        memset(made->data, 77, bytes_of(made));
        assert(normals_job_run(&job, &in->raster, NULL, NULL, &made->raster, &area, NULL) ==
               JOB_DONE);
        for (int y = 0; y < 300; y++) {
            for (int x = 0; x < 33; x++) {
                const int at = y * 33 + x;
                const bool inside = x >= 5 && x < 20 && y >= 140 && y < 290;
                assert(made->data[3 * at + 2] == (inside ? open->data[at] : 77));
            }
        }
        s.value[FN_PRESET] = PRESET_NONE;
        job = normals_job_from(&s);
        assert(!job.occludes);
    }
    free(memory_of);
    memory_free(in);
    memory_free(made);
    memory_free(open);
}

static void test_dxt5nm_and_presets(void)
{
    memory *in = memory_new(9, 7, 1, NTP_TYPE_U16), *made = memory_new(9, 7, 4, NTP_TYPE_U16);
    memory *plain = memory_new(9, 7, 3, NTP_TYPE_U16);
    const uint16_t *a = (const uint16_t *) (void *) made->data;
    const uint16_t *b = (const uint16_t *) (void *) plain->data;
    settings s;
    fill(in);
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 3;
    s.value[FN_CHANNELS] = ORDER_DXT5NM;
    const normals_job dxt = normals_job_from(&s);
    expect_normals(plain, in, &dxt);
    assert(normals_job_needs_alpha(&dxt, NTP_TYPE_U16));
    assert(normals_job_run(&dxt, &in->raster, NULL, NULL, &made->raster, NULL, NULL) == JOB_DONE);
    for (int i = 0; i < 63; i++, a += 4, b += 3)
        assert(a[0] == 65535 && a[1] == b[1] && a[2] == 0 && a[3] == b[0]);

    s.value[FN_PRESET] = PRESET_LABPBR;
    normals_job job = normals_job_from(&s);
    assert(job.y == NTP_Y_DOWN && job.encoding == NTP_ENCODING_XY && job.alpha == ALPHA_HEIGHT &&
           job.how.alpha == NTP_ALPHA_HEIGHT && job.channels == ORDER_XYZ && job.how.scale == 3);
    s.value[FN_PRESET] = PRESET_UNITY;
    job = normals_job_from(&s);
    assert(job.y == NTP_Y_UP && job.encoding == NTP_ENCODING_STANDARD && job.alpha == ALPHA_KEEP);
    s.value[FN_PRESET] = PRESET_GIMP;
    job = normals_job_from(&s);
    assert(job.luminance && job.how.blue == NTP_BLUE_NEAREST && job.how.scale == 3 &&
           job.how.border_x == NTP_BORDER_CLAMP);
    s.value[FN_PRESET] = PRESET_GIMP_NORMALMAP;
    s.value[FN_KERNEL] = NTP_KERNEL_SOBEL3;
    job = normals_job_from(&s);
    assert(!job.luminance && job.how.scale == 24 && job.y == NTP_Y_DOWN &&
           job.how.source == NTP_HEIGHT_SOURCE_LUMA_GIMP);
    s.value[FN_SCALE] = 0;
    job = normals_job_from(&s);
    assert(job.measures && job.how.scale == 1);
    assert(preset_decides(PRESET_UNREAL, "to-y") && !preset_decides(PRESET_UNREAL, "kernel") &&
           !preset_decides(PRESET_NONE, "to-y") && preset_decides(PRESET_LABPBR, "alpha"));
    memory_free(in);
    memory_free(made);
    memory_free(plain);
}

static void test_flip_and_swap(void)
{
    memory *in = memory_new(9, 7, 1, NTP_TYPE_U8), *made = memory_new(9, 7, 3, NTP_TYPE_U8);
    memory *plain = memory_new(9, 7, 3, NTP_TYPE_U8);
    settings s;
    fill(in);
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 3;
    /* heights of a picture mirrored left to right have the opposite slope to the right */
    memory *mirrored = memory_new(9, 7, 1, NTP_TYPE_U8);
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

/* A scale of 0 is that of the whole layer, also where only a part is made; the old procedure's is 0. */
static void test_scale_of_the_layer(void)
{
    static const int32_t HEIGHTS[] = { 90, 260 };
    for (int i = 0; i < 16; i++) {
        const int32_t width = 40, height = HEIGHTS[i % 2];
        memory *in = memory_new(width, height, 1, NTP_TYPE_U16);
        memory *made = memory_new(width, height, 3, NTP_TYPE_U16);
        memory *expected = memory_new(width, height, 3, NTP_TYPE_U16);
        settings s;
        fill(in);
        settings_reset(&procedures[PROCEDURE_NORMALS], &s);
        s.value[FN_KERNEL] = i % 3 == 0 ? NTP_KERNEL_GIMP9 : NTP_KERNEL_CENTRAL;
        s.value[FN_BORDER_Y] = i / 2 % 5;
        s.value[FN_FLIP_X] = i % 2;
        assert(s.value[FN_SCALE] == 0);
        normals_job job = normals_job_from(&s), told = job;
        const ntp_image view = raster_view(&in->raster, in->data, height);
        const ntp_const_image whole = ntp_image_as_const(&view);
        ntp_relief relief = { { 0 } };
        for (int32_t y = 0; y < height; y++) {
            int32_t first = 0;
            const int32_t step = ntp_relief_row(width, height, y, &first);
            assert(step == 1 && ntp_relief_add(&relief, &whole, &job.how, first, y, 1) == NTP_OK);
        }
        told.measures = false;
        told.how.scale *= ntp_relief_scale(&relief);
        assert((told.how.scale < 0) == (i % 2 == 1));
        expect_normals(expected, in, &told);
        assert(normals_job_run(&job, &in->raster, NULL, NULL, &made->raster, NULL, NULL) ==
               JOB_DONE);
        assert(memcmp(made->data, expected->data, bytes_of(made)) == 0);
        memory_free(in);
        memory_free(made);
        memory_free(expected);
    }
}

static void test_alpha_rules(void)
{
    static const int EXPECTED[] = { 40, 255, 0, 215, 200, 55, 90 }; /* in the order of alphas */
    for (int rule = ALPHA_KEEP; rule <= ALPHA_LAYER; rule++) {
        memory *in = memory_new(5, 4, 2, NTP_TYPE_U8), *made = memory_new(5, 4, 4, NTP_TYPE_U8);
        memory *mask = memory_new(2, 2, 1, NTP_TYPE_U16);
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
    memory *in = memory_new(8, 600, 1, NTP_TYPE_U8), *made = memory_new(8, 600, 3, NTP_TYPE_U8);
    memory *small = memory_new(8, 599, 1, NTP_TYPE_U8);
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

/* ----------------------------------------------------------------------------- settings */

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
    assert(settings_check(p, &s) == &p->fields[FN_SCALE] && s.value[FN_SCALE] == 0);
}

int main(void)
{
    test_settings();
    test_bands();
    test_forms_and_dither();
    test_occlusion();
    test_dxt5nm_and_presets();
    test_flip_and_swap();
    test_scale_of_the_layer();
    test_alpha_rules();
    test_failures();
    return 0;
}
