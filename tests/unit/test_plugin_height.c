/* SPDX-License-Identifier: MIT */
/*
 * test_plugin_height.c - heights from normals, in the GIMP plug-in's jobs
 */
#undef NDEBUG
#include "height.h"
#include "normals.h"
#include "rasters.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

static void test_height(void)
{
    enum { W = 40, H = 33 };
    memory *in = memory_new(W, H, 1, NTP_TYPE_U16), *normals = memory_new(W, H, 3, NTP_TYPE_U16);
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
    for (int i = 0; i < W * H; i++) { /* flat is not a gradient but one gray */
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

/* Every kernel can be inverted, tiling and open, by some method. */
static void test_height_kernels(void)
{
    enum { W = 26, H = 21 };
    memory *in = memory_new(W, H, 1, NTP_TYPE_U16), *normals = memory_new(W, H, 3, NTP_TYPE_U16);
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

int main(void)
{
    test_height();
    test_height_kernels();
    return 0;
}
