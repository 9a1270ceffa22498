/* SPDX-License-Identifier: MIT */
/*
 * test_turns.c - angles of 16-bit texels whose last group of lanes is not full
 *
 * Where an angle is in doubt it is found again.  What is in the lanes behind it may be no number.
 */
#include "guarded.h"
#include "base/inlining.h"
#include "measure/far_texels.h"
#include "measure/judged_sums.h"
#include "texel/angle.h"
#include "texel/level.h"

#include <math.h>

enum { M = 65535, LANES = 4, SKIPPED = 77 };

#ifdef NTP_HAVE_AVX2
#  include "base/cpu.h"

/* Of a pair that is too long: is the angle to its clean vector hardly off the middle of two micro-degrees? */
static bool is_in_doubt(const int32_t c[3])
{
    int32_t r = c[0], g = c[1];
    ntp__pull(&r, &g, M);
    const int32_t blue = ntp__blue_of_rest(ntp__rest(r, g, M), M, false);
    const double x1 = ntp__num(c[0], M), y1 = ntp__num(c[1], M), z1 = ntp__num(c[2], M);
    const double x2 = ntp__num(r, M), y2 = ntp__num(g, M), z2 = ntp__num(blue, M);
    const double x = y1 * z2 - z1 * y2, y = z1 * x2 - x1 * z2, z = x1 * y2 - y1 * x2;
    const double angle =
        ntp__radians(sqrt(x * x + y * y + z * z), x1 * x2 + y1 * y2 + z1 * z2) * (180e6 / M_PI);
    return fabs(angle - floor(angle) - 0.5) < 0x1p-16;
}

static void find_doubt(int32_t c[3])
{
    uint64_t seed = 2026;
    do {
        c[0] = M - random_level(&seed, 8191);
        c[1] = random_level(&seed, M);
        c[2] = 40000 + random_level(&seed, 19999);
    } while (ntp__rest(c[0], c[1], M) >= 0 || !is_in_doubt(c));
}

/* What the next function finds on its stack are no numbers. */
static SELDOM double leave_no_numbers(void)
{
    volatile double left[32768];
    for (size_t i = 0; i < sizeof left / sizeof left[0]; i++)
        left[i] = NAN;
    return left[0];
}

/* Two texels that point down, four in doubt that are too long, and two others: six are turned beside all. */
static void test_last_lanes(void)
{
    static ntp__sums some, each;
    static ntp__far_counts far;
    const int32_t down[3] = { 40000, 30000, 5000 }, up[3] = { 40000, 30000, 50000 };
    int32_t doubt[3];
    ntp__block block, copy;
    find_doubt(doubt);
    for (int32_t i = 0; i < 2 * LANES; i++) {
        const int32_t *const c = i < 2 ? down : i < 2 + LANES ? doubt : up;
        for (int k = 0; k < 3; k++)
            block.c[k][i] = c[k];
    }
    copy = block;
    CHECK(isnan(leave_no_numbers()));
    CHECK(ntp__add_far_avx2(&some, &far, &block, 2 * LANES) == 0);
    ntp__add_block(&each, &copy, NULL, 2 * LANES, M, NTP_ENCODING_STANDARD);
    CHECK(some.texels == each.texels && some.angles.sum == each.angles.sum &&
          some.angles.max == each.angles.max);
}
#endif

int main(void)
{
#ifdef NTP_HAVE_AVX2
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    test_last_lanes();
    return 0;
#else
    return SKIPPED;
#endif
}
