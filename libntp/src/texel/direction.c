/* SPDX-License-Identifier: MIT */
/*
 * direction.c - texels as integer vectors, and integer vectors of any length as levels
 *
 * With M + 1 even, the level floor((M + 1 + M v / L) / 2) is (M + 1) / 2 + floor(M v / 2L).  A
 * double decides that floor unless the quotient lies within 2^-30 of an integer k, because its
 * error is below 2^16 * 12 * 2^-53.  Else M M v v and 4 k k L L are compared as integers.
 * Blocks of vectors go through a kernel first, which leaves only the few near a boundary to that.
 */
#include "texel/direction.h"
#include "texel/level.h"
#include "base/bignum.h"

#include <math.h>
#include <string.h>

void ntp__texel_vector(int32_t v[3], const ntp__block *block, int32_t i, int32_t m,
                       ntp_encoding encoding)
{
    int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
    if (encoding == NTP_ENCODING_XY)
        b = ntp__derive(&r, &g, m, false);
    v[0] = ntp__num(r, m);
    v[1] = ntp__num(g, m);
    v[2] = encoding == NTP_ENCODING_ZZERO ? b : ntp__num(b, m);
}

void ntp__pull_pairs(int32_t *r, int32_t *g, const int32_t *marks, int32_t n, int32_t m)
{
    const ntp__kernels_table *kernels = ntp__kernels(NTP__CPU_ALL);
    int32_t at[NTP__BLOCK], c[2][NTP__BLOCK], doubt[NTP__BLOCK];
    const int32_t count = kernels->find(at, marks, INT32_MIN, n);
    for (int32_t i = 0; i < count; i++) {
        c[0][i] = r[at[i]];
        c[1][i] = g[at[i]];
    }
    for (int32_t i = count; i % NTP__KERNEL_LANES != 0; i++)
        c[0][i] = c[1][i] = 0;
    kernels->pull(c[0], c[1], doubt, count, m);
    for (int32_t i = 0; i < count; i++) {
        if (doubt[i]) {
            ntp__pull(&r[at[i]], &g[at[i]], m);
        } else {
            r[at[i]] = c[0][i];
            g[at[i]] = c[1][i];
        }
    }
}

void ntp__block_vectors(ntp__vectors *v, const ntp__block *block, int32_t n, int32_t m,
                        ntp_encoding encoding)
{
    const ntp__kernels_table *kernels = ntp__kernels(NTP__CPU_ALL);
    const bool xy = encoding == NTP_ENCODING_XY;
    int32_t derived[NTP__BLOCK], pulled[2][NTP__BLOCK], any = 0;
    const int32_t *r = block->c[0], *g = block->c[1], *b = block->c[2];
    if (xy) {
        kernels->derive(derived, r, g, n, m, false);
        b = derived;
    }
    for (int32_t i = 0; xy && i < n; i++)
        any |= derived[i];
    if (any < 0) {
        memcpy(pulled[0], r, (size_t) n * sizeof r[0]);
        memcpy(pulled[1], g, (size_t) n * sizeof g[0]);
        ntp__pull_pairs(pulled[0], pulled[1], derived, n, m);
        r = pulled[0];
        g = pulled[1];
        kernels->derive(derived, r, g, n, m, false);
    }
    kernels->numerators(v, r, g, b, n, m, encoding == NTP_ENCODING_ZZERO, 1, 1);
}

uint64_t ntp__pull_directions(ntp__block *out, int32_t *doubt, const ntp__vectors *v, int32_t n,
                              int32_t m, bool zzero)
{
    uint64_t found = 0;
    for (int32_t i = 0; i < n; i++) {
        if (doubt[i] != NTP__OVERLONG)
            continue;
        int32_t *const r = &out->c[0][i], *const g = &out->c[1][i];
        ntp__pull_rounded(r, g, m);
        const int32_t b = ntp__derive(r, g, m, zzero);
        out->c[2][i] = !zzero && v->c[2][i] < 0 ? m - b : b;
        doubt[i] = 0;
        found++;
    }
    return found;
}

