/* SPDX-License-Identifier: MIT */
/*
 * blend.c - a detail normals texture over a base
 *
 * The vector of each mode is a polynomial in the levels of both texels, so its direction is known
 * exactly and rounded once.  With base B / M, detail D / N, strength n / 2^k and e = (0, 0, 1), the
 * vectors without their denominators are
 *     reoriented  t = B + M e,  u = (-n Dx, -n Dy, 2^k Dz):  t (t.u) - M t.z u
 *     whiteout    (2^k N Bx + n M Dx, 2^k N By + n M Dy, 2^k Bz Dz)
 *     UDN         the same with z = 2^k N Bz
 *     linear      the same with z = 2^k (N Bz + M Dz)
 * A numerator of a level has 17 bits with its sign, n has 53 bits, and 2^k has 62, but not together
 * with a large n.  So all components are below 2^116.
 * An alpha a / A that fades the detail makes it a D + (A - a) N e, and linearly A N B + a M D.
 * Only u can then be too long; it is shortened.
 */
#include "base/cpu.h"
#include "reshape/blend_kernels.h"
#include "reshape/mix_avx2.h"
#include "texel/direction.h"
#include "texel/unused.h"
#include "texel/level.h"

#include <math.h>
#include <string.h>

typedef struct job {
    const ntp_image *dst;
    const ntp_const_image *base, *detail;
    ntp_blend_options how;
    ntp__strength strength;
    int32_t mb, md; /* M of base and detail */
    bool flip;      /* the y of base and detail differ */
    bool fades;     /* alpha fades the detail */
    bool exact;     /* whole numbers below 2^53 need no doubt */
    ntp__mixture mixture;
} job;

static void reoriented(ntp__i128 out[3], const int32_t b[3], const ntp__i128 d[3], int32_t mb)
{
    int64_t t[3] = { b[0], b[1], (int64_t) b[2] + mb };
    ntp__i128 u[3] = { ntp__i128_negate(d[0]), ntp__i128_negate(d[1]), d[2] };
    ntp__i128 dot = ntp__i128_of(0);
    for (int32_t k = 0; k < 3; k++)
        dot = ntp__i128_add(dot, ntp__i128_multiply(u[k], t[k]));
    for (int32_t k = 0; k < 3; k++)
        out[k] =
            ntp__i128_subtract(ntp__i128_multiply(dot, t[k]), ntp__i128_multiply(u[k], t[2] * mb));
}

/* The vector of the mode from those of base and detail; the detail counts alpha / most. */
static void blend_vectors(const job *j, ntp__i128 out[3], const int32_t b[3], const int32_t d[3],
                          int32_t alpha, int32_t most)
{
    ntp__i128 detail[3];
    const int32_t shift = j->strength.shift;
    const bool linear = j->how.mode == NTP_BLEND_LINEAR;
    int64_t z = (int64_t) d[2] * alpha + (linear ? 0 : (int64_t) (most - alpha) * j->md);
    for (int32_t k = 0; k < 2; k++)
        detail[k] = ntp__i128_multiply(ntp__i128_of(j->strength.numerator), (int64_t) d[k] * alpha);
    detail[2] = ntp__i128_shift(ntp__i128_of(z), shift);
    if (j->how.mode == NTP_BLEND_RNM) {
        enum { MOST_BITS = 88 }; /* t has 17 */
        if (most > 1)
            ntp__i128_shorten(detail, MOST_BITS);
        reoriented(out, b, detail, j->mb);
        return;
    }
    for (int32_t k = 0; k < 3; k++)
        out[k] = ntp__i128_shift(ntp__i128_of((int64_t) b[k] * j->md * most), shift);
    for (int32_t k = 0; k < (linear ? 3 : 2); k++)
        out[k] = ntp__i128_add(out[k], ntp__i128_multiply(detail[k], j->mb));
    if (j->how.mode == NTP_BLEND_WHITEOUT)
        out[2] = ntp__i128_multiply(detail[2], b[2]);
}

