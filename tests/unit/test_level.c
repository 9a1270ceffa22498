/* SPDX-License-Identifier: MIT */
/*
 * test_level.c - the integer root of level.h, just below and at squares, where a rounded one fails first;
 * and the short way to pull pairs that were rounded, against the long one for all such pairs
 */
#include "guarded.h"
#include "texel/level.h"

enum {
    ALL = 1 << 18,     /* roots of levels and of their sums are below */
    GREATEST = 1 << 26 /* of its square on, numbers are not all doubles */
};

static void check_roots(void)
{
    for (uint64_t k = 1; k <= ALL; k++) {
        const uint64_t great = GREATEST - ALL + k;
        CHECK(ntp__isqrt(k * k - 1) == k - 1);
        CHECK(ntp__isqrt(k * k) == k);
        CHECK(ntp__isqrt(great * great - 1) == great - 1);
        CHECK(great == GREATEST || ntp__isqrt(great * great) == great);
    }
}

/* All pairs of |Y| longer than M, and at most M + sqrt(2); returns how many. */
static int32_t check_pulled(int32_t r, int32_t m)
{
    const double x = ntp__num(r, m), most = m + 1.41421357, y2 = most * most - x * x;
    int32_t found = 0;
    for (int32_t g = y2 < 0 ? 0 : (int32_t) ((m + sqrt(y2)) / 2); g > m / 2; g--) {
        if (ntp__rest(r, g, m) >= 0)
            break;
        for (int32_t k = 0; k < 2; k++) {
            int32_t want[2] = { r, k == 0 ? g : m - g }, got[2] = { r, want[1] };
            ntp__pull(&want[0], &want[1], m);
            ntp__pull_rounded(&got[0], &got[1], m);
            CHECK(got[0] == want[0] && got[1] == want[1]);
            found++;
        }
    }
    return found;
}

static void check_all_pulled(int32_t m)
{
    int32_t found = 0;
    for (int32_t r = 0; r <= m; r++)
        found += check_pulled(r, m);
    /* a ring of area 2 pi sqrt(2) M, where a pair has 4 */
    CHECK(found > 2 * m && found < 3 * m);
}

int main(void)
{
    check_roots();
    check_all_pulled(255);
    check_all_pulled(65535);
    return 0;
}
