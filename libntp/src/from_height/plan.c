/* SPDX-License-Identifier: MIT */
/*
 * plan.c - checks the options of heightfield -> normals and turns them into numbers
 */
#include "from_height/gradient.h"

#include "base/cpu.h"
#include "base/finite.h"

#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------- checks */

static double quotient(double scale, double spacing)
{
    return spacing == 0 ? scale : scale / spacing;
}

static bool options_good(const ntp_normals_options *how)
{
    return how != NULL && ntp__is_finite(how->scale) && how->dx >= 0 && ntp__is_finite(how->dx) &&
           how->dy >= 0 && ntp__is_finite(how->dy) && how->min_z >= 0 && how->min_z <= 1 &&
           (int) how->kernel >= 0 && (int) how->kernel < (int) NTP__KERNELS &&
           (int) how->border_x >= 0 && (int) how->border_x <= NTP_BORDER_REPEAT_SLOPE &&
           (int) how->border_y >= 0 && (int) how->border_y <= NTP_BORDER_REPEAT_SLOPE &&
           (int) how->source >= 0 && (int) how->source <= NTP_HEIGHT_SOURCE_SCREEN &&
           (how->blue == NTP_BLUE_DERIVED || how->blue == NTP_BLUE_NEAREST) &&
           (int) how->alpha >= 0 && (int) how->alpha <= NTP_ALPHA_INVERSE_HEIGHT &&
           ntp__is_finite(quotient(how->scale, how->dx)) &&
           ntp__is_finite(quotient(how->scale, how->dy));
}

ntp_status ntp__gradient_source(ntp__gradient *g, ntp_height_source source)
{
    static const int32_t luma[3][3] = { { 2126, 7152, 722 },
                                        { 3000, 5900, 1100 },
                                        { 2125, 7154, 721 } };
    int32_t channels = g->src->channels;
    int64_t m = g->src->type == NTP_TYPE_F32 ? 1 : ntp__max(g->src->type);
    bool gray = channels <= 2;
    g->source = source;
    g->reads = 1;
    g->read[0] = 0;
    g->weight[0] = 1;
    g->range = m;
    if (source == NTP_HEIGHT_SOURCE_ALPHA) {
        g->read[0] = channels - 1;
        return channels == 2 || channels == 4 ? NTP_OK : NTP_ERR_FORMAT;
    }
    if (source <= NTP_HEIGHT_SOURCE_BLUE) {
        g->read[0] = gray ? 0 : (int32_t) source;
        return NTP_OK;
    }
    if (gray && source != NTP_HEIGHT_SOURCE_SCREEN) {
        g->source = NTP_HEIGHT_SOURCE_RED;
        return NTP_OK;
    }
    g->reads = 3;
    for (int32_t k = 0; k < 3; k++) {
        bool weighted = source >= NTP_HEIGHT_SOURCE_LUMA && source <= NTP_HEIGHT_SOURCE_LUMA_EBERLY;
        g->read[k] = gray ? 0 : k;
        g->weight[k] = weighted ? luma[source - NTP_HEIGHT_SOURCE_LUMA][k] : 1;
    }
    if (source <= NTP_HEIGHT_SOURCE_LUMA_EBERLY)
        g->range = 10000 * m;
    else if (source == NTP_HEIGHT_SOURCE_MEAN)
        g->range = 3 * m;
    else if (source == NTP_HEIGHT_SOURCE_SCREEN)
        g->range = m * m * m;
    return NTP_OK;
}

static void set_borders(ntp__gradient *g, const ntp_normals_options *how)
{
    int32_t width = g->src->width, height = g->src->height;
    g->border_x = ntp__border_beyond(how->border_x);
    g->border_y = ntp__border_beyond(how->border_y);
    g->right_x = ntp__stencil_span(g->kernel, true, how->border_x, width);
    g->right_y = ntp__stencil_span(g->kernel, false, how->border_y, height);
    g->down_x = ntp__stencil_span(g->kernel, false, how->border_x, width);
    g->down_y = ntp__stencil_span(g->kernel, true, how->border_y, height);
}

