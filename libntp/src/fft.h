/* SPDX-License-Identifier: MIT */
/*
 * fft.h - Fourier and cosine transforms of many rows at once, of any length
 *
 * A batch is NTP__FFT_ROWS real rows: two rows make the real and the imaginary part of a complex
 * line, and NTP__FFT_LANES such lines lie interleaved, so that every butterfly is a plain loop
 * over lanes.  Lanes do not mix; the two rows of a line do, by rounding errors.
 */
#ifndef NTP_FFT_H
#define NTP_FFT_H

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
    NTP__FFT_COSINE = 1
} ntp__fft_kind;

/* A complex transform whose length has no prime factors but 2, 3 and 5. */
typedef struct ntp__fft_core {
    int32_t n, stages;
    int32_t radix[NTP__FFT_STAGES];
    double *turns; /* cos and -sin of 2 pi k/n */
} ntp__fft_core;

typedef struct ntp__fft {
    ntp__fft_kind kind;
    int32_t n;
    ntp__fft_core core; /* of length n, or longer: then Bluestein's convolution */
    double *chirp;      /* cos and -sin of pi i*i/n; NULL: core has length n */
    double *response;   /* the transform of the conjugate chirp, over core.n */
    double *quarter;    /* cos and sin of pi k/(2n); NTP__FFT_COSINE */
} ntp__fft;

/* Bytes of the tables of a length 1..65535, and of the working memory of each batch. */
size_t ntp__fft_tables(ntp__fft_kind kind, int32_t n);
size_t ntp__fft_work(ntp__fft_kind kind, int32_t n);

/* Makes the tables in memory of that size; work is that of a batch.  Both aligned to 64. */
void ntp__fft_init(ntp__fft *fft, ntp__fft_kind kind, int32_t n, void *tables, void *work);

/* Puts a row into a batch, for ntp__fft_forward; rows that are not put in are to be zeros. */
void ntp__fft_load(const ntp__fft *fft, int32_t row, const double *line, void *work);

/* Transforms the batch into rows of n floats.  The inverse undoes it in place, with its factor
 * 1/n.  The arithmetic is in double: errors at low frequencies would be multiplied by n^2. */
void ntp__fft_forward(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work);
void ntp__fft_inverse(const ntp__fft *fft, float *const rows[NTP__FFT_ROWS], void *work);

/* cos and sin of 2 pi k/n, 0 <= k < n <= 2^31, right to the last bit or two, exact at quarters. */
void ntp__turn(double *c, double *s, int64_t k, int64_t n);

#endif
