/* SPDX-License-Identifier: MIT */
/*
 * convert_runs.c - the common conversions, many texels at a time
 *
 * convert.c says what the bytes are.  Of biased levels, planes are converted with the kernel that
 * derives blues; float vectors go through that for directions.  Biased floats go by their levels.
 */
#include "base/cpu.h"
#include "base/finite.h"
#include "base/inlining.h"
#include "repair/convert.h"
#include "texel/direction.h"
#include "texel/unused.h"

#ifdef NTP_HAVE_AVX2
#  include "repair/convert_avx2.h"
#endif

#include <math.h>
#include <string.h>

/* Blue by value, where source and target store z differently. */
static void blues_by_value(const ntp__conversion *j, int32_t *restrict out,
                           const int32_t *restrict b, int32_t n)
{
    const int32_t ms = j->ms, md = j->md;
    const bool to_zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
    for (int32_t i = 0; to_zzero && i < n; i++)
        out[i] = ntp__deepen(ntp__abs(2 * b[i] - ms), ms, md);
    if (to_zzero)
        return;
    /* From Z-zero; narrowing is floor((b/257 + 256)/2) as one quotient. */
    for (int32_t i = 0; i < n; i++)
        out[i] = ms == md  ? (b[i] + md + 1) / 2
                 : ms < md ? (257 * b[i] + 65536) / 2
                           : (b[i] + 65792) / 514;
}

/* The blue of each texel that is exact, derived anew: want of the source, blue of the target.  Marks
 * those that are too long there, and returns whether there are any.  (-1 is no blue.) */
static int32_t put_exact(const ntp__conversion *j, int32_t *restrict out,
                         const int32_t *restrict in, const int32_t *restrict want,
                         const int32_t *restrict blue, int32_t *restrict pull, int32_t n)
{
    const int32_t ms = j->ms;
    /* z < 0 up to this level, and what the target makes of it: M - b or b */
    const int32_t low = j->src->encoding == NTP_ENCODING_STANDARD ? (ms - 1) / 2 : -1;
    const int32_t mirror = j->dst->encoding == NTP_ENCODING_STANDARD ? -1 : 0;
    const int32_t most = j->md & mirror;
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t up = in[i] <= low ? ms - in[i] : in[i];
        int32_t z = in[i] <= low ? most + (blue[i] ^ mirror) - mirror : blue[i];
        out[i] = want[i] == up ? z : out[i];
        pull[i] = -((want[i] == up) & (blue[i] < 0));
        any |= pull[i];
    }
    return any;
}

/* Pulls the texels that are marked, and derives their blue. */
SELDOM static uint64_t pull_marked(const ntp__conversion *j, ntp__block *out, const ntp__block *in,
                                   const int32_t *pull, int32_t n)
{
    const bool standard = j->src->encoding == NTP_ENCODING_STANDARD;
    uint64_t pulled = 0;
    for (int32_t i = 0; i < n; i++) {
        if (!pull[i])
            continue;
        int32_t b = ntp__derive(&out->c[0][i], &out->c[1][i], j->md,
                                j->dst->encoding == NTP_ENCODING_ZZERO);
        bool negative = standard && ntp__z_negative(in->c[2][i], j->ms);
        if (j->dst->encoding != NTP_ENCODING_XY)
            out->c[2][i] = negative && j->dst->encoding == NTP_ENCODING_STANDARD ? j->md - b : b;
        pulled++;
    }
    return pulled;
}

/* The third sample of the target for used texels.  Marks those that have to be pulled, and returns
 * whether there are any. */
static int32_t convert_blues(const ntp__conversion *j, ntp__block *out, const ntp__block *in,
                             int32_t *pull, int32_t n)
{
    const ntp_encoding from = j->src->encoding, to = j->dst->encoding;
    int32_t want[NTP__BLOCK], blue[NTP__BLOCK], any = 0;
    if (from == to && (j->ms == j->md || (from == NTP_ENCODING_XY && j->ms < j->md)))
        return 0;
    j->kernels->derive(blue, out->c[0], out->c[1], n, j->md, to == NTP_ENCODING_ZZERO);
    if (from == NTP_ENCODING_XY && to != NTP_ENCODING_XY) {
        memcpy(out->c[2], blue, (size_t) n * sizeof blue[0]);
        for (int32_t i = 0; i < n; i++)
            any |= pull[i] = -(blue[i] < 0);
        return any;
    }
    j->kernels->derive(want, in->c[0], in->c[1], n, j->ms, from == NTP_ENCODING_ZZERO);
    if (from == NTP_ENCODING_XY) {
        for (int32_t i = 0; i < n; i++)
            any |= pull[i] = -((want[i] >= 0) & (blue[i] < 0));
        return any;
    }
    if (from != to && to != NTP_ENCODING_XY && j->src->type != NTP_TYPE_F32)
        blues_by_value(j, out->c[2], in->c[2], n);
    any = put_exact(j, out->c[2], in->c[2], want, blue, pull, n);
    for (int32_t i = 0; to == NTP_ENCODING_XY && i < n; i++)
        out->c[2][i] = j->md;
    return any;
}

