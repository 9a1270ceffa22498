/* SPDX-License-Identifier: MIT */
/*
 * test_tap_sums.c - tap sums of rows of heights: as the table of kernels says, and the same bytes with
 * every instruction set; and so are floats that are made of sums
 */
#include "from_height/gradient.h"
#include "guarded.h"
#include "texel/kernels.h"

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

/* Floats of every instruction set are those of the base level, and so are their doubts. */
static void test_floats_of_sums(const ntp__gradient_kernels *base,
                                const ntp__gradient_kernels *level, int32_t n, uint64_t *seed)
{
    static const double SCALES[] = { 1e-44, 1e-6, 0.02, 30, 1e9 };
    for (int choice = 0; choice < 40; choice++) {
        const ntp__encode e = { .cx = SCALES[choice % 5],
                                .cy = -SCALES[choice % 5],
                                .shortened = 0.8,
                                .use_shortened = choice & 1,
                                .min_z = choice & 1 ? 0.6 : 0,
                                .zzero = choice & 2,
                                .unit = choice & 4,
                                .rough = next(seed) % 2 ? 0 : 1e-9 };
        static float got[2][3][WIDEST];
        static int32_t doubt[2][WIDEST];
        static double sum[2][WIDEST];
        for (int32_t i = 0; i < 2 * n; i++)
            sum[i % 2][i / 2] =
                next(seed) % 8 ? ((double) (next(seed) % 40001) - 20000) * 0x1p-9 : 0;
        for (int k = 0; k < 2; k++) {
            float *const to[3] = { got[k][0], got[k][1], got[k][2] };
            (k ? level : base)->encode_floats(to, doubt[k], sum[0], sum[1], n, &e);
            CHECK(memcmp(doubt[0], doubt[k], (size_t) n * sizeof doubt[0][0]) == 0);
            for (int c = 0; c < 3; c++)
                CHECK(memcmp(got[0][c], got[k][c], (size_t) n * sizeof got[0][c][0]) == 0);
        }
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
    for (int32_t n = 1; n <= WIDEST; n += n < 40 ? 1 : 27) {
        test_sums(base, level, n, &seed);
        test_floats_of_sums(base, level, n, &seed);
    }
    return 0;
}
