/* SPDX-License-Identifier: MIT */
/*
 * evidence.c - what the texels say about levels and blue; compiled once for each instruction set
 */
#include "to_height/evidence.h"

#include "texel/level.h"
#include "texel/unused.h"

#ifndef NTP_ISA
#  define NTP_ISA base
#endif
#define JOIN_(a, b) a##b
#define JOIN(a, b)  JOIN_(a, b)

enum {
    ROWS = 256, /* rows that are looked at, spread over the picture */
    EACH = 4,   /* one texel in so many tells about flat ground */
    LANES = 4   /* sums side by side */
};

/* Loops of vectors go on to whole lanes.  What is there counts for nothing. */
static int32_t whole(int32_t n)
{
    return (n + 2 * LANES - 1) & -2 * LANES;
}

static void add_ground(evidence *e, const ntp__block *b, int32_t n)
{
    for (int32_t i = 0; i < n; i += EACH) {
        uint32_t x = (uint32_t) (b->c[0][i] - FIRST_AROUND);
        uint32_t y = (uint32_t) (b->c[1][i] - FIRST_AROUND);
        e->near[x < AROUND ? x : AROUND][y < AROUND ? y : AROUND]++;
        e->asked++;
    }
}

/* Is this the blue that is derived where x^2 + y^2 leave `rest`?  It takes no root. */
static bool is_derived(int64_t blue, int64_t rest, int32_t m, bool zzero)
{
    int64_t low = zzero ? 2 * blue - 1 : 2 * blue - m - 1, high = low + 2;
    int64_t scaled = zzero ? 4 * rest : rest;
    return low >= 0 && low * low <= scaled && scaled < high * high;
}

static void add_neutral(evidence *e, const ntp__block *b, int32_t n)
{
    int32_t level = 0, beside = 0, low = 0, high = 0;
    for (int32_t i = 0; i < whole(n); i++) {
        int32_t red = b->c[0][i];
        level += b->c[1][i] == 128;
        beside += (red == 126) + (red == 129);
        low += red == 127;
        high += red == 128;
    }
    e->level += level;
    e->beside += beside;
    e->pile[0] += low;
    e->pile[1] += high;
}

static void add_tilted(evidence *e, const ntp__block *b, const double *rest, int32_t m, bool zzero,
                       int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        if (rest[i] >= 0 && rest[i] < e->most_rest) {
            e->tilted++;
            e->derived += is_derived(b->c[2][i], (int64_t) rest[i], m, zzero);
        }
    }
}

/* Some encoders store 0 as -1. */
static void add_negative(evidence *e, const double *z, double unit, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        if (z[i] < -1) {
            e->negative++;
            e->negative2 += z[i] * z[i] * unit;
        }
    }
}

/* Sums of z^2 and 1 - x^2 - y^2.  Several sums of each run side by side, which compilers vectorize. */
static void add_squares(evidence *e, const double *z2, const double *rest, double unit, int32_t n)
{
    double off2[LANES] = { 0 }, longer[LANES] = { 0 }, one[LANES] = { 0 }, one2[LANES] = { 0 };
    double two[LANES] = { 0 }, two2[LANES] = { 0 }, both[LANES] = { 0 };
    for (int32_t i = 0; i < n; i += LANES) {
        for (int32_t k = 0; k < LANES; k++) {
            double off = z2[i + k] - rest[i + k], u = rest[i + k] * unit, v = z2[i + k] * unit;
            off2[k] += off * off;
            longer[k] += off > 0 ? off * off : 0;
            one[k] += u;
            one2[k] += u * u;
            two[k] += v;
            two2[k] += v * v;
            both[k] += u * v;
        }
    }
    for (int32_t k = 0; k < LANES; k++) {
        e->lengths += off2[k];
        e->longer += longer[k];
        e->rest += one[k];
        e->rest2 += one2[k];
        e->z2 += two[k];
        e->z4 += two2[k];
        e->both += both[k];
    }
}

/* What x, y and z tell together.  In units of a half level they are integers, which doubles hold,
 * and so are their squares.  The loops over single arrays are for the compiler to vectorize. */