/* Puts unused texels back, which are converted by value alone; what is no vector is flat.  Returns how many
 * of the latter. */
SELDOM static uint64_t keep_unused(const ntp__conversion *j, ntp__block *out, const ntp__block *in,
                                   const uint8_t *kept, int32_t x, int32_t y, int32_t n)
{
    const int32_t middle = (j->md + 1) / 2, flat[4] = { middle, middle, j->md, j->md };
    uint64_t found = 0;
    for (int32_t i = 0; i < n; i++) {
        const bool broken = in->any_broken && in->broken[i];
        const float *raw = ntp__at(j->src, x + i, y);
        for (int32_t k = 0; kept[i] && k < 4; k++)
            out->c[k][i] = broken ? flat[k]
                           : j->src->type == NTP_TYPE_F32 && k < j->src->channels
                               ? ntp__level_of(raw[k], j->md)
                               : ntp__deepen(in->c[k][i], j->ms, j->md);
        found += broken;
    }
    return found;
}

/* Writes flat floats, which are no levels, where there is no vector. */
SELDOM static void write_broken(const ntp__conversion *j, const ntp__block *in, int32_t x,
                                int32_t y, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        float *d = ntp__at_mut(j->dst, x + i, y);
        for (int32_t k = 0; in->broken[i] && k < j->dst->channels; k++)
            d[k] = k < 2 ? 0.5F : 1.0F;
    }
}

static uint64_t count_negative(const ntp__conversion *j, const int32_t *b, const uint8_t *kept,
                               int32_t n)
{
    int32_t count = 0;
    for (int32_t i = 0; i < n; i++)
        count += ntp__z_negative(b[i], j->ms);
    for (int32_t i = 0; kept != NULL && i < n; i++)
        count -= kept[i] && ntp__z_negative(b[i], j->ms);
    return (uint64_t) count;
}

/* A blue from floats, where source and target store z differently. */
static int32_t blue_of_float(double blue, int32_t m, bool to_zzero)
{
    if (to_zzero)
        return ntp__level_of(fabs(2.0 * blue - 1.0), m);
    const double mv = blue * m;
    return (m + 1 + (mv > 0 ? mv < m ? (int32_t) mv : m : 0)) / 2;
}

/* The levels of biased floats at the depth of the target, by value. */
static void read_floats(const ntp__conversion *j, ntp__block *out, int32_t x, int32_t y, int32_t n)
{
    const bool from_zzero = j->src->encoding == NTP_ENCODING_ZZERO,
               to_zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
    for (int32_t k = 0; k < j->src->channels; k++) {
        const char *s = ntp__at(j->src, x, y);
        for (int32_t i = 0; i < n; i++, s += j->src->pixel_stride) {
            const double v = ((const float *) (const void *) s)[k];
            out->c[k][i] = k == 2 && from_zzero != to_zzero ? blue_of_float(v, j->md, to_zzero)
                                                            : ntp__level_of(v, j->md);
        }
    }
}

/* Writes levels as biased floats, y flipped where `flip` is set and it is not `kept`.  Floats of the source whose
 * level, in `in`, did not change stay as they are.  v + v/M is as in ntp__decode. */