/* Reads n texels of row y of the detail, which repeats. */
static void unpack_detail(const job *j, ntp__block *out, int32_t x, int32_t y, int32_t n)
{
    const ntp_const_image *v = j->detail;
    int32_t row = y % v->height;
    if (x % v->width + n <= v->width) {
        ntp__unpack(out, v, x % v->width, row, n);
        return;
    }
    out->any_broken = false;
    for (int32_t done = 0; done < n;) {
        int32_t column = (x + done) % v->width, run = v->width - column;
        run = run < n - done ? run : n - done;
        ntp__block part;
        ntp__unpack(&part, v, column, row, run);
        for (int32_t k = 0; k < 4; k++)
            memcpy(out->c[k] + done, part.c[k], (size_t) run * sizeof part.c[k][0]);
        for (int32_t i = 0; i < run; i++)
            out->broken[done + i] = part.any_broken && part.broken[i];
        out->any_broken = out->any_broken || part.any_broken;
        done += run;
    }
}

/* Copies the samples of a base texel that a blend leaves as they are. */
static void copy_samples(const job *j, int32_t x, int32_t y, bool all)
{
    ptrdiff_t size = ntp__sample_size(j->base->type);
    int32_t first = all ? 0 : j->base->encoding == NTP_ENCODING_XY ? 2 : 3;
    if (first < j->base->channels)
        memmove((char *) ntp__at_mut(j->dst, x, y) + first * size,
                (const char *) ntp__at(j->base, x, y) + first * size,
                (size_t) ((j->base->channels - first) * size));
}

static void store_texel(const job *j, int32_t x, int32_t y, const ntp__block *out, int32_t i)
{
    float *d = (float *) (void *) ntp__at_mut(j->dst, x + i, y);
    const bool component = j->base->encoding == NTP_ENCODING_VECTOR;
    for (int32_t k = 0; k < (j->base->encoding == NTP_ENCODING_XY ? 2 : 3); k++) {
        const int32_t c = out->c[k][i];
        d[k] = (float) ((double) (component ? ntp__num(c, 65535) : c) / 65535.0);
    }
}

/* The levels of one texel, exactly. */
static void blend_exactly(const job *j, int32_t c[3], const ntp__block *base,
                          const ntp__block *detail, int32_t i)
{
    int32_t b[3], d[3];
    ntp__i128 v[3];
    ntp__texel_vector(b, base, i, j->mb, j->base->encoding);
    ntp__texel_vector(d, detail, i, j->md, j->detail->encoding);
    d[1] = j->flip ? -d[1] : d[1];
    blend_vectors(j, v, b, d, j->fades ? detail->c[3][i] : 1, j->fades ? j->md : 1);
    /* A steep detail, reoriented on a steep base, can point below the horizon. */
    if (ntp__i128_negative(v[2]) && b[2] >= 0 && d[2] >= 0)
        v[2] = ntp__i128_of(0);
    ntp__direction_levels(c, v, j->mb, j->base->encoding);
}

/* One texel in doubt, whose vector is `known` in doubles. */
static void blend_texel(const job *j, ntp__block *out, const ntp__block *base,
                        const ntp__block *detail, const ntp__vectors *known, int32_t i)
{
    const double v[3] = { known->c[0][i], known->c[1][i], known->c[2][i] };
    int32_t c[3] = { 0, 0, out->c[2][i] };
    if (!j->exact || !ntp__direction_decided(c, v, j->mb, j->base->encoding))
        blend_exactly(j, c, base, detail, i);
    for (int32_t k = 0; k < 3; k++)
        out->c[k][i] = c[k];
}

extern const ntp__blend_kernels ntp__blend_loops_base, ntp__blend_loops_avx2;

static ntp__mixture mixture_of(const job *j)
{
    const double strength = ntp__strength_value(&j->strength);
    const bool linear = j->how.mode == NTP_BLEND_LINEAR,
               whiteout = j->how.mode == NTP_BLEND_WHITEOUT;
    return (ntp__mixture) { .strength = strength,
                            .turn = j->flip ? -strength : strength,
                            .mb = j->mb,
                            .md = j->md,
                            .by_alpha = j->fades,
                            .opaque = !j->fades,
                            .most = j->fades ? j->md : 1,
                            .filled = linear ? 0 : j->md,
                            .base_z = !whiteout,
                            .detail_z = linear,
                            .product = whiteout };
}

