/* SPDX-License-Identifier: MIT */
/*
 * shade.c - a lit plane: Lambert and Blinn-Phong, the viewer straight above
 *
 * The bytes are the same everywhere: everything is in doubles with + - * / and sqrt only, in a
 * fixed order, and the build allows no fused multiply-add.  Sums of three are taken from left to
 * right.
 */
#include "texel/level.h"
#include "texel/unused.h"
#include "picture/picture.h"

#include <math.h>
#include <string.h>

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

/* A block of texels, as planes, so that compilers vectorize the loops. */
typedef struct planes {
    double n[3][NTP__BLOCK]; /* unit vectors, y up */
    double lambert[NTP__BLOCK], glint[NTP__BLOCK];
    int32_t level[3][NTP__BLOCK];
} planes;

/* The stored vectors over their lengths, y up. */
static void decode(planes *restrict p, const job *j, const ntp__block *restrict block, int32_t n)
{
    const double m = ntp__max(j->src->type), up = j->src->y == NTP_Y_DOWN ? -1.0 : 1.0;
    const bool zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    const bool xy = j->src->encoding == NTP_ENCODING_XY;
    const double twice = zzero ? 1.0 : 2.0, less = zzero ? 0.0 : m;
    for (int32_t i = 0; i < n; i++) {
        double x = 2 * block->c[0][i] - m, y = (2 * block->c[1][i] - m) * up;
        double z = twice * block->c[2][i] - less, rest = m * m - x * x - y * y;
        z = xy ? sqrt(rest > 0 ? rest : 0.0) : z;
        double length = sqrt(x * x + y * y + z * z);
        p->n[0][i] = x / length;
        p->n[1][i] = y / length;
        p->n[2][i] = z / length;
    }
}

static void reflect(planes *restrict p, const job *j, int32_t n)
{
    const double a = j->towards[0], b = j->towards[1], c = j->towards[2];
    const double d = j->half[0], e = j->half[1], f = j->half[2];
    for (int32_t i = 0; i < n; i++) {
        double x = p->n[0][i], y = p->n[1][i], z = p->n[2][i];
        double lambert = x * a + y * b + z * c, glint = x * d + y * e + z * f;
        glint = glint > 0 ? glint : 0.0;
        for (int32_t k = 0; k < SQUARINGS; k++)
            glint = glint * glint;
        p->glint[i] = lambert > 0 ? glint : 0.0;
        p->lambert[i] = lambert > 0 ? lambert : 0.0;
    }
}

static inline double linear(const ntp_light *l, int32_t k, double lambert, double glint)
{
    return l->color[k] * (l->ambient + l->diffuse * lambert) + l->specular * glint;
}

static inline int32_t display(double linear)
{
    double v = linear < 1.0 ? linear : 1.0;
    return (int32_t) (sqrt(v) * 255.0 + 0.5);
}

static void color(planes *restrict p, const job *j, int32_t k, int32_t n)
{
    const ntp_light l = j->light;
    for (int32_t i = 0; i < n; i++)
        p->level[k][i] = display(linear(&l, k, p->lambert[i], p->glint[i]));
}

static void luminance(planes *restrict p, const job *j, int32_t n)
{
    const ntp_light l = j->light;
    for (int32_t i = 0; i < n; i++) {
        double rgb[3];
        for (int32_t k = 0; k < 3; k++)
            rgb[k] = linear(&l, k, p->lambert[i], p->glint[i]);
        p->level[0][i] = display(dot(LUMINANCE, rgb));
    }
}

static void shade_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block block;
    planes p;
    const int32_t m = ntp__max(j->src->type), channels = j->dst->channels;
    const double *light = j->light.color;
    ntp__unpack(&block, j->src, x, y, n);
    decode(&p, j, &block, n);
    reflect(&p, j, n);
    if (channels == 1)
        luminance(&p, j, n);
    for (int32_t k = 0; channels > 1 && k < 3; k++) {
        if (k > 0 && light[k] == light[k - 1])
            memcpy(p.level[k], p.level[k - 1], (size_t) n * sizeof p.level[k][0]);
        else
            color(&p, j, k, n);
    }
    const bool suspect = ntp__any_suspect(&block, n, m);
    uint8_t *d = ntp__at_mut(j->dst, x, y);
    for (int32_t i = 0; i < n; i++, d += j->dst->pixel_stride) {
        uint8_t rgb[3] = { (uint8_t) p.level[0][i], (uint8_t) p.level[1][i],
                           (uint8_t) p.level[2][i] };
        if (suspect && ntp__texel_unused(&block, i, m, 0)) {
            bool bright = ((x + i) / CHECKER_SIDE + y / CHECKER_SIDE) % 2 == 0;
            rgb[0] = rgb[1] = rgb[2] = bright ? CHECKER_LIGHT : CHECKER_DARK;
        }
        ntp__paint(d, channels, rgb);
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
