/* SPDX-License-Identifier: MIT */
/*
 * test_dither.c - dithering of two waves with AVX-512 gives what the base level gives of one after the
 * other, and touches no byte beside them
 */
#include "base/cpu.h"
#include "from_height/gradient.h"
#include "guarded.h"

#include <math.h>
#include <string.h>

enum { M = 255, ROWS = NTP__WAVES * NTP__WAVE, SKIPPED = 77 };

/* Slopes and errors of a wave, and what became of them. */
typedef struct side {
    guarded steps[NTP__WAVES], along, down;
} side;

static int32_t rows_of(int32_t rows, int32_t wave)
{
    const int32_t left = rows - wave * NTP__WAVE;
    return left < 0 ? 0 : left < NTP__WAVE ? left : NTP__WAVE;
}

static size_t steps_of(int32_t rows, int32_t n)
{
    return rows == 0 ? 0 : sizeof(ntp__wave_step) * (size_t) (n + rows - 1);
}

static side make_side(int32_t rows, int32_t n, bool at_start)
{
    side s;
    for (int32_t k = 0; k < NTP__WAVES; k++) {
        const size_t size = steps_of(rows_of(rows, k), n);
        s.steps[k] = guarded_alloc(size, at_start);
        memset(s.steps[k].data, 0, size);
    }
    s.along = guarded_alloc(sizeof(double) * (size_t) rows, at_start);
    s.down = guarded_alloc(sizeof(double) * (size_t) n, at_start);
    return s;
}

static void free_side(side *s)
{
    for (int32_t k = 0; k < NTP__WAVES; k++)
        guarded_free(&s->steps[k]);
    guarded_free(&s->along);
    guarded_free(&s->down);
}

static double share(uint64_t *seed)
{
    return (double) random_bits(seed) * 0x1p-31 - 1;
}

/* A slope of at most a size, or 0; or one next to a boundary of levels, or next to 0. */
static double some_slope(uint64_t *seed, double size, bool edge)
{
    if (random_bits(seed) % 8 == 0)
        return edge ? share(seed) * 0x1p-54 : 0;
    if (!edge)
        return share(seed) * size;
    const double n = ((double) (random_bits(seed) % M) - 127) / 127.5;
    return n / sqrt(1 - n * n) * (1 + share(seed) * 0x1p-24);
}

static void fill(side *a, side *b, int32_t rows, int32_t n, double size, bool edge, uint64_t *seed)
{
    for (int32_t k = 0; k < rows; k++) {
        ntp__wave_step *steps[] = { a->steps[k / NTP__WAVE].data, b->steps[k / NTP__WAVE].data };
        const int32_t row = k % NTP__WAVE;
        for (int32_t i = 0; i < n; i++) {
            const double x = some_slope(seed, size, edge), y = edge ? 0 : share(seed) * size;
            for (int j = 0; j < 2; j++) {
                steps[j][i + row].slope[0][row] = x;
                steps[j][i + row].slope[1][row] = y;
            }
        }
    }
    const double error = edge ? 0 : size * 0x1p-6;
    for (int32_t k = 0; k < rows; k++)
        ((double *) a->along.data)[k] = ((double *) b->along.data)[k] = share(seed) * error;
    for (int32_t i = 0; i < n; i++)
        ((double *) a->down.data)[i] = ((double *) b->down.data)[i] = share(seed) * error;
}

static void check(const side *a, const side *b, int32_t rows, int32_t n)
{
    CHECK(memcmp(a->along.data, b->along.data, sizeof(double) * (size_t) rows) == 0);
    CHECK(memcmp(a->down.data, b->down.data, sizeof(double) * (size_t) n) == 0);
    for (int32_t k = 0; k < rows; k++) {
        const ntp__wave_step *p = a->steps[k / NTP__WAVE].data, *q = b->steps[k / NTP__WAVE].data;
        const int32_t row = k % NTP__WAVE;
        for (int32_t i = 0; i < n; i++) {
            for (int32_t c = 0; c < 3; c++)
                CHECK(p[i + row].level[c][row] == q[i + row].level[c][row]);
        }
    }
}

