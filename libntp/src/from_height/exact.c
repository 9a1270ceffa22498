/* SPDX-License-Identifier: MIT */
/*
 * exact.c - one texel of heightfield -> normals, rounded exactly
 *
 * The vector (a, b, N) with a = c D, b = d E is made of integers times powers of two.  With L as
 * its length, the sign of
 *     (w^2 - u^2) a^2  -  u^2 b^2  -  u^2 N^2
 * tells whether |a| / L is at least u / w, and the sign of
 *     (w^2 - u^2) a^2  -  u^2 b^2  -  w^2 min_z^2 a^2
 * tells whether |a| sqrt(1 - min_z^2) / |(a, b)| is at least u / w.  The component is the lesser of
 * the two, so it is at least u / w when both are.  A double finds the one boundary u / w that
 * matters.  base/bignum.h has the arithmetic.
 */
#include "from_height/gradient.h"

#include <math.h>
#include <string.h>

/* Doubles below are off by less than 2^-48 of their value.  Four times that counts as doubt. */
static const double doubt = 0x1p-46;

/* A tap sum: an integer times a power of two. */
typedef struct tap_total {
    ntp__scaled value;
    bool finite;
} tap_total;

/* The three parts of the vector: magnitudes as integers times powers of two. */
typedef struct vector {
    ntp__wide part[3];
    int32_t exponent[3];
    bool negative[3];
    double near[3]; /* the magnitudes, scaled by one power of two so that the greatest is near 1 */
} vector;

ntp__scaled ntp__scaled_from(double v)
{
    ntp__scaled s = { 0, 0, v < 0 };
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    int32_t field = (int32_t) (bits >> 52 & 0x7ff);
    s.mantissa = bits & 0xfffffffffffffu;
    if (field > 0)
        s.mantissa |= (uint64_t) 1 << 52;
    s.exponent = (field > 0 ? field : 1) - 1075;
    if (s.mantissa == 0)
        s.exponent = 0;
    for (; s.mantissa != 0 && s.mantissa % 2 == 0; s.mantissa /= 2)
        s.exponent++;
    return s;
}

/* ------------------------------------------------------------------------- tap sums */

/* The sum of float heights as multiples of 2^-149, or of 2^-447 for products of three. */
typedef struct collector {
    ntp__wide plus, minus;
} collector;

/* The magnitude of a float as a multiple of 2^-149; returns whether the float is negative.  The
 * next function does so for 1 - v. */
static bool fixed_point(ntp__wide *out, float v)
{
    ntp__scaled s = ntp__scaled_from((double) v);
    ntp__wide mantissa;
    ntp__wide_set(&mantissa, s.mantissa);
    ntp__wide_shift(out, &mantissa, s.mantissa == 0 ? 0 : s.exponent + 149);
    return s.negative;
}

static bool one_minus(ntp__wide *out, float v)
{
    ntp__wide one, unit;
    bool negative = fixed_point(out, v);
    ntp__wide_set(&unit, 1);
    ntp__wide_shift(&one, &unit, 149);
    if (negative) {
        ntp__wide_add(out, &one);
        return false;
    }
    if (ntp__wide_compare(out, &one) > 0) {
        ntp__wide_subtract(out, &one);
        return true;
    }
    ntp__wide_subtract(&one, out);
    ntp__wide_copy(out, &one);
    return false;
}

static void collect(collector *c, const ntp__wide *magnitude, bool negative, int32_t weight)
{
    ntp__wide w, product;
    ntp__wide_set(&w, (uint64_t) (weight < 0 ? -weight : weight));
    ntp__wide_multiply(&product, magnitude, &w);
    ntp__wide_add(negative != (weight < 0) ? &c->minus : &c->plus, &product);
}

static const float *float_samples(const ntp__gradient *g, int32_t x, int32_t y)
{
    return (const float *) ntp__at(g->src, x, y);
}

