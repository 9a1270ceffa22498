/* SPDX-License-Identifier: MIT */
/*
 * test_gradient.c - the wide integers of heightfield -> normals, and that every instruction set
 * gives the bytes of the base level
 */
#include "../../gimp-plugin/choices.h"
#include "from_height/gradient.h"
#include "guarded.h"
#include "texel/kernels.h"

#include <math.h>
#include <string.h>

enum { WIDEST = NTP__BLOCK, ROUNDS = 20000, SKIPPED = 77 };

static uint64_t next(uint64_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return *seed;
}

/* (a + b)^2 = a^2 + 2ab + b^2 and (a + b) - b = a for numbers with many limbs. */
static void test_identities(uint64_t *seed)
{
    for (int round = 0; round < ROUNDS; round++) {
        ntp__wide a, b, part, sum, left, right;
        ntp__wide_set(&part, next(seed));
        ntp__wide_shift(&a, &part, (int32_t) (next(seed) % 400));
        ntp__wide_set(&part, next(seed) >> (next(seed) % 64));
        ntp__wide_shift(&b, &part, (int32_t) (next(seed) % 400));
        ntp__wide_copy(&sum, &a);
        ntp__wide_add(&sum, &b);
        ntp__wide_multiply(&left, &sum, &sum);
        ntp__wide_multiply(&part, &a, &b);
        ntp__wide_shift(&right, &part, 1);
        ntp__wide_multiply(&part, &a, &a);
        ntp__wide_add(&right, &part);
        ntp__wide_multiply(&part, &b, &b);
        ntp__wide_add(&right, &part);
        CHECK(ntp__wide_compare(&left, &right) == 0);
        ntp__wide_subtract(&sum, &b);
        CHECK(ntp__wide_compare(&sum, &a) == 0);
        CHECK(a.n == 0 || ntp__wide_bits(&a) > 32 * (a.n - 1));
    }
}

/* x 2^ex - y 2^ey - z 2^ez for small numbers, where a double gives the sign; and for exponents far
 * apart. */
static void test_sign(uint64_t *seed)
{
    for (int round = 0; round < ROUNDS; round++) {
        ntp__wide w[3];
        uint64_t v[3];
        int32_t e[3];
        double value[3];
        for (int k = 0; k < 3; k++) {
            v[k] = next(seed) % 16;
            e[k] = (int32_t) (next(seed) % 12);
            ntp__wide_set(&w[k], v[k]);
            value[k] = ldexp((double) v[k], e[k]);
        }
        double d = value[0] - value[1] - value[2];
        int32_t sign = ntp__wide_sign(&w[0], e[0], &w[1], e[1], &w[2], e[2]);
        CHECK(sign == (d > 0) - (d < 0));
        /* the same far from 0, and with a z that only breaks ties */
        CHECK(sign == ntp__wide_sign(&w[0], e[0] - 3000, &w[1], e[1] - 3000, &w[2], e[2] - 3000));
        d = value[0] - value[1];
        sign = ntp__wide_sign(&w[0], e[0], &w[1], e[1], &w[2], e[2] - 5000);
        CHECK(sign == (d > 0 ? 1 : d < 0 ? -1 : v[2] > 0 ? -1 : 0));
        sign = ntp__wide_sign(&w[0], e[0], &w[1], e[1], &w[2], e[2] + 5000);
        CHECK(sign == (v[2] > 0 ? -1 : (d > 0) - (d < 0)));
    }
}

static void test_to_double(uint64_t *seed)
{
    for (int round = 0; round < ROUNDS; round++) {
        uint64_t v = next(seed) >> (next(seed) % 64);
        int32_t e = (int32_t) (next(seed) % 2400) - 1300;
        ntp__wide a, shifted;
        ntp__wide_set(&a, v);
        /* (double) v is rounded once; also a denormal if v has few bits */
        double expected = e < -1074 ? ldexp((double) (v >> 11), e) : ldexp((double) v, e);
        if (e < -1074)
            ntp__wide_set(&a, v >> 11);
        CHECK(ntp__wide_to_double(&a, e) == expected);
        ntp__wide_shift(&shifted, &a, 77);
        CHECK(ntp__wide_to_double(&shifted, e - 77) == expected);
    }
}

