/* SPDX-License-Identifier: MIT */
/*
 * find_seams.c - does a texture tile?
 *
 * There are two questions for each axis.  Closure: the slopes along a row add up to the height at
 * its end less that at its beginning.  In a texture that tiles this is 0 up to rounding, whose size
 * is known.  Jump: the step from the last texel to the first has to be like the steps inside.
 * Compression and noise spoil the sums.  So there is a third question: do the slopes before and after
 * the seam differ as little as those around a place inside?  Sampled rows are asked.  Columns are
 * the rows of the transposed image.
 */
#include "base/cpu.h"
#include "detect/line_loops_tmpl.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

enum {
    MOST_LINES = 128,
    LEAST_TEXELS = 16, /* of a line; and the least number of lines */
    WINDOWS = NTP__WINDOWS,
    WIDEST = NTP__WIDEST
};

/* Closure as a share of the height differences within a line. */
static const double MOST_CLOSURE = 0.2;
/* Compression of an image leaves steps at its edges.  They are no seam while the heights close. */
static const double MOST_CLOSURE_TIMES_JUMP = 0.4;
/* Or: at least this share of the steps inside is as large. */
static const double LEAST_RANK = 0.2;
/* It is certainly a seam if the step is large, and in most lines the largest of all.  (An edge of
 * bricks or planks at the border of the picture is large too, but so are the others.) */
static const double SEAM_JUMP = 3, SEAM_LARGEST = 0.6, SEAM_CLOSURE = 0.3;
/* Slopes continue across a seam if they differ by no more than this, in units of their difference
 * inside.  It tells nothing unless slopes inside differ far less than those of two places that have
 * nothing to do with each other.  Damage spoils the closure, but not as a seam does.  It leaves the
 * step and the lean small: on 238 damaged axes that tile they were at most 1.8 and 0.015; smooth
 * pictures cut where slopes happen to be alike had 2.1 or 0.06. */
static const double MOST_SEAM = 1.5, MOST_INSIDE = 0.5, MOST_DAMAGED_CLOSURE = 0.4;
static const double MOST_DAMAGED_JUMP = 2, MOST_DAMAGED_LEAN = 0.03;
/* Flat places fit each other wherever they are cut, as the faces of two bricks do: where the step at
 * the seam is below this, edges that fit decide nothing.  Of tiles with detail all over it is 0.7 or more. */
static const double LEAST_JUMP = 0.6;
/* Heights must vary by so many times the variance that rounding gives them, or they tell
 * nothing. */
static const double LEAST_SIGNAL = 4;
/* The rounding of steep texels is known less well, as their slopes end at STEEPEST.  Where it makes so
 * many times the variance of rounded level ground, and this share of that of the heights, sums that
 * close tell nothing: the share was at most 0.018 in steep tiles, and 0.02 to 0.05 in cut bricks whose edges ring. */
static const double STEEP_NOISE = 4, MOST_STEEP_NOISE = 0.02;

/* Sums over lines. */
typedef struct axis_sums {
    double full, full2;   /* sums of slopes of a line, and their squares */
    double variance;      /* of the heights along a line */
    double noise;         /* expected variance of a line's sum */
    double jump, inside;  /* step at the seam; mean of the steps inside */
    double rank;          /* share of steps inside that are larger */
    int32_t largest;      /* lines in which no step inside is larger */
    double seam[WINDOWS]; /* for each window, squares of differences at the seam */
    ntp__windows windows; /* and inside */
    int32_t lines, asked; /* lines used, and lines looked at */
} axis_sums;

/* Reads n texels.  Channel `along` holds the component along the line. */
static void read_line(ntp__line *l, const ntp_const_image *src, uint32_t touch, int32_t along,
                      int32_t x, int32_t y, int32_t n)
{
    int32_t m = ntp__max(src->type);
    ntp__block *b = &l->block;
    ntp__unpack(b, src, x, y, n);
    const bool any = ntp__any_suspect(b, n, m);
    for (int32_t i = 0; i < n; i++)
        l->bad[i] = any && ntp__texel_unused(b, i, m, touch);
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        ntp__line_slopes_avx2(l, along, m, n);
    else
#endif
        ntp__line_slopes(l->p + 1, l->q + 1, b->c[along], b->c[1 - along], m, n);
    for (int32_t i = 0; i < n && any; i++) {
        if (l->bad[i])
            l->p[i + 1] = l->q[i + 1] = 0;
    }
}

static void sum_up(ntp__line_sums *sums, ntp__windows *windows, ntp__line *l, bool first,
                   double jump, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__sum_line_avx2(sums, windows, l, first, jump, n);
        return;
    }
#endif
    ntp__sum_line(sums, windows, l, first, jump, n);
}

static double size(double v)
{
    return v < 0 ? -v : v;
}

/* Slopes at both ends of a line, in order: those at the end first. */
typedef struct ends {
    double p[2 * WIDEST], q[2 * WIDEST];
} ends;

/* Reads the two ends of the line; false: one of them is no normal. */
static bool read_ends(ends *e, ntp__line *l, const ntp_const_image *src, uint32_t touch,
                      int32_t along, int32_t y)
{
    for (int32_t first = 0; first < 2; first++) {
        read_line(l, src, touch, along, first ? 0 : src->width - WIDEST, y, WIDEST);
        if (l->bad[first ? 0 : WIDEST - 1])
            return false;
        memcpy(e->p + first * WIDEST, l->p + 1, WIDEST * sizeof *e->p);
        memcpy(e->q + first * WIDEST, l->q + 1, WIDEST * sizeof *e->q);
    }
    return true;
}

