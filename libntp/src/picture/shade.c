/* SPDX-License-Identifier: MIT */
/*
 * shade.c - a lit plane: Lambert and Blinn-Phong, the viewer straight above
 *
 * The bytes are the same everywhere: everything is in doubles with + - * / and sqrt only, in a
 * fixed order, and the build allows no fused multiply-add.  Sums of three are taken from left to
 * right.  Floats decide most levels; where they are near a boundary, doubles do.
 */
#include "base/cpu.h"
#include "texel/kernels.h"
#include "texel/level.h"
#include "texel/unused.h"
#include "picture/paint_avx2.h"
#include "picture/picture.h"
#include "picture/picture_kernels.h"

#include <math.h>
#include <string.h>

/* Texels without a normal show a checker, as image editors show what is transparent. */
static const uint8_t CHECKER[2] = { 88, 72 };

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
    ntp__lamp lamp;
#ifdef NTP_HAVE_AVX2
    ntp__shade_rgb *shade_rgb; /* of packed RGB; all colors reflect alike */
#endif
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
} planes;

/* The stored vectors over their lengths, y up. */
static void decode(planes *restrict p, const job *j, const ntp__block *restrict block, int32_t n)
{
    const double m = ntp__max(j->src->type), up = j->src->y == NTP_Y_DOWN ? -1.0 : 1.0;
    const bool zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    const bool xy = j->src->encoding == NTP_ENCODING_XY;
    const double twice = zzero ? 1.0 : 2.0, less = zzero ? 0.0 : m;
    for (int32_t i = 0; i < ntp__whole(n); i++) {
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
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        double x = p->n[0][i], y = p->n[1][i], z = p->n[2][i];
        double lambert = x * a + y * b + z * c, glint = x * d + y * e + z * f;
        glint = glint > 0 ? glint : 0.0;
        for (int32_t k = 0; k < NTP__SQUARINGS; k++)
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

static void color(int32_t *restrict level, const planes *restrict p, const job *j, int32_t k,
                  int32_t n)
{
    const ntp_light l = j->light;
    for (int32_t i = 0; i < ntp__whole(n); i++)
        level[i] = display(linear(&l, k, p->lambert[i], p->glint[i]));
}

static void luminance(int32_t *restrict level, const planes *restrict p, const job *j, int32_t n)
{
    const ntp_light l = j->light;
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        double rgb[3];
        for (int32_t k = 0; k < 3; k++)
            rgb[k] = linear(&l, k, p->lambert[i], p->glint[i]);
        level[i] = display(dot(LUMINANCE, rgb));
    }
}

/* The levels of a block, exactly. */
static void shade_exactly(ntp__block *out, const job *j, const ntp__block *block, int32_t n)
{
    planes p;
    const double *light = j->light.color;
    decode(&p, j, block, n);
    reflect(&p, j, n);
    if (j->dst->channels == 1)
        luminance(out->c[0], &p, j, n);
    for (int32_t k = 0; j->dst->channels > 1 && k < 3; k++) {
        if (k > 0 && light[k] == light[k - 1])
            memcpy(out->c[k], out->c[k - 1], (size_t) n * sizeof out->c[k][0]);
        else
            color(out->c[k], &p, j, k, n);
    }
}

/* Parts of 1/M in which z of XY is given to floats: as many as an integer has room for. */
static int32_t lift_of(const job *j)
{
    return j->src->type == NTP_TYPE_U8 ? 1 << 22 : 1 << 14;
}

static void lift_z(const job *j, ntp__block *block, int32_t n)
{
    const double m = ntp__max(j->src->type), lift = lift_of(j);
    for (int32_t i = 0; i < ntp__whole(n); i++) {
        const double x = 2 * block->c[0][i] - m, y = 2 * block->c[1][i] - m;
        const double rest = m * m - x * x - y * y;
        block->c[2][i] = (int32_t) (sqrt(rest > 0 ? rest : 0) * lift + 0.5);
    }
}

/*
 * The same in floats, whose roundings are off by up to u = 2^-24 of a result; squares of u are left out.
 * A square of a length is off by 3 u of itself, so 1 over the length is by 3.5 u.  The sum of products with
 * the light, or with the half vector, has 4 roundings, of numbers whose sizes add up to the length at most.
 * Its product with 1 over the length has one more.  z of XY, a root in whole 1/LIFT (lift_z), is off by 1.1 u of
 * itself as a float, which turns the vector by half of that at most.  So both cosines are off by 10 u.  The
 * power is off by 32 * 10 u of g^31, which is at most g^32 + 1/85, and by 31 u of itself: 360 u of itself and
 * 4 u.  All else rounds light up to 1 six times.  Where the light just touches a texel, it may be on the wrong
 * side.  A linear light v that is off by `off` has a root that is off by at most off / root(v); and by half of
 * that, and a 50th of it, where v is not below 16 off, as it is nowhere with enough ambient light.
 */
static ntp__lamp lamp_of(const job *j)
{
    const ntp_light *l = &j->light;
    const float m = (float) ntp__max(j->src->type);
    const bool zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    const bool xy = j->src->encoding == NTP_ENCODING_XY;
    ntp__lamp lamp = { .m = m,
                       .up = j->src->y == NTP_Y_DOWN ? -1.0F : 1.0F,
                       .twice = xy      ? 1 / (float) lift_of(j)
                                : zzero ? 1.0F
                                        : 2.0F,
                       .less = zzero || xy ? 0.0F : m,
                       .ambient = (float) l->ambient,
                       .diffuse = (float) l->diffuse,
                       .specular = (float) l->specular,
                       .white = 1 };
    for (int32_t k = 0; k < 3; k++) {
        lamp.towards[k] = (float) j->towards[k];
        lamp.half[k] = (float) j->half[k];
    }
    float least = 1;
    for (int32_t k = 0; k < 3; k++)
        least = (float) l->color[k] < least ? (float) l->color[k] : least;
    const float off = (8 + 10 * lamp.diffuse + 5 * lamp.specular) * 0x1p-24F;
    const float more = 360 * lamp.specular * 0x1p-24F;
    const float by = least * lamp.ambient > 17 * (off + more) ? 0.52F * 255.0F : 255.0F;
    lamp.off = off * by;
    lamp.off_by_glint = more * by;
    return lamp;
}

/* The levels of a block; those of texels in doubt once more, exactly. */
static void shade_block(ntp__block *out, const job *j, const ntp__block *block, int32_t n)
{
    const ntp__picture_kernels *loops = ntp__picture_loops();
    ntp__lit lit;
    ntp__block few, again;
    int32_t at[NTP__BLOCK];
    const double *light = j->light.color;
    loops->light(&lit, block, ntp__whole(n), &j->lamp);
    for (int32_t k = 0; k < 3; k++) {
        if (k > 0 && light[k] == light[k - 1])
            memcpy(out->c[k], out->c[k - 1], (size_t) n * sizeof out->c[k][0]);
        else
            loops->show(&lit, out->c[k], ntp__whole(n), &j->lamp, (float) light[k]);
    }
    const int32_t found = ntp__kernels(NTP__CPU_ALL)->find(at, lit.doubt, -1, n);
    for (int32_t i = 0; i < found; i++) {
        for (int32_t k = 0; k < 3; k++)
            few.c[k][i] = block->c[k][at[i]];
    }
    ntp__fill_group(&few, found);
    shade_exactly(&again, j, &few, found);
    for (int32_t i = 0; i < found; i++) {
        for (int32_t k = 0; k < 3; k++)
            out->c[k][at[i]] = again.c[k][i];
    }
}

static void shade_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block block, out;
    uint8_t unused[NTP__BLOCK];
    const int32_t m = ntp__max(j->src->type);
    ntp__unpack(&block, j->src, x, y, n);
    ntp__fill_group(&block, n);
    const bool suspect = ntp__any_suspect(&block, n, m);
    for (int32_t i = 0; i < n; i++)
        unused[i] = suspect && ntp__texel_unused(&block, i, m, 0);
    /* Where z is a difference of squares, floats are too coarse. */
    if (j->src->encoding == NTP_ENCODING_XY)
        lift_z(j, &block, n);
    if (j->dst->channels == 1)
        shade_exactly(&out, j, &block, n);
    else
        shade_block(&out, j, &block, n);
    for (int32_t i = 0; suspect && i < n; i++) {
        if (unused[i])
            out.c[0][i] = out.c[1][i] = out.c[2][i] = CHECKER[ntp__checker(x + i, y)];
    }
    ntp__pack_opaque(j->dst, &out, x, y, n);
}