typedef struct levels {
    int32_t plane[3][WIDEST], doubt[WIDEST];
} levels;

static void compare_levels(const levels *a, const levels *b, int32_t n)
{
    for (int k = 0; k < 3; k++)
        CHECK(memcmp(a->plane[k], b->plane[k], (size_t) n * sizeof a->plane[k][0]) == 0);
    CHECK(memcmp(a->doubt, b->doubt, (size_t) n * sizeof a->doubt[0]) == 0);
}

/* Where float is sure, it agrees with double; and it is for most texels. */
static void check_doubts(const levels *single, const levels *precise, int32_t n)
{
    int32_t doubts = 0;
    for (int32_t i = 0; i < n; i++) {
        doubts += single->doubt[i];
        for (int k = 0; k < 3 && !single->doubt[i]; k++)
            CHECK(precise->doubt[i] || single->plane[k][i] == precise->plane[k][i]);
    }
    CHECK(doubts <= n / 2 + 8);
}

static void test_encode(const ntp__gradient_kernels *base, const ntp__gradient_kernels *level,
                        int32_t n, uint64_t *seed)
{
    int32_t right[WIDEST], down[WIDEST];
    double right_d[WIDEST], down_d[WIDEST];
    for (int32_t i = 0; i < n; i++) {
        right_d[i] = right[i] = (int32_t) (next(seed) % 4001) - 2000;
        down_d[i] = down[i] = (int32_t) (next(seed) % 4001) - 2000;
    }
    for (int choice = 0; choice < 16; choice++) {
        static levels a, b, c;
        const ntp__encode e = { .cx = 0.00113,
                                .cy = -0.00209,
                                .half = choice & 2 ? 127.5 : 32767.5,
                                .shortened = 0.8,
                                .use_shortened = choice & 1,
                                .zzero = choice & 4,
                                .off = 1 };
        int32_t *blue_a = choice & 8 ? NULL : a.plane[2], *blue_b = choice & 8 ? NULL : b.plane[2];
        int32_t *blue_c = choice & 8 ? NULL : c.plane[2];
        memset(&a, 0, sizeof a);
        memset(&b, 0, sizeof b);
        memset(&c, 0, sizeof c);
        base->encode_i(a.plane[0], a.plane[1], blue_a, a.doubt, right, down, n, &e);
        level->encode_i(b.plane[0], b.plane[1], blue_b, b.doubt, right, down, n, &e);
        compare_levels(&a, &b, n);
        level->encode_d(b.plane[0], b.plane[1], blue_b, b.doubt, right_d, down_d, n, &e);
        compare_levels(&a, &b, n);
        base->encode_precisely(c.plane[0], c.plane[1], blue_c, c.doubt, right_d, down_d, n, &e);
        level->encode_precisely(b.plane[0], b.plane[1], blue_b, b.doubt, right_d, down_d, n, &e);
        compare_levels(&c, &b, n);
        check_doubts(&a, &c, n);
    }
}

/* A sum whose component is next to a boundary between two levels if the other sum is 0; or any other. */
static double some_sum(uint64_t *seed, double scale, int32_t m, bool ints)
{
    double sum = ((double) (next(seed) % 4001) - 2000) * (next(seed) % 2 ? 1 : 0.01);
    if (next(seed) % 4 == 0)
        sum = 0;
    else if (next(seed) % 2 == 0) {
        const double n = (2.0 * (double) (next(seed) % (uint64_t) m) - m + 1) / m;
        sum = n / sqrt(1 - n * n) / scale * (1 + ((double) (next(seed) % 2001) - 1000) * 0x1p-36);
    }
    return ints ? (double) (int32_t) (sum < 2e9 && sum > -2e9 ? sum : 1e9) : sum;
}