/* Adds weight * height at a texel; false where a sample of it is not finite. */
static bool collect_height(collector *c, const ntp__gradient *g, int32_t x, int32_t y,
                           int32_t weight)
{
    const float *s = float_samples(g, x, y);
    for (int32_t k = 0; k < g->reads; k++) {
        if (!(s[g->read[k]] - s[g->read[k]] == 0.0f))
            return false;
    }
    ntp__wide a, b, product;
    if (g->source == NTP_HEIGHT_SOURCE_SCREEN) {
        /* The 1 of 1 - (1-r)(1-g)(1-b) drops out: taps add up to 0. */
        bool negative = one_minus(&a, s[g->read[0]]) != one_minus(&b, s[g->read[1]]);
        ntp__wide_multiply(&product, &a, &b);
        negative = negative != one_minus(&b, s[g->read[2]]);
        ntp__wide_multiply(&a, &product, &b);
        collect(c, &a, !negative, weight);
    } else if (g->source == NTP_HEIGHT_SOURCE_MAX || g->source == NTP_HEIGHT_SOURCE_MIN) {
        bool negative = fixed_point(&a, (float) ntp__height_value(g, x, y));
        collect(c, &a, negative, weight);
    } else {
        for (int32_t k = 0; k < g->reads; k++) {
            bool negative = fixed_point(&a, s[g->read[k]]);
            collect(c, &a, negative, weight * g->weight[k]);
        }
    }
    return true;
}

static tap_total integer_total(int64_t sum)
{
    tap_total total = { { (uint64_t) (sum < 0 ? -sum : sum), 0, sum < 0 }, true };
    return total;
}

/* The tap sum of the slope to the right, or down, from where repeat-slope takes it. */
static tap_total tap_sum(const ntp__gradient *g, int32_t x, int32_t y, bool down)
{
    int32_t radius = g->kernel->radius;
    int64_t total = 0;
    collector c = { { 0, { 0 } }, { 0, { 0 } } };
    tap_total result = { { 0, 0, false }, true };
    bool floats = g->src->type == NTP_TYPE_F32;
    x = ntp__clamp(x, down ? g->down_x : g->right_x);
    y = ntp__clamp(y, down ? g->down_y : g->right_y);
    for (int32_t j = -radius; j <= radius; j++) {
        ntp__mapped row = ntp__border_map(g->border_y, y + j, g->src->height);
        for (int32_t i = -radius; i <= radius; i++) {
            int32_t a = NTP__MAX_RADIUS + (down ? j : i), b = NTP__MAX_RADIUS + (down ? i : j);
            const ntp__taps *t = g->kernel->term;
            int32_t w = t[0].along[a] * t[0].across[b] + t[1].along[a] * t[1].across[b];
            if (w == 0)
                continue;
            ntp__mapped column = ntp__border_map(g->border_x, x + i, g->src->width);
            for (int32_t k = 0; k < row.count * column.count; k++) {
                int32_t p = k % column.count, q = k / column.count;
                int32_t weight = w * column.weight[p] * row.weight[q];
                if (!floats)
                    total += weight * ntp__height_integer(g, column.index[p], row.index[q]);
                else if (!collect_height(&c, g, column.index[p], row.index[q], weight))
                    result.finite = false;
            }
        }
    }
    if (!floats)
        return integer_total(total);
    if (result.finite) {
        bool negative = ntp__wide_compare(&c.plus, &c.minus) < 0;
        ntp__wide *greater = negative ? &c.minus : &c.plus;
        ntp__wide_subtract(greater, negative ? &c.plus : &c.minus);
        int32_t unit = g->source == NTP_HEIGHT_SOURCE_SCREEN ? -447 : -149;
        result.value = ntp__scaled_from(ntp__wide_to_double(greater, unit));
        result.value.negative = negative;
    }
    return result;
}

/* ------------------------------------------------------------------------ comparisons */

static void set_part(vector *v, int32_t i, ntp__scaled factor, ntp__scaled value)
{
    ntp__wide a, b;
    ntp__wide_set(&a, factor.mantissa);
    ntp__wide_set(&b, value.mantissa);
    ntp__wide_multiply(&v->part[i], &a, &b);
    v->exponent[i] = factor.exponent + value.exponent;
    v->negative[i] = factor.negative != value.negative;
}

static void set_near(vector *v)
{
    int32_t top = 0;
    bool any = false;
    for (int32_t i = 0; i < 3; i++) {
        int32_t t = ntp__wide_bits(&v->part[i]) + v->exponent[i];
        if (v->part[i].n > 0 && (!any || t > top)) {
            top = t;
            any = true;
        }
    }
    for (int32_t i = 0; i < 3; i++)
        v->near[i] = ntp__wide_to_double(&v->part[i], v->exponent[i] - top);
}

