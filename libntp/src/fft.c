/* SPDX-License-Identifier: MIT */
/*
 * fft.c - Fourier and cosine transforms of many rows at once, of any length
 *
 * Stockham's algorithm (no bit reversal) with radices 4, 2, 3 and 5; other lengths by Bluestein's
 * convolution.  The DCT-II is Makhoul's: even texels forwards, odd ones backwards, a Fourier
 * transform, and a turn of each pair.  Sines and cosines are our own, in double: no two libms
 * agree, and the bytes of a heightfield are to be the same everywhere.
 */
#include "fft.h"

#include <string.h>

enum {
    LANES = NTP__FFT_LANES,
    CELL = 2 * LANES, /* numbers of one complex element in all lanes */
    ALIGNMENT = 64
};

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

/* -------------------------------------------------------------------------- butterflies */

/* One complex element of all lanes: LANES real parts, then LANES imaginary ones. */
#define EACH_LANE for (int32_t l = 0; l < LANES; l++)

/* out = (a + i b) times (w[0] + i w[1]) */
static inline void store_turned(double *restrict out, const double *restrict re,
                                const double *restrict im, const double w[2])
{
    double c = w[0], s = w[1];
    EACH_LANE
    {
        out[l] = re[l] * c - im[l] * s;
        out[l + LANES] = re[l] * s + im[l] * c;
    }
}

static inline void radix2(double *restrict y, const double *restrict x, size_t in, size_t out,
                          const double w[][2])
{
    double re[LANES], im[LANES];
    EACH_LANE
    {
        const double *b = x + in + l;
        double ar = x[l], ai = x[l + LANES], br = b[0], bi = b[LANES];
        y[l] = ar + br;
        y[l + LANES] = ai + bi;
        re[l] = ar - br;
        im[l] = ai - bi;
    }
    store_turned(y + out, re, im, w[1]);
}

static inline void radix3(double *restrict y, const double *restrict x, size_t in, size_t out,
                          const double w[][2])
{
    const double half_root3 = 0.86602540378443864676;
    double re[2][LANES], im[2][LANES];
    EACH_LANE
    {
        const double *b = x + in + l, *c = x + 2 * in + l;
        double ar = x[l], ai = x[l + LANES];
        double sr = b[0] + c[0], si = b[LANES] + c[LANES];
        double dr = (b[0] - c[0]) * half_root3, di = (b[LANES] - c[LANES]) * half_root3;
        double mr = ar - 0.5 * sr, mi = ai - 0.5 * si;
        y[l] = ar + sr;
        y[l + LANES] = ai + si;
        re[0][l] = mr + di;
        im[0][l] = mi - dr;
        re[1][l] = mr - di;
        im[1][l] = mi + dr;
    }
    store_turned(y + out, re[0], im[0], w[1]);
    store_turned(y + 2 * out, re[1], im[1], w[2]);
}

static inline void radix4(double *restrict y, const double *restrict x, size_t in, size_t out,
                          const double w[][2])
{
    double re[3][LANES], im[3][LANES];
    EACH_LANE
    {
        const double *b = x + in + l, *c = x + 2 * in + l, *d = x + 3 * in + l;
        double acr = x[l] + c[0], aci = x[l + LANES] + c[LANES];
        double amr = x[l] - c[0], ami = x[l + LANES] - c[LANES];
        double bdr = b[0] + d[0], bdi = b[LANES] + d[LANES];
        double bmr = b[0] - d[0], bmi = b[LANES] - d[LANES];
        y[l] = acr + bdr;
        y[l + LANES] = aci + bdi;
        re[0][l] = amr + bmi;
        im[0][l] = ami - bmr;
        re[1][l] = acr - bdr;
        im[1][l] = aci - bdi;
        re[2][l] = amr - bmi;
        im[2][l] = ami + bmr;
    }
    for (size_t k = 0; k < 3; k++)
        store_turned(y + (k + 1) * out, re[k], im[k], w[k + 1]);
}

