/* SPDX-License-Identifier: MIT */
/*
 * compare_steps_tmpl.h - how kernels that compare packed RGB go along a block
 *
 * The file that includes it has STEP, the texels that its step8 and step16 take, and what these keep:
 * pairs and sums.
 */
#include <string.h>

enum {
    BYTES = 6 * STEP, /* of a step at most */
    AHEAD = 1536      /* bytes; what is asked for now is there when it is needed */
};

/* The last texels, with black ones after them. */
ONE_COPY static const uint8_t *copy_last(uint8_t few[BYTES], const uint8_t *from, int32_t bytes)
{
    memset(few, 0, BYTES);
    return memcpy(few, from, (size_t) bytes);
}

static inline __attribute__((always_inline)) void take_steps(pairs *p, sums *sum, const uint8_t *a,
                                                             const uint8_t *b, int32_t n, bool deep)
{
    const int32_t texel = deep ? 6 : 3;
    uint8_t few[2][BYTES];
    for (; n > 0; n -= STEP, a += texel * STEP, b += texel * STEP) {
        /* As numbers: they may be beyond the picture, where this does nothing. */
        __builtin_prefetch((const void *) ((uintptr_t) a + AHEAD));
        __builtin_prefetch((const void *) ((uintptr_t) b + AHEAD));
        if (n < STEP) {
            a = copy_last(few[0], a, texel * n);
            b = copy_last(few[1], b, texel * n);
        }
        if (deep)
            step16(p, sum, a, b);
        else
            step8(p, sum, a, b);
    }
}
