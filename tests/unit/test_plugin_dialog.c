/* SPDX-License-Identifier: MIT */
/*
 * test_plugin_dialog.c - what a dialog shows: previews, the report, and remedies
 */
#undef NDEBUG
#include "normals.h"
#include "preview.h"
#include "rasters.h"
#include "remedy.h"
#include "repair.h"
#include "report.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------- preview and report */

/* The mean slope of the texels under a pixel, as a level. */
static double mean_slope(const unsigned char *whole, int width, double x, double y, double step,
                         int channel)
{
    const int n = (int) ceil(step);
    double sum = 0;
    for (int k = 0; k < n * n; k++) {
        const int right = k % n, down = k / n;
        const int tx = (int) (x + (right + 0.5) / n * step),
                  ty = (int) (y + (down + 0.5) / n * step);
        const unsigned char *t = whole + (ty * width + tx) * 3;
        sum += (2.0 * t[channel] - 255) / (2.0 * t[2] - 255);
    }
    return sum / (n * n);
}

static void test_preview(void)
{
    memory *in = memory_new(300, 200, 1, NTP_TYPE_U8),
           *whole = memory_new(300, 200, 3, NTP_TYPE_U8);
    settings s;
    fill(in);
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    normals_job job = normals_job_from(&s);
    preview_scale found = { 0 };
    assert(normals_job_find_scale(&job, &in->raster) == JOB_DONE);
    expect_normals(whole, in, &job);
    static const double STEPS[] = { 3.7, 1, 0.25 };
    for (int k = 0; k < 6; k++) {
        static uint8_t map[50 * 40 * 3], lit[50 * 40 * 3], before[50 * 40 * 3];
        const double step = STEPS[k % 3];
        const preview p = { .procedure = &procedures[PROCEDURE_NORMALS],
                            .settings = &s,
                            .layer = &in->raster,
                            .width = 50,
                            .height = 40,
                            .x = 20.3,
                            .y = 11.8,
                            .step = step,
                            .most = k < 3,
                            .scale = &found };
        assert(preview_render(&p, map, lit, before) == JOB_DONE && found.value == job.how.scale);
        for (int i = 0; i < 50 * 40; i++) {
            const int right = i % 50, down = i / 50;
            const double x = 20.3 + right * step, y = 11.8 + down * step;
            const int at = (int) (y + step / 2) * 300 + (int) (x + step / 2);
            const uint8_t *shown = map + 3 * i;
            if (step <= 1 || k < 3) { /* the texel in the middle */
                assert(memcmp(shown, whole->data + at * 3, 3) == 0);
                assert(before[3 * i] == in->data[at] && before[3 * i + 2] == in->data[at]);
                continue;
            }
            const double p0 = mean_slope(whole->data, 300, x, y, step, 0);
            const double q0 = mean_slope(whole->data, 300, x, y, step, 1);
            const double length = sqrt(p0 * p0 + q0 * q0 + 1);
            assert(fabs((p0 / length + 1) * 127.5 - shown[0]) < 0.51);
            assert(fabs((q0 / length + 1) * 127.5 - shown[1]) < 0.51);
            assert(fabs((1 / length + 1) * 127.5 - shown[2]) < 0.51);
        }
    }
    memory_free(in);
    memory_free(whole);
}

/* The heights in a preview have no pattern of single pixels, at any zoom. */
static void test_preview_of_heights(void)
{
    enum { W = 230, H = 150 };
    memory *height = memory_new(W, H, 1, NTP_TYPE_U16), *in = memory_new(W, H, 3, NTP_TYPE_U16);
    static const double STEPS[] = { 2.3, 1, 0.5 };
    static uint8_t map[100 * 60 * 3], lit[100 * 60 * 3];
    settings s;
    wave(height, in, NTP_KERNEL_CENTRAL);
    settings_reset(&procedures[PROCEDURE_HEIGHT], &s);
    for (int k = 0; k < 3; k++) {
        const preview p = { .procedure = &procedures[PROCEDURE_HEIGHT],
                            .settings = &s,
                            .layer = &in->raster,
                            .width = 100,
                            .height = 60,
                            .end = k == 2 ? 60 : 0, /* all rows, as the widget says it */
                            .step = STEPS[k] };
        assert(preview_render(&p, map, lit, NULL) == JOB_DONE);
        double dots = 0, range = 0;
        for (int j = 1; j < 59; j++) {
            for (int i = 1; i < 99; i++) {
                const uint8_t *h = map + 3 * (j * 100 + i);
                const double bend = 2.0 * h[0] - h[3] - h[-3];
                dots += STEPS[k] < 1 ? 0 : (i % 2 ? bend : -bend) * (j % 2 ? 1 : -1);
                range = fmax(range, fabs(h[0] - (double) map[0]));
            }
        }
        assert(range > 20 && fabs(dots) / (58 * 98) < 0.3);
    }
    memory_free(height);
    memory_free(in);
}