/* The vectors of the mode in doubles.  Beyond n, base, detail and alpha become 0. */
static void estimate(const job *j, ntp__vectors *out, double *size, ntp__vectors *base,
                     ntp__vectors *detail, int32_t *alpha, int32_t n)
{
    const ntp__blend_kernels *loops =
        NTP__CPU_PICK(NTP__CPU_ALL, ntp__blend_loops_base, ntp__blend_loops_avx2);
    const int32_t filled = (n + NTP__KERNEL_LANES - 1) / NTP__KERNEL_LANES * NTP__KERNEL_LANES;
    const size_t beyond = (size_t) (filled - n);
    for (int32_t k = 0; k < 3; k++) {
        memset(base->c[k] + n, 0, beyond * sizeof base->c[k][0]);
        memset(detail->c[k] + n, 0, beyond * sizeof detail->c[k][0]);
    }
    memset(alpha + n, 0, beyond * sizeof alpha[0]);
    ntp__mix_fn *mix = j->how.mode == NTP_BLEND_RNM ? loops->reoriented : loops->others;
    mix(out, size, base, detail, alpha, filled, &j->mixture);
}

/* Doubts vectors whose terms nearly cancel each other, and a z whose sign is not sure. */
static void doubt_small(int32_t *doubt, const ntp__vectors *v, const double *size, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        double x = v->c[0][i], y = v->c[1][i], z = v->c[2][i], least = size[i] * 0x1p-8;
        bool small = x * x + y * y + z * z < least * least;
        if (small || (z != 0 && fabs(z) < size[i] * 0x1p-40))
            doubt[i] = NTP__IN_DOUBT;
    }
}

static bool keeps(const job *j, const ntp__block *base, const ntp__block *detail, int32_t i)
{
    return ntp__texel_unused(base, i, j->mb, j->how.touch_unused) ||
           ntp__texel_unused(detail, i, j->md, j->how.touch_unused);
}

static bool same_texel(const ntp__block *b, int32_t i, int32_t k)
{
    return b->c[0][i] == b->c[0][k] && b->c[1][i] == b->c[1][k] && b->c[2][i] == b->c[2][k] &&
           b->c[3][i] == b->c[3][k];
}

/* The levels of n texels; the planes change beyond n. */
static void blend_block(const job *j, ntp__block *out, const ntp__block *base, ntp__block *detail,
                        int32_t n)
{
    ntp__vectors b, d, v;
    double size[NTP__BLOCK];
    int32_t doubt[NTP__BLOCK];
    ntp__block_vectors(&b, base, n, j->mb, j->base->encoding);
    ntp__block_vectors(&d, detail, n, j->md, j->detail->encoding);
    estimate(j, &v, size, &b, &d, detail->c[3], n);
    for (int32_t k = 2; k < 4; k++)
        memcpy(out->c[k], base->c[k], (size_t) n * sizeof out->c[k][0]);
    bool any = ntp__block_directions(out, doubt, &v, n, j->mb, j->base->encoding, j->exact);
    if (!j->exact)
        doubt_small(doubt, &v, size, n);
    const bool suspect = ntp__any_suspect(base, n, j->mb) || ntp__any_suspect(detail, n, j->md);
    any = any || suspect || !j->exact;
    int32_t last = -1; /* the last exact one: twice flat of 16 bit, for one, is always in doubt */
    for (int32_t i = 0; any && i < n; i++) {
        const bool keep = suspect && keeps(j, base, detail, i);
        for (int32_t k = 0; keep && k < 3; k++)
            out->c[k][i] = base->c[k][i];
        if (keep || !doubt[i])
            continue;
        const bool again = last >= 0 && same_texel(base, i, last) && same_texel(detail, i, last);
        for (int32_t k = 0; again && k < 3; k++)
            out->c[k][i] = out->c[k][last];
        if (!again)
            blend_texel(j, out, base, detail, &v, i);
        last = i;
    }
}

