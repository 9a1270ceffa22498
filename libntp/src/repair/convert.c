/* SPDX-License-Identifier: MIT */
/*
 * convert.c - conversion between encodings, depths and Y orientations
 *
 * Samples are converted by value.  A texel that is `exact` gets its blue derived anew from its
 * converted red and green, which keeps clean textures clean.  All that is between biased samples, and
 * what is common of the rest, is in convert_runs.c, many texels at a time, and what makes vectors in to_vectors.c;
 * here are heights, and what is left from vectors, texel by texel.
 */
#include "base/finite.h"
#include "repair/convert.h"
#include "repair/convert_avx2.h"
#include "texel/float_vector.h"

#include <math.h>
#include <string.h>

typedef ntp__conversion job;

/* One texel on its way: its source samples, and the levels of the target. */
typedef struct texel {
    int32_t c[4];     /* source levels */
    const float *raw; /* source samples of a float image, else NULL */
} texel;

/* Channel k by value. */
static int32_t by_value(const job *j, const texel *t, int32_t k)
{
    return t->raw != NULL ? ntp__level_of(t->raw[k], j->md) : ntp__deepen(t->c[k], j->ms, j->md);
}

void ntp__convert_vector(const ntp__conversion *j, const float raw[3], int32_t out[3],
                         ntp_convert_counts *counts)
{
    bool zzero = j->dst->encoding == NTP_ENCODING_ZZERO, negative = raw[2] < 0;
    const float v[3] = { raw[0], j->flip ? -raw[1] : raw[1], raw[2] };
    int32_t z;
    ntp__vector_levels(out, &z, v, j->md);
    if (j->dst->encoding == NTP_ENCODING_XY) {
        out[2] = j->md;
        return;
    }
    counts->z_negative += negative && zzero;
    if (j->how.blue == NTP_BLUE_NEAREST) {
        out[2] = zzero ? z : out[2];
        return;
    }
    counts->pulled += ntp__rest(out[0], out[1], j->md) < 0;
    out[2] = ntp__derive(&out[0], &out[1], j->md, zzero);
    if (negative && !zzero)
        out[2] = j->md - out[2];
}

static void convert_vector(const job *j, const texel *t, int32_t out[4], ntp_convert_counts *counts)
{
    ntp__convert_vector(j, t->raw, out, counts);
    out[3] = j->src->channels == 4 ? ntp__level_of(t->raw[3], j->md) : j->md;
}

#ifdef NTP_HAVE_AVX2
/* Does a texel again whose vector the loop without planes is in doubt about. */
static void encode_exactly(const ntp__conversion *j, const float raw[3], int32_t c[3],
                           ntp_convert_counts *counts)
{
    const double size = fabs((double) raw[0]) + fabs((double) raw[1]) + fabs((double) raw[2]);
    if (size > 0.0 && ntp__is_finite(size)) {
        ntp__convert_vector(j, raw, c, counts);
        return;
    }
    c[0] = c[1] = (j->md + 1) / 2;
    c[2] = j->md;
    counts->not_finite++;
}

/* Texels of 16, from s to d, that the loop leaves. */
void ntp__settle_vectors(const ntp__conversion *j, uint8_t *d, const float *s,
                         const ntp__left *left, ntp_convert_counts *counts)
{
    const bool deep = j->md > 255, zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
    for (int32_t i = 0; (left->doubt | left->overlong) >> i != 0; i++) {
        const bool doubt = left->doubt >> i & 1;
        uint16_t *d16 = (uint16_t *) (void *) d + 3 * i;
        uint8_t *d8 = d + 3 * i;
        int32_t c[3] = { deep ? d16[0] : d8[0], deep ? d16[1] : d8[1] };
        if (doubt) {
            encode_exactly(j, s + 3 * i, c, counts);
        } else if (left->overlong >> i & 1) {
            c[2] = ntp__derive(&c[0], &c[1], j->md, zzero);
            c[2] = !zzero && left->negative >> i & 1 ? j->md - c[2] : c[2];
            counts->pulled++;
        } else {
            continue;
        }
        for (int32_t k = 0; k < 3; k++) {
            if (deep)
                d16[k] = (uint16_t) c[k];
            else
                d8[k] = (uint8_t) c[k];
        }
    }
}

#endif

/* Of vectors. */
static void biased_floats(const job *j, const texel *t, float out[4], ntp_convert_counts *counts)
{
    int32_t level[4];
    convert_vector(j, t, level, counts);
    for (int32_t k = 0; k < 4; k++)
        out[k] = (float) ((double) level[k] / j->md);
}

/* The levels for a texel that is not a vector: flat, or height 0. */
static void flat_levels(const job *j, int32_t out[4])
{
    bool height = j->dst->encoding == NTP_ENCODING_HEIGHT;
    out[0] = out[1] = height ? 0 : (j->md + 1) / 2;
    out[2] = height ? 0 : j->md;
    out[3] = j->md;
}