/* Texels that are not left are those of doubles, where these are sure. */
static void check_packed(const uint8_t *got, int32_t *at, int32_t found, const levels *c, int32_t n,
                         bool deep)
{
    at[found] = n;
    for (int32_t i = 0, next_left = 0; i < n; i++) {
        if (at[next_left] == i) {
            next_left++;
            continue;
        }
        CHECK(at[next_left] > i && (c->doubt[i] || c->plane[2][i] >= 0));
        for (int k = 0; k < 3 && !c->doubt[i]; k++) {
            uint16_t value = got[3 * i + k];
            if (deep)
                memcpy(&value, got + 6 * i + 2 * k, 2);
            CHECK(value == c->plane[k][i]);
        }
    }
}

/* Of tap sums, with derived blue; and some are not left. */
static void test_packed(const ntp__gradient_kernels *base, const ntp__gradient_kernels *level,
                        int32_t n, uint64_t *seed)
{
    static const double SCALES[] = { 1e-9, 0.0004, 0.02, 3, 1e5 };
    for (int choice = 0; choice < 80; choice++) {
        const bool ints = choice & 1, deep = choice & 2;
        const int32_t m = deep ? 65535 : 255, size = deep ? 6 : 3;
        const double scale = SCALES[choice / 16];
        const ntp__encode e = { .cx = choice & 4 ? scale : -scale,
                                .cy = choice & 8 ? scale : -scale,
                                .half = m / 2.0,
                                .off = n % 2 ? 1 : 3 };
        static int32_t right[WIDEST], down[WIDEST];
        static double right_d[WIDEST], down_d[WIDEST];
        static levels c;
        uint8_t got[6 * WIDEST + 1];
        int32_t at[WIDEST + 1];
        for (int32_t i = 0; i < n; i++) {
            right_d[i] = some_sum(seed, scale, m, ints);
            down_d[i] = next(seed) % 2 ? 0 : some_sum(seed, scale, m, ints);
            right[i] = ints ? (int32_t) right_d[i] : 0;
            down[i] = ints ? (int32_t) down_d[i] : 0;
        }
        const void *const sums[3] = { ints ? (const void *) right : right_d,
                                      ints ? (const void *) down : down_d };
        base->encode_precisely(c.plane[0], c.plane[1], NULL, c.doubt, right_d, down_d, n, &e);
        ntp__kernels(0)->derive(c.plane[2], c.plane[0], c.plane[1], n, m, 0);
        got[size * n] = 77;
        const int32_t found = level->encode_packed(
            got, at, sums, ints ? NTP__FROM_SUMS_I : NTP__FROM_SUMS_D, n, &e, deep);
        CHECK(got[size * n] == 77 && (scale != 0.02 || found <= n / 8 * 7 + 8));
        check_packed(got, at, found, &c, n, deep);
    }
}

/* Heights of a row, whose zeros follow: integers; or floats, of which large ones cancel out in tap sums. */
static void make_heights(float *h, int32_t row, int32_t n, bool ints, double rough, double small,
                         uint64_t *seed)
{
    const bool flat = next(seed) % 4 == 0;
    for (int32_t i = 0; i < n + 2; i++) {
        const double some = (double) (next(seed) % 65536) / 65536 * (next(seed) % 8 ? small : 1e-7);
        if (ints)
            h[i] = (float) (next(seed) % 65536);
        else if (flat)
            h[i] = 0.75F;
        else
            h[i] = (float) ((i & 2 ? row == 1 ? -rough : rough : 0) + some);
    }
    memset(h + n + 2, 0, NTP__LANES * sizeof *h);
}

