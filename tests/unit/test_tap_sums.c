/* SPDX-License-Identifier: MIT */
/*
 * test_tap_sums.c - tap sums of rows of heights: as the table of kernels says, and the same bytes with
 * every instruction set; and floats that are made of sums: right, or in doubt where they have to be
 */
#include "from_height/gradient.h"
#include "guarded.h"
#include "texel/kernels.h"

#include <math.h>
#include <string.h>

enum { WIDEST = NTP__BLOCK, SKIPPED = 77 };

static uint64_t next(uint64_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return *seed;
}

/* The tap sum of texel i, straight from the table. */
static int32_t plain_sum(const int32_t *const rows[NTP__MAX_TAPS], const ntp__kernel *kernel,
                         bool down, int32_t i)
{
    int32_t sum = 0;
    for (int32_t a = 0; a < NTP__MAX_TAPS; a++) {
        for (int32_t b = 0; b < NTP__MAX_TAPS; b++) {
            for (int32_t t = 0; t < kernel->terms; t++)
                sum += kernel->term[t].along[a] * kernel->term[t].across[b] *
                       (down ? rows[a][i + b] : rows[b][i + a]);
        }
    }
    return sum;
}

static void test_sums(const ntp__gradient_kernels *base, const ntp__gradient_kernels *level,
                      int32_t n, uint64_t *seed)
{
    static ntp__height_row row[NTP__MAX_TAPS], row_d[NTP__MAX_TAPS];
    const int32_t *rows[NTP__MAX_TAPS];
    const double *rows_d[NTP__MAX_TAPS];
    for (int k = 0; k < NTP__MAX_TAPS; k++) {
        for (int32_t i = 0; i < NTP__GRADIENT_ROW; i++) {
            row[k].h.i[i] = (int32_t) (next(seed) % 65536);
            row_d[k].h.d[i] = (double) (next(seed) % 65536) / 65535;
        }
        rows[k] = row[k].h.i;
        rows_d[k] = row_d[k].h.d;
    }
    for (int kernel = 0; kernel < (int) NTP__KERNELS; kernel++) {
        for (int down = 0; down < 2; down++) {
            int32_t a[WIDEST], b[WIDEST];
            double c[WIDEST], d[WIDEST];
            base->tap_sums_i(a, rows, &ntp__kernel_table[kernel], down, n);
            level->tap_sums_i(b, rows, &ntp__kernel_table[kernel], down, n);
            CHECK(memcmp(a, b, (size_t) n * sizeof *a) == 0);
            for (int32_t i = 0; i < n; i++)
                CHECK(a[i] == plain_sum(rows, &ntp__kernel_table[kernel], down != 0, i));
            base->tap_sums_d(c, rows_d, &ntp__kernel_table[kernel], down, n);
            level->tap_sums_d(d, rows_d, &ntp__kernel_table[kernel], down, n);
            CHECK(memcmp(c, d, (size_t) n * sizeof *c) == 0);
        }
    }
}

/* Components of a texel as floats, the least and the greatest, if each is off by `part` of it and by `more`.
 * The doubles here are off by less than 2^-48 of it, those of (n + 1)/2 by less than 2^-50 besides. */
static void bounds_of(float range[3][2], double right, double down, const ntp__encode *e,
                      double part, double more)
{
    const double x = right * e->cx, y = down * e->cy, square = x * x + y * y;
    const double z = 1 / sqrt(1 + square), shortened = e->shortened / sqrt(square);
    const double factor = e->use_shortened && shortened < z ? shortened : z;
    const double n[3] = { x * factor, y * factor, z };
    for (int k = 0; k < 3; k++) {
        const bool unit = e->unit && (k < 2 || !e->zzero);
        const double least = k < 2 ? -1 : unit ? (e->min_z + 1) / 2 : e->min_z;
        const double t = unit ? (n[k] + 1) / 2 : n[k], off = fabs(t) * part + more;
        for (int i = 0; i < 2; i++) {
            const float v = (float) (i ? t + off : t - off) + 0.0F;
            range[k][i] = k == 2 && v < (float) least ? (float) least : v;
        }
    }
}

static bool one_float(float range[3][2])
{
    return range[0][0] == range[0][1] && range[1][0] == range[1][1] && range[2][0] == range[2][1];
}

/* What ntp__gradient_exact might count as wide is in doubt, little else is, and what is not is right. */
static void check_vectors(ntp__encode_vectors_fn *encode, const void *const from[3],
                          ntp__packed_from which, double sum[2][WIDEST], int32_t n,
                          const ntp__encode *e)
{
    static float got[3 * WIDEST + 1];
    int32_t at[WIDEST], next_at = 0;
    got[3 * n] = 7;
    const int32_t found = encode(got, at, from, which, n, e);
    CHECK(got[3 * n] == 7 && found >= 0 && found <= n);
    for (int32_t i = 0; i < n; i++) {
        float range[3][2];
        const bool doubt = next_at < found && at[next_at] == i;
        next_at += doubt;
        if (doubt) {
            bounds_of(range, sum[0][i], sum[1][i], e, 0x1p-43, 1.01 * e->rough + 0x1p-47 * e->unit);
            /* A z that becomes min_z may be in doubt, too. */
            CHECK(!one_float(range) || e->use_shortened);
            continue;
        }
        bounds_of(range, sum[0][i], sum[1][i], e, 0x1.4p-46, 0);
        CHECK(one_float(range));
        for (int k = 0; k < 3; k++)
            CHECK(got[3 * i + k] == range[k][0] &&
                  !(got[3 * i + k] == 0 && signbit(got[3 * i + k])));
    }
    CHECK(next_at == found);
}

