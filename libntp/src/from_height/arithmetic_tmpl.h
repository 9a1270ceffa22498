/* SPDX-License-Identifier: MIT */
/*
 * arithmetic_tmpl.h - a part of gradient.c: which arithmetic its numbers allow the loops
 */

/* Within these limits no float (double) of the encoding loops leaves the normal range.  The least
 * is for c/N unless it is 0, the most for c/N times the greatest tap sum.  The loops compute
 * squares of such numbers. */
static const double least_single = 0x1p-60, most_single = 0x1p60;
static const double least_double = 0x1p-400, most_double = 0x1p400;

/* Float heights other than 0 differ by no less than 2^-24 of the least one, so with these their
 * slopes too stay in the range of floats. */
static const double least_height = 0x1p-70, least_for_floats = 0x1p-30;

/* The error of tap sums in double that are not exact, over the greatest sum: they have fewer than
 * 64 roundings. */
static const double sum_error = 0x1p-47;

static bool within(const ntp__scaled *exact, double c, double least, double most, double greatest)
{
    c = c < 0 ? -c : c;
    return exact->mantissa == 0 || (c >= least && c * greatest <= most);
}

/* Decides which arithmetic the loops may use for tap sums up to `greatest`. */
static void set_arithmetic(walk *w, double greatest)
{
    const ntp__gradient *g = &w->g;
    const double least = w->floats ? least_for_floats : least_single;
    const double most = greatest > 1 ? greatest : 1;
    w->doubles = (g->m > 0 || g->shortened > 0) &&
                 within(&g->x, g->cx, least_double, most_double, greatest) &&
                 within(&g->y, g->cy, least_double, most_double, greatest);
    w->single = w->doubles && within(&g->x, g->cx, least, most_single, most) &&
                within(&g->y, g->cy, least, most_single, most);
    w->encode.steep = !w->single;
    w->encode.off = 1;
    w->encode.rough = 0;
}

/* The tap sums, in doubles, are off by up to greatest * sum_error.  No component of a normal
 * changes by more than the slope does. */
static void set_inexact(walk *w, double greatest)
{
    double cx = w->g.cx < 0 ? -w->g.cx : w->g.cx, cy = w->g.cy < 0 ? -w->g.cy : w->g.cy;
    w->encode.rough = (cx + cy) * greatest * sum_error;
    const double off = w->encode.half * w->encode.rough;
    w->doubles = w->doubles && off < 0.25;
    if (w->doubles)
        w->encode.off = 2 + (int32_t) (off * NTP__OFF_ONE);
}

/* Are components other than 0 in the normal range of floats, for tap sums from `least` to `greatest`, and
 * as exact as doubles? */
static ONE_COPY void set_plain(walk *w, double least, double greatest)
{
    if (w->encode.unit || w->encode.use_shortened || w->encode.rough > 0) {
        w->encode.plain = false;
        return;
    }
    const double x = fabs(w->g.cx), y = fabs(w->g.cy), most = 1 + (x + y) * greatest;
    const double x0 = x > 0 ? x : 1, y0 = y > 0 ? y : 1, c = x0 < y0 ? x0 : y0;
    w->encode.plain = (c * least < 1 ? c * least : 1) > 0x1p-124 * most;
}