/* The same from rows of heights. */
static void test_rows(const ntp__gradient_kernels *base, ntp__encode_packed_fn *encode, int32_t n,
                      uint64_t *seed)
{
    static const float TAPS[][2] = { { 0, 1 }, { 1, 1 }, { 1, 2 }, { 3, 10 } };
    for (int choice = 0; choice < 64; choice++) {
        const bool ints = choice & 1, deep = choice & 2;
        const int32_t m = deep ? 65535 : 255, size = deep ? 6 : 3;
        const float *taps = TAPS[choice / 4 % 4];
        const double scale = (ints ? 0x1p-16 : 1) * (choice & 16 ? -1 : 1) / 8;
        const double rough = choice & 32 ? 0 : 3000,
                     small = rough > 0 && next(seed) % 4 == 0 ? 1e-7 : 1;
        const ntp__encode e = { .cx = scale,
                                .cy = next(seed) % 2 ? scale : -scale,
                                .half = m / 2.0,
                                .side = taps[0],
                                .middle = taps[1],
                                .spread = 2 * rough + 1,
                                .off = 1 };
        float h[3][NTP__GRADIENT_ROW];
        double sums[2][WIDEST] = { { 0 } }; /* whole groups are encoded */
        static levels c;
        uint8_t got[6 * WIDEST + 1];
        int32_t at[WIDEST + 1];
        for (int32_t k = 0; k < 3; k++)
            make_heights(h[k], k, n, ints, rough, small, seed);
        if (small < 1) /* no slope down, so that red decides alone */
            memcpy(h[2], h[0], sizeof h[0]);
        for (int32_t i = 0; i < n; i++) {
            double d[2][3]; /* to the right and down */
            for (int k = 0; k < 3; k++) {
                d[0][k] = (double) h[k][i + 2] - (double) h[k][i];
                d[1][k] = (double) h[2][i + k] - (double) h[0][i + k];
            }
            for (int k = 0; k < 2; k++)
                sums[k][i] = (double) taps[0] * (d[k][0] + d[k][2]) + (double) taps[1] * d[k][1];
        }
        const void *const from[3] = { h[0], h[1], h[2] };
        base->encode_precisely(c.plane[0], c.plane[1], NULL, c.doubt, sums[0], sums[1], n, &e);
        ntp__kernels(0)->derive(c.plane[2], c.plane[0], c.plane[1], n, m, 0);
        got[size * n] = 77;
        const int32_t found =
            encode(got, at, from, ints ? NTP__FROM_INTEGERS : NTP__FROM_FLOATS, n, &e, deep);
        CHECK(got[size * n] == 77 && (found >= 0 || rough > 0));
        CHECK(found <= n / 2 + 8 || rough > 0);
        if (found >= 0)
            check_packed(got, at, found, &c, n, deep);
    }
}

/* Heights as they are, and the range of floats. */
static void test_heights(const ntp__gradient_kernels *level, int32_t n, uint64_t *seed)
{
    uint8_t s8[WIDEST] = { 0 };
    uint16_t s16[WIDEST] = { 0 };
    float s[WIDEST] = { 0 }, got[WIDEST + 1], low = 0x1p127F, high = -0x1p127F;
    double h[WIDEST];
    ntp__magnitudes m = { INT32_MAX, 0, low, high }, want = m;
    for (int32_t i = 0; i < n; i++) {
        s8[i] = (uint8_t) next(seed);
        s16[i] = (uint16_t) next(seed);
        s[i] = next(seed) % 5 && n % 7 ? (float) ((double) next(seed) * 1e-9 - 1e10) : 0;
        low = s[i] < low ? s[i] : low;
        high = s[i] > high ? s[i] : high;
    }
    got[n] = -7;
    level->take_heights(got, s8, NTP_TYPE_U8, n, &m);
    for (int32_t i = 0; i < n; i++)
        CHECK(got[i] == (float) s8[i]);
    level->take_heights(got, s16, NTP_TYPE_U16, n, &m);
    for (int32_t i = 0; i < n; i++)
        CHECK(got[i] == (float) s16[i]);
    CHECK(m.least == INT32_MAX && m.most == 0);
    level->take_heights(got, s, NTP_TYPE_F32, n, &m);
    level->take_floats(h, s, n, &want);
    CHECK(memcmp(got, s, (size_t) n * sizeof *s) == 0);
    CHECK(m.least == want.least && m.most == want.most);
    CHECK(m.low == low && m.high == high);
    CHECK(got[n] == -7);
}

