/* SPDX-License-Identifier: MIT */
/*
 * test_flags.c - the flags of packed pixels, beside those that level.h finds with integers
 *
 * Of 8 bit all triplets.  Of 16 bit texels of all kinds, and those about the limits of each test.
 */
#include "guarded.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { SKIPPED = 77 };

/* Flags of n packed texels, whose memory ends at a guard page, and of none beyond them. */
static void check_flags_rgb(const ntp__kernels_table *level, const void *texels, int32_t n,
                            const ntp__validity *how)
{
    const size_t bytes = (size_t) n * (how->m > 255 ? 6 : 3);
    const bool xy = how->others != 0;
    guarded src = guarded_alloc(bytes, false), got = guarded_alloc((size_t) n, false);
    memcpy(src.data, texels, bytes);
    const uint8_t *p8 = src.data, *flags = got.data;
    const uint16_t *p16 = src.data;
    level->validate_rgb(got.data, src.data, n, how);
    for (int32_t i = 0; i < n; i++) {
        int32_t c[3];
        for (int32_t k = 0; k < 3; k++)
            c[k] = how->m > 255 ? p16[3 * i + k] : p8[3 * i + k];
        uint32_t want =
            ntp__flags(c[0], c[1], c[2], how->m, xy ? NTP_ENCODING_XY : NTP_ENCODING_STANDARD,
                       how->keep_negative_z != 0);
        want |= ntp__unused(c[0], c[1], c[2], how->m, how->m, 0) ? NTP_FLAG_UNUSED : 0;
        CHECK(flags[i] == want);
    }
    guarded_free(&src);
    guarded_free(&got);
}

static ntp__validity random_validity(int32_t m, uint64_t *seed)
{
    const uint32_t bits = random_bits(seed);
    const bool xy = bits & 1, keep = bits & 2;
    return (ntp__validity) { m, 0, keep, xy ? NTP_FLAG_XY_TOO_LONG : 0xff, xy ? 7 : 0 };
}

/* Packed RGB of 8 bit: all triplets, in runs of all widths. */
static void check_all_triplets(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { ALL = 1 << 24, LONGEST = 16384 };
    static uint8_t p[3 * LONGEST];
    for (int32_t at = 0, n = 1; at < ALL; at += n, n = n < 600 ? n + 1 : LONGEST) {
        n = n < ALL - at ? n : ALL - at;
        for (int32_t i = 0; i < 3 * n; i++)
            p[i] = (uint8_t) ((at + i / 3) >> 8 * (i % 3));
        const ntp__validity how = random_validity(255, seed);
        check_flags_rgb(level, p, n, &how);
    }
}

/* Of 16 bit: about the limits of each test, whose places in blue are found by bisection. */
static void check_limits_16(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { PAIRS = 20000, TEXELS = 48 };
    const int32_t m = 65535, k = 32768;
    uint16_t p[3 * TEXELS];
    for (int32_t pair = 0; pair < PAIRS; pair++) {
        const int32_t r = random_level(seed, m), g = random_level(seed, m);
        const bool down = random_bits(seed) & 1;
        int32_t n = 0;
        for (uint32_t flag = NTP_FLAG_NEIGHBOR; flag <= NTP_FLAG_EXACT; flag *= 2) {
            for (int32_t side = 0; side < 2; side++) {
                /* Longer and shorter than every texel with the flag, as its test sees them */
                int32_t low = k, high = m;
                while (low < high) {
                    const int32_t b = (low + high) / 2;
                    const int64_t x = 2 * r - m, y = 2 * g - m, z = 2 * b - m;
                    const bool passes = ntp__flags(r, g, b, m, NTP_ENCODING_STANDARD, false) & flag;
                    const bool is_long = x * x + y * y + z * z > (int64_t) m * m;
                    if (side == 0 ? passes || is_long : is_long && !passes)
                        high = b;
                    else
                        low = b + 1;
                }
                for (int32_t b = low - 3; b <= low + 3; b++) {
                    const int32_t in = b < k ? k : b > m ? m : b;
                    p[3 * n] = (uint16_t) r;
                    p[3 * n + 1] = (uint16_t) g;
                    p[3 * n++ + 2] = (uint16_t) (down ? m - in : in);
                }
            }
        }
        const ntp__validity how = random_validity(m, seed);
        check_flags_rgb(level, p, n - pair % 7, &how);
    }
}

/* Texels whose box only touches the sphere, from within or from outside: sums of three squares that
 * are K(K - 1) or one more. */
static void check_touching_16(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { TRIES = 200, K = 32768, TEXELS = 3 };
    uint16_t p[3 * TEXELS];
    int32_t found = 0;
    for (int32_t i = 0; i < TRIES; i++) {
        const int32_t x = (int32_t) (random_bits(seed) % (K - 1)) + 1, more = i & 1;
        for (int32_t y = more; y < K; y++) {
            const int64_t square = (int64_t) K * (K - 1) + more - ntp__sq(x) - ntp__sq(y);
            const int32_t z = square < 0 ? 0 : (int32_t) ntp__isqrt((uint64_t) square);
            if (z <= more || ntp__sq(z) != square)
                continue;
            for (int32_t k = 0; k < TEXELS; k++) {
                p[3 * k] = (uint16_t) (K + x - more);
                p[3 * k + 1] = (uint16_t) (K - 1 - (y - more));
                p[3 * k + 2] = (uint16_t) (K + z - more + k - 1);
            }
            const ntp__validity how = random_validity(65535, seed);
            check_flags_rgb(level, p, TEXELS, &how);
            found++;
        }
    }
    CHECK(found > 50);
}

/* And texels of all kinds, black and white ones too. */
static void check_texels_16(const ntp__kernels_table *level, uint64_t *seed)
{
    static uint16_t p[3 * 600];
    for (int32_t n = 1; n <= 600; n++) {
        for (int32_t i = 0; i < 3 * n; i++)
            p[i] = i % 3 != 0 && random_bits(seed) % 2 ? p[i - 1]
                                                       : (uint16_t) random_level(seed, 65535);
        const ntp__validity how = random_validity(65535, seed);
        check_flags_rgb(level, p, n, &how);
    }
}

int main(int argc, char **argv)
{
    const bool wide = argc > 1 && strcmp(argv[1], "avx512") == 0;
    ntp__kernels_table level;
    uint64_t seed = 99;
    ntp__pick_kernels(&level, wide ? NTP__CPU_ALL : NTP__CPU_AVX2);
    if (level.validate_rgb == NULL /* planes are as fast */ ||
        (wide && !ntp__cpu_has_avx512(NTP__CPU_ALL)))
        return SKIPPED;
    check_all_triplets(&level, &seed);
    check_limits_16(&level, &seed);
    check_touching_16(&level, &seed);
    check_texels_16(&level, &seed);
    return 0;
}
