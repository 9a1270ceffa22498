/* SPDX-License-Identifier: MIT */
/*
 * shade.c - a lit plane: Lambert and Blinn-Phong, the viewer straight above
 *
 * The bytes are the same everywhere: everything is in doubles with + - * / and sqrt only, in a
 * fixed order, and the build allows no fused multiply-add.  Sums of three are taken from left to
 * right.
 */
#include "texel/level.h"
#include "picture/picture.h"

#include <math.h>

enum {
    SQUARINGS = 5, /* specular exponent 2^5 = 32 */
    /* Texels without a normal show a checker, as image editors show what is transparent. */
    CHECKER_SIDE = 8,
    CHECKER_DARK = 72,
    CHECKER_LIGHT = 88
};

/* From the upper left; a flat texel comes out as 165, a little lighter than the middle. */
static const ntp_light DEFAULT_LIGHT = {
    .direction = { -1.0, 1.0, 1.2 },
    .ambient = 0.1,
    .diffuse = 0.9,
    .specular = 0.2,
    .color = { 0.6, 0.6, 0.6 },
};

/* Rec. 709 luminance weights, for linear light. */
static const double LUMINANCE[3] = { 0.2126, 0.7152, 0.0722 };

typedef struct job {
    const ntp_image *dst;
    const ntp_const_image *src;
    ntp_light light;
    double towards[3], half[3]; /* unit vectors: to the light, and halfway to the viewer */
} job;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* v / |v|; 0 if v is 0. */
static void to_unit(double unit[3], const double v[3])
{
    double length = sqrt(dot(v, v));
    for (int32_t k = 0; k < 3; k++)
        unit[k] = length > 0 ? v[k] / length : 0.0;
}

static bool is_fraction(double v)
{
    return v >= 0.0 && v <= 1.0;
}

static bool all_zero(const ntp_light *l)
{
    return l->direction[0] == 0 && l->direction[1] == 0 && l->direction[2] == 0 &&
           l->ambient == 0 && l->diffuse == 0 && l->specular == 0 && l->color[0] == 0 &&
           l->color[1] == 0 && l->color[2] == 0;
}

static ntp_status set_light(job *j, const ntp_light *light)
{
    j->light = light == NULL || all_zero(light) ? DEFAULT_LIGHT : *light;
    const ntp_light *l = &j->light;
    double greatest = 0, scaled[3];
    for (int32_t k = 0; k < 3; k++) {
        double size = l->direction[k] < 0 ? -l->direction[k] : l->direction[k];
        if (size - size != 0.0 || !is_fraction(l->color[k]))
            return NTP_ERR_ARGUMENT;
        greatest = size > greatest ? size : greatest;
    }
    if (greatest == 0 || !is_fraction(l->ambient) || !is_fraction(l->diffuse) ||
        !is_fraction(l->specular))
        return NTP_ERR_ARGUMENT;
    /* Scaled first, so that squares neither overflow nor vanish. */
    for (int32_t k = 0; k < 3; k++)
        scaled[k] = l->direction[k] / greatest;
    to_unit(j->towards, scaled);
    double sum[3] = { j->towards[0], j->towards[1], j->towards[2] + 1.0 };
    to_unit(j->half, sum);
    return NTP_OK;
}

/* The stored vector over its length, y up. */
static void decode(double n[3], const job *j, int32_t r, int32_t g, int32_t b)
{
    int32_t m = ntp__max(j->src->type);
    int32_t y = ntp__num(g, m);
    double v[3] = { ntp__num(r, m), j->src->y == NTP_Y_DOWN ? -y : y, 0.0 };
    if (j->src->encoding == NTP_ENCODING_XY) {
        int64_t rest = ntp__rest(r, g, m);
        v[2] = rest > 0 ? sqrt((double) rest) : 0.0;
    } else {
        v[2] = j->src->encoding == NTP_ENCODING_ZZERO ? b : ntp__num(b, m);
    }
    to_unit(n, v);
}

static uint8_t display(double linear)
{
    double v = linear < 1.0 ? linear : 1.0;
    return (uint8_t) (sqrt(v) * 255.0 + 0.5);
}

static void shade_texel(uint8_t rgb[3], const job *j, const double n[3])
{
    const ntp_light *l = &j->light;
    double lambert = dot(n, j->towards), glint = 0.0, linear[3];
    if (lambert > 0) {
        glint = dot(n, j->half);
        glint = glint > 0 ? glint : 0.0;
        for (int32_t i = 0; i < SQUARINGS; i++)
            glint = glint * glint;
    } else {
        lambert = 0.0;
    }
    for (int32_t k = 0; k < 3; k++)
        linear[k] = l->color[k] * (l->ambient + l->diffuse * lambert) + l->specular * glint;
    if (j->dst->channels == 1) {
        rgb[0] = display(dot(LUMINANCE, linear));
        return;
    }
    for (int32_t k = 0; k < 3; k++)
        rgb[k] = display(linear[k]);
}

static void shade_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block block;
    int32_t m = ntp__max(j->src->type);
    ntp__unpack(&block, j->src, x, y, n);
    uint8_t *d = ntp__at_mut(j->dst, x, y);
    for (int32_t i = 0; i < n; i++, d += j->dst->pixel_stride) {
        int32_t r = block.c[0][i], g = block.c[1][i], b = block.c[2][i];
        uint8_t rgb[3];
        if ((block.any_broken && block.broken[i]) || ntp__unused(r, g, b, block.c[3][i], m, 0)) {
            bool light = ((x + i) / CHECKER_SIDE + y / CHECKER_SIDE) % 2 == 0;
            rgb[0] = rgb[1] = rgb[2] = light ? CHECKER_LIGHT : CHECKER_DARK;
        } else {
            double normal[3];
            decode(normal, j, r, g, b);
            shade_texel(rgb, j, normal);
        }
        ntp__paint(d, j->dst->channels, rgb);
    }
}

ntp_status ntp_shade(const ntp_image *dst, const ntp_const_image *src, const ntp_light *light,
                     const ntp_rect *area)
{
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_painting(dst, src, 1));
    job j = { .dst = dst, .src = src };
    NTP__TRY(set_light(&j, light));
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            shade_run(&j, x, y, n);
        }
    }
    return NTP_OK;
}
