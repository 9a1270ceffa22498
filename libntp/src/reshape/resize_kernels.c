/* SPDX-License-Identifier: MIT */
/*
 * resize_kernels.c - the loops of ntp_resize, compiled once for each instruction set
 */
#include "reshape/resize_kernels.h"

#include <string.h>

#define CONCAT_(a, b) a##b
#define CONCAT(a, b)  CONCAT_(a, b)

static void add_rows(double *restrict sums, const float *const *rows, const int32_t *weight,
                     int32_t taps, int32_t count)
{
    const float *restrict a = rows[0], *restrict b = rows[1];
    double u = weight[0], v = weight[1];
    int32_t t = 2;
    count = count / 8 * 8;
    for (int32_t i = 0; i < count; i++)
        sums[i] = u * (double) a[i] + v * (double) b[i];
    for (; t + 4 <= taps; t += 4) {
        const float *restrict c = rows[t + 2], *restrict d = rows[t + 3];
        const double w = weight[t + 2], x = weight[t + 3];
        a = rows[t], b = rows[t + 1], u = weight[t], v = weight[t + 1];
        for (int32_t i = 0; i < count; i++)
            sums[i] +=
                (u * (double) a[i] + v * (double) b[i]) + (w * (double) c[i] + x * (double) d[i]);
    }
    if (t < taps) {
        a = rows[t], b = rows[t + 1], u = weight[t], v = weight[t + 1];
        for (int32_t i = 0; i < count; i++)
            sums[i] += u * (double) a[i] + v * (double) b[i];
    }
}

/* Not where it would only make the library greater for processors from before 2013. */
#if defined(__AVX2__) || !defined(NTP_HAVE_AVX2)
/* Sums of floats of 18 bits are exact. */
static void add_pairs(double *restrict sums, const float *const *rows, const int32_t *weight,
                      int32_t taps, int32_t count)
{
    const int32_t last = taps - 1, half = taps / 2;
    count = count / 8 * 8;
    for (int32_t t = 0; t < half; t += 2) {
        /* The middle one of an odd number of pairs is taken once more, 0 times. */
        const int32_t s = t + 1 < half ? t + 1 : t;
        const float *restrict a = rows[t], *restrict b = rows[last - t];
        const float *restrict c = rows[s], *restrict d = rows[last - s];
        const double u = weight[t], v = t + 1 < half ? weight[s] : 0;
        if (t == 0) {
            for (int32_t i = 0; i < count; i++)
                sums[i] = u * (double) (a[i] + b[i]) + v * (double) (c[i] + d[i]);
        } else {
            for (int32_t i = 0; i < count; i++)
                sums[i] += u * (double) (a[i] + b[i]) + v * (double) (c[i] + d[i]);
        }
    }
}

#else
#  define add_pairs add_rows
#endif

static void add_columns(ntp__vectors *restrict out, double *restrict total,
                        const double *restrict sums, const int32_t *restrict first,
                        const double *restrict weight, int32_t taps, int32_t n)
{
    for (int32_t i = 0; i < n; i++, weight += taps) {
        const double *c = sums + 4 * (ptrdiff_t) first[i];
        double sum[4] = { 0, 0, 0, 0 };
        for (int32_t t = 0; t < taps; t += 2, c += 8) {
            for (int32_t k = 0; k < 4; k++)
                sum[k] += weight[t] * c[k] + weight[t + 1] * c[k + 4];
        }
        out->c[0][i] = sum[0];
        out->c[1][i] = sum[1];
        out->c[2][i] = sum[2];
        total[i] = sum[3];
    }
}

static void add_low_bits(int32_t *restrict low, const double *restrict sums,
                         const int32_t *restrict first, const ntp__span_of_taps *restrict span,
                         const int32_t *restrict weight, int32_t stride, int32_t n)
{
    for (int32_t i = 0; i < n; i++, weight += stride) {
        const double *c = sums + 4 * (ptrdiff_t) first[i];
        uint32_t sum[4] = { 0, 0, 0, 0 };
        for (int32_t t = 0; t < span[i].count; t++, c += 4) {
            for (int32_t k = 0; k < 4; k++) {
                const double d = c[k] + 0x1.8p52; /* whose last bits are those of an integer */
                uint64_t bits;
                memcpy(&bits, &d, sizeof bits);
                sum[k] += (uint32_t) weight[t] * (uint32_t) bits;
            }
        }
        for (int32_t k = 0; k < 4; k++)
            low[NTP__BLOCK * k + i] = (int32_t) sum[k];
    }
}

extern const ntp__resize_kernels CONCAT(ntp__resize_loops_, NTP_ISA);
const ntp__resize_kernels CONCAT(ntp__resize_loops_, NTP_ISA) = { add_rows, add_pairs, add_columns,
                                                                  add_low_bits };
