/* SPDX-License-Identifier: MIT */
/*
 * test_level.c - the integer root of level.h, just below and at squares, where a rounded one fails first;
 * and the short way to pull pairs that were rounded, against the long one for all such pairs; and the levels
 * of floats, against integers
 */
#include "base/view.h"
#include "guarded.h"
#include "texel/level.h"

#include <string.h>

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

static float float_of(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The level of 16 bit of these bits of a float, in whole numbers: n/2^s is its size. */
static int32_t level_of_bits(uint32_t bits, bool component)
{
    enum { ONE = 0x3f800000 };
    const uint32_t size = bits & 0x7fffffff;
    const bool negative = bits >> 31;
    if (size > 0x7f800000 || (negative && !component)) /* NaN */
        return 0;
    if (size >= ONE)
        return negative ? 0 : 65535;
    const int64_t n = size >> 23 > 0 ? (size & 0x7fffff) | 0x800000 : size & 0x7fffff;
    const int32_t s = 150 - (int32_t) (size >> 23 > 0 ? size >> 23 : 1);
    if (s > 61) /* less than 2^-37 */
        return component ? (negative && n > 0 ? 32767 : 32768) : 0;
    if (!component)
        return (int32_t) ((2 * n * 65535 + ((int64_t) 1 << s)) >> (s + 1));
    const int64_t down = negative ? -((n * 65535 + ((int64_t) 1 << s) - 1) >> s) : n * 65535 >> s;
    return (int32_t) ((65536 + down) / 2);
}

/* Texels of three samples each, of which many are not finite. */
static void check_float_levels(const uint32_t *bits, ntp_encoding encoding)
{
    float texels[3 * NTP__BLOCK];
    for (int32_t i = 0; i < 3 * NTP__BLOCK; i++)
        texels[i] = float_of(bits[i]);
    const ntp_const_image view = { .data = texels,
                                   .width = NTP__BLOCK,
                                   .height = 1,
                                   .row_stride = sizeof texels,
                                   .pixel_stride = 3 * sizeof texels[0],
                                   .type = NTP_TYPE_F32,
                                   .channels = 3,
                                   .encoding = encoding };
    ntp__block block;
    ntp__unpack(&block, &view, 0, 0, NTP__BLOCK);
    const bool vector = encoding == NTP_ENCODING_VECTOR;
    const float zero = vector ? 0 : 0.5f;
    for (int32_t i = 0; i < NTP__BLOCK; i++) {
        const float *s = &texels[3 * i];
        bool broken = s[0] == zero && s[1] == zero && s[2] == zero;
        for (int32_t k = 0; k < 3; k++) {
            CHECK(block.c[k][i] == level_of_bits(bits[3 * i + k], vector));
            broken = broken || (bits[3 * i + k] & 0x7f800000) == 0x7f800000;
        }
        CHECK((block.any_broken && block.broken[i]) == broken);
    }
}

static void check_all_float_levels(ntp_encoding encoding)
{
    enum { NEAR = 3, SAMPLES = 3 * NTP__BLOCK };
    uint32_t bits[SAMPLES];
    int32_t n = 0;
    /* around all boundaries: v M = k of components, and v M = k/2 of units, is at k/2M */
    for (int32_t k = 0; k <= 2 * 65535; k++) {
        const float v = (float) (k / 131070.0);
        uint32_t middle;
        memcpy(&middle, &v, sizeof middle);
        for (int32_t step = -NEAR; step <= NEAR; step++) {
            bits[n++] = (middle + (uint32_t) step) ^ (k % 3 == 0 ? 0x80000000 : 0);
            if (n == SAMPLES)
                check_float_levels(bits, encoding);
            n %= SAMPLES;
        }
    }
    /* of all sizes, and what is no number: by high bits */
    for (uint32_t high = 0; high < 1 << 16; high++) {
        for (uint32_t low = 0; low < 3; low++) {
            bits[n++] = high << 16 | (low == 0 ? 0 : low == 1 ? 1 : 0xffff);
            if (n == SAMPLES)
                check_float_levels(bits, encoding);
            n %= SAMPLES;
        }
    }
    /* lengths of 0 among others */
    const float zero = encoding == NTP_ENCODING_VECTOR ? 0 : 0.5f;
    for (n = 0; n < SAMPLES; n++) {
        const float v = n % 15 < 3 || n % 4 == 0 ? zero : 0.75f;
        memcpy(&bits[n], &v, sizeof v);
    }
    check_float_levels(bits, encoding);
}

int main(void)
{
    check_all_float_levels(NTP_ENCODING_STANDARD);
    check_all_float_levels(NTP_ENCODING_VECTOR);
    check_roots();
    check_all_pulled(255);
    check_all_pulled(65535);
    return 0;
}