/* A sum whose x (or z, if it is large) is close to a middle of two floats: within 2^-43 of it. */
static double near_middle(uint64_t *seed, bool large)
{
    const double middle = (double) (next(seed) % 0x800000 + 0x800000) + 0.5;
    const double v = middle * (1 + ((double) (next(seed) % 65) - 32) * 0x1p-48) * 0x1p-60;
    return next(seed) % 2 ? large ? 1 / v : v : large ? -1 / v : -v;
}

static void test_floats_of_sums(ntp__encode_vectors_fn *encode, int32_t n, uint64_t *seed)
{
    static const double SCALES[] = { 1e-44, 1e-6, 1, 0.02, 30, 1e9, 1e25 };
    for (int choice = 0; choice < 7 * 16; choice++) {
        ntp__encode e = { .cx = SCALES[choice % 7],
                          .cy = -SCALES[choice % 7],
                          .shortened = 0.8,
                          .use_shortened = choice & 1,
                          .min_z = choice & 1 ? 0.6 : 0,
                          .zzero = choice & 2,
                          .unit = choice & 4,
                          .steep = choice & 8 || choice % 7 == 6,
                          .rough = next(seed) % 2 ? 0 : 1e-9,
                          .ahead = (const char *) SCALES };
        e.plain = choice % 7 != 0 && !e.use_shortened && !e.unit && e.rough == 0 && next(seed) % 2;
        static double sum[2][WIDEST];
        static int32_t sum_i[2][WIDEST];
        for (int32_t i = 0; i < n; i++) {
            for (int k = 0; k < 2; k++) {
                sum_i[k][i] = next(seed) % 8 ? (int32_t) (next(seed) % 40001) - 20000 : 0;
                sum[k][i] = sum_i[k][i] * 0x1p-9;
            }
            if (choice % 7 == 2 && i % 2) {
                sum[0][i] = near_middle(seed, next(seed) % 2);
                sum[1][i] = 0;
            }
        }
        const void *const from[3] = { sum[0], sum[1] }, *const from_i[3] = { sum_i[0], sum_i[1] };
        check_vectors(encode, from, NTP__FROM_SUMS_D, sum, n, &e);
        for (int32_t i = 0; i < n; i++) {
            for (int k = 0; k < 2; k++)
                sum[k][i] = sum_i[k][i];
        }
        check_vectors(encode, from_i, NTP__FROM_SUMS_I, sum, n, &e);
    }
}

/* Straight from rows of heights: of integers, of floats whose sums are exact in doubles, and of such that get lost
 * beside others. */
static void test_floats_of_rows(ntp__encode_vectors_fn *encode, int32_t n, uint64_t *seed)
{
    static float row[3][NTP__GRADIENT_ROW];
    static double sum[2][WIDEST];
    for (int choice = 0; choice < 3; choice++) {
        const double scale = choice ? 0x1p-1 : 0x1p-14;
        const ntp__encode e = { .cx = scale,
                                .cy = scale / 3,
                                .side = 3,
                                .middle = 10,
                                .rough = choice == 2 ? 0x1p-44 : 0,
                                .plain = choice < 2,
                                .ahead = (const char *) row };
        for (int32_t i = 0; i < 3 * NTP__GRADIENT_ROW; i++) {
            const uint64_t r = next(seed);
            const float small = (float) (r >> 48) * 0x1p-16F;
            row[i % 3][i / 3] = choice == 0   ? small * 0x1p16F
                                : choice == 1 ? small
                                : r % 2       ? (float) (r >> 62)
                                              : small * 0x1p-70F;
        }
        for (int32_t i = 0; i < n; i++) {
            static const int taps[3] = { 3, 10, 3 };
            /* Exact: the sums of heights of 1 and more, and those of others. */
            double large[2] = { 0 }, rest[2] = { 0 };
            for (int k = 0; k < 9; k++) {
                const int x = k % 3, y = k / 3;
                const double h = (double) row[y][i + x];
                double *to = h < 1 ? rest : large;
                to[0] += h * ((x - 1) * taps[y]);
                to[1] += h * ((y - 1) * taps[x]);
            }
            for (int k = 0; k < 2; k++)
                sum[k][i] = large[k] + rest[k];
        }
        const void *const from[3] = { row[0], row[1], row[2] };
        check_vectors(encode, from, choice ? NTP__FROM_FLOATS : NTP__FROM_INTEGERS, sum, n, &e);
    }
}

int main(int argc, char **argv)
{
    bool avx2 = argc > 1 && strcmp(argv[1], "avx2") == 0;
    if (avx2 && !ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    uint64_t seed = 88172645463325252u;
    const ntp__gradient_kernels *base = ntp__gradient_kernels_for(0);
    const ntp__gradient_kernels *level = ntp__gradient_kernels_for(avx2 ? NTP__CPU_AVX2 : 0);
    ntp__encode_vectors_fn *const vectors_512 = ntp__encode_vectors_for(avx2 ? NTP__CPU_ALL : 0);
    for (int32_t n = 1; n <= WIDEST; n += n < 40 ? 1 : 27) {
        test_sums(base, level, n, &seed);
        test_floats_of_sums(level->encode_vectors, n, &seed);
        test_floats_of_sums(vectors_512, n, &seed);
        if (level->take_heights != NULL) {
            test_floats_of_rows(level->encode_vectors, n, &seed);
            test_floats_of_rows(vectors_512, n, &seed);
        }
    }
    return 0;
}