static inline void radix5(double *restrict y, const double *restrict x, size_t in, size_t out,
                          const double w[][2])
{
    const double c1 = 0.30901699437494742410, c2 = -0.80901699437494742410;
    const double s1 = 0.95105651629515357212, s2 = 0.58778525229247312917;
    double re[4][LANES], im[4][LANES];
    EACH_LANE
    {
        const double *b = x + in + l, *c = x + 2 * in + l, *d = x + 3 * in + l, *e = x + 4 * in + l;
        double ar = x[l], ai = x[l + LANES];
        double ber = b[0] + e[0], bei = b[LANES] + e[LANES];
        double cdr = c[0] + d[0], cdi = c[LANES] + d[LANES];
        double bmr = b[0] - e[0], bmi = b[LANES] - e[LANES];
        double cmr = c[0] - d[0], cmi = c[LANES] - d[LANES];
        double m1r = ar + c1 * ber + c2 * cdr, m1i = ai + c1 * bei + c2 * cdi;
        double m2r = ar + c2 * ber + c1 * cdr, m2i = ai + c2 * bei + c1 * cdi;
        double n1r = s1 * bmr + s2 * cmr, n1i = s1 * bmi + s2 * cmi;
        double n2r = s2 * bmr - s1 * cmr, n2i = s2 * bmi - s1 * cmi;
        y[l] = ar + ber + cdr;
        y[l + LANES] = ai + bei + cdi;
        re[0][l] = m1r + n1i;
        im[0][l] = m1i - n1r;
        re[1][l] = m2r + n2i;
        im[1][l] = m2i - n2r;
        re[2][l] = m2r - n2i;
        im[2][l] = m2i + n2r;
        re[3][l] = m1r - n1i;
        im[3][l] = m1i + n1r;
    }
    for (size_t k = 0; k < 4; k++)
        store_turned(y + (k + 1) * out, re[k], im[k], w[k + 1]);
}

/* ------------------------------------------------------------------- the complex transform */

/* A stage: `left` is the length still to be transformed, `stride` the product of radices done. */
static void stage(double *restrict y, const double *restrict x, const double *turns, int32_t radix,
                  int32_t left, int32_t stride)
{
    size_t m = (size_t) (left / radix), r = (size_t) radix, s = (size_t) stride;
    for (size_t p = 0; p < m; p++) {
        double w[5][2];
        for (size_t k = 1; k < r; k++)
            memcpy(w[k], turns + 2 * p * k * s, sizeof w[k]);
        for (size_t q = 0; q < s; q++) {
            const double *from = x + CELL * (q + s * p);
            double *to = y + CELL * (q + s * r * p);
            if (radix == 4)
                radix4(to, from, CELL * s * m, CELL * s, (const double(*)[2]) w);
            else if (radix == 2)
                radix2(to, from, CELL * s * m, CELL * s, (const double(*)[2]) w);
            else if (radix == 3)
                radix3(to, from, CELL * s * m, CELL * s, (const double(*)[2]) w);
            else
                radix5(to, from, CELL * s * m, CELL * s, (const double(*)[2]) w);
        }
    }
}

/* Transforms a, with b to work in; returns the one that holds the result. */
static double *transform(const ntp__fft_core *core, double *a, double *b)
{
    int32_t left = core->n, stride = 1;
    for (int32_t i = 0; i < core->stages; i++) {
        stage(b, a, core->turns, core->radix[i], left, stride);
        left /= core->radix[i];
        stride *= core->radix[i];
        double *swap = a;
        a = b;
        b = swap;
    }
    return a;
}

/* a times (w[0] + i w[1]) */
static void turn(double *a, const double w[2])
{
    double c = w[0], s = w[1];
    EACH_LANE
    {
        double re = a[l], im = a[l + LANES];
        a[l] = re * c - im * s;
        a[l + LANES] = re * s + im * c;
    }
}

static void exchange_parts(double *a, size_t n)
{
    for (size_t i = 0; i < n; i++, a += CELL) {
        EACH_LANE
        {
            double re = a[l];
            a[l] = a[l + LANES];
            a[l + LANES] = re;
        }
    }
}