static void blend_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block base, detail, out;
    ntp__unpack(&base, j->base, x, y, n);
    unpack_detail(j, &detail, x, y, n);
    blend_block(j, &out, &base, &detail, n);
    if (j->base->type != NTP_TYPE_F32) {
        ntp__pack(j->dst, &out, x, y, n, j->dst->channels);
        return;
    }
    for (int32_t i = 0; i < n; i++) {
        const bool keep = keeps(j, &base, &detail, i);
        copy_samples(j, x + i, y, keep);
        if (!keep)
            store_texel(j, x, y, &out, i);
    }
}

#ifdef NTP_HAVE_AVX2
static void blend_left(const void *job_, ntp__block *base, ntp__block *detail, int32_t n)
{
    ntp__block out;
    blend_block(job_, &out, base, detail, n);
    for (int32_t k = 0; k < 3; k++)
        memcpy(base->c[k], out.c[k], (size_t) n * sizeof base->c[k][0]);
}

/* With AVX2: packed RGB of one depth; false: there is another way only. */
static bool blend_packed(const job *j, const ntp_rect *r)
{
    const ntp_const_image target = ntp_image_as_const(j->dst);
    const ntp__mixing how = { .dst = j->dst,
                              .base = j->base,
                              .detail = j->detail,
                              .how = &j->mixture,
                              .reoriented = j->how.mode == NTP_BLEND_RNM,
                              .exact = j->exact,
                              .touch_unused = j->how.touch_unused,
                              .settle = blend_left,
                              .job = j };
    if (!ntp__can_mix(j->base) || !ntp__can_mix(j->detail) || !ntp__can_mix(&target) ||
        j->mb != j->md || !(fabs(j->mixture.strength) <= NTP__MOST_MIXED) ||
        !ntp__cpu_has_avx2(NTP__CPU_ALL))
        return false;
    for (int32_t y = r->y0; y < r->y1; y++)
        ntp__mix_row_avx2(&how, r->x0, r->x1, y);
    return true;
}
#endif

ntp_status ntp_blend(const ntp_image *dst, const ntp_const_image *base,
                     const ntp_const_image *detail, const ntp_blend_options *how,
                     const ntp_rect *area)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(base));
    NTP__TRY(ntp__check_normals(detail));
    NTP__TRY(ntp__check_normals(&target));
    if (!ntp__same_size(&target, base))
        return NTP_ERR_SHAPE;
    if (dst->type != base->type || dst->encoding != base->encoding ||
        dst->channels != base->channels || dst->y != base->y)
        return NTP_ERR_FORMAT;
    if (dst->data == detail->data)
        return NTP_ERR_OVERLAP;
    job j = { .dst = dst,
              .base = base,
              .detail = detail,
              .mb = ntp__max(base->type),
              .md = ntp__max(detail->type),
              .flip = base->y != detail->y };
    if (how != NULL)
        j.how = *how;
    if ((int) j.how.mode < NTP_BLEND_RNM || (int) j.how.mode > NTP_BLEND_LINEAR ||
        j.how.touch_unused > NTP_UNUSED_ALL ||
        !ntp__strength_of(&j.strength, j.how.use_strength ? j.how.strength : 1.0))
        return NTP_ERR_ARGUMENT;
    j.fades = j.how.detail_alpha != 0 && detail->channels == 4;
    j.exact = !j.fades && j.strength.shift == 0 &&
              (j.strength.numerator == 1 || j.strength.numerator == -1);
    j.mixture = mixture_of(&j);
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, base, area));
#ifdef NTP_HAVE_AVX2
    if (blend_packed(&j, &rect))
        return NTP_OK;
#endif
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK)
            blend_run(&j, x, y, rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK);
    }
    return NTP_OK;
}

const char *ntp_blend_mode_name(ntp_blend_mode mode)
{
    static const char *const NAME[] = { "rnm", "whiteout", "udn", "linear" };
    return (int) mode >= 0 && (int) mode < 4 ? NAME[mode] : "unknown";
}
