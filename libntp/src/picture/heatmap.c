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
#include "picture/picture.h"

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

typedef struct strengths {
    int32_t xy, length, z;
} strengths;

/* Vermilion, sky blue and yellow of Okabe and Ito, which color-blind people can tell apart. */
static const uint8_t SAFE_XY[3] = { 213, 94, 0 };
static const uint8_t SAFE_LENGTH[3] = { 86, 180, 233 };
static const uint8_t SAFE_Z[3] = { 240, 228, 66 };

/* The color of a float texel that is not a vector. */
static const uint8_t NOT_A_VECTOR[3] = { 255, 255, 255 };

static int32_t xy_strength(int64_t xy2, int32_t m)
{
    if (xy2 > ntp__sq(m + 2 * XY_STRONG_LEVELS))
        return STRONG;
    return xy2 > ntp__sq(m) ? WEAK : 0;
}

static bool length_off(int64_t length2, int32_t m, int32_t levels)
{
    return length2 >= ntp__sq(m + 2 * levels) || length2 <= ntp__sq(m - 2 * levels);
}

static strengths judge(int32_t r, int32_t g, int32_t b, int32_t m, ntp_encoding encoding)
{
    int64_t rest = ntp__rest(r, g, m);
    strengths s = { xy_strength(ntp__sq(m) - rest, m), 0, 0 };
    if (encoding == NTP_ENCODING_XY)
        return s;
    /* x, y that are too long have their own color.  So the length is that of the pulled pair and z,
     * and tells only what is wrong with z. */
    if (rest < 0) {
        ntp__pull(&r, &g, m);
        rest = ntp__rest(r, g, m);
    }
    bool zzero = encoding == NTP_ENCODING_ZZERO;
    int64_t length2 = ntp__sq(m) - rest + ntp__sq(zzero ? b : ntp__num(b, m));
    if (length_off(length2, m, LENGTH_STRONG_LEVELS))
        s.length = STRONG;
    else if (length_off(length2, m, LENGTH_WEAK_LEVELS))
        s.length = WEAK;
    /* M - b runs from the middle, just below zero, to M, which is z = -1. */
    if (!zzero && ntp__z_negative(b, m))
        s.z = m == 255 ? m - b : ntp__narrow(m - b);
    return s;
}

static void paint_gray(uint8_t rgb[3], int32_t r, int32_t g, int32_t b, int32_t m)
{
    int32_t whole = LUMA_WHOLE * (m / 255);
    int32_t luma = (LUMA_RED * r + LUMA_GREEN * g + LUMA_BLUE * b + whole / 2) / whole;
    rgb[0] = rgb[1] = rgb[2] = (uint8_t) (GRAY_BASE + luma / 2);
}

static void paint_fault(uint8_t rgb[3], const strengths *s, ntp_palette palette)
{
    if (palette == NTP_PALETTE_REFERENCE) {
        rgb[0] = (uint8_t) s->xy;
        rgb[1] = (uint8_t) s->length;
        rgb[2] = (uint8_t) s->z;
        return;
    }
    const uint8_t *hue = s->z > 0 ? SAFE_Z : s->xy > 0 ? SAFE_XY : SAFE_LENGTH;
    int32_t strength = s->z > 0 ? s->z : s->xy > 0 ? s->xy : s->length;
    for (int32_t k = 0; k < 3; k++)
        rgb[k] = (uint8_t) ((hue[k] * strength + STRONG / 2) / STRONG);
}

static void paint_run(const ntp_image *dst, const ntp_const_image *src, ntp_palette palette,
                      uint32_t touch, int32_t x, int32_t y, int32_t n)
{
    ntp__block block;
    int32_t m = ntp__max(src->type);
    ntp_encoding encoding =
        src->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : src->encoding;
    ntp__unpack(&block, src, x, y, n);
    uint8_t *d = ntp__at_mut(dst, x, y);
    for (int32_t i = 0; i < n; i++, d += dst->pixel_stride) {
        int32_t r = block.c[0][i], g = block.c[1][i], b = block.c[2][i];
        if (block.any_broken && block.broken[i]) {
            ntp__paint(d, dst->channels, NOT_A_VECTOR);
            continue;
        }
        strengths s = { 0, 0, 0 };
        if (!ntp__unused(r, g, b, block.c[3][i], m, touch))
            s = judge(r, g, b, m, encoding);
        uint8_t rgb[3];
        if (s.xy + s.length + s.z > 0)
            paint_fault(rgb, &s, palette);
        else
            paint_gray(rgb, r, g, b, m);
        ntp__paint(d, dst->channels, rgb);
    }
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
