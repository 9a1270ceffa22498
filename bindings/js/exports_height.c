// SPDX-License-Identifier: MIT
/*
 * exports_height.c - what the WebAssembly module exports of heights: to normals, and back
 *
 * exports.c says how arguments and results are passed.
 */
#include "exports.h"

/* ------------------------------------------------------------------ normals of heights */

/* What the heights of a texture are made into normals with. */
typedef struct normals_how {
    double scale, dx, dy, min_z;
    int32_t kernel, border_x, border_y, source, blue, alpha, invert;
} normals_how;

static ntp_normals_options normals_options_of(const normals_how *how)
{
    return (ntp_normals_options) { .scale = how->scale,
                                   .dx = how->dx,
                                   .dy = how->dy,
                                   .min_z = how->min_z,
                                   .kernel = (ntp_kernel) how->kernel,
                                   .border_x = (ntp_border) how->border_x,
                                   .border_y = (ntp_border) how->border_y,
                                   .source = (ntp_height_source) how->source,
                                   .blue = (ntp_blue) how->blue,
                                   .alpha = (ntp_alpha) how->alpha,
                                   .invert = how->invert };
}

/* counts: not finite, exact. */
EXPORT(normalsFromHeight)
ntp_status ntp_js_normals_from_height(double *counts, const picture *to, const picture *p,
                                      const normals_how *how, int32_t dither)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const ntp_normals_options options = normals_options_of(how);
    ntp_normals_counts done = { 0 };
    ntp_status status;

    if (dither) {
        const size_t size = ntp_normals_dithered_scratch_size(p->width);
        void *scratch = ntp_js_allocate(size);

        status = ntp_normals_dithered(&dst, &src, &options, scratch, size, &done, NULL);
        free(scratch);
    } else {
        status = ntp_normals_from_height(&dst, &src, &options, &done, NULL);
    }
    counts[0] = (double) done.not_finite;
    counts[1] = (double) done.exact;
    return status;
}

/* *scale: the scale that shows the relief; 0: all is flat. */
EXPORT(reliefScale)
ntp_status ntp_js_relief_scale(double *scale, const picture *p, const normals_how *how)
{
    const ntp_const_image src = const_view_of(p);
    const ntp_normals_options options = normals_options_of(how);
    ntp_relief *relief = ntp_js_allocate(sizeof *relief);
    ntp_status status = relief == NULL ? NTP_ERR_SCRATCH : NTP_OK;

    for (int32_t y = 0; status == NTP_OK && y < src.height; y++) {
        int32_t first = 0;
        const int32_t step = ntp_relief_row(src.width, src.height, y, &first);

        if (step > 0)
            status = ntp_relief_add(relief, &src, &options, first, y, step);
    }
    if (status == NTP_OK)
        *scale = ntp_relief_scale(relief);
    free(relief);
    return status;
}

/* ------------------------------------------------------------------ heights of normals */

/* AUTO in kernel, border_x and border_y: as the texels tell. */
typedef struct heights_how {
    double dx, dy;
    int32_t method, kernel, border_x, border_y, decode, z, refine, detrend;
    uint32_t touch_unused;
} heights_how;

static ntp_status find_borders(ntp_height_options *options, const ntp_const_image *src)
{
    const int32_t open[2] = { options->border_x == (ntp_border) AUTO,
                              options->border_y == (ntp_border) AUTO };
    const ntp_height_method method = options->method;
    ntp_border_fit fit[2] = { { 0 }, { 0 } };
    ntp_seam seams[2] = { { 0 }, { 0 } };

    if (open[0])
        options->border_x = NTP_BORDER_WRAP;
    if (open[1])
        options->border_y = NTP_BORDER_WRAP;
    if ((!open[0] && !open[1]) || method == NTP_HEIGHT_FRANKOT_CHELLAPPA)
        return NTP_OK;
    if (method != NTP_HEIGHT_POISSON_DCT)
        ntp_find_seams(&seams[0], &seams[1], src, options->touch_unused);

    const int32_t wraps[2] = { seams[0].wraps, seams[1].wraps };
    const size_t size = ntp_find_borders_scratch_size(options, src->width, src->height, 1);
    void *scratch = ntp_js_allocate(size);
    const ntp_status status =
        scratch == NULL ? NTP_ERR_SCRATCH
                        : ntp_find_borders(fit, src, options, open, wraps, scratch, size, NULL);

    free(scratch);
    for (int i = 0; i < 2; i++) {
        const int never = method == NTP_HEIGHT_POISSON_DCT && fit[i].border == NTP_BORDER_WRAP;
        ntp_border *border = i == 0 ? &options->border_x : &options->border_y;

        if (open[i])
            *border = never ? ntp_free_border(options->kernel) : fit[i].border;
    }
    /* A kernel that no border solves is for the solution itself to refuse. */
    return status == NTP_ERR_FORMAT ? NTP_OK : status;
}

/* facts: least and greatest height, method, kernel, both borders, decode, z, residual in levels,
 * rounds, texels that differ after them. */
EXPORT(heightFromNormals)
ntp_status ntp_js_height_from_normals(double *facts, float *heights, const picture *p,
                                      const heights_how *how)
{
    const ntp_image dst = ntp_image_packed(heights, p->width, p->height, 1, NTP_TYPE_F32);
    const ntp_const_image src = const_view_of(p);
    ntp_height_options options = { .method = (ntp_height_method) how->method,
                                   .kernel = (ntp_kernel) how->kernel,
                                   .border_x = (ntp_border) how->border_x,
                                   .border_y = (ntp_border) how->border_y,
                                   .decode = (ntp_decode) how->decode,
                                   .z = (ntp_z) how->z,
                                   .refine = how->refine,
                                   .detrend = how->detrend,
                                   .touch_unused = how->touch_unused,
                                   .residual_scope = NTP_RESIDUAL_ALL,
                                   .dx = how->dx,
                                   .dy = how->dy };
    ntp_height_result result = { 0 };
    ntp_kernel_fit fit;
    ntp_status status;

    if (how->kernel == AUTO) {
        status = ntp_find_kernel(&fit, &src, how->touch_unused);
        options.kernel = status == NTP_OK ? fit.kernel : NTP_KERNEL_CENTRAL;
        if (options.method == NTP_HEIGHT_TELESCOPING && options.kernel == NTP_KERNEL_BAKED)
            options.kernel = NTP_KERNEL_CENTRAL;
    }
    status = find_borders(&options, &src);
    if (status == NTP_OK) {
        const size_t size = ntp_height_scratch_size(&options, p->width, p->height, 1);
        void *scratch = ntp_js_allocate(size);

        status = scratch == NULL
                     ? NTP_ERR_SCRATCH
                     : ntp_height_from_normals(&dst, &src, &options, scratch, size, NULL, &result);
        free(scratch);
    }
    *facts++ = result.min;
    *facts++ = result.max;
    *facts++ = (double) result.method;
    *facts++ = (double) options.kernel;
    *facts++ = (double) options.border_x;
    *facts++ = (double) options.border_y;
    *facts++ = (double) result.decode;
    *facts++ = (double) result.z;
    *facts++ = result.residual;
    *facts++ = (double) result.rounds;
    *facts = (double) result.refine_left;
    return status;
}
