/* SPDX-License-Identifier: MIT */
/*
 * test_fft.c - the transforms against direct sums, for every length to 300 and some beyond
 */
#include "fft.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = NTP__FFT_ROWS, ALIGNMENT = 64 };

static const double pi = 3.14159265358979323846;
static const double tolerance = 2e-7; /* of the largest value: results are stored as floats */

static uint32_t state = 1;

static double noise(void)
{
    state = state * 1664525u + 1013904223u;
    return (double) (state >> 8) / (1 << 23) - 1;
}

/* Coefficient j of a line, as fft.h defines it. */
static double direct(ntp__fft_kind kind, const double *line, int32_t n, int32_t j)
{
    double sum = 0;
    for (int64_t i = 0; i < n; i++) {
        if (kind == NTP__FFT_COSINE)
            sum += line[i] * cos(pi * (double) (j * (2 * i + 1) % (4 * n)) / (2.0 * n));
        else if (2 * j <= n)
            sum += line[i] * cos(2 * pi * (double) (j * i % n) / n);
        else
            sum -= line[i] * sin(2 * pi * (double) ((n - j) * i % n) / n);
    }
    return sum;
}

static void *allocate(size_t bytes)
{
    void *memory = aligned_alloc(ALIGNMENT, (bytes / ALIGNMENT + 1) * ALIGNMENT);
    if (memory == NULL)
        abort();
    return memory;
}

static int check(ntp__fft_kind kind, int32_t n)
{
    ntp__fft fft;
    size_t row = (size_t) n;
    void *tables = allocate(ntp__fft_tables(kind, n)), *work = allocate(ntp__fft_work(kind, n));
    double *lines = allocate(ROWS * row * sizeof *lines);
    float *out = allocate(ROWS * row * sizeof *out), *rows[ROWS];
    double largest = 0, off = 0;
    ntp__fft_init(&fft, kind, n, tables, work);
    for (int32_t r = 0; r < ROWS; r++) {
        for (size_t i = 0; i < row; i++)
            lines[(size_t) r * row + i] = noise();
        rows[r] = out + (size_t) r * row;
        ntp__fft_load(&fft, r, lines + (size_t) r * row, work);
    }
    ntp__fft_forward(&fft, rows, work);
    for (int32_t r = 0; r < ROWS; r += 5) { /* of either parity, and the first and last lanes */
        for (int32_t j = 0; j < n; j++) {
            double want = direct(kind, lines + (size_t) r * row, n, j);
            largest = fmax(largest, fabs(want));
            off = fmax(off, fabs(want - (double) rows[r][j]));
        }
    }
    int bad = off > tolerance * largest;
    ntp__fft_inverse(&fft, rows, work);
    double back = 0;
    for (size_t i = 0; i < ROWS * row; i++)
        back = fmax(back, fabs(lines[i] - (double) out[i]));
    bad = bad || back > 2 * tolerance;
    if (bad)
        printf("kind %d, length %d: off by %g of %g, inverse by %g\n", (int) kind, (int) n, off,
               largest, back);
    free(tables);
    free(work);
    free(lines);
    free(out);
    return bad;
}

static int check_turns(void)
{
    int bad = 0;
    for (int64_t n = 1; n <= 128; n++) {
        for (int64_t k = 0; k < n; k++) {
            double c, s, angle = 2 * pi * (double) k / (double) n;
            ntp__turn(&c, &s, k, n);
            /* the angle itself is rounded, by up to 2^-51 */
            bad += fabs(c - cos(angle)) > 2e-15 || fabs(s - sin(angle)) > 2e-15;
            bad += (4 * k == n || 4 * k == 3 * n) && c != 0;
            bad += (k == 0 || 2 * k == n) && s != 0;
        }
    }
    if (bad)
        printf("%d sines or cosines are wrong\n", bad);
    return bad;
}

int main(void)
{
    static const int32_t more[] = { 307, 331, 512, 997, 1000, 1024, 1296, 2039 };
    int bad = check_turns();
    for (int32_t n = 1; n <= 300; n++)
        bad += check(NTP__FFT_REAL, n) + check(NTP__FFT_COSINE, n);
    for (size_t i = 0; i < sizeof more / sizeof more[0]; i++)
        bad += check(NTP__FFT_REAL, more[i]) + check(NTP__FFT_COSINE, more[i]);
    return bad != 0;
}