static void write_floats(const ntp__conversion *j, const ntp__block *out, const ntp__block *in,
                         const uint8_t *kept, int32_t x, int32_t y, int32_t n)
{
    for (int32_t k = 0; k < j->dst->channels; k++) {
        const bool flip = k == 1 && j->flip;
        const int32_t *same = in != NULL && k < j->src->channels ? in->c[k] : NULL;
        char *d = ntp__at_mut(j->dst, x, y);
        const char *s = ntp__at(j->src, x, y);
        for (int32_t i = 0; i < n; i++, d += j->dst->pixel_stride, s += j->src->pixel_stride) {
            float v = (float) out->c[k][i] * 0x1p-16F;
            v += v * (1 / 65535.0F);
            if (same != NULL && same[i] == out->c[k][i])
                v = ((const float *) (const void *) s)[k];
            if (flip && kept != NULL && !kept[i])
                v = (float) (1.0 - (double) v);
            ((float *) (void *) d)[k] = v;
        }
    }
}

/* From biased samples to biased samples. */
static void convert_levels(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                           ntp_convert_counts *counts)
{
    ntp__block in, out;
    int32_t pull[NTP__BLOCK];
    uint8_t kept[NTP__BLOCK] = { 0 };
    const bool floats = j->src->type == NTP_TYPE_F32;
    ntp__unpack(&in, j->src, x, y, n);
    const bool suspect = ntp__any_suspect(&in, n, j->ms);
    for (int32_t i = 0; suspect && i < n; i++) {
        kept[i] = ntp__texel_unused(&in, i, j->ms, j->how.touch_unused);
        if (!kept[i] && j->src->channels == 2)
            in.c[2][i] = j->ms;
    }
    for (int32_t k = 0; k < (j->dst->channels == 4 ? 4 : 3); k++) {
        for (int32_t i = 0; i < n; i++)
            out.c[k][i] = ntp__deepen(in.c[k][i], j->ms, j->md);
    }
    if (floats && (j->md < j->ms || (j->src->encoding == NTP_ENCODING_ZZERO) !=
                                        (j->dst->encoding == NTP_ENCODING_ZZERO)))
        read_floats(j, &out, x, y, n);
    const int32_t any = convert_blues(j, &out, &in, pull, n);
    for (int32_t i = 0; suspect && any && i < n; i++)
        pull[i] = kept[i] ? 0 : pull[i];
    if (any)
        counts->pulled += pull_marked(j, &out, &in, pull, n);
    if (j->src->encoding == NTP_ENCODING_STANDARD && j->dst->encoding == NTP_ENCODING_ZZERO)
        counts->z_negative += count_negative(j, in.c[2], suspect ? kept : NULL, n);
    const bool to_floats = j->dst->type == NTP_TYPE_F32;
    for (int32_t i = 0; j->flip && !to_floats && i < n; i++)
        out.c[1][i] = j->md - out.c[1][i];
    if (suspect)
        counts->not_finite += keep_unused(j, &out, &in, kept, x, y, n);
    if (to_floats)
        write_floats(j, &out, floats ? &in : NULL, kept, x, y, n);
    else
        ntp__pack(j->dst, &out, x, y, n, j->dst->channels);
    if (to_floats && in.any_broken)
        write_broken(j, &in, x, y, n);
}

#ifdef NTP_HAVE_AVX2
/* The same for a row of packed RGB.  What the loop without planes gives back goes by the block, so
 * that textures with much of it lose little. */
static void convert_rgb(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                        ntp_convert_counts *counts)
{
    ntp__convert_rgb_fn *loop = ntp__convert_rgb_avx2;
#  ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        loop = ntp__convert_rgb_avx512;
#  endif
    while (n > 0) {
        const int32_t done =
            loop(j, ntp__at_mut(j->dst, x, y), ntp__at(j->src, x, y), n, &counts->z_negative);
        const int32_t left = n - done < NTP__BLOCK ? n - done : NTP__BLOCK;
        if (left > 0)
            convert_levels(j, x + done, y, left, counts);
        x += done + left;
        n -= done + left;
    }
}

/* Flips biased floats, but those of unused texels; 1 - v is exact before it is rounded. */
static void flip_floats(const ntp__conversion *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block in;
    for (int32_t at = 0, some; at < n; at += some) {
        some = n - at < NTP__BLOCK ? n - at : NTP__BLOCK;
        float *d = (float *) ntp__at_mut(j->dst, x + at, y) + 1;
        ntp__unpack(&in, j->src, x + at, y, some);
        const bool suspect = ntp__any_suspect(&in, some, j->ms);
        for (int32_t i = 0; i < some; i++, d += j->dst->channels) {
            if (!suspect || !ntp__texel_unused(&in, i, j->ms, j->how.touch_unused))
                *d = 1 - *d;
        }
    }
}

