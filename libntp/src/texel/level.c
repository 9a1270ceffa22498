/* SPDX-License-Identifier: MIT */
/*
 * level.c - pulls a pair onto the disc, in one place: it is long, and few texels need it
 */
#include "texel/level.h"

/* ax, ay are |X|, |Y|.  The caller puts the signs of X, Y back; before that, results can be -1. */
static void pull_sizes(int32_t *px, int32_t *py, int32_t ax, int32_t ay, int32_t m)
{
    uint64_t m2 = (uint64_t) m * (uint64_t) m;
    uint64_t x2 = (uint64_t) ax * (uint64_t) ax, y2 = (uint64_t) ay * (uint64_t) ay;
    int32_t ox = (int32_t) ntp__isqrt(m2 * x2 / (x2 + y2));
    int32_t oy = (int32_t) ntp__isqrt(m2 * y2 / (x2 + y2));
    ox = ox % 2 == 0 ? ox - 1 : ox;
    oy = oy % 2 == 0 ? oy - 1 : oy;
    *px = ox;
    *py = oy;
    if (ax == ay)
        return;
    int64_t best = (int64_t) ox * ax + (int64_t) oy * ay;
    for (int32_t i = 1; i < 4; i++) {
        int32_t x = ox + (i & 1) * 2, y = oy + (i & 2);
        int64_t along = (int64_t) x * ax + (int64_t) y * ay;
        if (ntp__sq(x) + ntp__sq(y) <= (int64_t) m2 && along > best) {
            best = along;
            *px = x;
            *py = y;
        }
    }
}

void ntp__pull(int32_t *r, int32_t *g, int32_t m)
{
    int32_t x = ntp__num(*r, m), y = ntp__num(*g, m), px, py;
    pull_sizes(&px, &py, ntp__abs(x), ntp__abs(y), m);
    *r = ntp__level(x < 0 ? -px : px, m);
    *g = ntp__level(y < 0 ? -py : py, m);
}

/*
 * In each coordinate the pair is at most half a level from the disc, so (|X|, |Y|) is no longer than M + sqrt(2), and
 * its projection is less than 2 away in each.  Of the four pairs around that, the greatest is the pair itself,
 * outside, and the least is one level off in both coordinates.  Of the other two, that off in the lesser coordinate
 * reaches farther.
 */
void ntp__pull_rounded(int32_t *r, int32_t *g, int32_t m)
{
    const int32_t x = ntp__num(*r, m), y = ntp__num(*g, m), ax = ntp__abs(x), ay = ntp__abs(y);
    const int64_t rest = ntp__rest(*r, *g, m);
    /* one level off |X| adds 4 |X| - 4 to S */
    const bool fits_r = ax != ay && rest + 4 * (int64_t) (ax - 1) >= 0,
               fits_g = ax != ay && rest + 4 * (int64_t) (ay - 1) >= 0;
    if (!fits_g || (fits_r && ax < ay))
        *r -= x > 0 ? 1 : -1;
    if (!fits_r || (fits_g && ay < ax))
        *g -= y > 0 ? 1 : -1;
}
