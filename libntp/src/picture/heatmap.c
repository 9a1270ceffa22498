/* SPDX-License-Identifier: MIT */
/*
 * heatmap.c - paints what is wrong with a texel, and how much, in integers
 *
 * A level is 2 in the odd numerators X, Y, Z over M, so "longer than 1 by k levels" is
 * L >= M + 2k, compared by squares.  Each fault has a strength of 128 to 255, or 0 where there is
 * none.  The reference palette takes the three strengths as red, green and blue.  The safe palette
 * takes the color of the most serious fault, scaled by its strength.
 */
#include "texel/kernels.h"
#include "texel/level.h"
#include "texel/unused.h"
#include "picture/paint_avx2.h"
#include "picture/picture.h"
#include "picture/picture_kernels.h"

#include <string.h>

enum {
    XY_STRONG_LEVELS = 1,     /* x, y longer than 1 by more than this many levels; weak: by any */
    LENGTH_STRONG_LEVELS = 3, /* |length - 1| of at least this many levels */
    LENGTH_WEAK_LEVELS = 2,
    FEW = 8,               /* too long pairs of a block: fewer are pulled one by one */
    DARK = NTP__GRAY_BASE, /* the grays of black and of white */
    LIGHT = NTP__GRAY_BASE + 127
};

/* The color of a float texel that is not a vector. */
static const uint8_t NOT_A_VECTOR[3] = { 255, 255, 255 };

/* (L*L - 1)/4 - (M*M - 1)/4 for odd L.  Such quarters have 31 bits and their sums are compared with
 * those of M + 2k; what is left over, a square has less than 1. */
static int32_t beyond(int32_t l, int32_t m)
{
    return (int32_t) ((ntp__sq(l) - ntp__sq(m)) / 4);
}

static ntp__limits limits_of(int32_t m, bool zzero)
{
    const ntp__limits limits = { m,
                                 zzero,
                                 beyond(m + 2 * XY_STRONG_LEVELS, m),
                                 beyond(m - 2 * LENGTH_WEAK_LEVELS, m),
                                 beyond(m - 2 * LENGTH_STRONG_LEVELS, m),
                                 beyond(m + 2 * LENGTH_WEAK_LEVELS, m),
                                 beyond(m + 2 * LENGTH_STRONG_LEVELS, m) };
    return limits;
}

/* x, y that are too long have their own color.  So the length is that of the pulled pair and z, and
 * tells only what is wrong with z. */
static void pull_long(const ntp__faults *f, int32_t *xy, const ntp__block *block, int32_t n,
                      int32_t m, bool few)
{
    int32_t at[NTP__BLOCK], pair[2][NTP__BLOCK], doubt[NTP__BLOCK];
    const int32_t found = ntp__kernels(NTP__CPU_ALL)->find(at, f->xy, -1, n);
    for (int32_t i = 0; i < found; i++) {
        pair[0][i] = block->c[0][at[i]];
        pair[1][i] = block->c[1][at[i]];
        doubt[i] = few;
    }
    for (int32_t i = found; i % NTP__KERNEL_LANES != 0; i++)
        pair[0][i] = pair[1][i] = 0;
    if (!few)
        ntp__kernels(NTP__CPU_ALL)->pull(pair[0], pair[1], doubt, found, m);
    for (int32_t i = 0; i < found; i++) {
        int32_t r = pair[0][i], g = pair[1][i];
        if (doubt[i]) {
            r = block->c[0][at[i]];
            g = block->c[1][at[i]];
            ntp__pull(&r, &g, m);
        }
        xy[at[i]] = (int32_t) -((ntp__rest(r, g, m) + 1) / 4);
    }
}

/* False: there is no fault, and nothing was written.  Where the block before had `many` pairs that
 * are too long, it is not looked whether there is a fault. */