/* The transform of length fft->n, Bluestein's if need be: k i = (k*k + i*i - (k - i)^2)/2. */
static double *transform_any(const ntp__fft *fft, double *a, double *b)
{
    if (fft->chirp == NULL)
        return transform(&fft->core, a, b);
    size_t n = (size_t) fft->n, m = (size_t) fft->core.n;
    for (size_t i = 0; i < n; i++)
        turn(a + CELL * i, fft->chirp + 2 * i);
    memset(a + CELL * n, 0, (m - n) * CELL * sizeof *a);
    double *c = transform(&fft->core, a, b);
    for (size_t i = 0; i < m; i++)
        turn(c + CELL * i, fft->response + 2 * i);
    /* The inverse is the transform with real and imaginary parts exchanged. */
    exchange_parts(c, m);
    c = transform(&fft->core, c, c == a ? b : a);
    exchange_parts(c, n);
    for (size_t i = 0; i < n; i++)
        turn(c + CELL * i, fft->chirp + 2 * i);
    return c;
}

/* --------------------------------------------------------------------------------- rows */

/* Where element i of a row goes: evens forwards, then odds backwards, for the DCT. */
static size_t place(const ntp__fft *fft, size_t i)
{
    if (fft->kind == NTP__FFT_REAL)
        return i;
    return i % 2 == 0 ? i / 2 : (size_t) fft->n - 1 - i / 2;
}

/* Turns the pair of a frequency, its real part and its imaginary one, to cosine coefficients;
 * it is a reflection, and undoes itself. */
static inline void turn_pair(double *restrict re, double *restrict im, const double w[2])
{
    double c = w[0], s = w[1];
    EACH_LANE
    {
        double r = re[l], i = im[l];
        re[l] = c * r + s * i;
        im[l] = s * r - c * i;
    }
}

void ntp__fft_load(const ntp__fft *fft, int32_t row, const double *line, void *work)
{
    double *lane = (double *) work + row % 2 * LANES + row / 2;
    for (size_t i = 0; i < (size_t) fft->n; i++)
        lane[CELL * place(fft, i)] = line[i];
}

void ntp__fft_forward(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work)
{
    size_t n = (size_t) fft->n;
    double *a = work, *b = a + CELL * (size_t) fft->core.n;
    const double *z = transform_any(fft, a, b);
    for (size_t k = 0; 2 * k <= n; k++) {
        const double *u = z + CELL * k, *v = z + CELL * ((n - k) % n);
        double re[CELL], im[CELL]; /* of the even rows, then of the odd ones */
        EACH_LANE
        {
            re[l] = 0.5 * (u[l] + v[l]);
            im[l] = 0.5 * (u[l + LANES] - v[l + LANES]);
            re[l + LANES] = 0.5 * (u[l + LANES] + v[l + LANES]);
            im[l + LANES] = 0.5 * (v[l] - u[l]);
        }
        if (fft->kind == NTP__FFT_COSINE) {
            turn_pair(re, im, fft->quarter + 2 * k);
            turn_pair(re + LANES, im + LANES, fft->quarter + 2 * k);
        }
        for (size_t r = 0; r < CELL; r++) {
            rows[r][k] = (float) re[r % 2 * LANES + r / 2];
            if (k > 0 && 2 * k < n)
                rows[r][n - k] = (float) im[r % 2 * LANES + r / 2];
        }
    }
}

void ntp__fft_inverse(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work)
{
    size_t n = (size_t) fft->n;
    double *a = work, *b = a + CELL * (size_t) fft->core.n;
    double scale = 1 / (double) fft->n;
    for (size_t k = 0; 2 * k <= n; k++) {
        double re[CELL], im[CELL];
        int single = k == 0 || 2 * k == n;
        for (size_t r = 0; r < CELL; r++) {
            re[r % 2 * LANES + r / 2] = rows[r][k];
            im[r % 2 * LANES + r / 2] = single ? 0 : rows[r][n - k];
        }
        if (fft->kind == NTP__FFT_COSINE && k > 0) {
            if (single)
                memcpy(im, re, sizeof im);
            turn_pair(re, im, fft->quarter + 2 * k);
            turn_pair(re + LANES, im + LANES, fft->quarter + 2 * k);
            if (single)
                memset(im, 0, sizeof im);
        }
        /* Real and imaginary parts exchanged: the forward transform then is the inverse. */
        double *u = a + CELL * k, *v = a + CELL * ((n - k) % n);
        EACH_LANE
        {
            double ar = re[l], ai = im[l], br = re[l + LANES], bi = im[l + LANES];
            v[l + LANES] = scale * (ar + bi);
            v[l] = scale * (br - ai);
            u[l + LANES] = scale * (ar - bi);
            u[l] = scale * (ai + br);
        }
    }
    const double *z = transform_any(fft, a, b);
    for (size_t i = 0; i < n; i++) {
        const double *cell = z + CELL * place(fft, i);
        for (size_t r = 0; r < CELL; r++)
            rows[r][i] = (float) cell[(1 - r % 2) * LANES + r / 2];
    }
}

