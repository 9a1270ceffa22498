/* SPDX-License-Identifier: MIT */
/* surfaces.c - sums of what makes heights, normals and maps of surfaces, and of other shapes. */
#include "sums.h"

#include <stdlib.h>

/* --------------------------------------------------------------- heights, and normals */

static uint64_t normals_of(uint64_t hash, const ntp_const_image *src,
                           const ntp_normals_options *how, ntp_type type, ntp_encoding encoding)
{
    ntp_image out = picture(NARROW, LOW, 3, type, encoding);
    OK(ntp_normals_from_height(&out, src, how, NULL, NULL));
    hash = hash_image(hash, &out);
    free(out.data);
    return hash;
}

static uint64_t dithered_of(uint64_t hash, const ntp_const_image *src,
                            const ntp_normals_options *how)
{
    const size_t size = ntp_normals_dithered_scratch_size(NARROW);
    ntp_image out = picture(NARROW, LOW, 3, NTP_TYPE_U8, NTP_ENCODING_STANDARD);
    void *scratch = reserve(size);
    OK(ntp_normals_dithered(&out, src, how, scratch, size, NULL, NULL));
    hash = hash_image(hash, &out);
    free(scratch);
    free(out.data);
    return hash;
}

/* Each kernel with another border; the exact sums of steep and of gentle slopes differ. */
uint64_t normals_from_height(ntp_type type)
{
    static const ntp_encoding encodings[] = { NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO };
    ntp_image heights = make_heights(NARROW, LOW, type);
    const ntp_const_image src = ntp_image_as_const(&heights);
    uint64_t hash = seed;
    for (int k = 0; k < NTP_KERNEL_BAKED; k++) {
        const ntp_normals_options how = { .scale = k % 2 ? 33.3 : 0.7,
                                          .kernel = (ntp_kernel) k,
                                          .border_x = (ntp_border) (k % NTP_BORDERS),
                                          .border_y = (ntp_border) ((k + 2) % NTP_BORDERS),
                                          .blue = k % 4 < 2 ? NTP_BLUE_NEAREST : NTP_BLUE_DERIVED };
        hash = normals_of(hash, &src, &how, NTP_TYPE_U8, encodings[k % 2]);
        hash = normals_of(hash, &src, &how, NTP_TYPE_U16, encodings[1 - k % 2]);
        hash = normals_of(hash, &src, &how, NTP_TYPE_F32, NTP_ENCODING_VECTOR);
        hash = dithered_of(hash, &src, &how);
    }
    free(heights.data);
    return hash;
}

uint64_t relief(ntp_type type)
{
    ntp_image heights = make_heights(WIDE, HIGH, type);
    const ntp_const_image src = ntp_image_as_const(&heights);
    ntp_relief counts = { { 0 } };
    ntp_peer peer;
    OK(ntp_normals_like(&peer, "gimp-normalmap:9x9", 3.1));
    for (int y = 0; y < HIGH; y++) {
        int32_t first;
        const int32_t step = ntp_relief_row(WIDE, HIGH, y, &first);
        if (step > 0)
            OK(ntp_relief_add(&counts, &src, &peer.options, first, y, step));
    }
    free(heights.data);
    return hash_double(seed, ntp_relief_scale(&counts));
}

static uint64_t solve(uint64_t hash, const ntp_image *image, const ntp_height_options *how)
{
    const ntp_const_image src = ntp_image_as_const(image);
    const size_t size = ntp_height_scratch_size(how, image->width, image->height, 1);
    ntp_image out = picture(image->width, image->height, 1, NTP_TYPE_F32, NTP_ENCODING_HEIGHT);
    void *scratch = reserve(size);
    ntp_height_result result;
    need(size > 0, "cannot be solved");
    OK(ntp_height_from_normals(&out, &src, how, scratch, size, NULL, &result));
    hash = hash_double(hash_image(hash, &out), result.residual);
    hash = hash_number(hash, (uint64_t) result.iterations + result.refine_left);
    free(scratch);
    free(out.data);
    return hash;
}

static const struct {
    ntp_kernel kernel;
    ntp_border border_x, border_y;
} surfaces[] = { { NTP_KERNEL_FORWARD, NTP_BORDER_CLAMP, NTP_BORDER_WRAP },
                 { NTP_KERNEL_CENTRAL, NTP_BORDER_WRAP, NTP_BORDER_WRAP },
                 { NTP_KERNEL_SOBEL3, NTP_BORDER_WRAP, NTP_BORDER_CLAMP },
                 { NTP_KERNEL_BAKED, NTP_BORDER_CLAMP, NTP_BORDER_CLAMP } };

enum { SURFACES = sizeof surfaces / sizeof *surfaces };