/* The preview of cleaning is what cleaning writes, by the method that the report found. */
static void test_preview_of_cleaning(void)
{
    enum { W = 60, H = 50 };
    memory *in = memory_new(W, H, 3, NTP_TYPE_U16),
           *wave_height = memory_new(W, H, 1, NTP_TYPE_U16);
    memory *bytes = memory_new(W, H, 3, NTP_TYPE_U8), *made = memory_new(W, H, 3, NTP_TYPE_U8);
    static report found;
    static uint8_t map[W * H * 3], lit[W * H * 3];
    settings s, question;
    wave(wave_height, in, NTP_KERNEL_BAKED);
    for (int i = 0; i < W * H * 3; i++)
        bytes->data[i] = (unsigned char) (((uint16_t *) (void *) in->data)[i] >> 8);
    for (int i = 0; i < W * H; i += 7) /* a blue that does not match red and green */
        bytes->data[3 * i + 2] = (unsigned char) (bytes->data[3 * i + 2] - 40);
    for (int how = 0; how < 3; how++) {
        settings_reset(&procedures[PROCEDURE_CLEAN], &s);
        s.value[FC_METHOD] = how;
        assert(repair_finds_out(&s, &question));
        assert(report_run(&found, &question, &bytes->raster, NULL, NULL) == JOB_DONE);
        assert(found.judged && found.encoding == NTP_ENCODING_STANDARD);
        const repair_job job = repair_job_from(&s, &found);
        assert(how > 1 || job.how.method == (ntp_clean_method) how);
        assert(repair_job_run(&job, &bytes->raster, NULL, &made->raster, NULL, NULL, NULL) ==
               JOB_DONE);
        const preview p = { .procedure = &procedures[PROCEDURE_CLEAN],
                            .settings = &s,
                            .layer = &bytes->raster,
                            .found = &found,
                            .width = W,
                            .height = H,
                            .step = 1 };
        assert(preview_render(&p, map, lit, NULL) == JOB_DONE);
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
    memory *in = memory_new(W, H, 1, NTP_TYPE_U16), *normals = memory_new(W, H, 3, NTP_TYPE_U8);
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

/* Padding of one color that no normal has counts as little as black does (NT044). */
static void test_padding(void)
{
    enum { W = 64, H = 64 };
    memory *in = memory_new(W, H, 3, NTP_TYPE_U8);
    static report r;
    const settings question = { { 0 } };
    for (int i = 0; i < W * H; i++) {
        const int slope = 4 * (i % 7);
        in->data[3 * i] = (unsigned char) (128 + slope);
        in->data[3 * i + 1] = 128;
        in->data[3 * i + 2] =
            (unsigned char) (127.5 + 127.5 * sqrt(1 - pow((2 * (128 + slope) - 255) / 255.0, 2)) +
                             0.5);
    }
    for (int i = 0; i < 4 * W; i++)
        memcpy(in->data + 3 * i, "\0\377\0", 3);
    assert(report_run(&r, &question, &in->raster, NULL, NULL) == JOB_DONE);
    assert(r.judged && r.stats.padding == 4 * W && r.used == (H - 4) * W && r.failing == 0);
    assert(r.right && r.errors == 0 && strstr(r.text, "NT044") != NULL);
    in->data[3 * 40 * W + 2] = 140; /* and a fault counts */
    assert(report_run(&r, &question, &in->raster, NULL, NULL) == JOB_DONE);
    assert(!r.right && r.failing == 1);
    memory_free(in);
}

/* Normals of waves with two colors of unused texels. */
static void fill_waves(memory *in)
{
    const int32_t w = in->raster.width, h = in->raster.height;
    memory *heights = memory_new(w, h, 1, NTP_TYPE_U16);
    settings s;
    settings_reset(&procedures[PROCEDURE_NORMALS], &s);
    s.value[FN_SCALE] = 20;
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        ((uint16_t *) (void *) heights->data)[i] =
            (uint16_t) (32767 + 15000 * sin(x * 0.31) * cos(y * 0.23) +
                        9000 * sin(0.11 * x + 0.17 * y));
    }
    const normals_job job = normals_job_from(&s);
    assert(normals_job_run(&job, &heights->raster, NULL, NULL, &in->raster, NULL, NULL) ==
           JOB_DONE);
    memset(in->data, 0, 3 * (size_t) w);
    memory_free(heights);
}

static void run_remedy(remedy which, const findings *f, memory *in, memory *made)
{
    undo_kind accident = UNDO_NOTHING;
    undone right;
    assert(remedy_applies(which, f));
    const repair_job job = remedy_job(which, f, &accident);
    undone_open(&right, &in->raster, accident);
    assert(repair_job_run(&job, &right.raster, NULL, &made->raster, NULL, NULL, NULL) == JOB_DONE);
}

/* Each remedy is what libntp makes of the whole, and leaves unused texels as they are. */
static void test_remedies(void)
{
    enum { W = 160, H = 140 };
    memory *in = memory_new(W, H, 3, NTP_TYPE_U8), *made = memory_new(W, H, 3, NTP_TYPE_U8);
    memory *bad = memory_new(W, H, 3, NTP_TYPE_U8);
    static findings f;
    const settings question = { { 0 } };
    fill_waves(in);
    assert(remedy_look(&f, &question, &in->raster, NULL, NULL) == JOB_DONE && !f.undoes);
    assert(f.found.right && remedy_needed(&f) == (remedy) REMEDIES);
    assert(!remedy_applies(REMEDY_UNDO, &f) && !remedy_applies(REMEDY_STANDARD, &f));
    run_remedy(REMEDY_GREEN, &f, in, made);
    for (int i = 0; i < W * H; i++) {
        const int green = in->data[3 * i + 1];
        assert(made->data[3 * i] == in->data[3 * i]);
        assert(made->data[3 * i + 1] == (i < W ? green : 255 - green));
        assert(made->data[3 * i + 2] == in->data[3 * i + 2]);
    }
    for (int i = 0; i < W * H; i++) { /* red and blue exchanged */
        for (int c = 0; c < 3; c++)
            bad->data[3 * i + c] = in->data[3 * i + 2 - c];
    }
    assert(remedy_look(&f, &question, &bad->raster, NULL, NULL) == JOB_DONE && f.undoes);
    assert(f.found.misplaced && remedy_needed(&f) == REMEDY_UNDO);
    assert(!remedy_applies(REMEDY_CLEAN, &f) && !remedy_applies(REMEDY_GREEN, &f));
    run_remedy(REMEDY_UNDO, &f, bad, made);
    assert(memcmp(made->data, in->data, bytes_of(in)) == 0);
    for (int i = W; i < W * H; i++) /* Z-zero */
        bad->data[3 * i + 2] = (unsigned char) (2 * in->data[3 * i + 2] - 255);
    for (int i = W; i < W * H; i++)
        memcpy(bad->data + 3 * i, in->data + 3 * i, 2);
    memset(bad->data, 0, 3 * W);
    assert(remedy_look(&f, &question, &bad->raster, NULL, NULL) == JOB_DONE);
    assert(f.found.encoding == NTP_ENCODING_ZZERO && remedy_applies(REMEDY_STANDARD, &f));
    run_remedy(REMEDY_STANDARD, &f, bad, made);
    for (int i = 0; i < 3 * W * H; i++)
        assert(abs(made->data[i] - in->data[i]) <= (i % 3 == 2));
    memory_free(in);
    memory_free(made);
    memory_free(bad);
}

static void run_backwards(void *user, int32_t count, void (*task)(void *work, int32_t index),
                          void *work)
{
    (void) user;
    for (int32_t i = count - 1; i >= 0; i--)
        task(work, i);
}

/* The parts of a report, in any order, count what the whole picture has. */
static void test_report_in_parts(void)
{
    static const surroundings AROUND = { .parallel = run_backwards, .threads = 4 };
    static report r;
    const settings question = { .value = { [FK_FROM] = 1 } };
    for (int32_t height = 1; height < 300; height += 41) {
        memory *in = memory_new(37, height, 3, NTP_TYPE_U8);
        fill(in);
        ntp_tally *whole = calloc(1, ntp_tally_size());
        ntp_image view = ntp_image_packed(in->data, 37, height, 3, NTP_TYPE_U8);
        const ntp_const_image seen = ntp_image_as_const(&view);
        ntp_stats stats;
        assert(whole != NULL && ntp_tally_add(whole, &seen, 0, NULL) == NTP_OK);
        assert(ntp_tally_summarize(&stats, whole, NTP_ENCODING_STANDARD) == NTP_OK);
        assert(report_run(&r, &question, &in->raster, NULL, &AROUND) == JOB_DONE);
        assert(r.stats.texels == stats.texels && r.stats.z_negative == stats.z_negative);
        assert(r.stats.standard.exact == stats.standard.exact);
        assert(r.stats.standard.neighbor == stats.standard.neighbor);
        assert(r.stats.xy_too_long == stats.xy_too_long && r.stats.unused == stats.unused);
        assert(!(r.stats.angles.mean < stats.angles.mean) &&
               !(r.stats.angles.mean > stats.angles.mean));
        free(whole);
        memory_free(in);
    }
}

int main(void)
{
    test_preview();
    test_preview_of_heights();
    test_preview_of_cleaning();
    test_report();
    test_report_in_parts();
    test_padding();
    test_remedies();
    return 0;
}
