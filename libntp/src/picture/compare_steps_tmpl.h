/* SPDX-License-Identifier: MIT */
/*
 * compare_steps_tmpl.h - how kernels that compare packed RGB go along a block
 *
 * The file that includes it has STEP, the texels that its step8 and step16 take, and what these keep:
 * pairs and sums.  Pairs have n texels of a block, and `listed` bins, of which `counted` are in `bins`.
 */
#include "base/inlining.h"

#include <string.h>

enum {
    BYTES = 6 * STEP, /* of a step at most */
    AHEAD = 1536      /* bytes; what is asked for now is there when it is needed */
};

/* The last texels, with black ones after them. */
SELDOM static const uint8_t *copy_last(uint8_t few[BYTES], const uint8_t *from, int32_t bytes)
{
    memset(few, 0, BYTES);
    return memcpy(few, from, (size_t) bytes);
}

/* Counts bins of the block before, while the numbers of this one are waited for. */
static inline void count_some(pairs *p)
{
    if (p->listed - p->counted < STEP)
        return;
    const int32_t *const bin = p->bin + p->counted;
    p->counted += STEP;
    uint32_t *const bins = p->bins;
    for (int32_t i = 0; i < STEP; i += 2) {
        uint64_t two;
        memcpy(&two, bin + i, sizeof two);
        bins[(uint32_t) two]++;
        bins[two >> 32]++;
    }
}

/* Counts those that are not counted yet. */
ONE_COPY static void count_rest(pairs *p)
{
    ntp__count_angles(p->bins, p->bin + p->counted, p->listed - p->counted);
    p->listed = p->counted = 0;
}

/* Goes along whole steps, at least one, until the block is full; returns how many texels these are. */
static ALWAYS_INLINE int32_t take_whole(pairs *p, sums *sum, const uint8_t *a, const uint8_t *b,
                                        int32_t n, bool deep)
{
    const int32_t bytes = (deep ? 6 : 3) * STEP;
    int32_t i = 0;
    do {
        /* As numbers: they may be beyond the picture, where this does nothing. */
        __builtin_prefetch((const void *) ((uintptr_t) a + AHEAD));
        __builtin_prefetch((const void *) ((uintptr_t) b + AHEAD));
        count_some(p);
        if (deep)
            step16(p, sum, a, b);
        else
            step8(p, sum, a, b);
        i += STEP;
        a += bytes;
        b += bytes;
    } while (i < n && p->n < NTP__BLOCK);
    return i;
}

/* Goes on until a block is full, for a step at least; returns how many texels are left.  A call would
 * keep constants out of registers in the loop above: the last texels are copied here. */
static inline int32_t take_steps(pairs *p, sums *sum, const uint8_t *a, const uint8_t *b, int32_t n,
                                 bool deep)
{
    const int32_t texel = deep ? 6 : 3;
    uint8_t few[2][BYTES];
    p->n = 0;
    do {
        int32_t some = n & -STEP;
        if (n < STEP) {
            a = copy_last(few[0], a, texel * n);
            b = copy_last(few[1], b, texel * n);
            some = STEP;
        }
        some = deep ? take_whole(p, sum, a, b, some, true) : take_whole(p, sum, a, b, some, false);
        a += texel * some;
        b += texel * some;
        n -= some;
    } while (n > 0 && p->n < NTP__BLOCK);
    return n < 0 ? 0 : n;
}
