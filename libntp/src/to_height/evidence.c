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
    }
    e->asked += (n + EACH - 1) / EACH;
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

/* Which tilted texels have the blue that is derived where x^2 + y^2 leave `rest`?  It takes no root, and all
 * numbers are integers below 2^53. */
static void add_tilted(evidence *e, const double *z, const double *rest, bool zzero, int32_t n)
{
    const double scale = zzero ? 2 : 1;
    int32_t tilted = 0, derived = 0, too_long = 0;
    for (int32_t i = 0; i < n; i++) {
        double v = rest[i], low = z[i] * scale - 1, high = low + 2;
        if (!(v < e->most_rest))
            continue;
        too_long += v < 0;
        tilted += v >= 0;
        v *= scale * scale;
        derived += (low >= 0) & (low * low <= v) & (v < high * high);
    }
    e->tilted += tilted;
    e->derived += derived;
    e->too_long += too_long;
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

/* Sums of z^2 and 1 - x^2 - y^2.  Several sums of each run side by side, which compilers vectorize.  Returns
 * how many texels are negative or tilted. */
static double add_squares(evidence *e, const double *z, const double *rest, double unit, int32_t n)
{
    double off2[LANES] = { 0 }, longer[LANES] = { 0 }, one[LANES] = { 0 }, one2[LANES] = { 0 };
    double two[LANES] = { 0 }, two2[LANES] = { 0 }, both[LANES] = { 0 }, right[LANES] = { 0 };
    double special[LANES] = { 0 };
    const double most_off = e->most_off, most_rest = e->most_rest;
    for (int32_t i = 0; i < n; i += LANES) {
        for (int32_t k = 0; k < LANES; k++) {
            double w = z[i + k], z2 = w * w, r = rest[i + k];
            double off = z2 - r, off_2 = off * off, u = r * unit, v = z2 * unit;
            off2[k] += off_2;
            longer[k] += off > 0 ? off_2 : 0;
            right[k] += off_2 < most_off ? 1 : 0;
            one[k] += u;
            one2[k] += u * u;
            two[k] += v;
            two2[k] += v * v;
            both[k] += u * v;
            special[k] += w < -1 ? 1 : r < most_rest ? 1 : 0;
        }
    }
    for (int32_t k = 0; k < LANES; k++) {
        e->lengths += off2[k];
        e->longer += longer[k];
        e->right += right[k];
        e->rest += one[k];
        e->rest2 += one2[k];
        e->z2 += two[k];
        e->z4 += two2[k];
        e->both += both[k];
    }
    return special[0] + special[1] + special[2] + special[3];
}

/* What x, y and z tell together.  In units of a half level they are integers, which doubles hold,
 * and so are their squares.  The loops over single arrays are for the compiler to vectorize. */
static void add_lengths(evidence *e, const ntp__block *b, int32_t m, bool zzero, int32_t n)
{
    double z[NTP__BLOCK], rest[NTP__BLOCK];
    const double square = (double) m * m, unit = 1 / square;
    const int32_t scale = zzero ? 1 : 2, zero = zzero ? 0 : m, filled = whole(n);
    for (int32_t i = 0; i < filled; i++) {
        double x = 2 * b->c[0][i] - m, y = 2 * b->c[1][i] - m;
        z[i] = scale * b->c[2][i] - zero;
        rest[i] = square - x * x - y * y;
    }
    for (int32_t i = n; i < filled; i++)
        rest[i] = z[i] = 0;
    const double special = add_squares(e, z, rest, unit, filled);
    e->right -= filled - n; /* of which no length is off */
    e->all += n;
    if (special > 0) {
        add_negative(e, z, unit, n);
        add_tilted(e, z, rest, zzero, n);
    }
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
    double error[NTP__BLOCK], sum = r->sum, gain = r->gain, gain2 = r->gain2;
    find_errors(error, r, c, n);
    for (int32_t i = 0; i < n; i++) {
        double e = error[i], by = plain[i] * plain[i] - e * e;
        sum += e * e;
        gain += by;
        gain2 += by * by;
    }
    r->sum = sum;
    r->gain = gain;
    r->gain2 = gain2;
}

/* 0 or 1, and no branch. */
static int32_t is_flat(int32_t level)
{
    return (level == 127) | (level == 128);
}

/* How well each rule explains the lengths of 8-bit texels.  Neutral ones tell nothing, and there can be
 * many.  No branch: which texels are kept nobody foresees.  Those whose pair has all its votes are left out
 * first, as each vote keeps the next one waiting. */
static void add_rules(evidence *e, const ntp__block *b, int32_t n)
{
    int32_t c[3][NTP__BLOCK], kept[NTP__BLOCK], pair[NTP__BLOCK], asked = 0, count = 0;
    double plain[NTP__BLOCK], sum = e->unorm.sum;
    uint8_t *votes = e->votes;
    for (int32_t i = 0; i < whole(n); i++) {
        int32_t red = b->c[0][i], green = b->c[1][i];
        int32_t at = (green & VOTE_MASK) << VOTE_BITS | (red & VOTE_MASK);
        pair[i] = is_flat(red) & is_flat(green) ? NEUTRAL_PAIR : at;
    }
    for (int32_t i = 0; i < n; i++) {
        kept[asked] = i;
        asked += votes[pair[i]] < MOST_VOTES;
    }
    for (int32_t k = 0; k < asked; k++) {
        int32_t i = kept[k], before = votes[pair[i]], more = before < MOST_VOTES;
        votes[pair[i]] = (uint8_t) (before + more);
        kept[count] = i;
        count += more;
    }
    for (int32_t j = 0; j < 3; j++) {
        for (int32_t k = 0; k < count; k++)
            c[j][k] = b->c[j][kept[k]];
    }
    e->count += count;
    for (int32_t i = count; i < whole(count); i++)
        c[0][i] = c[1][i] = c[2][i] = 0;
    find_errors(plain, &e->unorm, c, count);
    for (int32_t i = 0; i < count; i++)
        sum += plain[i] * plain[i];
    e->unorm.sum = sum;
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
    e->votes[NEUTRAL_PAIR] = MOST_VOTES;
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