ntp_status ntp__gradient_plan(ntp__gradient *g, const ntp_image *dst, const ntp_const_image *src,
                              const ntp_normals_options *how)
{
    if (dst == NULL || src == NULL || !options_good(how))
        return NTP_ERR_ARGUMENT;
    ntp_const_image view = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(&view));
    NTP__TRY(ntp__check_view(src));
    if (src->encoding != NTP_ENCODING_HEIGHT)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&view, src))
        return NTP_ERR_SHAPE;
    if (dst->data == src->data)
        return NTP_ERR_OVERLAP;
    memset(g, 0, sizeof *g);
    g->src = src;
    g->dst = dst;
    g->kernel = &ntp__kernel_table[how->kernel];
    NTP__TRY(ntp__gradient_source(g, how->source));
    set_borders(g, how);
    g->invert = how->invert != 0;
    /* n.x falls with the slope to the right; n.y, up, grows with the slope down. */
    double sx = quotient(how->scale, how->dx), sy = quotient(how->scale, how->dy);
    sx = g->invert ? sx : -sx;
    sy = g->invert != (dst->y == NTP_Y_DOWN) ? -sy : sy;
    double norm = (double) (g->kernel->denominator * g->range);
    g->x = ntp__scaled_from(sx);
    g->y = ntp__scaled_from(sy);
    g->cx = sx / norm;
    g->cy = sy / norm;
    g->min_z = how->min_z;
    g->min_z_exact = ntp__scaled_from(how->min_z);
    g->shortened = sqrt((1 - how->min_z) * (1 + how->min_z));
    g->m = dst->type == NTP_TYPE_F32 ? 0 : ntp__max(dst->type);
    g->derived = how->blue == NTP_BLUE_DERIVED;
    g->alpha = how->alpha;
    if (g->m > 0)
        g->min_z_level =
            ntp__gradient_z_level(how->min_z, g->m, dst->encoding == NTP_ENCODING_ZZERO);
    g->loops = ntp__gradient_kernels_for(NTP__CPU_ALL);
    return NTP_OK;
}

int32_t ntp_normals_reach(const ntp_normals_options *how)
{
    if (!options_good(how))
        return -1;
    int32_t radius = ntp__kernel_table[how->kernel].radius;
    return how->border_y == NTP_BORDER_REPEAT_SLOPE ? 2 * radius : radius;
}

const char *ntp_kernel_name(ntp_kernel kernel)
{
    if (kernel == NTP_KERNEL_BAKED)
        return "baked";
    return (int) kernel >= 0 && (int) kernel < (int) NTP__KERNELS ? ntp__kernel_table[kernel].name
                                                                  : "unknown";
}

const char *ntp_border_name(ntp_border border)
{
    static const char *const names[] = { "wrap", "clamp", "mirror", "extrapolate", "repeat-slope" };
    return (int) border >= 0 && (int) border <= NTP_BORDER_REPEAT_SLOPE ? names[border] : "unknown";
}

extern const ntp__gradient_kernels ntp__gradient_kernels_base, ntp__gradient_kernels_avx2;

const ntp__gradient_kernels *ntp__gradient_kernels_for(int mask)
{
    return NTP__CPU_PICK(mask, ntp__gradient_kernels_base, ntp__gradient_kernels_avx2);
}

extern ntp__dither_waves_fn ntp__dither_avx512;
extern ntp__encode_packed_fn ntp__encode_avx512;
extern ntp__encode_vectors_fn ntp__vectors_avx512;

ntp__dither_waves_fn *ntp__dither_waves(int mask)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(mask))
        return ntp__dither_avx512;
#endif
    (void) mask;
    return NULL;
}

ntp__encode_packed_fn *ntp__encode_rows_for(int mask)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(mask))
        return ntp__encode_avx512;
#endif
    (void) mask;
    return NULL;
}

ntp__encode_vectors_fn *ntp__encode_vectors_for(int mask)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(mask))
        return ntp__vectors_avx512;
#endif
    return ntp__gradient_kernels_for(mask)->encode_vectors;
}