static void store_floats(const job *j, const texel *t, bool broken, float *d,
                         ntp_convert_counts *counts)
{
    float out[4];
    const bool height = j->dst->encoding == NTP_ENCODING_HEIGHT;
    if (broken) {
        out[0] = out[1] = height ? 0.0f : 0.5f;
        out[2] = height ? 0.0f : 1.0f;
        out[3] = 1.0f;
    } else if (height && t->raw != NULL) {
        memcpy(out, t->raw, (size_t) j->src->channels * sizeof *out);
    } else if (height) {
        for (int32_t k = 0; k < 4; k++)
            out[k] = (float) ((double) t->c[k] / j->ms);
    } else {
        biased_floats(j, t, out, counts);
    }
    memcpy(d, out, (size_t) j->dst->channels * sizeof *d);
}

static void levels_of(const job *j, const texel *t, bool broken, int32_t out[4],
                      ntp_convert_counts *counts)
{
    if (broken)
        flat_levels(j, out);
    else if (j->dst->encoding == NTP_ENCODING_HEIGHT)
        for (int32_t k = 0; k < 4; k++)
            out[k] = k < j->src->channels ? by_value(j, t, k) : j->md;
    else
        convert_vector(j, t, out, counts);
}

void ntp__convert_each(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                       ntp_convert_counts *counts)
{
    ntp__block block;
    const bool floats = j->src->type == NTP_TYPE_F32,
               height = j->src->encoding == NTP_ENCODING_HEIGHT;
    ntp__unpack(&block, j->src, x, y, n);
    const char *s = ntp__at(j->src, x, y);
    char *d = ntp__at_mut(j->dst, x, y);
    for (int32_t i = 0; i < n; i++, s += j->src->pixel_stride, d += j->dst->pixel_stride) {
        float raw[4] = { 0, 0, 1, 1 };
        texel t = { .raw = NULL };
        for (int32_t k = 0; k < 4; k++)
            t.c[k] = block.c[k][i];
        if (height && j->src->channels == 2)
            t.c[1] = t.c[3];
        if (floats) {
            memcpy(raw, s, (size_t) j->src->channels * sizeof *raw);
            t.raw = raw;
        }
        bool broken = block.any_broken && block.broken[i];
        counts->not_finite += broken;
        if (j->dst->type == NTP_TYPE_F32) {
            store_floats(j, &t, broken, (float *) (void *) d, counts);
            continue;
        }
        int32_t out[4];
        levels_of(j, &t, broken, out, counts);
        for (int32_t k = 0; k < j->dst->channels; k++) {
            if (j->dst->type == NTP_TYPE_U8)
                ((uint8_t *) d)[k] = (uint8_t) out[k];
            else
                ((uint16_t *) (void *) d)[k] = (uint16_t) out[k];
        }
    }
}

/* Does each row begin where the one above it ends?  Then some are as good as one. */
static bool is_one_run(const ntp_const_image *v)
{
    return v->ring_rows == 0 && v->row_stride == v->width * v->pixel_stride;
}

ntp_status ntp_convert(const ntp_image *dst, const ntp_const_image *src,
                       const ntp_convert_options *how, ntp_convert_counts *counts,
                       const ntp_rect *area)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_view(src));
    NTP__TRY(ntp__check_view(&target));
    if (!ntp__same_size(&target, src))
        return NTP_ERR_SHAPE;
    if ((src->encoding == NTP_ENCODING_HEIGHT) != (dst->encoding == NTP_ENCODING_HEIGHT) ||
        (src->encoding == NTP_ENCODING_HEIGHT && src->channels != dst->channels))
        return NTP_ERR_FORMAT;
    if (dst->data == src->data && dst->type != src->type)
        return NTP_ERR_OVERLAP;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    job j = { .dst = dst,
              .src = src,
              .ms = ntp__max(src->type),
              .md = ntp__max(dst->type),
              .flip = src->y != dst->y && src->encoding != NTP_ENCODING_HEIGHT,
              .kernels = ntp__kernels(NTP__CPU_ALL) };
    if (how != NULL)
        j.how = *how;
    if ((int) j.how.blue < NTP_BLUE_DERIVED || (int) j.how.blue > NTP_BLUE_NEAREST ||
        j.how.touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    int32_t most = NTP__BLOCK;
    ntp__convert_fn *fast = ntp__fast_conversion(&j, &most);
    ntp__convert_fn *convert = fast != NULL ? fast : ntp__convert_each;
    ntp_convert_counts local = { 0, 0, 0 };
    const int32_t width = rect.x1 - rect.x0;
    const bool joined =
        most == NTP_MAX_SIDE && width == src->width && is_one_run(src) && is_one_run(&target);
    const int32_t rows = joined ? NTP_MAX_SIDE / width : 1;
    for (int32_t y = rect.y0; y < rect.y1; y += rows) {
        const int32_t end = rect.x0 + width * (rect.y1 - y < rows ? rect.y1 - y : rows);
        for (int32_t x = rect.x0; x < end; x += most) {
            int32_t n = end - x < most ? end - x : most;
            convert(&j, x, y, n, &local);
        }
    }
    if (counts != NULL) {
        counts->z_negative += local.z_negative;
        counts->not_finite += local.not_finite;
        counts->pulled += local.pulled;
    }
    return NTP_OK;
}
