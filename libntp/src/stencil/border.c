/* SPDX-License-Identifier: MIT */
/*
 * border.c - what lies beyond the edges of an axis, and where a stencil has all its texels inside
 */
#include "stencil/border.h"

static int32_t modulo(int32_t i, int32_t n)
{
    int32_t rest = i % n;
    return rest < 0 ? rest + n : rest;
}

ntp__mapped ntp__border_map(ntp_border border, int32_t i, int32_t n)
{
    ntp__mapped one = { 1, { i, 0 }, { 1, 0 } };
    if (i >= 0 && i < n)
        return one;
    int32_t edge = i < 0 ? 0 : n - 1;
    if (n == 1 || border == NTP_BORDER_CLAMP) {
        one.index[0] = edge;
    } else if (border == NTP_BORDER_WRAP) {
        one.index[0] = modulo(i, n);
    } else if (border == NTP_BORDER_MIRROR) {
        int32_t j = modulo(i, 2 * (n - 1));
        one.index[0] = j < n ? j : 2 * (n - 1) - j;
    } else {
        int32_t beyond = i < 0 ? -i : i - (n - 1);
        one.count = 2;
        one.index[0] = edge;
        one.index[1] = i < 0 ? 1 : n - 2;
        one.weight[0] = 1 + beyond;
        one.weight[1] = -beyond;
    }
    return one;
}

ntp_border ntp__border_beyond(ntp_border border)
{
    return border == NTP_BORDER_REPEAT_SLOPE ? NTP_BORDER_EXTRAPOLATE : border;
}

/* The offsets of the first and the last tap that is not 0, along the slope or across it. */
static void extent(const ntp__kernel *k, bool along, int32_t *first, int32_t *last)
{
    *first = NTP__MAX_RADIUS;
    *last = -NTP__MAX_RADIUS;
    for (int32_t i = -NTP__MAX_RADIUS; i <= NTP__MAX_RADIUS; i++) {
        int32_t at = i + NTP__MAX_RADIUS;
        bool tap = along ? k->term[0].along[at] != 0 || k->term[1].along[at] != 0
                         : k->term[0].across[at] != 0 || k->term[1].across[at] != 0;
        if (tap && i < *first)
            *first = i;
        if (tap)
            *last = i;
    }
}

ntp__span ntp__stencil_span(const ntp__kernel *k, bool along, ntp_border border, int32_t n)
{
    ntp__span span = { 0, n - 1 };
    int32_t first, last;
    extent(k, along, &first, &last);
    if (border == NTP_BORDER_REPEAT_SLOPE && last - first < n) {
        span.first = first < 0 ? -first : 0;
        span.last = last > 0 ? n - 1 - last : n - 1;
    }
    return span;
}
