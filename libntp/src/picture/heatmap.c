/* SPDX-License-Identifier: MIT */
/*
 * heatmap.c - paints what is wrong with a texel, and how much, in integers
 *
 * A level is 2 in the odd numerators X, Y, Z over M, so "longer than 1 by k levels" is
 * L >= M + 2k, compared by squares.  Each fault has a strength of 128 to 255, or 0 where there is
 * none.  The reference palette takes the three strengths as red, green and blue.  The safe palette
 * takes the color of the most serious fault, scaled by its strength.
 */
#include "texel/level.h"
#include "texel/unused.h"
#include "picture/picture.h"

#include <string.h>

enum {
    STRONG = 255,
    WEAK = 128,
    XY_STRONG_LEVELS = 1,     /* x, y longer than 1 by more than this many levels; weak: by any */
    LENGTH_STRONG_LEVELS = 3, /* |length - 1| of at least this many levels */
    LENGTH_WEAK_LEVELS = 2,
    GRAY_BASE = 100 /* faultless texels: 100 + luma/2, so 100..227, never taken for a fault */
};

/* Rec. 709 luma weights in ten-thousandths. */
enum { LUMA_RED = 2126, LUMA_GREEN = 7152, LUMA_BLUE = 722, LUMA_WHOLE = 10000 };

/* The faults of a block of texels, as planes, so that compilers vectorize the loops. */
typedef struct faults {
    int32_t xy[NTP__BLOCK], length[NTP__BLOCK], z[NTP__BLOCK];
} faults;

/* Vermilion, sky blue and yellow of Okabe and Ito, which color-blind people can tell apart. */
static const uint8_t SAFE_XY[3] = { 213, 94, 0 };
static const uint8_t SAFE_LENGTH[3] = { 86, 180, 233 };
static const uint8_t SAFE_Z[3] = { 240, 228, 66 };

/* The color of a float texel that is not a vector. */
static const uint8_t NOT_A_VECTOR[3] = { 255, 255, 255 };

/* (L*L - 1)/4 - (M*M - 1)/4 for odd L.  Such quarters have 31 bits and their sums are compared with
 * those of M + 2k; what is left over, a square has less than 1. */
static int32_t beyond(int32_t l, int32_t m)
{
    return (int32_t) ((ntp__sq(l) - ntp__sq(m)) / 4);
}

static void judge_xy(int32_t *restrict fault, int32_t *restrict xy, const int32_t *restrict r,
                     const int32_t *restrict g, int32_t n, int32_t m)
{
    const int32_t k = (m + 1) / 2, most = k * (k - 1), strong = beyond(m + 2 * XY_STRONG_LEVELS, m);
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        int32_t p = r[i] - k, q = g[i] - k, sum = p * (p + 1) - most + q * (q + 1);
        fault[i] = sum >= strong ? STRONG : sum >= 0 ? WEAK : 0;
        xy[i] = sum;
    }
}

/* x, y that are too long have their own color.  So the length is that of the pulled pair and z, and
 * tells only what is wrong with z. */
static void pull_long(const faults *f, int32_t *xy, const ntp__block *block, int32_t n, int32_t m)
{
    for (int32_t i = 0; i < n; i++) {
        if (f->xy[i] == 0)
            continue;
        int32_t r = block->c[0][i], g = block->c[1][i];
        ntp__pull(&r, &g, m);
        xy[i] = (int32_t) -((ntp__rest(r, g, m) + 1) / 4);
    }
}

static void judge_z(faults *restrict f, const int32_t *restrict xy, const int32_t *restrict b,
                    int32_t n, int32_t m, bool zzero)
{
    const int32_t short1 = beyond(m - 2 * LENGTH_WEAK_LEVELS, m);
    const int32_t short2 = beyond(m - 2 * LENGTH_STRONG_LEVELS, m);
    const int32_t long1 = beyond(m + 2 * LENGTH_WEAK_LEVELS, m);
    const int32_t long2 = beyond(m + 2 * LENGTH_STRONG_LEVELS, m);
    const int32_t k = (m + 1) / 2;
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        int32_t half = zzero ? b[i] >> 1 : b[i] - k, other = zzero ? b[i] - half : half + 1;
        int32_t sum = xy[i] + half * other;
        int32_t weak = (sum >= long1) | (sum < short1), strong = (sum >= long2) | (sum < short2);
        f->length[i] = strong ? STRONG : weak ? WEAK : 0;
    }
    /* M - b runs from the middle, just below zero, to M, which is z = -1.  At 16 bits it is
     * ntp__narrow without its division. */
    const int32_t factor = m == 255 ? 1 : 255, more = m == 255 ? 0 : 32895,
                  bits = m == 255 ? 0 : 16;
    const int32_t low = zzero ? -1 : k - 1;
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        int32_t z = b[i] <= low ? m - b[i] : 0;
        f->z[i] = (factor * z + more) >> bits;
    }
}