static uint64_t heights_by(ntp_type type, ntp_height_method method, int refine)
{
    const ntp_encoding encoding =
        type == NTP_TYPE_F32 ? NTP_ENCODING_VECTOR : NTP_ENCODING_STANDARD;
    ntp_image image = make_damaged(NARROW, LOW, type, encoding, 3);
    uint64_t hash = seed;
    for (int i = 0; i < SURFACES; i++) {
        const bool sums = i < 2; /* telescoping knows forward and central */
        const ntp_height_options how = { .kernel = surfaces[i].kernel,
                                         .border_x = surfaces[i].border_x,
                                         .border_y =
                                             refine ? surfaces[i].border_x : surfaces[i].border_y,
                                         .method = method,
                                         .refine = refine,
                                         .residual_scope = NTP_RESIDUAL_ALL };
        if (method != NTP_HEIGHT_TELESCOPING || sums)
            hash = solve(hash, &image, &how);
    }
    free(image.data);
    return hash;
}

uint64_t heights_direct(ntp_type type)
{
    return heights_by(type, NTP_HEIGHT_AUTO, 0);
}

uint64_t heights_refined(ntp_type type)
{
    return heights_by(type, NTP_HEIGHT_AUTO, 3);
}

uint64_t heights_weighted(ntp_type type)
{
    return heights_by(type, NTP_HEIGHT_WEIGHTED, 0);
}

uint64_t heights_summed(ntp_type type)
{
    return heights_by(type, NTP_HEIGHT_TELESCOPING, 0);
}

uint64_t depth(ntp_type type)
{
    static const ntp_camera cameras[] = { { 0, 0, 0, 0 }, { 60, 61, 22, 18.5 } };
    ntp_image image = make_damaged(NARROW, LOW, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    const size_t size = ntp_depth_scratch_size(NARROW, LOW);
    uint64_t hash = seed;
    for (int i = 0; i < 2; i++) {
        const ntp_depth_options how = { .camera = cameras[i], .rounds = 4 };
        ntp_image out = picture(NARROW, LOW, 1, NTP_TYPE_F32, NTP_ENCODING_HEIGHT);
        void *scratch = reserve(size);
        OK(ntp_depth_from_normals(&out, NULL, &src, &how, scratch, size, NULL, NULL));
        for (int texel = 0; texel < NARROW * LOW;
             texel++) { /* the bits of a NaN are not promised */
            float *value = (float *) out.data + texel;
            if (*value != *value)
                *value = 0;
        }
        hash = hash_image(hash, &out);
        free(scratch);
        free(out.data);
    }
    free(image.data);
    return hash;
}

/* ------------------------------------------------------------------------ other shapes */

uint64_t resize(ntp_type type)
{
    static const int32_t sizes[][2] = { { 40, 31 }, { 110, 61 } };
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 4);
    const ntp_const_image src = ntp_image_as_const(&image);
    uint64_t hash = seed;
    for (int i = 0; i < 6; i++) {
        const ntp_resize_options how = { .filter = (ntp_filter) (i / 2),
                                         .border_x = (ntp_border) (i / 2),
                                         .border_y = NTP_BORDER_CLAMP };
        const int32_t width = sizes[i % 2][0], height = sizes[i % 2][1];
        ntp_image out = picture(width, height, 4, type, NTP_ENCODING_STANDARD);
        const size_t size = ntp_resize_plan_size(&how, WIDE, HIGH, width, height);
        void *memory = reserve(size);
        ntp_resize_plan *plan;
        OK(ntp_resize_plan_init(&plan, memory, size, &how, WIDE, HIGH, width, height));
        void *scratch = reserve(ntp_resize_scratch_size(plan));
        OK(ntp_resize(&out, &src, plan, scratch, ntp_resize_scratch_size(plan), NULL));
        hash = hash_image(hash, &out);
        free(scratch);
        free(memory);
        free(out.data);
    }
    free(image.data);
    return hash;
}

uint64_t transform(ntp_type type)
{
    ntp_image image = make_damaged(NARROW, LOW, type, NTP_ENCODING_STANDARD, 4);
    const ntp_const_image src = ntp_image_as_const(&image);
    uint64_t hash = seed;
    for (int i = 0; i < 4; i++) {
        const ntp_transform_options how = { .quarter_turns = 2 * (i % 2),
                                            .flip_x = i % 2,
                                            .use_strength = 1,
                                            .strength = 0.3 + i,
                                            .angle = i < 2 ? 0 : 17.5 * i,
                                            .border_x = NTP_BORDER_MIRROR,
                                            .border_y = NTP_BORDER_WRAP };
        ntp_image out = picture(NARROW, LOW, 4, type, NTP_ENCODING_STANDARD);
        OK(ntp_transform(&out, &src, &how, NULL));
        hash = hash_image(hash, &out);
        free(out.data);
    }
    free(image.data);
    return hash;
}