#ifdef NTP_HAVE_AVX2
static int32_t shade_rgb(const void *how, uint8_t *dst, uint8_t odd[NTP__BLOCK / 8],
                         const void *src, int32_t n, bool deep)
{
    const job *j = how;
    return j->shade_rgb(dst, odd, src, n, deep, &j->lamp, (float) j->light.color[0]);
}

static void shade_odd(const void *how, ntp__block *out, const ntp__odd_texels *odd)
{
    shade_exactly(out, how, &odd->block, odd->n);
}

static bool shade_packed(job *j, const ntp_rect *rect)
{
    j->shade_rgb = ntp__shade_rgb_avx2;
#  ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        j->shade_rgb = ntp__shade_rgb_avx512;
#  endif
    const double *light = j->light.color;
    const ntp__painter painter = { .dst = j->dst,
                                   .src = j->src,
                                   .job = j,
                                   .unused = { { CHECKER[0], CHECKER[1] },
                                               { CHECKER[0], CHECKER[1] } },
                                   .paint = shade_rgb,
                                   .again = shade_odd };
    return light[0] == light[1] && light[1] == light[2] && ntp__paint_packed(&painter, rect);
}
#else
static bool shade_packed(job *j, const ntp_rect *rect)
{
    (void) j, (void) rect;
    return false;
}
#endif

ntp_status ntp_shade(const ntp_image *dst, const ntp_const_image *src, const ntp_light *light,
                     const ntp_rect *area)
{
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_painting(dst, src, 1));
    job j = { .dst = dst, .src = src };
    NTP__TRY(set_light(&j, light));
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    j.lamp = lamp_of(&j);
    if (shade_packed(&j, &rect))
        return NTP_OK;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            shade_run(&j, x, y, n);
        }
    }
    return NTP_OK;
}