static void judge(faults *f, const ntp__block *block, int32_t n, int32_t m, ntp_encoding encoding)
{
    int32_t xy[NTP__BLOCK], any = 0;
    judge_xy(f->xy, xy, block->c[0], block->c[1], n, m);
    if (encoding == NTP_ENCODING_XY) {
        memset(f->length, 0, sizeof f->length);
        memset(f->z, 0, sizeof f->z);
        return;
    }
    for (int32_t i = 0; i < n; i++)
        any |= f->xy[i];
    if (any)
        pull_long(f, xy, block, n, m);
    judge_z(f, xy, block->c[2], n, m, encoding == NTP_ENCODING_ZZERO);
}

/* A quotient plus 1/2 is no whole number, and farther from one than doubles are wrong. */
static void make_gray(ntp__block *restrict gray, const ntp__block *restrict block, int32_t n,
                      int32_t m)
{
    const int32_t whole = LUMA_WHOLE * (m / 255), more = whole / 2;
    const double share = 1.0 / whole;
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        int32_t sum = LUMA_RED * block->c[0][i] + LUMA_GREEN * block->c[1][i] +
                      LUMA_BLUE * block->c[2][i] + more;
        gray->c[0][i] = gray->c[1][i] = gray->c[2][i] =
            GRAY_BASE + (int32_t) ((sum + 0.5) * share) / 2;
    }
}

static void paint_fault(uint8_t rgb[3], const faults *f, int32_t i)
{
    const int32_t xy = f->xy[i], length = f->length[i], z = f->z[i];
    const uint8_t *hue = z > 0 ? SAFE_Z : xy > 0 ? SAFE_XY : SAFE_LENGTH;
    const int32_t strength = z > 0 ? z : xy > 0 ? xy : length;
    for (int32_t k = 0; k < 3; k++)
        rgb[k] = (uint8_t) ((hue[k] * strength + STRONG / 2) / STRONG);
}

/* The colors of the reference palette are the faults themselves. */
static void paint_reference(ntp__block *restrict out, const faults *restrict f, int32_t n)
{
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        const int32_t none = -((f->xy[i] | f->length[i] | f->z[i]) == 0);
        out->c[0][i] = f->xy[i] | (out->c[0][i] & none);
        out->c[1][i] = f->length[i] | (out->c[1][i] & none);
        out->c[2][i] = f->z[i] | (out->c[2][i] & none);
    }
}

static void paint_safe(ntp__block *out, const faults *f, int32_t n)
{
    int32_t any[NTP__BLOCK];
    for (int32_t i = 0; i < n; i++)
        any[i] = f->xy[i] | f->length[i] | f->z[i];
    for (int32_t first = 0; first < n; first += NTP__GROUP) {
        const int32_t end = ntp__group_end(any, first, n);
        for (int32_t i = first; i < end; i++) {
            uint8_t rgb[3];
            if (any[i] == 0)
                continue;
            paint_fault(rgb, f, i);
            for (int32_t k = 0; k < 3; k++)
                out->c[k][i] = rgb[k];
        }
    }
}

static void paint_run(const ntp_image *dst, const ntp_const_image *src, ntp_palette palette,
                      uint32_t touch, int32_t x, int32_t y, int32_t n)
{
    ntp__block block, out;
    faults f;
    const int32_t m = ntp__max(src->type);
    ntp__unpack(&block, src, x, y, n);
    ntp__fill_group(&block, n);
    judge(&f, &block, n, m, src->encoding);
    make_gray(&out, &block, n, m);
    if (ntp__any_suspect(&block, n, m)) {
        for (int32_t i = 0; i < n; i++) {
            if (ntp__texel_unused(&block, i, m, touch))
                f.xy[i] = f.length[i] = f.z[i] = 0;
        }
    }
    if (palette == NTP_PALETTE_REFERENCE)
        paint_reference(&out, &f, n);
    else
        paint_safe(&out, &f, n);
    for (int32_t i = 0; block.any_broken && i < n; i++) {
        for (int32_t k = 0; block.broken[i] && k < 3; k++)
            out.c[k][i] = NOT_A_VECTOR[k];
    }
    ntp__pack_opaque(dst, &out, x, y, n);
}

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
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            paint_run(dst, src, palette, touch_unused, x, y, n);
        }
    }
    return NTP_OK;
}
