/* SPDX-License-Identifier: MIT */
/*
 * fft.c - tables of the Fourier and cosine transforms; fft_lines_tmpl.h has the transforms
 *
 * Sines and cosines are worked out here, in double.  No two libms agree on them, and the bytes of a
 * heightfield have to be the same everywhere.
 */
#include "to_height/shared/fft.h"

#include "to_height/shared/solver_kernels.h"

#include <string.h>

/* ------------------------------------------------------------------------------ angles */

static const double quarter_pi = 0.78539816339744830962;

/* For 0 <= x <= pi/4; the first terms left out are below 2^-56. */
static double sine(double x)
{
    double x2 = x * x, sum = 0;
    for (int32_t k = 17; k > 1; k -= 2)
        sum = (1 - sum) * x2 / (k * (k - 1));
    return x * (1 - sum);
}

static double cosine(double x)
{
    double x2 = x * x, sum = 0;
    for (int32_t k = 18; k > 0; k -= 2)
        sum = (1 - sum) * x2 / (k * (k - 1));
    return 1 - sum;
}

void ntp__turn(double *c, double *s, int64_t k, int64_t n)
{
    int64_t u = 8 * k; /* in units of 1/(8n) of a turn */
    int sign_s = 1, sign_c = 1;
    if (u > 4 * n) {
        u = 8 * n - u;
        sign_s = -1;
    }
    if (u > 2 * n) {
        u = 4 * n - u;
        sign_c = -1;
    }
    int swap = u > n;
    double x = quarter_pi * ((double) (swap ? 2 * n - u : u) / (double) n);
    double cx = swap ? sine(x) : cosine(x), sx = swap ? cosine(x) : sine(x);
    *c = sign_c * cx;
    *s = sign_s * sx;
}

/* ------------------------------------------------------------------------------- sizes */

/* What is left of n without its factors 2, 3 and 5. */
static int32_t rough_part(int32_t n)
{
    for (int32_t p = 2; p <= 5; p++) {
        while (n % p == 0)
            n /= p;
    }
    return n;
}

static int32_t period_of(ntp__fft_kind kind, int32_t n)
{
    return kind == NTP__FFT_MIRROR && n > 1 ? 2 * (n - 1) : n;
}

/* The length of the transform behind a period. */
static int32_t core_length(int32_t period)
{
    if (rough_part(period) == 1)
        return period;
    int32_t m = 2 * period - 1;
    while (rough_part(m) != 1)
        m++;
    return m;
}

static size_t pairs(int32_t n, bool single)
{
    return 2 * (size_t) n * (single ? sizeof(float) : sizeof(double));
}

size_t ntp__fft_work_bytes(ntp__fft_kind kind, int32_t n, bool single)
{
    return 2 * NTP__FFT_LANES * pairs(core_length(period_of(kind, n)), single);
}

/* ------------------------------------------------------------------------------ tables */

/* table[k] = (cos, sign sin) of angle/n of a turn. */
static void put_turn(const ntp__fft *fft, void *table, int32_t k, int64_t angle, int64_t n,
                     int sign)
{
    double c, s;
    size_t at = 2 * (size_t) k;
    ntp__turn(&c, &s, angle, n);
    s = sign * s;
    if (fft->single) {
        float *single = table;
        single[at] = (float) c;
        single[at + 1] = (float) s;
    } else {
        double *wide = table;
        wide[at] = c;
        wide[at + 1] = s;
    }
}

static void factorize(ntp__fft *fft)
{
    static const int32_t order[] = { 5, 3, 4, 2 };
    int32_t n = fft->m;
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        for (; n % order[i] == 0; n /= order[i])
            fft->radix[fft->stages++] = order[i];
    }
}

static void lay_out(ntp__fft *fft, ntp__scratch *memory)
{
    bool bluestein = fft->m != fft->period;
    fft->turns = ntp__take(memory, pairs(fft->m, fft->single));
    if (fft->kind == NTP__FFT_COSINE)
        fft->quarter = ntp__take(memory, pairs(fft->n, fft->single));
    if (bluestein) {
        fft->chirp = ntp__take(memory, pairs(fft->period, fft->single));
        fft->response = ntp__take(memory, pairs(fft->m, fft->single));
    }
}

/* table[k] from table[from], with its parts swapped or of other signs. */
static void copy_turn(const ntp__fft *fft, void *table, int32_t k, int32_t from, bool swapped,
                      int sign_c, int sign_s)
{
    size_t at = 2 * (size_t) k, c = 2 * (size_t) from + swapped, s = c ^ 1;
    if (fft->single) {
        float *single = table;
        single[at] = (float) sign_c * single[c];
        single[at + 1] = (float) sign_s * single[s];
    } else {
        double *wide = table;
        wide[at] = sign_c * wide[c];
        wide[at + 1] = sign_s * wide[s];
    }
}

/* The turns of a circle in n parts, to the other side.  An eighth of it tells the rest, to the bit: ntp__turn
 * takes all angles from there. */
static void put_circle(const ntp__fft *fft, void *table, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        if (k > n - k)
            copy_turn(fft, table, k, n - k, false, 1, -1);
        else if (n % 2 == 0 && k > n / 2 - k)
            copy_turn(fft, table, k, n / 2 - k, false, -1, 1);
        else if (n % 4 == 0 && k > n / 4 - k)
            copy_turn(fft, table, k, n / 4 - k, true, -1, -1);
        else
            put_turn(fft, table, k, k, n, -1);
    }
}

static void fill_tables(ntp__fft *fft, void *work)
{
    put_circle(fft, fft->turns, fft->m);
    for (int32_t k = 0; fft->quarter != NULL && k < fft->n; k++) {
        if (k > fft->n - k)
            copy_turn(fft, fft->quarter, k, fft->n - k, true, 1, 1);
        else
            put_turn(fft, fft->quarter, k, k, 4 * (int64_t) fft->n, 1);
    }
    if (fft->chirp == NULL)
        return;
    const int64_t period = fft->period, whole = 2 * period;
    for (int64_t i = 0; i < period; i++) {
        if (period % 2 == 0 && i > period - i) /* squares that differ by a multiple of `whole` */
            copy_turn(fft, fft->chirp, (int32_t) i, (int32_t) (period - i), false, 1, 1);
        else
            put_turn(fft, fft->chirp, (int32_t) i, i * i % whole, whole, -1);
    }
    fft->loops->respond(fft, work);
}

void ntp__fft_plan(ntp__fft *fft, ntp__scratch *memory, ntp__fft_kind kind, int32_t n, bool single,
                   void *work)
{
    const ntp__solver_kernels *kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    memset(fft, 0, sizeof *fft);
    fft->loops = single ? &kernels->fft_single : &kernels->fft_double;
    fft->kind = kind;
    fft->single = single;
    fft->n = n;
    fft->period = period_of(kind, n);
    fft->m = core_length(fft->period);
    factorize(fft);
    lay_out(fft, memory);
    if (memory->base != NULL)
        fill_tables(fft, work);
}

void *ntp__fft_line(const ntp__fft *fft, void *work, int32_t row)
{
    /* Lines lie in the second of the two arrays of a transform. */
    size_t real = fft->single ? sizeof(float) : sizeof(double);
    size_t at = NTP__FFT_ROWS * (size_t) fft->m + (size_t) row * (size_t) fft->n;
    return (char *) work + at * real;
}