bool ntp__block_directions(ntp__block *out, int32_t *doubt, ntp__vectors *v, int32_t n, int32_t m,
                           ntp_encoding encoding, bool exact)
{
    bool zzero = encoding == NTP_ENCODING_ZZERO;
    int32_t kept[NTP__BLOCK];
    const size_t size = (size_t) n * sizeof kept[0];
    if (encoding == NTP_ENCODING_XY)
        memcpy(kept, out->c[2], size);
    const int32_t any =
        ntp__kernels(NTP__CPU_ALL)
            ->directions(out->c[0], out->c[1], out->c[2], doubt, v, n, m, zzero, exact);
    if (any & NTP__OVERLONG)
        ntp__pull_directions(out, doubt, v, n, m, zzero);
    if (encoding == NTP_ENCODING_XY)
        memcpy(out->c[2], kept, size);
    return any & NTP__IN_DOUBT;
}

static ntp__i128 magnitude(ntp__i128 a)
{
    return ntp__i128_negative(a) ? ntp__i128_negate(a) : a;
}

/* |a| as a wide number. */
static void wide_of(ntp__wide *w, ntp__i128 a)
{
    ntp__wide high, shifted;
    a = magnitude(a);
    ntp__wide_set(w, a.lo);
    ntp__wide_set(&high, a.hi);
    ntp__wide_shift(&shifted, &high, 64);
    ntp__wide_add(w, &shifted);
}

static void wide_square(ntp__wide *out, ntp__i128 a)
{
    ntp__wide w;
    wide_of(&w, a);
    ntp__wide_multiply(out, &w, &w);
}

/* The sign of M |v[i]| - 2k L. */
static int32_t compare_exactly(const ntp__i128 v[3], int32_t i, int32_t k, int32_t m)
{
    ntp__wide square, sum, factor, left, right;
    ntp__wide_set(&sum, 0);
    for (int32_t j = 0; j < 3; j++) {
        wide_square(&square, v[j]);
        ntp__wide_add(&sum, &square);
    }
    ntp__wide_set(&factor, 4 * (uint64_t) k * (uint64_t) k);
    ntp__wide_multiply(&right, &sum, &factor);
    wide_square(&square, v[i]);
    ntp__wide_set(&factor, (uint64_t) m * (uint64_t) m);
    ntp__wide_multiply(&left, &square, &factor);
    return ntp__wide_compare(&left, &right);
}

/* The nearest whole number to d, and the floor of the quotient that d is near to: is it sure? */
static bool floor_of(int32_t *nearest, int32_t *floor, double d)
{
    enum { LIFT = 65536 }; /* makes the quotient positive, so that a cast is a floor */
    *nearest = (int32_t) (d + LIFT + 0.5) - LIFT;
    const double away = d - *nearest;
    *floor = away < 0 ? *nearest - 1 : *nearest;
    return fabs(away) > 0x1p-30;
}

/* floor(M v[i] / 2L); d is an approximation of the quotient. */
static int32_t half_quotient(const ntp__i128 v[3], int32_t i, int32_t m, double d)
{
    int32_t nearest, floor;
    if (floor_of(&nearest, &floor, d))
        return floor;
    if (ntp__i128_is_zero(v[i]))
        return 0;
    int32_t sign = compare_exactly(v, i, nearest, m);
    if (ntp__i128_negative(v[i]))
        sign = -sign;
    return sign >= 0 ? nearest : nearest - 1;
}

/* Puts blue to red and green. */
static void add_blue(int32_t c[3], int32_t m, ntp_encoding encoding, bool down)
{
    int32_t b = ntp__derive(&c[0], &c[1], m, encoding == NTP_ENCODING_ZZERO);
    if (encoding != NTP_ENCODING_XY)
        c[2] = encoding != NTP_ENCODING_ZZERO && down ? m - b : b;
}

