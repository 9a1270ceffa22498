/* SPDX-License-Identifier: MIT */
/*
 * test_judge.c - what a measurement finds out about texels, against level.h, angle.c and doubles
 *
 * At 8 bit all pairs of magnitudes with all blues; at 16 bit random texels, and such whose blue is
 * the derived one, or lies near it.  Then surveys of all widths, against a loop.
 */
#include "guarded.h"
#include "odd_texel.h"
#include "base/view.h"
#include "measure/judged_sums.h"
#include "texel/angle.h"
#include "texel/judged.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { BLOCKS = 3000, SKIPPED = 77 };

static int32_t steepness(int32_t r, int32_t g, int32_t m)
{
    const int64_t x = ntp__num(r, m), y = ntp__num(g, m), rho2 = x * x + y * y, m2 = ntp__sq(m);
    int32_t bin = 0;
    while (bin < NTP__STEEPNESS_BINS - 1 && 64 * rho2 >= m2 * (bin + 1) * (bin + 1))
        bin++;
    return ntp__is_padding(r, g, m) ? NTP__PADDING_BIN : bin;
}

static void check_fit(const ntp__judged_fit *fit, const int32_t c[3], int32_t i, int32_t m,
                      bool zzero)
{
    const int64_t x = ntp__num(c[0], m), y = ntp__num(c[1], m), s = ntp__rest(c[0], c[1], m);
    const int64_t z = zzero ? c[2] : ntp__num(c[2], m), length2 = x * x + y * y + z * z;
    const double far = NTP__FAR_SQUARED * ((double) m * m);
    const bool negative = !zzero && ntp__z_negative(c[2], m);
    uint32_t want =
        ntp__flags(c[0], c[1], c[2], m, zzero ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD, false);
    int32_t off = NTP__NO_BLUE;
    if (s >= 0) {
        const int32_t blue = ntp__blue_of_rest(s, m, zzero);
        want |= c[2] == blue ? NTP_FLAG_EXACT : 0;
        want |= !zzero && m - c[2] == blue ? NTP__MIRRORED : 0;
        off = ntp__abs((negative ? m - c[2] : c[2]) - blue);
    }
    want |= length2 > ntp__sq(m) ? NTP__LONG : 0;
    want |= (double) (x * x + y * y) > far ? NTP__FAR : 0;
    CHECK((uint32_t) fit->key[i] == ((uint32_t) steepness(c[0], c[1], m) << 8 | want));
    CHECK(fit->levels_off[i] == off);
    CHECK(fit->length[i] == ntp__fixed_length((double) length2, m));
    CHECK(fit->off[i] == (uint32_t) ntp__abs(fit->length[i] - NTP__LENGTH_ONE));
}

static void check_angle(const ntp__judged *j, const int32_t c[3], int32_t i, int32_t m, bool zzero)
{
    const int64_t x = ntp__num(c[0], m), y = ntp__num(c[1], m), s = ntp__rest(c[0], c[1], m);
    const int32_t blue = s >= 0 ? ntp__blue_of_rest(s, m, zzero) : -1;
    CHECK(j->want[i] == blue);
    CHECK(blue >= 0 || j->angle[i] < 0);
    if (j->angle[i] < 0)
        return;
    const int64_t z = zzero ? c[2] : ntp__num(c[2], m), w = zzero ? blue : ntp__num(blue, m);
    CHECK((uint32_t) j->angle[i] == ntp__angle(x, y, z, x, y, w));
}

/* Returns whether the kernel left an angle out that there is. */
static bool check_angles(const ntp__judged *j, const int32_t c[3], int32_t i, int32_t m, bool zzero)
{
    const int64_t x = ntp__num(c[0], m), y = ntp__num(c[1], m), z = ntp__num(c[2], m);
    check_angle(j, c, i, m, zzero);
    if (zzero || z >= 0)
        return j->angle[i] < 0 && j->want[i] >= 0;
    CHECK(j->mirrored[i] < 0 || (uint32_t) j->mirrored[i] == ntp__angle(x, y, z, x, y, -z));
    return j->mirrored[i] < 0 || (j->angle[i] < 0 && j->want[i] >= 0);
}

static void check_block(const ntp__kernels_table *level, ntp__block *block, int32_t n, int32_t m,
                        bool zzero)
{
    static ntp__judged j;
    uint32_t count[NTP__BLOCK];
    uint64_t sum = 0;
    int32_t left = 0;
    for (int32_t i = 0; i < n; i++)
        count[i] = (uint32_t) i % 3 + 1;
    level->judge_block(&j, block->c[0], block->c[1], block->c[2], count, n, m, zzero);
    for (int32_t i = 0; i < n; i++) {
        const int32_t c[] = { block->c[0][i], block->c[1][i], block->c[2][i] };
        check_fit(&j.fit[0], c, i, m, false);
        check_fit(&j.fit[1], c, i, m, true);
        left += check_angles(&j, c, i, m, zzero);
        sum += (uint64_t) (uint32_t) j.fit[1].length[i] * count[i];
        CHECK(((uint32_t) j.fit[0].key[i] & j.fit[0].every) == j.fit[0].every);
        CHECK(((uint32_t) j.fit[0].key[i] & ~j.fit[0].some) == 0);
    }
    CHECK(j.fit[1].length_sum == sum && left < 4); /* one in 4096 is in doubt */
}

static void check_8_bit(const ntp__kernels_table *level)
{
    ntp__block block;
    for (int32_t r = 128; r < 256; r++) {
        for (int32_t g = 128; g <= r; g++) {
            for (int32_t i = 0; i < 256; i++) {
                block.c[0][i] = i & 1 ? r : 255 - r;
                block.c[1][i] = g;
                block.c[2][i] = i;
            }
            check_block(level, &block, 256, 255, g & 1);
        }
    }
}

