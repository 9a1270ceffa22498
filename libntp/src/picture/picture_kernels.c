/* SPDX-License-Identifier: MIT */
/*
 * picture_kernels.c - loops over blocks of texels, compiled once for each instruction set
 *
 * heatmap.c, shade.c and compare.c say what they are for.
 */
#include "picture/picture_kernels.h"

#include "picture/picture.h"

#include <math.h>

#define CONCAT_(a, b) a##b
#define CONCAT(a, b)  CONCAT_(a, b)

/* n, as a compiler knows it to be whole groups: loops then have no remainder. */
static inline int32_t whole_groups(int32_t n)
{
    return n & -NTP__GROUP;
}

/* Vermilion, sky blue and yellow of Okabe and Ito, which color-blind people can tell apart. */
static const uint8_t SAFE_XY[3] = { 213, 94, 0 };
static const uint8_t SAFE_LENGTH[3] = { 86, 180, 233 };
static const uint8_t SAFE_Z[3] = { 240, 228, 66 };

/* Where blue is standard, z is below 0 up to this level. */
static inline int32_t last_negative(const ntp__limits *how)
{
    return how->zzero ? -1 : (how->m - 1) / 2;
}

/* The products of both kinds of blue have one form: shifted, plus or minus a number. */
static inline int32_t blue_square(int32_t b, int32_t shift, int32_t k)
{
    return ((b >> shift) - k) * (((b + 1) >> shift) - k);
}

static int32_t any_fault(const ntp__block *restrict block, int32_t n,
                         const ntp__limits *restrict how)
{
    const ntp__limits l = *how;
    const int32_t k = (l.m + 1) / 2, most = k * (k - 1), low = last_negative(&l);
    const int32_t shift = l.zzero ? 1 : 0, less = l.zzero ? 0 : k;
    int32_t any = 0;
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        int32_t p = block->c[0][i] - k, q = block->c[1][i] - k, b = block->c[2][i];
        int32_t xy = p * (p + 1) - most + q * (q + 1), sum = xy + blue_square(b, shift, less);
        any |= (xy >= 0) | (sum >= l.long_weak) | (sum < l.short_weak) | (b <= low);
    }
    return any;
}

static int32_t judge_pairs(int32_t *restrict fault, int32_t *restrict xy, const int32_t *restrict r,
                           const int32_t *restrict g, int32_t n, const ntp__limits *restrict how)
{
    const int32_t k = (how->m + 1) / 2, most = k * (k - 1), strong = how->xy_strong;
    int32_t found = 0;
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        int32_t p = r[i] - k, q = g[i] - k, sum = p * (p + 1) - most + q * (q + 1);
        fault[i] = sum >= strong ? NTP__STRONG : sum >= 0 ? NTP__WEAK : 0;
        found += sum >= 0;
        xy[i] = sum;
    }
    return found;
}

static void judge_blues(ntp__faults *restrict f, const int32_t *restrict xy,
                        const int32_t *restrict b, int32_t n, const ntp__limits *restrict how)
{
    const ntp__limits l = *how;
    const int32_t k = (l.m + 1) / 2, low = last_negative(&l);
    const int32_t shift = l.zzero ? 1 : 0, less = l.zzero ? 0 : k;
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        int32_t sum = xy[i] + blue_square(b[i], shift, less);
        int32_t weak = (sum >= l.long_weak) | (sum < l.short_weak);
        int32_t strong = (sum >= l.long_strong) | (sum < l.short_strong);
        f->length[i] = strong ? NTP__STRONG : weak ? NTP__WEAK : 0;
        /* M - b runs from the middle, just below zero, to M, which is z = -1.  At 16 bits it is
         * ntp__narrow without its division. */
        int32_t z = b[i] <= low ? l.m - b[i] : 0;
        f->z[i] = l.m == 255 ? z : (255 * z + 32895) >> 16;
    }
}

/* Half of luma is below 128.  As a float it is wrong by less than 2^-14, and 2^-13 less than it is
 * computed: so its floor is right or one too low. */
static void make_gray(ntp__block *restrict out, const ntp__block *restrict block, int32_t n,
                      int32_t m)
{
    const int32_t whole = NTP__LUMA_WHOLE * (m / 255), more = whole / 2, twice = 2 * whole;
    const float share = 1.0F / (float) twice;
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        int32_t sum = NTP__LUMA_RED * block->c[0][i] + NTP__LUMA_GREEN * block->c[1][i] +
                      NTP__LUMA_BLUE * block->c[2][i] + more;
        int32_t low = (int32_t) ((float) sum * share + (NTP__GRAY_BASE - 0x1p-13F));
        int32_t gray = low + (sum - (low - NTP__GRAY_BASE) * twice >= twice);
        out->c[0][i] = gray;
        out->c[1][i] = gray;
        out->c[2][i] = gray;
    }
}