/* Do slopes go on across the seam as inside? */
static bool continues(const axis_sums *s)
{
    const ntp__windows *w = &s->windows;
    for (int32_t k = 0; k < WINDOWS && w->places > 0; k++) {
        double n = w->places, x = w->mean[k][0] / n, y = w->mean[k][1] / n;
        double inside = w->within[k] / n, apart = 2 * (w->mean2[k] / n - x * x - y * y);
        if (inside <= MOST_INSIDE * apart && s->seam[k] / s->lines <= MOST_SEAM * inside)
            return true;
    }
    return false;
}

/* Adds line y: its closure, the variance of its heights, and how its steps compare with the
 * seam. */
static void add_line(axis_sums *s, ntp__line *l, const ntp_const_image *src, uint32_t touch,
                     int32_t along, int32_t y)
{
    ends e;
    ntp__line_sums sums = { 0 };
    double level = 2.0 / ntp__max(src->type), mean[2][WINDOWS];
    int32_t w = src->width;
    s->asked++;
    if (!read_ends(&e, l, src, touch, along, y))
        return;
    double jump = size(e.p[WIDEST] - e.p[WIDEST - 1]) + size(e.q[WIDEST] - e.q[WIDEST - 1]);
    for (int32_t x = 0; x < w; x += NTP__BLOCK) {
        int32_t n = w - x < NTP__BLOCK ? w - x : NTP__BLOCK;
        l->p[0] = x > 0 ? l->p[NTP__BLOCK] : 0; /* the last of the stretch before */
        l->q[0] = x > 0 ? l->q[NTP__BLOCK] : 0;
        read_line(l, src, touch, along, x, y, n);
        sum_up(&sums, &s->windows, l, x == 0, jump, n);
    }
    ntp__add_differences(s->seam, mean, e.p + WIDEST, e.q + WIDEST);
    s->full += sums.height;
    s->full2 += sums.height * sums.height;
    s->variance += sums.sum2 / w - sums.sum / w * (sums.sum / w);
    s->noise += sums.noise * level * level / 12;
    s->jump += jump;
    s->inside += sums.inside / (w - 1);
    s->rank += 0.5 * (double) sums.larger / (w - 1);
    s->largest += sums.larger < 2;
    s->lines++;
}

static void judge(ntp_seam *seam, const axis_sums *s, const ntp_const_image *src)
{
    memset(seam, 0, sizeof *seam);
    if (s->lines < LEAST_TEXELS || 2 * s->lines < s->asked || !(s->inside > 0))
        return;
    double n = s->lines, mean = s->full / n, noise = s->noise / n;
    /* A line that leans has variance from that too, which tells nothing about closure. */
    double closing = s->full2 / n - mean * mean - noise;
    double signal = s->variance / n - mean * mean / 12;
    double walk = noise / 6; /* the variance that rounding gives to the heights of a line */
    seam->lean = mean / src->width;
    seam->jump = s->jump / s->inside;
    seam->rank = s->rank / n;
    seam->largest = s->largest / n;
    if (signal < LEAST_SIGNAL * walk)
        return;
    seam->closure = closing > 0 ? sqrt(closing / (signal - walk)) : 0;
    double level = 2.0 / ntp__max(src->type), plain = src->width * level * level / 12;
    bool vague = noise > STEEP_NOISE * plain && noise > MOST_STEEP_NOISE * signal;
    bool closes = seam->closure <= MOST_CLOSURE;
    bool has_seam =
        seam->closure >= SEAM_CLOSURE && seam->jump >= SEAM_JUMP && seam->largest >= SEAM_LARGEST;
    seam->tiles = closes && (seam->closure * seam->jump <= MOST_CLOSURE_TIMES_JUMP ||
                             seam->rank >= LEAST_RANK);
    bool damaged = seam->closure <= MOST_DAMAGED_CLOSURE && seam->jump <= MOST_DAMAGED_JUMP &&
                   size(seam->lean) <= MOST_DAMAGED_LEAN;
    seam->tiles |= damaged && seam->jump >= LEAST_JUMP && continues(s);
    /* Encoders that cut off fractions add half a level. */
    seam->wraps = seam->tiles && size(seam->lean) <= 1.5 / ntp__max(src->type);
    seam->tiles = seam->tiles && seam->jump >= LEAST_JUMP && !vague;
    seam->decided = seam->tiles || has_seam;
}

static void measure(ntp_seam *seam, const ntp_const_image *src, uint32_t touch, int32_t along)
{
    axis_sums s;
    ntp__line l;
    memset(&s, 0, sizeof s);
    int32_t lines = src->height < MOST_LINES ? src->height : MOST_LINES;
    for (int32_t i = 0; i < lines && src->width >= LEAST_TEXELS; i++)
        add_line(&s, &l, src, touch, along, (int32_t) ((int64_t) i * src->height / lines));
    judge(seam, &s, src);
}

ntp_status ntp_find_seams(ntp_seam *x, ntp_seam *y, const ntp_const_image *src,
                          uint32_t touch_unused)
{
    if ((x == NULL && y == NULL) || touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    const ntp_const_image turned = ntp__transposed(src);
    if (x != NULL)
        measure(x, src, touch_unused, 0);
    if (y != NULL)
        measure(y, &turned, touch_unused, 1);
    return NTP_OK;
}