static void check_16_bit(const ntp__kernels_table *level, uint64_t *seed)
{
    const int32_t m = 65535;
    ntp__block block;
    for (int32_t k = 0; k < BLOCKS; k++) {
        const bool zzero = k & 1;
        const int32_t n = 1 + (int32_t) (random_bits(seed) % NTP__BLOCK);
        /* angles around all magnitudes: 0, one or some levels off, and any blue */
        const uint32_t apart = (k >> 1) % 4 == 3 ? 0 : 1U << random_bits(seed) % 8;
        for (int32_t i = 0; i < n; i++) {
            const int32_t r = random_level(seed, m), g = random_level(seed, m);
            const int64_t s = ntp__rest(r, g, m);
            int32_t b = random_level(seed, m);
            if (apart > 0 && s >= 0) {
                b = ntp__blue_of_rest(s, m, zzero) + (int32_t) (random_bits(seed) % apart);
                b = b < m ? b : m;
            }
            block.c[0][i] = r;
            block.c[1][i] = g;
            block.c[2][i] = b;
        }
        check_block(level, &block, n, m, zzero);
    }
}

/* Runs of any length end at a guard page; bytes are seldom far from `middle`. */
static void check_survey8(const ntp__kernels_table *level, int32_t channels, uint64_t *seed)
{
    for (int32_t n = 0; n < 300; n++) {
        guarded src = guarded_alloc((size_t) n * (size_t) channels, true);
        uint8_t *const p = src.data;
        ntp__survey8 found, want = { .least = { 255, 255, 255 } };
        const int32_t middle = (int32_t) random_level(seed, 255);
        for (int32_t i = 0; i < n * channels; i++) {
            const bool any = random_level(seed, 40) == 0;
            p[i] = (uint8_t) (any ? random_level(seed, 255) : middle);
        }
        const int32_t done = level->survey8(&found, p, n, channels);
        CHECK(done <= n && n - done < 32);
        for (int32_t i = 0; i < done * channels; i++) {
            const int32_t c = i % channels;
            if (c == 3)
                continue;
            want.sum[c] += p[i];
            want.least[c] = p[i] < want.least[c] ? p[i] : want.least[c];
            want.greatest[c] = p[i] > want.greatest[c] ? p[i] : want.greatest[c];
        }
        for (int32_t c = 0; done > 0 && c < 3; c++)
            CHECK(found.sum[c] == want.sum[c] && found.least[c] == want.least[c] &&
                  found.greatest[c] == want.greatest[c]);
        guarded_free(&src);
    }
}

/* Sums of many texels: more than 16 bits, and 32. */
static void check_long_survey8(const ntp__kernels_table *level)
{
    enum { TEXELS = 6 << 20 };
    static uint8_t bright[3 * TEXELS];
    ntp__survey8 found;
    memset(bright, 254, sizeof bright);
    bright[4] = 255;
    bright[5] = 1;
    CHECK(level->survey8(&found, bright, TEXELS, 3) == TEXELS);
    CHECK(found.sum[0] == 254ULL * TEXELS && found.sum[1] == found.sum[0] + 1 &&
          found.sum[2] == found.sum[0] - 253);
    CHECK(found.greatest[0] == 254 && found.greatest[1] == 255 && found.greatest[2] == 254);
    CHECK(found.least[0] == 254 && found.least[1] == 254 && found.least[2] == 1);
}

static void check_survey(const ntp__kernels_table *level, uint64_t *seed)
{
    ntp__block block;
    ntp__survey found;
    for (int32_t k = 0; k < 4 * BLOCKS; k++) {
        const int32_t n = 1 + k % NTP__BLOCK;
        uint32_t least[3] = { 65535, 65535, 65535 }, greatest[3] = { 0 }, sum[3] = { 0 };
        bool odd = false;
        for (int32_t i = 0; i < n; i++) {
            const int32_t kind = random_bits(seed) % 512;
            int32_t c[3];
            for (int32_t e = 0; e < 3; e++)
                c[e] = kind == 0   ? (int32_t) (random_bits(seed) % 256) * 257
                       : kind == 1 ? 32766 + (int32_t) (random_bits(seed) % 4)
                                   : (int32_t) (random_bits(seed) % 65536);
            c[2] = kind == 2 ? c[1] = c[0] : c[2];
            odd |= is_odd(c);
            for (int32_t e = 0; e < 3; e++) {
                const uint32_t v = (uint32_t) c[e];
                block.c[e][i] = c[e];
                least[e] = v < least[e] ? v : least[e];
                greatest[e] = v > greatest[e] ? v : greatest[e];
                sum[e] += v;
            }
        }
        level->survey(&found, block.c[0], block.c[1], block.c[2], n);
        CHECK((found.odd != 0) == odd);
        CHECK(memcmp(found.least, least, sizeof least) == 0);
        CHECK(memcmp(found.greatest, greatest, sizeof greatest) == 0);
        CHECK(memcmp(found.sum, sum, sizeof sum) == 0);
    }
}

int main(int argc, char **argv)
{
    const bool avx2 = argc > 1 && strcmp(argv[1], "avx2") == 0;
    if (avx2 && !ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    const ntp__kernels_table *level = ntp__kernels(avx2 ? NTP__CPU_AVX2 : 0);
    uint64_t seed = 2026;
    printf("level %s\n", level->name);
    check_8_bit(level);
    check_16_bit(level, &seed);
    check_survey(level, &seed);
    check_survey8(level, 3, &seed);
    check_survey8(level, 4, &seed);
    check_long_survey8(level);
    return 0;
}