/* The colors of the reference palette are the faults themselves. */
static void paint_reference(ntp__block *restrict out, const ntp__faults *restrict f, int32_t n)
{
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        const int32_t base = (f->xy[i] | f->length[i] | f->z[i]) == 0 ? out->c[0][i] : 0;
        out->c[0][i] = f->xy[i] | base;
        out->c[1][i] = f->length[i] | base;
        out->c[2][i] = f->z[i] | base;
    }
}

static void paint_safe(ntp__block *restrict out, const ntp__faults *restrict f, int32_t n)
{
    n = whole_groups(n);
    for (int32_t k = 0; k < 3; k++) {
        const int32_t of_xy = SAFE_XY[k], of_length = SAFE_LENGTH[k], of_z = SAFE_Z[k];
        for (int32_t i = 0; i < n; i++) {
            const int32_t xy = f->xy[i], length = f->length[i], z = f->z[i];
            const int32_t hue = z > 0 ? of_z : xy > 0 ? of_xy : of_length;
            const int32_t strength = z > 0 ? z : xy > 0 ? xy : length;
            const int32_t sum = hue * strength + NTP__STRONG / 2;
            const int32_t shown = (sum + 1 + (sum >> 8)) >> 8; /* sum / 255 below 65535 */
            out->c[k][i] = strength == 0 ? out->c[k][i] : shown;
        }
    }
}

static void paint(ntp__block *out, const ntp__faults *f, int32_t n, int32_t safe)
{
    (safe ? paint_safe : paint_reference)(out, f, n);
}

static void light(ntp__lit *restrict lit, const ntp__block *restrict block, int32_t n,
                  const ntp__lamp *restrict lamp)
{
    const float m = lamp->m, up = lamp->up, twice = lamp->twice, less = lamp->less;
    const float a = lamp->towards[0], b = lamp->towards[1], c = lamp->towards[2];
    const float d = lamp->half[0], f = lamp->half[1], g = lamp->half[2];
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        float x = 2.0F * (float) block->c[0][i] - m, y = (2.0F * (float) block->c[1][i] - m) * up;
        float z = twice * (float) block->c[2][i] - less;
        float over = 1.0F / sqrtf(x * x + y * y + z * z);
        float lambert = (x * a + y * b + z * c) * over, glint = (x * d + y * f + z * g) * over;
        glint = glint > 0 ? glint : 0.0F;
        for (int32_t k = 0; k < NTP__SQUARINGS; k++)
            glint = glint * glint;
        lit->glint[i] = lambert > 0 ? glint : 0.0F;
        lit->lambert[i] = lambert > 0 ? lambert : 0.0F;
        lit->doubt[i] = fabsf(lambert) < NTP__EDGE_OF_LIGHT;
    }
}

static void show(ntp__lit *restrict lit, int32_t *restrict level, int32_t n,
                 const ntp__lamp *restrict lamp, float own)
{
    const float ambient = lamp->ambient, diffuse = lamp->diffuse, specular = lamp->specular;
    const float off = lamp->off, more = lamp->off_by_glint, white = lamp->white;
    n = whole_groups(n);
    for (int32_t i = 0; i < n; i++) {
        float v = own * (ambient + diffuse * lit->lambert[i]) + specular * lit->glint[i];
        float root = sqrtf(v < white ? v : white), shown = root * 255.0F + 0.5F;
        int32_t whole = (int32_t) shown;
        float part = shown - (float) whole, gap = part < 0.5F ? part : 1.0F - part;
        level[i] = whole;
        lit->doubt[i] |= !(gap * root > off + more * lit->glint[i] + 0x1p-14F * root);
    }
}

static int32_t differ(int32_t *restrict greatest, int32_t *restrict most, const int32_t *restrict a,
                      const int32_t *restrict b, int32_t by_a, int32_t by_b, int32_t n)
{
    int32_t sum = 0, high = *most;
    for (int32_t i = 0; i < n; i++) {
        int32_t off = a[i] * by_a - b[i] * by_b;
        off = off < 0 ? -off : off;
        sum += off;
        high = off > high ? off : high;
        greatest[i] = off > greatest[i] ? off : greatest[i];
    }
    *most = high;
    return sum;
}

static uint64_t bins(int32_t *restrict bin, int32_t *restrict most, const int32_t *restrict angle,
                     int32_t n)
{
    enum { LOW = 65535 };
    int32_t high = *most, lows = 0, highs = 0; /* of 256 angles each is below 2^24 */
    for (int32_t i = 0; i < n; i++) {
        bin[i] = (angle[i] + 500) / 1000;
        high = angle[i] > high ? angle[i] : high;
        lows += angle[i] & LOW;
        highs += angle[i] >> 16;
    }
    *most = high;
    return (uint64_t) lows + (uint64_t) highs * (LOW + 1);
}

extern const ntp__picture_kernels CONCAT(ntp__picture_loops_, NTP_ISA);
const ntp__picture_kernels CONCAT(ntp__picture_loops_, NTP_ISA) = {
    any_fault, judge_pairs, judge_blues, make_gray, paint, light, show, differ, bins,
};