/* Zeros, infinities and what is no number too. */
static void test_floats(const ntp__gradient_kernels *level, int32_t n, uint64_t *seed)
{
    float s[WIDEST];
    double h[WIDEST];
    ntp__magnitudes m = { INT32_MAX, 0, 0, 0 };
    int32_t least = INT32_MAX, most = 0;
    for (int32_t i = 0; i < n; i++) {
        const uint32_t bits = next(seed) % 5 ? (uint32_t) next(seed) : (uint32_t) next(seed) << 31;
        const int32_t size = (int32_t) (bits & INT32_MAX);
        memcpy(&s[i], &bits, sizeof bits);
        most = size > most ? size : most;
        least = size > 0 && size - 1 < least ? size - 1 : least;
    }
    level->take_floats(h, s, n, &m);
    CHECK(m.least == least && m.most == most);
    for (int32_t i = 0; i < n; i++)
        CHECK(h[i] == (double) s[i] || (s[i] != s[i] && h[i] != h[i]));
}

typedef struct wave {
    ntp__wave_step steps[NTP__WAVE_STEPS];
    double along[NTP__WAVE], down[WIDEST];
} wave;

/* A slope of at most a size, or 0; or one whose level of 8 bit is next to another one, but for an error
 * from before. */
static double some_slope(uint64_t *seed, double size, bool edge)
{
    if (edge && next(seed) % 4 == 0)
        return ((double) (next(seed) % 3) - 1) * 1e-12;
    if (edge) {
        const double n = ((double) (next(seed) % 255) - 127) / 127.5;
        return n / sqrt(1 - n * n) * (1 + ((double) (next(seed) % 2001) - 1000) * 0x1p-34);
    }
    return next(seed) % 8 == 0 ? 0 : ((double) (next(seed) % 4001) / 2000 - 1) * size;
}

static void test_dither(const ntp__gradient_kernels *base, const ntp__gradient_kernels *level,
                        int32_t n, uint64_t *seed)
{
    static const double SIZES[] = { 0.02, 0.4, 5, 400, 1e7 };
    for (int32_t choice = 0; choice < 80; choice++) {
        static wave a, b;
        const double size = SIZES[choice / 8 % 5];
        const bool edge = choice >= 40 && n < 4;
        const int32_t rows = 1 + (int32_t) (next(seed) % NTP__WAVE);
        const ntp__dithering how = { choice & 1 ? 255 : 65535, choice & 2, choice & 4 ? 0.6 : 0,
                                     0.8 };
        memset(&a, 0, sizeof a);
        for (int32_t i = 0; i < n; i++) {
            for (int32_t k = 0; k < rows; k++) {
                a.steps[i + k].slope[0][k] = some_slope(seed, size, edge);
                a.steps[i + k].slope[1][k] = edge ? 0 : some_slope(seed, size, false);
            }
        }
        b = a;
        base->dither(a.steps, a.along, a.down, rows, n, &how);
        level->dither(b.steps, b.along, b.down, rows, n, &how);
        for (int32_t k = 0; k < rows; k++)
            CHECK(a.along[k] == b.along[k]);
        for (int32_t i = 0; i < n; i++) {
            CHECK(a.down[i] == b.down[i]);
            for (int32_t k = 0; k < rows; k++) {
                for (int32_t c = 0; c < 3; c++)
                    CHECK(a.steps[i + k].level[c][k] == b.steps[i + k].level[c][k]);
            }
        }
    }
}