static void square(ntp__wide *out, const ntp__wide *a)
{
    ntp__wide_multiply(out, a, a);
}

/* a^2 - b^2, whose factors are half as long as the squares. */
static void difference_of_squares(ntp__wide *out, const ntp__wide *a, const ntp__wide *b)
{
    ntp__wide sum, rest;
    ntp__wide_copy(&sum, a);
    ntp__wide_add(&sum, b);
    ntp__wide_copy(&rest, a);
    ntp__wide_subtract(&rest, b);
    ntp__wide_multiply(out, &sum, &rest);
}

/* The sign of part[i] / length - u / w, u <= w. */
static int32_t compare_unit(const vector *v, int32_t i, const ntp__wide *u, const ntp__wide *w)
{
    int32_t a = i, b = (i + 1) % 3, c = (i + 2) % 3;
    ntp__wide sq, u2, x, y, z;
    square(&u2, u);
    difference_of_squares(&z, w, u);
    square(&sq, &v->part[a]);
    ntp__wide_multiply(&x, &z, &sq);
    square(&sq, &v->part[b]);
    ntp__wide_multiply(&y, &u2, &sq);
    square(&sq, &v->part[c]);
    ntp__wide_multiply(&z, &u2, &sq);
    return ntp__wide_sign(&x, 2 * v->exponent[a], &y, 2 * v->exponent[b], &z, 2 * v->exponent[c]);
}

/* The sign of part[i] sqrt(1 - min_z^2) / |(part[0], part[1])| - u / w, i = 0 or 1. */
static int32_t compare_shortened(const vector *v, int32_t i, const ntp__wide *u, const ntp__wide *w,
                                 ntp__scaled min_z)
{
    int32_t a = i, b = 1 - i;
    ntp__wide sq, x, y, z, sum, rest, zz;
    difference_of_squares(&z, w, u);
    square(&sq, &v->part[a]);
    ntp__wide_multiply(&x, &z, &sq);
    ntp__wide_set(&zz, min_z.mantissa);
    ntp__wide_multiply(&sum, w, &zz);
    ntp__wide_multiply(&rest, &sum, &v->part[a]);
    square(&z, &rest);
    square(&rest, u);
    square(&sq, &v->part[b]);
    ntp__wide_multiply(&y, &rest, &sq);
    return ntp__wide_sign(&x, 2 * v->exponent[a], &y, 2 * v->exponent[b], &z,
                          2 * (min_z.exponent + v->exponent[a]));
}

/* The sign of the magnitude of component i of the normal minus u / w. */
static int32_t compare(const ntp__gradient *g, const vector *v, int32_t i, const ntp__wide *u,
                       const ntp__wide *w)
{
    int32_t sign = compare_unit(v, i, u, w);
    if (i < 2 && g->min_z > 0 && sign >= 0) {
        int32_t other = compare_shortened(v, i, u, w, g->min_z_exact);
        sign = other < sign ? other : sign;
    }
    return sign;
}

/* The magnitude of component i as a double, off by less than 2^-48 of it. */
static double near_component(const ntp__gradient *g, const vector *v, int32_t i)
{
    double xy2 = v->near[0] * v->near[0] + v->near[1] * v->near[1];
    double n = v->near[i] / sqrt(xy2 + v->near[2] * v->near[2]);
    if (i < 2 && g->min_z > 0 && xy2 > 0) {
        double other = v->near[i] * (g->shortened / sqrt(xy2));
        return other < n ? other : n;
    }
    return n;
}

/* ---------------------------------------------------------------------------- rounding */

