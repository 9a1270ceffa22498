/* SPDX-License-Identifier: MIT */
/*
 * test_level.c - the integer root of level.h, just below and at squares, where a rounded one fails first
 */
#include "guarded.h"
#include "texel/level.h"

enum {
    ALL = 1 << 18,     /* roots of levels and of their sums are below */
    GREATEST = 1 << 26 /* of its square on, numbers are not all doubles */
};

int main(void)
{
    for (uint64_t k = 1; k <= ALL; k++) {
        const uint64_t great = GREATEST - ALL + k;
        CHECK(ntp__isqrt(k * k - 1) == k - 1);
        CHECK(ntp__isqrt(k * k) == k);
        CHECK(ntp__isqrt(great * great - 1) == great - 1);
        CHECK(great == GREATEST || ntp__isqrt(great * great) == great);
    }
    return 0;
}
