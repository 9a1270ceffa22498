/* SPDX-License-Identifier: MIT */
/*
 * test_stencil.c - the slopes of a heightfield and their adjoint, kernel by kernel, border by border
 *
 * <A x, y> = <x, A' y> for random x, y; and the operator against ntp_normals_from_height, which has
 * the same kernels and borders in other code: slopes of unit heights, one after another.
 */
#include "to_height/shared/slope_operator.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 14 };

static uint64_t state = 88172645463325252u;
static int failures;

static double random_unit(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double) (state >> 11) * 0x1p-53 - 0.5;
}

static void fail(const char *what, ntp_kernel kernel, int bx, int by, int w, int h, double off)
{
    printf("%s: %s, borders %d %d, %d x %d: %g\n", what, ntp_kernel_name(kernel), bx, by, w, h,
           off);
    failures++;
}

/* out = adjoint of slopes u (right) and v (down). */
static void adjoint(const ntp__stencil *s, double *out, const double *u, const double *v)
{
    ntp__line_terms terms;
    int32_t w = s->width;
    double mixed[MOST];
    memset(out, 0, sizeof(double) * (size_t) (w * s->height));
    for (int32_t y = 0; y < s->height; y++) {
        for (int32_t t = 0; t < 2 * s->terms; t++) {
            bool right = t < s->terms;
            int32_t k = right ? t : t - s->terms;
            ntp__line_column(&terms, right ? &s->across_y[k] : &s->along_y[k], y);
            memset(mixed, 0, sizeof mixed);
            for (int32_t j = 0; j < terms.count; j++) {
                for (int32_t x = 0; x < w; x++)
                    mixed[x] += terms.weight[j] * (right ? u : v)[terms.at[j] * w + x];
            }
            ntp__line_adjoint(right ? &s->along_x[k] : &s->across_x[k], out + y * w, mixed);
        }
    }
}

static void slopes(const ntp__stencil *s, const double *heights, double *u, double *v)
{
    double work[MOST];
    ntp__plane plane = { heights, NULL, s->width };
    for (int32_t y = 0; y < s->height; y++)
        ntp__stencil_slopes(s, u + y * s->width, v + y * s->width, work, &plane, y);
}

static void check_adjoint(const ntp__stencil *s, ntp_kernel kernel, int bx, int by)
{
    double x[MOST * MOST], u[MOST * MOST], v[MOST * MOST], au[MOST * MOST], av[MOST * MOST],
        back[MOST * MOST], left = 0, right = 0;
    int32_t n = s->width * s->height;
    for (int32_t i = 0; i < n; i++) {
        x[i] = random_unit();
        u[i] = random_unit();
        v[i] = random_unit();
    }
    slopes(s, x, au, av);
    adjoint(s, back, u, v);
    for (int32_t i = 0; i < n; i++) {
        left += au[i] * u[i] + av[i] * v[i];
        right += x[i] * back[i];
    }
    if (!(fabs(left - right) <= 1e-13 * n))
        fail("adjoint", kernel, bx, by, s->width, s->height, left - right);
}

/* Slopes of random heights by ntp_normals_from_height: -x/z and y/z of its float vectors. */
static void check_slopes(const ntp__stencil *s, ntp_kernel kernel, ntp_border bx, ntp_border by)
{
    float heights[MOST * MOST], normals[MOST * MOST * 3];
    double x[MOST * MOST], u[MOST * MOST], v[MOST * MOST], worst = 0;
    int32_t n = s->width * s->height;
    for (int32_t i = 0; i < n; i++)
        x[i] = heights[i] = (float) random_unit();
    ntp_normals_options how;
    memset(&how, 0, sizeof how);
    how.scale = 1;
    how.kernel = kernel;
    how.border_x = bx;
    how.border_y = by;
    ntp_image src = ntp_image_packed(heights, s->width, s->height, 1, NTP_TYPE_F32);
    ntp_image dst = ntp_image_packed(normals, s->width, s->height, 3, NTP_TYPE_F32);
    dst.encoding = NTP_ENCODING_VECTOR;
    ntp_const_image seen = ntp_image_as_const(&src);
    if (ntp_normals_from_height(&dst, &seen, &how, NULL, NULL) != NTP_OK)
        fail("normals", kernel, (int) bx, (int) by, s->width, s->height, 0);
    slopes(s, x, u, v);
    for (int32_t i = 0; i < n; i++) {
        const float *c = normals + 3 * i;
        worst = fmax(worst, fabs(u[i] + (double) c[0] / (double) c[2]));
        worst = fmax(worst, fabs(v[i] - (double) c[1] / (double) c[2]));
    }
    if (!(worst <= 1e-5))
        fail("slopes", kernel, (int) bx, (int) by, s->width, s->height, worst);
}