/* floor((M + 1)/2 + M n/2) for a component n of the given sign. */
static int32_t signed_level(ntp__normal *normal, const ntp__gradient *g, const vector *v, int32_t i)
{
    int32_t zero = (g->m + 1) / 2;
    double half = near_component(g, v, i) * g->m / 2;
    int32_t k = (int32_t) (half + 0.5);
    if (v->part[i].n == 0 || (i < 2 && g->min_z == 1))
        return zero;
    if (k == 0)
        return v->negative[i] ? zero - 1 : zero;
    double over = half - k;
    int32_t sign = over > 0 ? 1 : -1;
    if (fabs(over) < half * doubt) {
        ntp__wide u, w;
        ntp__wide_set(&u, 2 * (uint64_t) k);
        ntp__wide_set(&w, (uint64_t) g->m);
        sign = compare(g, v, i, &u, &w);
        normal->wide = true;
    }
    if (v->negative[i])
        return zero - k - (sign > 0);
    return zero + k - (sign < 0);
}

/* floor(M z + 1/2) for z = part[2] / length. */
static int32_t zzero_level(ntp__normal *normal, const ntp__gradient *g, const vector *v)
{
    double full = near_component(g, v, 2) * g->m + 0.5;
    int32_t k = (int32_t) (full + 0.5);
    double over = full - k;
    int32_t sign = over > 0 ? 1 : -1;
    if (k == 0)
        return 0;
    if (fabs(over) < full * doubt) {
        ntp__wide u, w;
        ntp__wide_set(&u, 2 * (uint64_t) k - 1);
        ntp__wide_set(&w, 2 * (uint64_t) g->m);
        sign = compare(g, v, 2, &u, &w);
        normal->wide = true;
    }
    return k - (sign < 0);
}

int32_t ntp__gradient_z_level(double z, int32_t m, bool zzero)
{
    /* The level is the greatest k with 2 k - 1 <= 2 M z (Z-zero) or 2 k - M - 1 <= M z. */
    ntp__scaled s = ntp__scaled_from(z);
    ntp__wide mantissa, factor, left, right, none;
    ntp__wide_set(&mantissa, s.mantissa);
    ntp__wide_set(&factor, (uint64_t) (zzero ? 2 * m : m));
    ntp__wide_multiply(&left, &mantissa, &factor);
    ntp__wide_set(&none, 0);
    int32_t low = zzero ? 0 : (m + 1) / 2, high = m;
    while (low < high) {
        int32_t k = (low + high + 1) / 2;
        ntp__wide_set(&right, (uint64_t) (zzero ? 2 * k - 1 : 2 * k - m - 1));
        if (ntp__wide_sign(&left, s.exponent, &right, 0, &none, 0) >= 0)
            low = k;
        else
            high = k - 1;
    }
    return low;
}

/* The sign of n - t, or if unit of (n + 1)/2 - t, for component i, n = -|n| if negative.  t is a
 * double of at most 26 bits above 2^-150, |t| <= 1. */
static int32_t compare_float(const ntp__gradient *g, const vector *v, int32_t i, double t,
                             bool unit)
{
    ntp__scaled s = ntp__scaled_from(t);
    ntp__wide u, w, one, mantissa;
    bool negative = s.negative;
    ntp__wide_set(&one, 1);
    ntp__wide_set(&mantissa, s.mantissa);
    int32_t places = s.exponent < 0 ? -s.exponent : 0;
    ntp__wide_shift(&w, &one, places);
    ntp__wide_shift(&u, &mantissa, s.exponent + places);
    if (unit) { /* 2 t - 1 */
        ntp__wide twice;
        ntp__wide_shift(&twice, &u, 1);
        negative = ntp__wide_compare(&twice, &w) < 0;
        ntp__wide_copy(&u, negative ? &w : &twice);
        ntp__wide_subtract(&u, negative ? &twice : &w);
    }
    bool zero = v->part[i].n == 0 || (i < 2 && g->min_z == 1);
    bool below = v->negative[i] && !zero;
    if (below != negative && (!zero || u.n > 0))
        return below ? -1 : 1;
    if (zero)
        return u.n == 0 ? 0 : -1;
    int32_t sign = compare(g, v, i, &u, &w);
    return negative ? -sign : sign;
}