/* Integers to packed biased floats: levels of 16 bit are made first, the quickest way that there is for them,
 * and stay in the first cache. */
static void convert_by_levels(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                              ntp_convert_counts *counts)
{
    enum { SOME = 4 * NTP__BLOCK };
    uint16_t line[4 * SOME];
    ntp_const_image src = *j->src;
    ntp_image dst = *j->dst, levels = dst;
    levels.data = line;
    levels.type = NTP_TYPE_U16;
    levels.pixel_stride = levels.channels * (ptrdiff_t) sizeof line[0];
    const ntp_const_image made = ntp_image_as_const(&levels);
    ntp__conversion to_levels = *j, to_floats = *j;
    to_levels.src = &src;
    to_levels.dst = &levels;
    to_floats.src = &made;
    to_floats.dst = &dst;
    to_floats.ms = j->md;
    to_levels.flip = to_floats.flip = false;
    int32_t most = NTP__BLOCK;
    ntp__convert_fn *const make = ntp__fast_conversion(&to_levels, &most);
    most = most < SOME ? most : SOME;
    for (int32_t at = 0; at < n; at += most) {
        const int32_t some = n - at < most ? n - at : most;
        src.data = ntp__at(j->src, x + at, y);
        dst.data = ntp__at_mut(j->dst, x + at, y);
        make(&to_levels, 0, 0, some, counts);
        ntp__decode(&to_floats, 0, 0, some, counts);
    }
    if (j->flip)
        flip_floats(j, x, y, n);
}
#endif

/* Makes what is no vector 0; returns how many. */
SELDOM static uint64_t clear_broken(const ntp__conversion *j, ntp__vectors *v, ntp__block *out,
                                    int32_t n)
{
    uint64_t broken = 0;
    for (int32_t i = 0; i < n; i++) {
        double size = fabs(v->c[0][i]) + fabs(v->c[1][i]) + fabs(v->c[2][i]);
        if (size > 0.0 && ntp__is_finite(size))
            continue;
        v->c[0][i] = v->c[1][i] = v->c[2][i] = 0.0;
        out->c[3][i] = j->md;
        broken++;
    }
    return broken;
}

/* Reads float vectors, y as in the target; those that are none become 0.  Returns how many. */
static uint64_t read_vectors(const ntp__conversion *j, ntp__vectors *v, ntp__block *out, int32_t x,
                             int32_t y, int32_t n)
{
    const char *s = ntp__at(j->src, x, y);
    double any = 0;
    for (int32_t i = 0; i < n; i++, s += j->src->pixel_stride) {
        const float *raw = (const float *) (const void *) s;
        v->c[0][i] = raw[0];
        v->c[1][i] = raw[1];
        v->c[2][i] = raw[2];
        out->c[3][i] = j->src->channels == 4 ? ntp__level_of(raw[3], j->md) : j->md;
    }
    for (int32_t i = 0; i < n; i++) { /* not 0 when one is infinite or 0 */
        double size = fabs(v->c[0][i]) + fabs(v->c[1][i]) + fabs(v->c[2][i]);
        v->c[1][i] = j->flip ? -v->c[1][i] : v->c[1][i];
        any += size * 0.0 + (size == 0.0);
    }
    return any == 0.0 ? 0 : clear_broken(j, v, out, n);
}

/* Encodes float vectors, blue derived. */
static void encode_run(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                       ntp_convert_counts *counts)
{
    const bool zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
    const bool xy = j->dst->encoding == NTP_ENCODING_XY;
    ntp__block out;
    ntp__vectors v;
    int32_t doubt[NTP__BLOCK];
    const uint64_t broken = read_vectors(j, &v, &out, x, y, n);
    if (broken > 0 && j->dst->type == NTP_TYPE_F32) { /* they become 0.5, which is no level */
        ntp__convert_each(j, x, y, n, counts);
        return;
    }
    counts->not_finite += broken;
    int32_t any =
        j->kernels->directions(out.c[0], out.c[1], out.c[2], doubt, &v, n, j->md, zzero, true);
    for (int32_t i = 0; zzero && i < n; i++)
        counts->z_negative += v.c[2][i] < 0;
    if (any && !xy)
        counts->pulled += ntp__pull_directions(&out, doubt, &v, n, j->md, zzero);
    for (int32_t i = 0; any && i < n; i++) {
        if (!(doubt[i] & NTP__IN_DOUBT))
            continue;
        const float raw[3] = { (float) v.c[0][i], (float) (j->flip ? -v.c[1][i] : v.c[1][i]),
                               (float) v.c[2][i] };
        int32_t c[3];
        ntp_convert_counts one = { 0, 0, 0 };
        ntp__convert_vector(j, raw, c, &one);
        counts->pulled += one.pulled;
        for (int32_t k = 0; k < 3; k++)
            out.c[k][i] = c[k];
    }
    for (int32_t i = 0; xy && i < n; i++)
        out.c[2][i] = j->md;
    if (j->dst->type == NTP_TYPE_F32)
        write_floats(j, &out, NULL, NULL, x, y, n);
    else
        ntp__pack(j->dst, &out, x, y, n, j->dst->channels);
}

