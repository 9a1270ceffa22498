/* SPDX-License-Identifier: MIT */
/*
 * fft.h - Fourier and cosine transforms of many rows at once, of any length
 *
 * A batch is NTP__FFT_ROWS real rows: two rows make the real and the imaginary part of a complex
 * line, and NTP__FFT_LANES such lines lie interleaved, so that every butterfly is a plain loop
 * over lanes.  Lanes do not mix; the two rows of a line do, by rounding errors.  The arithmetic is
 * in double, or in float for data that are no better than 8 bit.
 */
#ifndef NTP_FFT_H
#define NTP_FFT_H

#include "base/scratch.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    NTP__FFT_LANES = 8,
    NTP__FFT_ROWS = 2 * NTP__FFT_LANES,
    NTP__FFT_STAGES = 20 /* factors of a length below 2^20 */
};

typedef enum ntp__fft_kind {
    /* X[k] = sum x[i] exp(-2 pi i k/n): the real parts at k <= n/2, the imaginary ones at n - k. */
    NTP__FFT_REAL = 0,
    /* DCT-II: X[k] = sum x[i] cos(pi k (i + 1/2) / n). */
    NTP__FFT_COSINE = 1,
    /* DCT-I, n >= 2: X[k] = x[0] + (-1)^k x[n-1] + 2 sum x[i] cos(pi k i/(n-1)), 0 < i < n - 1. */
    NTP__FFT_MIRROR = 2
} ntp__fft_kind;

typedef struct ntp__fft_loops ntp__fft_loops;

/* Tables are of float where `single`, else of double. */
typedef struct ntp__fft {
    const ntp__fft_loops *loops;
    ntp__fft_kind kind;
    bool single;
    int32_t n;      /* of a row */
    int32_t period; /* of the complex transform behind it */
    int32_t m;      /* of the transform that does it: period, or longer (Bluestein) */
    int32_t stages, radix[NTP__FFT_STAGES]; /* of m, which has no prime factors but 2, 3 and 5 */
    void *turns;                            /* cos and -sin of 2 pi k/m */
    void *chirp;                            /* cos and -sin of pi i*i/period; NULL: m is period */
    void *response;                         /* the transform of the conjugate chirp, over m */
    void *quarter;                          /* cos and sin of pi k/(2n); NTP__FFT_COSINE */
} ntp__fft;

/* Makes the tables of a length 1..65535 in memory that it takes.  `work` has ntp__fft_work_bytes.
 * With memory->base NULL it only measures. */
void ntp__fft_plan(ntp__fft *fft, ntp__scratch *memory, ntp__fft_kind kind, int32_t n, bool single,
                   void *work);

/* Bytes of the working memory of each batch; it is aligned as ntp__take aligns. */
size_t ntp__fft_work_bytes(ntp__fft_kind kind, int32_t n, bool single);

/* Where the caller puts row 0..NTP__FFT_ROWS - 1 of a batch, n floats or doubles, for `forward`. */
void *ntp__fft_line(const ntp__fft *fft, void *work, int32_t row);

/* What the columns of a batch are multiplied by at frequency k. */
typedef void ntp__fft_factors_fn(const void *user, int32_t k, double factor[NTP__FFT_ROWS]);

/* The transforms, compiled once for each instruction set (fft_lines_tmpl.h). */
struct ntp__fft_loops {
    /* Transforms the lines into rows of n floats; the inverse undoes it in place. */
    void (*forward)(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work);
    void (*inverse)(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work);
    /* Transforms `columns` adjacent columns, multiplies, and transforms back, all in place; first
     * is that of row 0, and rows are `stride` floats apart. */
    void (*filter)(const ntp__fft *fft, float *first, ptrdiff_t stride, int32_t columns,
                   ntp__fft_factors_fn *factors, const void *user, void *work);
    /* Fills fft->response from fft->chirp. */
    void (*respond)(const ntp__fft *fft, void *work);
};

/* cos and sin of 2 pi k/n, 0 <= k < n <= 2^31, right to the last bit or two, exact at quarters. */
void ntp__turn(double *c, double *s, int64_t k, int64_t n);

#endif