/* Rows of a wave go to its steps and back: column i of row k is in step i + k. */
static void test_turns(const ntp__gradient_kernels *level, int32_t n, int32_t rows, uint64_t *seed)
{
    static ntp__wave_step steps[NTP__WAVE_STEPS];
    static ntp__wave_rows part;
    static int32_t turned[NTP__WAVE_STEPS][3][NTP__WAVE];
    const int32_t used = n + rows - 1;
    for (int32_t first = 0; first < NTP__WAVE; first += NTP__WAVE_PART) {
        memset(&part, 0, sizeof part);
        for (int32_t k = 0; k < NTP__WAVE_PART && first + k < rows; k++) {
            for (int32_t i = 0; i < 2 * n; i++)
                part.slope[k][i % 2][NTP__WAVE + i / 2] = (double) (next(seed) % 99);
        }
        level->put_slopes(steps, &part, first, used);
        for (int32_t t = 0; t < used; t++) {
            for (int32_t i = 0; i < 2 * NTP__WAVE_PART; i++) {
                const int32_t k = i / 2, x = t - first - k;
                const double want = x < 0 || x >= n ? 0 : part.slope[k][i % 2][NTP__WAVE + x];
                CHECK(steps[t].slope[i % 2][first + k] == want);
            }
        }
    }
    for (int32_t i = 0; i < used * 3 * NTP__WAVE; i++)
        (&turned[0][0][0])[i] = (int32_t) (next(seed) % 65536);
    for (int32_t t = 0; t < used; t++)
        memcpy(steps[t].level, turned[t], sizeof turned[t]);
    for (int32_t k = 0; k < rows; k++) {
        if (k % NTP__WAVE_PART == 0)
            level->take_levels(&part, steps, k, used);
        for (int32_t i = 0; i < 3 * n; i++)
            CHECK(part.level[k % NTP__WAVE_PART][i % 3][NTP__WAVE + i / 3] ==
                  turned[i / 3 + k][i % 3][k]);
    }
}

/* The menus of the plug-in are in the library's order. */
static void test_choices(void)
{
#define N_(label)             label
#define NAME(id, name, label) name,
    static const char *const kernels[] = { NTP_KERNEL_CHOICES(NAME) };
    static const char *const borders[] = { NTP_BORDER_CHOICES(NAME) };
    CHECK(sizeof kernels / sizeof kernels[0] == NTP__KERNELS);
    CHECK(sizeof borders / sizeof borders[0] == NTP_BORDERS);
    for (int i = 0; i < NTP__KERNELS; i++)
        CHECK(strcmp(kernels[i], ntp_kernel_name((ntp_kernel) i)) == 0);
    for (int i = 0; i < NTP_BORDERS; i++)
        CHECK(strcmp(borders[i], ntp_border_name((ntp_border) i)) == 0);
}

int main(int argc, char **argv)
{
    bool avx2 = argc > 1 && strcmp(argv[1], "avx2") == 0;
    if (avx2 && !ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    uint64_t seed = 88172645463325252u;
    test_choices();
    test_identities(&seed);
    test_sign(&seed);
    test_to_double(&seed);
    const ntp__gradient_kernels *base = ntp__gradient_kernels_for(0);
    const ntp__gradient_kernels *level = ntp__gradient_kernels_for(avx2 ? NTP__CPU_AVX2 : 0);
    ntp__encode_packed_fn *const rows_512 = ntp__encode_rows_for(avx2 ? NTP__CPU_ALL : 0);
    for (int32_t n = 1; n <= WIDEST; n += n < 40 ? 1 : 27) {
        test_encode(base, level, n, &seed);
        test_floats(level, n, &seed);
        if (level->encode_packed != NULL) {
            test_packed(base, level, n, &seed);
            test_rows(base, level->encode_packed, n, &seed);
            if (rows_512 != NULL)
                test_rows(base, rows_512, n, &seed);
            if (n >= NTP__LANES)
                test_heights(level, n, &seed);
        }
        const int32_t columns = n < NTP__WAVE_COLUMNS ? n : NTP__WAVE_COLUMNS;
        test_dither(base, level, columns, &seed);
        test_turns(level, columns, 1 + (int32_t) (next(&seed) % NTP__WAVE), &seed);
    }
    for (int32_t i = 0; i < 40 && level->encode_packed != NULL; i++)
        test_rows(base, rows_512 != NULL && i % 2 ? rows_512 : level->encode_packed, WIDEST, &seed);
    test_turns(level, NTP__WAVE_COLUMNS, NTP__WAVE, &seed);
    for (int32_t i = 0; i < 200; i++)
        test_dither(base, level, 1 + i % 3, &seed);
    return 0;
}