static bool judge(ntp__faults *f, const ntp__block *block, int32_t n, const ntp__limits *limits,
                  bool xy_only, bool *many)
{
    const ntp__picture_kernels *loops = ntp__picture_loops();
    int32_t xy[NTP__BLOCK];
    if (!*many && !xy_only && !loops->any_fault(block, ntp__whole(n), limits))
        return false;
    const int32_t found =
        loops->judge_pairs(f->xy, xy, block->c[0], block->c[1], ntp__whole(n), limits);
    *many = found >= FEW;
    if (xy_only) {
        memset(f->length, 0, sizeof f->length);
        memset(f->z, 0, sizeof f->z);
        return found > 0;
    }
    if (found > 0)
        pull_long(f, xy, block, n, limits->m, !*many);
    loops->judge_blues(f, xy, block->c[2], ntp__whole(n), limits);
    return true;
}

typedef struct job {
    const ntp_image *dst;
    const ntp_const_image *src;
    bool safe;
    uint32_t touch;
    ntp__limits limits;
} job;

/* The block has whole groups. */
static void paint_block(ntp__block *out, const job *j, const ntp__block *block, int32_t n,
                        bool *many)
{
    ntp__faults f;
    const int32_t m = j->limits.m;
    const ntp__picture_kernels *loops = ntp__picture_loops();
    loops->make_gray(out, block, ntp__whole(n), m);
    if (judge(&f, block, n, &j->limits, j->src->encoding == NTP_ENCODING_XY, many)) {
        const bool suspect = ntp__any_suspect(block, n, m);
        for (int32_t i = 0; suspect && i < n; i++) {
            if (ntp__texel_unused(block, i, m, j->touch))
                f.xy[i] = f.length[i] = f.z[i] = 0;
        }
        loops->paint(out, &f, ntp__whole(n), j->safe);
    }
    for (int32_t i = 0; block->any_broken && i < n; i++) {
        for (int32_t k = 0; block->broken[i] && k < 3; k++)
            out->c[k][i] = NOT_A_VECTOR[k];
    }
}

static void paint_run(const job *j, int32_t x, int32_t y, int32_t n, bool *many)
{
    ntp__block block, out;
    ntp__unpack(&block, j->src, x, y, n);
    ntp__fill_group(&block, n);
    paint_block(&out, j, &block, n, many);
    ntp__pack_opaque(j->dst, &out, x, y, n);
}

#ifdef NTP_HAVE_AVX2
static int32_t paint_rgb(const void *how, uint8_t *dst, uint8_t odd[NTP__BLOCK / 8],
                         const void *src, int32_t n, bool deep)
{
    const job *j = how;
#  ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        return ntp__heat_rgb_avx512(dst, odd, src, n, deep, &j->limits);
#  endif
    return ntp__heat_rgb_avx2(dst, odd, src, n, deep, &j->limits);
}

static void paint_odd(const void *how, ntp__block *out, const ntp__odd_texels *odd)
{
    bool many = true;
    paint_block(out, how, &odd->block, odd->n, &many);
}

static bool paint_packed(const job *j, const ntp_rect *rect)
{
    const ntp__painter painter = { .dst = j->dst,
                                   .src = j->src,
                                   .job = j,
                                   .touch_unused = j->touch,
                                   .unused = { { DARK, DARK }, { LIGHT, LIGHT } },
                                   .paint = paint_rgb,
                                   .again = paint_odd };
    return !j->safe && ntp__paint_packed(&painter, rect);
}
#else
static bool paint_packed(const job *j, const ntp_rect *rect)
{
    (void) j, (void) rect;
    return false;
}
#endif

ntp_status ntp_heatmap(const ntp_image *dst, const ntp_const_image *src, ntp_palette palette,
                       uint32_t touch_unused, const ntp_rect *area)
{
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_painting(dst, src, 3));
    if ((palette != NTP_PALETTE_REFERENCE && palette != NTP_PALETTE_SAFE) ||
        touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    const job j = { .dst = dst,
                    .src = src,
                    .safe = palette == NTP_PALETTE_SAFE,
                    .touch = touch_unused,
                    .limits = limits_of(ntp__max(src->type), src->encoding == NTP_ENCODING_ZZERO) };
    bool many = false;
    if (paint_packed(&j, &rect))
        return NTP_OK;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            paint_run(&j, x, y, n, &many);
        }
    }
    return NTP_OK;
}