uint64_t blend(ntp_type type)
{
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 4);
    ntp_image detail = make_damaged(WIDE, HIGH, type == NTP_TYPE_U8 ? NTP_TYPE_U16 : NTP_TYPE_U8,
                                    NTP_ENCODING_ZZERO, 3);
    const ntp_const_image src = ntp_image_as_const(&image), over = ntp_image_as_const(&detail);
    uint64_t hash = seed;
    for (int i = 0; i < 4; i++) {
        const ntp_blend_options how = { .mode = (ntp_blend_mode) i,
                                        .use_strength = i % 2,
                                        .strength = 1.75 };
        ntp_image out = picture(WIDE, HIGH, 4, type, NTP_ENCODING_STANDARD);
        OK(ntp_blend(&out, &src, &over, &how, NULL));
        hash = hash_image(hash, &out);
        free(out.data);
    }
    free(detail.data);
    free(image.data);
    return hash;
}

uint64_t curvature(ntp_type type)
{
    ntp_image heights = make_heights(WIDE, HIGH, type);
    const ntp_const_image src = ntp_image_as_const(&heights);
    ntp_image out = picture(WIDE, HIGH, 1, NTP_TYPE_F32, NTP_ENCODING_HEIGHT);
    const ntp_const_image values = ntp_image_as_const(&out);
    uint64_t hash = seed;
    for (int k = NTP_CURVATURE_MEAN; k <= NTP_CURVATURE_CAVITY; k++) {
        const ntp_curvature_options how = { .kind = (ntp_curvature_kind) k, .scale = 20 };
        double range;
        OK(ntp_curvature(&out, &src, &how, NULL));
        OK(ntp_curvature_range(&range, &values));
        hash = hash_double(hash_image(hash, &out), range);
    }
    free(out.data);
    free(heights.data);
    return hash;
}

uint64_t occlusion(ntp_type type)
{
    const ntp_occlusion_options how = { .scale = 20, .border_x = NTP_BORDER_CLAMP };
    const size_t size = ntp_occlusion_scratch_size(&how, NARROW, LOW, 1);
    ntp_image heights = make_heights(NARROW, LOW, type);
    const ntp_const_image src = ntp_image_as_const(&heights);
    ntp_image out = picture(NARROW, LOW, 1, NTP_TYPE_F32, NTP_ENCODING_HEIGHT);
    void *scratch = reserve(size);
    uint64_t hash;
    OK(ntp_occlusion(&out, &src, &how, scratch, size, NULL));
    hash = hash_image(seed, &out);
    free(scratch);
    free(out.data);
    free(heights.data);
    return hash;
}

uint64_t blur(ntp_type type)
{
    const ntp_blur_options how = { .sigma = 3.5, .weight = 0.7, .border_x = NTP_BORDER_MIRROR };
    const size_t size = ntp_height_blur_scratch_size(&how, WIDE);
    ntp_image heights = make_heights(WIDE, HIGH, type);
    const ntp_const_image src = ntp_image_as_const(&heights);
    ntp_image out = picture(WIDE, HIGH, 1, NTP_TYPE_F32, NTP_ENCODING_HEIGHT);
    void *scratch = reserve(size);
    uint64_t hash;
    OK(ntp_height_blur(&out, &src, &how, scratch, size));
    hash = hash_image(seed, &out);
    free(scratch);
    free(out.data);
    free(heights.data);
    return hash;
}

/* The bytes of the blocks, of each quality. */
uint64_t blocks(ntp_type type)
{
    enum { COLUMNS = (NARROW + NTP_BLOCK_SIDE - 1) / NTP_BLOCK_SIDE, TWO = 16 };
    const int rows = (LOW + NTP_BLOCK_SIDE - 1) / NTP_BLOCK_SIDE;
    ntp_image normals = make_damaged(NARROW, LOW, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&normals);
    const size_t size = (size_t) rows * COLUMNS * TWO;
    uint8_t *bytes = reserve(size);
    uint64_t hash = seed;
    for (int quality = NTP_BLOCK_BY_ANGLE; quality <= NTP_BLOCK_QUICK; quality++) {
        const ntp_block_options how = { .quality = (ntp_block_quality) quality };
        OK(ntp_bc5_encode(bytes, (ptrdiff_t) COLUMNS * TWO, &src, &how, NULL));
        for (size_t i = 0; i < size; i++)
            hash = hash_number(hash, bytes[i]);
        OK(ntp_bc4_encode(bytes, (ptrdiff_t) COLUMNS * TWO, &src, &how, NULL));
        for (size_t i = 0; i < size; i++)
            hash = hash_number(hash, bytes[i]);
    }
    free(bytes);
    free(normals.data);
    return hash;
}