/* An area of heights, and what lies beyond it by the words of libntp.h, one step at a time: none of
 * the library's own borders. */
typedef struct field {
    const double *heights;
    int32_t width, height;
    ntp_border x, y;
} field;

static double height_at(const field *f, int32_t x, int32_t y)
{
    bool across = x < 0 || x >= f->width;
    if (!across && y >= 0 && y < f->height)
        return f->heights[y * f->width + x];
    int32_t n = across ? f->width : f->height, i = across ? x : y, edge = i < 0 ? 0 : n - 1;
    ntp_border border = n == 1 ? NTP_BORDER_CLAMP : across ? f->x : f->y;
    int32_t to = border == NTP_BORDER_WRAP     ? i < 0 ? i + n : i - n
                 : border == NTP_BORDER_MIRROR ? 2 * edge - i
                                               : edge;
    double there = across ? height_at(f, to, y) : height_at(f, x, to);
    if (border < NTP_BORDER_EXTRAPOLATE)
        return there;
    int32_t inner = i < 0 ? 1 : n - 2;
    double step = there - (across ? height_at(f, inner, y) : height_at(f, x, inner));
    return there + step * abs(i - edge);
}

/* Where repeat-slope takes the slope at i, whose taps are those of `taps` of all terms. */
static int32_t moved(const ntp__kernel *k, bool along, ntp_border border, int32_t i, int32_t n)
{
    int32_t before = 0, after = 0;
    for (int32_t at = -NTP__MAX_RADIUS; at <= NTP__MAX_RADIUS; at++) {
        for (int t = 0; t < k->terms; t++) {
            const ntp__taps *taps = &k->term[t];
            if ((along ? taps->along : taps->across)[at + NTP__MAX_RADIUS] != 0) {
                before = at < before ? at : before;
                after = at > after ? at : after;
            }
        }
    }
    if (border != NTP_BORDER_REPEAT_SLOPE || after - before >= n)
        return i;
    return i + before < 0 ? -before : i + after >= n ? n - 1 - after : i;
}

static double plain_slope(const field *f, const ntp__kernel *k, int32_t x, int32_t y, bool down)
{
    double sum = 0;
    x = moved(k, !down, f->x, x, f->width);
    y = moved(k, down, f->y, y, f->height);
    for (int t = 0; t < k->terms; t++) {
        for (int32_t i = -NTP__MAX_RADIUS; i <= NTP__MAX_RADIUS; i++) {
            for (int32_t j = -NTP__MAX_RADIUS; j <= NTP__MAX_RADIUS; j++) {
                int32_t tap = k->term[t].along[(down ? j : i) + NTP__MAX_RADIUS] *
                              k->term[t].across[(down ? i : j) + NTP__MAX_RADIUS];
                sum += tap == 0 ? 0 : tap * height_at(f, x + i, y + j);
            }
        }
    }
    return sum / k->denominator;
}

static void check_plainly(const ntp__stencil *s, ntp_kernel kernel, ntp_border bx, ntp_border by)
{
    double x[MOST * MOST], u[MOST * MOST], v[MOST * MOST], worst = 0;
    const ntp__kernel *k = &ntp__kernel_table[kernel];
    field f = { x, s->width, s->height, bx, by };
    for (int32_t i = 0; i < s->width * s->height; i++)
        x[i] = random_unit();
    slopes(s, x, u, v);
    for (int32_t i = 0; i < s->width * s->height; i++) {
        int32_t column = i % s->width, row = i / s->width;
        worst = fmax(worst, fabs(u[i] - plain_slope(&f, k, column, row, false)));
        worst = fmax(worst, fabs(v[i] - plain_slope(&f, k, column, row, true)));
    }
    if (!(worst <= 1e-12))
        fail("plainly", kernel, (int) bx, (int) by, s->width, s->height, worst);
}

int main(void)
{
    static const int32_t sizes[][2] = { { 1, 1 }, { 1, 5 },  { 6, 1 },  { 2, 3 },  { 4, 4 },
                                        { 5, 8 }, { 9, 10 }, { 14, 3 }, { 13, 14 } };
    ntp__stencil *s = malloc(sizeof *s);
    for (int k = 0; s != NULL && k < NTP__KERNELS; k++) {
        for (int b = 0; b < 25; b++) {
            for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
                ntp_kernel kernel = (ntp_kernel) k;
                ntp_border bx = (ntp_border) (b % 5), by = (ntp_border) (b / 5);
                ntp__stencil_init(s, kernel, bx, by, sizes[i][0], sizes[i][1], false);
                check_adjoint(s, kernel, b % 5, b / 5);
                check_slopes(s, kernel, bx, by);
                check_plainly(s, kernel, bx, by);
            }
        }
    }
    free(s);
    return failures != 0;
}
