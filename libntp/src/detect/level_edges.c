/* SPDX-License-Identifier: MIT */
/*
 * level_edges.c - do normals at the edges show a kernel and a mirror?
 *
 * A symmetric difference of heights that a mirror continues is zero at the edge.  A surface goes on there
 * as it does inside, and so do differences that wrap, or of a part that was cut out.  So components across
 * an edge are compared with what the two texels beside each make expect, and with damage: how far the
 * lengths of these normals are off.  Of a surface that is symmetric about its edge, as many tiles are,
 * those beside it already tell that there is little slope.
 */
#include "detect/level_edges.h"

#include "texel/level.h"
#include "texel/unused.h"

enum {
    BESIDE = 3,     /* texels from an edge on */
    LONGEST = 1024, /* of a longer edge the middle is looked at */
    LEAST_SIDE = 16
};

/* What is expected at an edge, and twice the component of the next texel, have more than so many times the
 * square of what is there.  White noise on level ground has 5 times the square. */
static const double EXPECTED = 8;
/* And that is less than so many times the square of an error of these lengths, to which half a square of an
 * 8-bit level is added.  Chosen on half of the heights of public projects.  Of other kernels and borders,
 * on 976 damaged maps, one had such edges. */
static const double DAMAGE = 4, LEAST_DAMAGE = 0.5;

/* Sums of squares over an edge, in steps of half a level. */
typedef struct sums {
    double here, next, expected, damage, texels;
} sums;

static void add(sums *s, const ntp__block line[BESIDE], int32_t along, int32_t n, int32_t m)
{
    for (int32_t i = 0; i < n; i++) {
        double v[BESIDE], here2 = 0;
        for (int32_t k = 0; k < BESIDE; k++) {
            v[k] = ntp__num(line[k].c[along][i], m);
            double c = ntp__num(line[0].c[k][i], m);
            here2 += c * c;
        }
        double expected = 2 * v[1] - v[2], off = (here2 / m - m) / 2;
        s->here += v[0] * v[0];
        s->next += v[1] * v[1];
        s->expected += expected * expected;
        s->damage += off * off;
    }
    s->texels += n;
}

/* Is the left edge level, or the right one?  Channel `along` holds the component across it. */
static bool is_level(const ntp_const_image *src, int32_t along, bool right)
{
    const ntp_const_image turned = ntp__transposed(src);
    ntp__block line[BESIDE];
    sums s = { 0, 0, 0, 0, 0 };
    int32_t m = ntp__max(src->type), length = turned.width < LONGEST ? turned.width : LONGEST;
    int32_t first = (turned.width - length) / 2, end = first + length;
    for (int32_t x = first; x < end; x += NTP__BLOCK) {
        int32_t n = end - x < NTP__BLOCK ? end - x : NTP__BLOCK;
        bool suspect = false;
        for (int32_t k = 0; k < BESIDE; k++) {
            ntp__unpack(&line[k], &turned, x, right ? src->width - 1 - k : k, n);
            suspect |= ntp__any_suspect(&line[k], n, m);
        }
        if (!suspect)
            add(&s, line, along, n, m);
    }
    double level = m / 127.5, least = LEAST_DAMAGE * level * level * s.texels;
    double expected = s.expected < 4 * s.next ? s.expected : 4 * s.next;
    return expected > EXPECTED * s.here && s.here < DAMAGE * (s.damage + least);
}

bool ntp__edges_are_level(const ntp_const_image *src, bool down)
{
    const ntp_const_image lines = down ? ntp__transposed(src) : *src;
    return src->width >= LEAST_SIDE && src->height >= LEAST_SIDE && is_level(&lines, down, false) &&
           is_level(&lines, down, true);
}
