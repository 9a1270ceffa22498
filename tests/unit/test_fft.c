/* SPDX-License-Identifier: MIT */
/*
 * test_fft.c - the transforms against direct sums, for every length to 300 and some beyond; and the
 * same bytes by every instruction set
 */
#include "to_height/shared/solver_kernels.h"

#include "../system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = NTP__FFT_ROWS };

static const double pi = 3.14159265358979323846;
/* Of the largest value: results are stored as floats. */
static const double tolerance = 2e-7, single_tolerance = 2e-6;

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
        if (kind == NTP__FFT_MIRROR && n == 1)
            sum += line[i];
        else if (kind == NTP__FFT_MIRROR)
            sum += line[i] * (i == 0 || i == n - 1 ? 1 : 2) *
                   cos(pi * (double) (j * i % (2 * n - 2)) / (n - 1.0));
        else if (kind == NTP__FFT_COSINE)
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
    void *memory = system_aligned(bytes + 1);
    if (memory == NULL)
        abort();
    return memory;
}

typedef struct batch {
    ntp__fft fft;
    void *tables, *work;
    double *lines;
    float *out, *rows[ROWS];
    size_t row;
} batch;

static void make(batch *b, ntp__fft_kind kind, int32_t n, bool single)
{
    size_t row = b->row = (size_t) n;
    ntp__scratch tables = { NULL, 0 };
    ntp__fft_plan(&b->fft, &tables, kind, n, single, NULL);
    b->tables = allocate(tables.used);
    tables = (ntp__scratch) { b->tables, 0 };
    b->work = allocate(ntp__fft_work_bytes(kind, n, single));
    b->lines = allocate(ROWS * row * sizeof *b->lines);
    b->out = allocate(ROWS * row * sizeof *b->out);
    ntp__fft_plan(&b->fft, &tables, kind, n, single, b->work);
    for (int32_t r = 0; r < ROWS; r++) {
        b->rows[r] = b->out + (size_t) r * row;
        for (size_t i = 0; i < row; i++)
            b->lines[(size_t) r * row + i] = (double) (float) noise();
    }
}

static void drop(batch *b)
{
    system_aligned_free(b->tables);
    system_aligned_free(b->work);
    system_aligned_free(b->lines);
    system_aligned_free(b->out);
}

static void forward(batch *b)
{
    for (int32_t r = 0; r < ROWS; r++) {
        void *line = ntp__fft_line(&b->fft, b->work, r);
        for (size_t i = 0; i < b->row; i++) {
            double v = b->lines[(size_t) r * b->row + i];
            if (b->fft.single)
                ((float *) line)[i] = (float) v;
            else
                ((double *) line)[i] = v;
        }
    }
    b->fft.loops->forward(&b->fft, b->rows, b->work);
}

/* Is pair k of a table the cosine and `sign` times the sine of this angle, to the last bit? */
static bool is_turn(const ntp__fft *fft, const void *table, int32_t k, int64_t angle, int64_t whole,
                    int sign)
{
    double wide[2];
    ntp__turn(&wide[0], &wide[1], angle, whole);
    wide[1] = sign * wide[1];
    const float narrow[2] = { (float) wide[0], (float) wide[1] };
    const size_t size = fft->single ? sizeof narrow : sizeof wide;
    const void *expected = fft->single ? (const void *) narrow : (const void *) wide;
    return memcmp((const char *) table + (size_t) k * size, expected, size) == 0;
}

static int check_tables(const ntp__fft *fft)
{
    int bad = 0;
    const int64_t period = fft->period;
    for (int32_t k = 0; k < fft->m; k++)
        bad += !is_turn(fft, fft->turns, k, k, fft->m, -1);
    for (int32_t k = 0; fft->quarter != NULL && k < fft->n; k++)
        bad += !is_turn(fft, fft->quarter, k, k, 4 * (int64_t) fft->n, 1);
    for (int64_t k = 0; fft->chirp != NULL && k < period; k++)
        bad += !is_turn(fft, fft->chirp, (int32_t) k, k * k % (2 * period), 2 * period, -1);
    if (bad > 0)
        printf("tables of %d: %d are off\n", (int) fft->n, bad);
    return bad;
}