/* ------------------------------------------------------------------------------- tables */

/* What is left of n without its factors 2, 3 and 5. */
static int32_t rough_part(int32_t n)
{
    for (int32_t p = 2; p <= 5; p++) {
        while (n % p == 0)
            n /= p;
    }
    return n;
}

/* The length of the complex transform behind n. */
static int32_t core_length(int32_t n)
{
    if (rough_part(n) == 1)
        return n;
    int32_t m = 2 * n - 1;
    while (rough_part(m) != 1)
        m++;
    return m;
}

static size_t aligned(size_t bytes)
{
    return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static size_t pairs(int32_t n)
{
    return aligned(2 * (size_t) n * sizeof(double));
}

size_t ntp__fft_tables(ntp__fft_kind kind, int32_t n)
{
    int32_t m = core_length(n);
    size_t bytes = pairs(m) + (kind == NTP__FFT_COSINE ? pairs(n) : 0);
    return m == n ? bytes : bytes + pairs(n) + pairs(m);
}

size_t ntp__fft_work(ntp__fft_kind kind, int32_t n)
{
    (void) kind;
    return aligned(2 * CELL * sizeof(double) * (size_t) core_length(n));
}

static double *take(char **memory, int32_t n)
{
    double *table = (double *) (void *) *memory;
    *memory += pairs(n);
    return table;
}

static void fill_turns(double *table, int32_t count, int64_t n, int sign)
{
    for (int32_t k = 0; k < count; k++) {
        double c, s;
        ntp__turn(&c, &s, k, n);
        table[2 * (size_t) k] = c;
        table[2 * (size_t) k + 1] = sign * s;
    }
}

static void init_core(ntp__fft_core *core, int32_t n, double *turns)
{
    static const int32_t order[] = { 5, 3, 4, 2 };
    core->n = n;
    core->stages = 0;
    core->turns = turns;
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        for (; n % order[i] == 0; n /= order[i])
            core->radix[core->stages++] = order[i];
    }
    fill_turns(turns, core->n, core->n, -1);
}

/* The chirp, and the transform of its conjugate, continued to negative indices. */
static void init_bluestein(ntp__fft *fft, double *work)
{
    size_t n = (size_t) fft->n, m = (size_t) fft->core.n;
    memset(work, 0, m * CELL * sizeof *work);
    for (size_t i = 0; i < n; i++) {
        double c, s;
        ntp__turn(&c, &s, (int64_t) (i * i % (2 * n)), 2 * (int64_t) n);
        fft->chirp[2 * i] = c;
        fft->chirp[2 * i + 1] = -s;
        work[CELL * i] = work[CELL * ((m - i) % m)] = c;
        work[CELL * i + LANES] = work[CELL * ((m - i) % m) + LANES] = s;
    }
    const double *z = transform(&fft->core, work, work + CELL * m);
    for (size_t i = 0; i < m; i++) {
        fft->response[2 * i] = z[CELL * i] / (double) m;
        fft->response[2 * i + 1] = z[CELL * i + LANES] / (double) m;
    }
}

void ntp__fft_init(ntp__fft *fft, ntp__fft_kind kind, int32_t n, void *tables, void *work)
{
    char *memory = tables;
    memset(fft, 0, sizeof *fft);
    fft->kind = kind;
    fft->n = n;
    int32_t m = core_length(n);
    init_core(&fft->core, m, take(&memory, m));
    if (kind == NTP__FFT_COSINE) {
        fft->quarter = take(&memory, n);
        fill_turns(fft->quarter, n, 4 * (int64_t) n, 1);
    }
    if (m != n) {
        fft->chirp = take(&memory, n);
        fft->response = take(&memory, m);
        init_bluestein(fft, work);
    }
}