void ntp__direction_levels(int32_t c[3], const ntp__i128 v[3], int32_t m, ntp_encoding encoding)
{
    double x = ntp__i128_to_double(v[0]), y = ntp__i128_to_double(v[1]);
    double z = ntp__i128_to_double(v[2]), length2 = x * x + y * y + z * z;
    c[0] = c[1] = (m + 1) / 2;
    if (length2 > 0) {
        double half = 0.5 * m / sqrt(length2);
        c[0] += half_quotient(v, 0, m, x * half);
        c[1] += half_quotient(v, 1, m, y * half);
    }
    add_blue(c, m, encoding, ntp__i128_negative(v[2]));
}

bool ntp__direction_decided(int32_t c[3], const double v[3], int32_t m, ntp_encoding encoding)
{
    const double half = 0.5 * m / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(half < m)) /* no length */
        return false;
    for (int32_t k = 0; k < 2; k++) {
        int32_t nearest, floor;
        if (!floor_of(&nearest, &floor, v[k] * half) && v[k] != 0)
            return false;
        c[k] = (m + 1) / 2 + floor;
    }
    add_blue(c, m, encoding, v[2] < 0);
    return true;
}

static uint64_t beyond(ntp__i128 a, int32_t bits)
{
    return bits < 64 ? a.hi | a.lo >> bits : a.hi >> (bits - 64);
}

void ntp__i128_shorten(ntp__i128 v[3], int32_t bits)
{
    ntp__i128 all = { 0, 0 };
    for (int32_t k = 0; k < 3; k++) {
        all.lo |= magnitude(v[k]).lo;
        all.hi |= magnitude(v[k]).hi;
    }
    int32_t drop = 0;
    for (; beyond(all, bits); drop++) {
        all.lo = all.lo >> 1 | all.hi << 63;
        all.hi >>= 1;
    }
    for (int32_t k = 0; drop > 0 && k < 3; k++) {
        ntp__i128 a = magnitude(v[k]);
        a.lo = drop < 64 ? a.lo >> drop | a.hi << (64 - drop) : a.hi >> (drop - 64);
        a.hi = drop < 64 ? a.hi >> drop : 0;
        v[k] = ntp__i128_negative(v[k]) ? ntp__i128_negate(a) : a;
    }
}

int32_t ntp__i128_ratio(ntp__i128 a, ntp__i128 b, int32_t max)
{
    double guess = ntp__i128_to_double(a) / ntp__i128_to_double(b) + 0.5;
    int32_t q = guess > 0 ? guess < max ? (int32_t) guess : max : 0;
    /* (2q - 1) b <= 2a < (2q + 1) b; the guess is off by one at most. */
    ntp__i128 twice = ntp__i128_add(a, a);
    if (q > 0 && ntp__i128_negative(ntp__i128_subtract(twice, ntp__i128_multiply(b, 2 * q - 1))))
        q--;
    else if (q < max &&
             !ntp__i128_negative(ntp__i128_subtract(twice, ntp__i128_multiply(b, 2 * q + 1))))
        q++;
    return q;
}

void ntp__store_levels(const ntp_image *view, const ntp__block *block, int32_t x, int32_t y,
                       int32_t n)
{
    if (view->type != NTP_TYPE_F32) {
        ntp__pack(view, block, x, y, n, view->channels);
        return;
    }
    ntp__float_planes planes;
    for (int32_t k = 0; k < view->channels; k++)
        ntp__floats_of_levels(planes[k], block->c[k], n, 65535,
                              view->encoding == NTP_ENCODING_VECTOR && k < 3);
    ntp__pack_floats(view, planes, x, y, n);
}

bool ntp__strength_of(ntp__strength *out, double strength)
{
    if (!(strength >= -NTP_MAX_STRENGTH && strength <= NTP_MAX_STRENGTH))
        return false;
    double s = strength < 0 ? -strength : strength;
    int32_t shift = 0;
    while (shift < 62 && s != (double) (int64_t) s) {
        s *= 2;
        shift++;
    }
    int64_t numerator = (int64_t) (s + 0.5);
    out->numerator = strength < 0 ? -numerator : numerator;
    out->shift = shift;
    return true;
}