static void test_waves(ntp__dither_waves_fn *waves, const ntp__gradient_kernels *base, int32_t rows,
                       int32_t n, uint64_t *seed)
{
    static const double SIZES[] = { 0.02, 0.4, 5, 400, 1e7, 1 };
    enum { EDGE = 5 };
    for (int32_t choice = 0; choice < 12; choice++) {
        const ntp__dithering how = { M, choice % 2, 0, 1 };
        side a = make_side(rows, n, choice & 1), b = make_side(rows, n, random_bits(seed) & 1);
        ntp__wave_step *steps[NTP__WAVES];
        fill(&a, &b, rows, n, SIZES[choice / 2], choice / 2 == EDGE, seed);
        for (int32_t k = 0; k < NTP__WAVES; k++) {
            steps[k] = b.steps[k].data;
            if (rows_of(rows, k) > 0)
                base->dither(a.steps[k].data, (double *) a.along.data + k * NTP__WAVE, a.down.data,
                             rows_of(rows, k), n, &how);
        }
        waves(steps, b.along.data, b.down.data, rows, n, how.zzero);
        check(&a, &b, rows, n);
        free_side(&a);
        free_side(&b);
    }
}

/* Every pair of numerators of 8 bit: the quotients of the kernel are those of a division. */
static void test_quotients(ntp__dither_waves_fn *waves, const ntp__gradient_kernels *base,
                           uint64_t *seed)
{
    static ntp__wave_step steps[NTP__WAVES][NTP__WAVE_STEPS];
    static ntp__wave_step other[NTP__WAVE_STEPS];
    for (int32_t r = 0; r <= M; r++) {
        for (int32_t first = 0; first <= M; first += NTP__WAVE) {
            double along[2][NTP__WAVE] = { { 0 } }, down[2] = { 0 };
            memset(steps[0], 0, sizeof steps[0][0] * NTP__WAVE);
            for (int32_t k = 0; k < NTP__WAVE; k++) {
                const double p = 2 * r - M, q = 2 * (first + k) - M,
                             z = M * (double) M - p * p - q * q;
                const double by = z > 0 ? 1 / sqrt(z) : 1;
                steps[0][k].slope[0][k] = p * by + share(seed) * 0x1p-9 * by;
                steps[0][k].slope[1][k] = q * by + share(seed) * 0x1p-9 * by;
            }
            memcpy(other, steps[0], sizeof steps[0][0] * NTP__WAVE);
            ntp__wave_step *given[NTP__WAVES] = { steps[0], steps[1] };
            const ntp__dithering how = { M, false, 0, 1 };
            waves(given, along[0], &down[0], NTP__WAVE, 1, false);
            base->dither(other, along[1], &down[1], NTP__WAVE, 1, &how);
            CHECK(down[0] == down[1]);
            for (int32_t k = 0; k < NTP__WAVE; k++) {
                CHECK(along[0][k] == along[1][k]);
                for (int32_t c = 0; c < 3; c++)
                    CHECK(steps[0][k].level[c][k] == other[k].level[c][k]);
            }
        }
    }
}

int main(void)
{
    const ntp__gradient_kernels *base = ntp__gradient_kernels_for(0);
    ntp__dither_waves_fn *waves = ntp__dither_waves(NTP__CPU_ALL);
    uint64_t seed = 20240229;
    CHECK(ntp__dither_waves(0) == NULL);
    if (waves == NULL)
        return SKIPPED;
    for (int32_t rows = 1; rows <= ROWS; rows++) {
        for (int32_t n = 1; n <= NTP__WAVE_COLUMNS; n += n < 6 ? 1 : 125)
            test_waves(waves, base, rows, n, &seed);
    }
    for (int32_t n = 1; n <= NTP__WAVE_COLUMNS; n += n < 40 ? 1 : 27)
        test_waves(waves, base, 1 + (int32_t) (random_bits(&seed) % ROWS), n, &seed);
    for (int32_t i = 0; i < 8; i++)
        test_quotients(waves, base, &seed);
    return 0;
}