/* (n + 1)/2; for a negative n, (1 - |n|)/2 without cancellation. */
static double near_unit(const ntp__gradient *g, const vector *v, int32_t i)
{
    double n = near_component(g, v, i);
    if (!v->negative[i] || n < 0.5)
        return (v->negative[i] ? 1.0 - n : 1.0 + n) / 2;
    int32_t b = 1 - i;
    double rest = v->near[b] * v->near[b] + v->near[2] * v->near[2];
    double all = rest + v->near[i] * v->near[i];
    double flat = v->near[0] * v->near[0] + v->near[1] * v->near[1];
    /* 1 - n^2 by the one of the two bounds that holds. */
    double left = rest / all;
    if (g->min_z > 0) {
        double z2 = g->min_z * g->min_z;
        double other = (v->near[b] * v->near[b] + z2 * v->near[i] * v->near[i]) / flat;
        left = other > left ? other : left;
    }
    return left / (1.0 + n) / 2;
}

/* A component, or (n + 1)/2, as the nearest float, ties to even. */
static float nearest_float(ntp__normal *normal, const ntp__gradient *g, const vector *v, int32_t i,
                           bool unit)
{
    double near = unit ? near_unit(g, v, i) : near_component(g, v, i);
    if (!unit && v->negative[i])
        near = -near;
    float low = (float) (near * (1 - doubt)), high = (float) (near * (1 + doubt));
    if (low == high)
        return low + 0.0f; /* never -0 */
    double middle = ((double) low + (double) high) / 2;
    int32_t sign = compare_float(g, v, i, middle, unit);
    normal->wide = true;
    float nearest = sign == 0 ? (float) middle : (sign > 0) == (high > low) ? high : low;
    return nearest + 0.0f;
}

static double times(ntp__scaled a, ntp__scaled b)
{
    ntp__wide x, y, product;
    ntp__wide_set(&x, a.mantissa);
    ntp__wide_set(&y, b.mantissa);
    ntp__wide_multiply(&product, &x, &y);
    double size = ntp__wide_to_double(&product, a.exponent + b.exponent);
    return a.negative != b.negative ? -size : size;
}

bool ntp__gradient_slopes(const ntp__gradient *g, int32_t x, int32_t y, double xy[2])
{
    tap_total right = tap_sum(g, x, y, false), down = tap_sum(g, x, y, true);
    double norm = (double) ((int64_t) g->kernel->denominator * g->range);
    bool finite = right.finite && down.finite;
    xy[0] = finite ? times(g->x, right.value) / norm : 0;
    xy[1] = finite ? times(g->y, down.value) / norm : 0;
    return finite;
}

void ntp__gradient_exact(ntp__normal *normal, const ntp__gradient *g, int32_t x, int32_t y,
                         const int64_t *sums)
{
    tap_total right = sums != NULL ? integer_total(sums[0]) : tap_sum(g, x, y, false);
    tap_total down = sums != NULL ? integer_total(sums[1]) : tap_sum(g, x, y, true);
    ntp_encoding encoding = g->dst->encoding;
    ntp__scaled norm = { (uint64_t) g->kernel->denominator * (uint64_t) g->range, 0, false };
    ntp__scaled one = { 1, 0, false };
    vector v;
    normal->wide = false;
    normal->finite = right.finite && down.finite;
    if (!normal->finite)
        right.value.mantissa = down.value.mantissa = 0;
    set_part(&v, 0, g->x, right.value);
    set_part(&v, 1, g->y, down.value);
    set_part(&v, 2, norm, one);
    set_near(&v);
    if (g->dst->type != NTP_TYPE_F32) {
        normal->level[0] = signed_level(normal, g, &v, 0);
        normal->level[1] = signed_level(normal, g, &v, 1);
        if (g->derived || encoding == NTP_ENCODING_XY)
            return;
        int32_t z = encoding == NTP_ENCODING_ZZERO ? zzero_level(normal, g, &v)
                                                   : signed_level(normal, g, &v, 2);
        normal->level[2] = z > g->min_z_level ? z : g->min_z_level;
        return;
    }
    bool unit = encoding != NTP_ENCODING_VECTOR;
    normal->value[0] = nearest_float(normal, g, &v, 0, unit);
    normal->value[1] = nearest_float(normal, g, &v, 1, unit);
    float z = nearest_float(normal, g, &v, 2, unit && encoding != NTP_ENCODING_ZZERO);
    double least = unit && encoding != NTP_ENCODING_ZZERO ? (g->min_z + 1) / 2 : g->min_z;
    normal->value[2] = z > (float) least ? z : (float) least;
}
