/* SPDX-License-Identifier: MIT */
/*
 * test_directions.c - what doubles decide of the levels of a direction, against whole numbers of 128 bits
 * and more
 */
#include "guarded.h"
#include "texel/direction.h"

enum { MANY = 20000 };

/* Returns whether doubles tell; if so, they are right. */
static bool decides(const double v[3], int32_t m, ntp_encoding encoding)
{
    int32_t got[3] = { 0, 0, 7 }, want[3] = { 0, 0, 7 };
    ntp__i128 whole[3];
    for (int32_t k = 0; k < 3; k++)
        whole[k] = ntp__i128_of((int64_t) v[k]);
    if (!ntp__direction_decided(got, v, m, encoding))
        return false;
    ntp__direction_levels(want, whole, m, encoding);
    for (int32_t k = 0; k < 3; k++)
        CHECK(got[k] == want[k]);
    return true;
}

static void check_random(int32_t m, ntp_encoding encoding)
{
    uint64_t seed = 5;
    int32_t decided = 0;
    for (int32_t i = 0; i < MANY; i++) {
        double v[3];
        for (int32_t k = 0; k < 3; k++)
            v[k] = (double) (random_bits(&seed) >> (1 + random_bits(&seed) % 20)) *
                   (random_bits(&seed) % 3 == 0 ? 1 << 21 : 1) * (random_bits(&seed) & 1 ? -1 : 1);
        decided += decides(v, m, encoding);
    }
    CHECK(decided > MANY * 0.9);
}

/* Components of 0 with either sign, of which none is negative, and others that leave hardly anything of 1. */
static void check_zeros(int32_t m, ntp_encoding encoding)
{
    const double some[] = { 0.0, -0.0, 1, -1, 0x1p50, -0x1p50 };
    enum { KINDS = sizeof some / sizeof some[0] };
    int32_t decided = 0;
    for (int32_t i = 0; i < KINDS * KINDS * KINDS; i++) {
        const double v[3] = { some[i % KINDS], some[i / KINDS % KINDS], some[i / KINDS / KINDS] };
        decided += decides(v, m, encoding);
    }
    CHECK(decided > KINDS * KINDS * KINDS / 2);
}

/* An exact tie is never decided. */
static void check_ties(int32_t m)
{
    const double tie[3] = { 2, -10, 11 }, beside[3] = { 2, -10, 12 };
    CHECK(!decides(tie, m, NTP_ENCODING_STANDARD));
    CHECK(decides(beside, m, NTP_ENCODING_STANDARD));
}

int main(void)
{
    for (int32_t m = 255; m <= 65535; m += 65535 - 255) {
        for (ntp_encoding e = NTP_ENCODING_STANDARD; e <= NTP_ENCODING_XY; e++) {
            check_random(m, e);
            check_zeros(m, e);
        }
        check_ties(m);
    }
    return 0;
}