#ifdef NTP_HAVE_AVX2
/* Encodes packed float vectors as packed RGB, blue derived. */
static void encode_rgb(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                       ntp_convert_counts *counts)
{
    enum { STEP = 16 };
    const bool deep = j->md > 255, zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
    const float *s = ntp__at(j->src, x, y);
    uint8_t *d = ntp__at_mut(j->dst, x, y);
    ntp__left left[NTP__BLOCK / STEP];
    const int32_t done = ntp__encode_rgb_avx2(d, s, n, deep, zzero, j->flip, left);
    for (int32_t i = 0; i < done; i += STEP) {
        const ntp__left *l = &left[i / STEP];
        for (uint32_t b = zzero ? l->negative & ~l->doubt : 0; b != 0; b &= b - 1)
            counts->z_negative++;
        if ((l->doubt | l->overlong) != 0)
            ntp__settle_vectors(j, d + (ptrdiff_t) (deep ? 6 : 3) * i, s + 3 * i, l, counts);
    }
    if (done < n)
        encode_run(j, x + done, y, n - done, counts);
}
#endif

ntp__convert_fn *ntp__fast_conversion(const ntp__conversion *j, int32_t *most)
{
    const ntp_encoding from = j->src->encoding, to = j->dst->encoding;
    const ntp_const_image target = ntp_image_as_const(j->dst);
    const bool packed =
        ntp__is_packed(j->src) && ntp__is_packed(&target) && j->src->channels == j->dst->channels;
    const bool bytes = j->src->type == NTP_TYPE_U8;
    if (from == NTP_ENCODING_HEIGHT)
        return NULL;
    const bool floats = j->dst->type == NTP_TYPE_F32;
    if (from == NTP_ENCODING_VECTOR && to != from) {
#ifdef NTP_HAVE_AVX2
        if (!floats && j->how.blue == NTP_BLUE_DERIVED && packed && j->src->channels == 3 &&
            to != NTP_ENCODING_XY && ntp__cpu_has_avx2(NTP__CPU_ALL))
            return encode_rgb;
#endif
        return j->how.blue == NTP_BLUE_DERIVED ? encode_run : NULL;
    }
    if (j->src->type == NTP_TYPE_F32)
        return to != NTP_ENCODING_VECTOR ? convert_levels : ntp__convert_to_vectors;
    const bool move = packed && j->src->type == j->dst->type && from == to;
    const bool to_vectors =
        packed && to == NTP_ENCODING_VECTOR && from != to && from != NTP_ENCODING_XY;
#ifdef NTP_HAVE_AVX2
    if (floats && to != NTP_ENCODING_VECTOR && ntp__is_packed(&target) &&
        ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        *most = NTP_MAX_SIDE;
        return convert_by_levels;
    }
#endif
    if (floats && !to_vectors)
        return to != NTP_ENCODING_VECTOR ? convert_levels : ntp__convert_to_vectors;
#ifdef NTP_HAVE_AVX2
    if (packed && j->src->channels == 3 && !move && !to_vectors && !j->flip &&
        from != NTP_ENCODING_XY && to != NTP_ENCODING_XY && ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        *most = NTP_MAX_SIDE;
        return convert_rgb;
    }
#endif
    if (!move && !to_vectors)
        return convert_levels;
    *most = NTP_MAX_SIDE; /* these make ready for a row, not for each block */
    if (to_vectors)
        return ntp__decode;
    return bytes ? ntp__move_8 : ntp__move_16;
}