static int check(ntp__fft_kind kind, int32_t n, bool single)
{
    batch b;
    double largest = 0, off = 0, back = 0, limit = single ? single_tolerance : tolerance;
    make(&b, kind, n, single);
    forward(&b);
    for (int32_t r = 0; r < ROWS; r += 5) { /* rows of both halves, and the first and last lanes */
        for (int32_t j = 0; j < n; j++) {
            double want = direct(kind, b.lines + (size_t) r * b.row, n, j);
            largest = fmax(largest, fabs(want));
            off = fmax(off, fabs(want - (double) b.rows[r][j]));
        }
    }
    int bad = off > limit * largest;
    b.fft.loops->inverse(&b.fft, b.rows, b.work);
    for (size_t i = 0; i < ROWS * b.row; i++)
        back = fmax(back, fabs(b.lines[i] - (double) b.out[i]));
    bad = bad || back > 4 * limit;
    if (bad)
        printf("kind %d, length %d, single %d: off by %g of %g, inverse by %g\n", (int) kind,
               (int) n, (int) single, off, largest, back);
    bad += check_tables(&b.fft);
    drop(&b);
    return bad;
}

/* Every instruction set has to give the same bytes. */
static int check_levels(ntp__fft_kind kind, int32_t n, bool single)
{
    batch b;
    const ntp__solver_kernels *base = ntp__solver_kernels_for(0);
    make(&b, kind, n, single);
    size_t bytes = ROWS * b.row * sizeof(float);
    float *first = allocate(bytes);
    forward(&b);
    memcpy(first, b.out, bytes);
    const ntp__fft_loops *best = b.fft.loops;
    b.fft.loops = single ? &base->fft_single : &base->fft_double;
    forward(&b);
    int bad = memcmp(first, b.out, bytes) != 0;
    b.fft.loops->inverse(&b.fft, b.rows, b.work);
    memcpy(first, b.out, bytes);
    forward(&b);
    best->inverse(&b.fft, b.rows, b.work);
    bad |= memcmp(first, b.out, bytes) != 0;
    if (bad)
        printf("kind %d, length %d: other bytes by other instructions\n", (int) kind, (int) n);
    system_aligned_free(first);
    drop(&b);
    return bad;
}

static void factors(const void *user, int32_t k, double factor[ROWS])
{
    (void) user;
    for (int32_t r = 0; r < ROWS; r++)
        factor[r] = k == 0 ? 1 : 2 * (r + 1);
}

/* Multiplied down columns, all frequencies but 0 by 2 (r + 1): the mean stays. */
static int check_filter(ntp__fft_kind kind, int32_t n, bool single, int32_t columns)
{
    batch b;
    double off = 0;
    make(&b, kind, n, single);
    float *grid = allocate((size_t) n * ROWS * sizeof *grid);
    for (size_t i = 0; i < (size_t) n * ROWS; i++)
        grid[i] = (float) b.lines[i];
    b.fft.loops->filter(&b.fft, grid, ROWS, columns, factors, NULL, b.work);
    for (size_t r = 0; r < ROWS; r++) {
        double mean = 0, weight = 0;
        for (size_t i = 0; i < (size_t) n; i++) {
            double share = kind == NTP__FFT_MIRROR && (i == 0 || i == (size_t) n - 1) ? 0.5 : 1;
            mean += share * b.lines[i * ROWS + r];
            weight += share;
        }
        mean /= weight;
        for (size_t i = 0; i < (size_t) n; i++) {
            double v = b.lines[i * ROWS + r], want = mean + 2 * ((double) r + 1) * (v - mean);
            want = r < (size_t) columns ? want : v;
            off = fmax(off, fabs((double) grid[i * ROWS + r] - want));
        }
    }
    system_aligned_free(grid);
    drop(&b);
    if (off > 1e-4)
        printf("filter, kind %d, length %d: off by %g\n", (int) kind, (int) n, off);
    return off > 1e-4;
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
    for (int kind = NTP__FFT_REAL; kind <= NTP__FFT_MIRROR; kind++) {
        for (int32_t n = 1; n <= 300; n++)
            bad += check((ntp__fft_kind) kind, n, false) + check((ntp__fft_kind) kind, n, true);
        for (size_t i = 0; i < sizeof more / sizeof more[0]; i++) {
            bad += check((ntp__fft_kind) kind, more[i], false);
            bad += check((ntp__fft_kind) kind, more[i], true);
        }
        for (int32_t n = 1; n <= 131; n++) {
            for (int single = 0; single < 2; single++) {
                bad += check_levels((ntp__fft_kind) kind, n, single != 0);
                bad += check_filter((ntp__fft_kind) kind, n, single != 0, 1 + n % ROWS);
            }
        }
    }
    return bad != 0;
}