static void add_lengths(evidence *e, const ntp__block *b, int32_t m, bool zzero, int32_t n)
{
    double z[NTP__BLOCK], z2[NTP__BLOCK], rest[NTP__BLOCK];
    double square = (double) m * m, unit = 1 / square;
    const double most_off = e->most_off, most_rest = e->most_rest;
    int32_t scale = zzero ? 1 : 2, zero = zzero ? 0 : m, negative = 0, tilted_some = 0;
    int32_t right_some = 0;
    for (int32_t i = 0; i < whole(n); i++) {
        double x = 2 * b->c[0][i] - m, y = 2 * b->c[1][i] - m;
        z[i] = scale * b->c[2][i] - zero;
        z2[i] = z[i] * z[i];
        rest[i] = square - x * x - y * y;
    }
    for (int32_t i = n; i < whole(n); i++)
        z2[i] = rest[i] = z[i] = 0;
    add_squares(e, z2, rest, unit, whole(n));
    for (int32_t i = n; i < whole(n); i++) /* neither right nor tilted */
        rest[i] = 4 * square;
    for (int32_t i = 0; i < whole(n); i++) {
        double off = z2[i] - rest[i];
        right_some += off * off < most_off;
        negative |= z[i] < -1;
        tilted_some |= rest[i] < most_rest;
    }
    e->right += right_some;
    e->all += n;
    if (negative)
        add_negative(e, z, unit, n);
    if (!tilted_some)
        return;
    add_tilted(e, b, rest, m, zzero, n);
    for (int32_t i = 0; i < n; i++)
        e->too_long += rest[i] < 0;
}

/* The errors of lengths by a rule. */
static void find_errors(double *restrict error, const rule *r, int32_t c[3][NTP__BLOCK], int32_t n)
{
    const double zero = r->zero, unit = r->unit;
    for (int32_t i = 0; i < whole(n); i++) {
        double x = (2 * c[0][i] - zero) * unit, y = (2 * c[1][i] - zero) * unit;
        double z = (2 * c[2][i] - zero) * unit;
        error[i] = (x * x + y * y + z * z - 1) / 2;
    }
}

static void compare(rule *r, int32_t c[3][NTP__BLOCK], const double *plain, int32_t n)
{
    double error[NTP__BLOCK];
    find_errors(error, r, c, n);
    for (int32_t i = 0; i < n; i++) {
        double e = error[i], gain = plain[i] * plain[i] - e * e;
        r->sum += e * e;
        r->gain += gain;
        r->gain2 += gain * gain;
    }
}

/* 0 or 1, and no branch. */
static int32_t is_flat(int32_t level)
{
    return (level == 127) | (level == 128);
}

/* How well each rule explains the lengths of 8-bit texels.  Neutral ones tell nothing, and there can be
 * many. */
static void add_rules(evidence *e, const ntp__block *b, int32_t n)
{
    int32_t c[3][NTP__BLOCK], count = 0;
    double plain[NTP__BLOCK];
    for (int32_t i = 0; i < n; i++) {
        int32_t red = b->c[0][i], green = b->c[1][i];
        uint8_t *votes = &e->votes[(green & VOTE_MASK) << VOTE_BITS | (red & VOTE_MASK)];
        if (*votes == MOST_VOTES || (is_flat(red) & is_flat(green)))
            continue;
        *votes += 1;
        c[0][count] = red;
        c[1][count] = green;
        c[2][count++] = b->c[2][i];
    }
    e->count += count;
    for (int32_t i = count; i < whole(count); i++)
        c[0][i] = c[1][i] = c[2][i] = 0;
    find_errors(plain, &e->unorm, c, count);
    for (int32_t i = 0; i < count; i++)
        e->unorm.sum += plain[i] * plain[i];
    compare(&e->trunc, c, plain, count);
    compare(&e->snorm, c, plain, count);
}

/* Keeps the texels that hold a normal; returns how many. */
static int32_t keep_used(ntp__block *b, int32_t n, int32_t m, uint32_t touch)
{
    int32_t kept = 0;
    if (!ntp__any_suspect(b, n, m))
        return n;
    for (int32_t i = 0; i < n; i++) {
        bool out = ntp__texel_unused(b, i, m, touch);
        for (int32_t c = 0; c < 3; c++)
            b->c[c][kept] = b->c[c][i];
        kept += !out;
    }
    return kept;
}

void JOIN(ntp__gather_evidence_, NTP_ISA)(evidence *e, const ntp_const_image *src, uint32_t touch,
                                          bool with_rules)
{
    ntp__block block;
    int32_t m = ntp__max(src->type), step = (src->height + ROWS - 1) / ROWS;
    bool zzero = src->encoding == NTP_ENCODING_ZZERO;
    for (int32_t y = 0; y < src->height; y += step) {
        for (int32_t x = 0; x < src->width; x += NTP__BLOCK) {
            int32_t n = src->width - x < NTP__BLOCK ? src->width - x : NTP__BLOCK;
            ntp__unpack(&block, src, x, y, n);
            n = keep_used(&block, n, m, touch);
            for (int32_t i = n; i < whole(n); i++)
                block.c[0][i] = block.c[1][i] = block.c[2][i] = 0;
            add_lengths(e, &block, m, zzero, n);
            if (with_rules) {
                add_neutral(e, &block, n);
                add_ground(e, &block, n);
            }
            if (with_rules && !zzero)
                add_rules(e, &block, n);
        }
    }
}
