/* SPDX-License-Identifier: MIT */
/*
 * resize_kernels.h - the loops of ntp_resize, compiled once for each instruction set
 */
#ifndef NTP_RESIZE_KERNELS_H
#define NTP_RESIZE_KERNELS_H

#include "reshape/resize.h"
#include "texel/kernels.h"

#include <stdbool.h>

enum {
    NTP__MOST_COLUMNS = 128, /* of the result, at a time */
    NTP__RUN = 136
};

/* A texel is x, y, z and 1 in four adjacent numbers. */
typedef struct ntp__resize_kernels {
    /* sums = the sum of weight[t] rows[t], of `count` numbers, a multiple of 8, and `taps` rows, a
     * multiple of 2. */
    void (*add_rows)(double *sums, const float *const *rows, const int32_t *weight, int32_t taps,
                     int32_t count);
    /* The same where the weights from the last to the first are those from the first to the last. */
    void (*add_pairs)(double *sums, const float *const *rows, const int32_t *weight, int32_t taps,
                      int32_t count);
    /* The same for n texels of the result, from columns first[i] on and with an even number of
     * weights of their own. */
    void (*add_columns)(ntp__vectors *v, double *total, const double *sums, const int32_t *first,
                        const double *weight, int32_t taps, int32_t n);
    /* Planes of x, y, z and weight of n texels mod 2^32, NTP__BLOCK apart, from integers below 2^51. */
    void (*add_low_bits)(int32_t *low, const double *sums, const int32_t *first,
                         const ntp__span_of_taps *span, const int32_t *weight, int32_t stride,
                         int32_t n);
} ntp__resize_kernels;

/* x, y, z and weight of texels of the result. */
typedef struct ntp__planes {
    float c[4][NTP__MOST_COLUMNS];
} ntp__planes;

/* With AVX2.  sums = the sum of scale weight[t] rows[t], of `count` numbers and up to 31 more;
 * symmetric: so are an even number of weights. */
void ntp__sum_rows_avx2(float *sums, const float *const *rows, const int32_t *weight, float scale,
                        int32_t taps, bool symmetric, int32_t count);

/* Weights in units of 2^-29, as 14 bits and the 15 below them; each is that of two rows of int16_t,
 * which may be the same one. */
typedef struct ntp__whole_weights {
    const float *row[NTP__MOST_COLUMNS], *other[NTP__MOST_COLUMNS];
    int16_t upper[NTP__MOST_COLUMNS], lower[NTP__MOST_COLUMNS];
    int32_t n; /* even */
} ntp__whole_weights;

/* The same for numbers of 9 bits, times 2^14. */
void ntp__sum_whole_avx2(float *sums, const ntp__whole_weights *from, int32_t count);
void ntp__sum_whole_avx512(float *sums, const ntp__whole_weights *from, int32_t count);

/* Exact sums of weights that are integers below 2^30, times 1 or a half, of numbers first.. of the rows. */
void ntp__add_whole_avx2(double *sums, const ntp__whole_weights *from, double scale, int32_t first,
                         int32_t count);

/* Where sides are halved: x of even columns in a run of NTP__RUN numbers, then x of odd ones, and so
 * y and z, as numerators over M: int16_t, or floats of 16 bit.  Runs of 1 may follow.  n is even, at
 * least 64.  False where a pixel is black or white; the rest is as for ntp__place_rgb_avx2. */
bool ntp__place_halves_avx2(void *to, bool *negative, const void *src, int32_t n, bool deep,
                            bool zzero);

/* Takes unused texels out of such runs, which become 0; are there any? */
bool ntp__leave_out_halves_avx2(void *to, int32_t n, bool deep, bool zzero, uint32_t touch_unused);

/* Runs of 1. */
void ntp__fill_halves_avx2(void *to, bool deep);

/* As ntp__sum_columns_avx2, of the first `planes` pairs of such runs and with the same weights for
 * all, as many and as great on both sides.  n is at least 32. */
void ntp__sum_halves_avx2(ntp__planes *out, float least[4], const float *sums, const float *weight,
                          int32_t taps, int32_t n, int32_t planes);

/* As add_columns; least[k]: the least number of a plane. */
void ntp__sum_columns_avx2(ntp__planes *out, float least[4], const float *sums,
                           const int32_t *first, const float *weight, int32_t taps, int32_t n);

/* Packed pixels, of 8 bit or 16 (deep), of the directions of vectors first.. to n - 1, a multiple of 8 and the end.
 * Their components are off by `error` at most (8 bit: and by 2^-24 of themselves), and 0 or at least 2^-50.
 * d is where pixel 0 is.  at[]: those in doubt, such as those that are not a number; returns how many. */
int32_t ntp__pack_directions_avx2(void *d, int32_t *at, const ntp__planes *p, int32_t first,
                                  int32_t n, float error, bool deep, bool zzero);

/* The same with AVX-512, of 8 bit, where z is signed.  Planes are read up to a multiple of 16 texels. */
int32_t ntp__pack_directions_avx512(uint8_t *d, int32_t *at, const ntp__planes *p, int32_t first,
                                    int32_t n, float error);

/* Of texels: not 0 where one that they are made of is used, below 0 where one has a negative z. */
typedef struct ntp__plane_marks {
    int16_t used[NTP__MOST_COLUMNS], below[NTP__MOST_COLUMNS];
} ntp__plane_marks;

/* All bits of the numbers, of a pair of runs of int16_t, that make each of n texels: of `half` columns of each run, and
 * of `taps` rows whose weight is not 0. */
void ntp__any_of_halves_avx2(int16_t *to, const float *const *rows, const int32_t *weight,
                             int32_t taps, int32_t half, int32_t run, int32_t n);

/* Vectors first.. to n - 1, a multiple of 8 and the end, whose components are off by `error` at most.  Those of
 * no weight (holes: there may be such) become flat; z below 0 that no source has becomes 0; x that is not
 * certain, as z or the weight may be 0, becomes a NaN. */
void ntp__judge_planes_avx2(ntp__planes *p, const ntp__plane_marks *marks, float m, float error,
                            bool holes, int32_t first, int32_t n);

/* Each the sum of two integers, of which the higher one is a multiple of 2^20. */
typedef struct ntp__whole_sums {
    double high[4][NTP__MOST_COLUMNS], low[4][NTP__MOST_COLUMNS];
} ntp__whole_sums;

/* Exact sums of columns, of sums of rows (ntp__add_whole_avx2) that are such runs, with weights that are
 * integers below 2^30, as many and as great on both sides; and those times 2^-31, as floats.  Texels and planes
 * are as above. */
void ntp__sum_exactly_avx2(ntp__whole_sums *exact, ntp__planes *out, const double *sums,
                           const double *weight, int32_t taps, int32_t first, int32_t n,
                           int32_t planes);
void ntp__sum_exactly_avx512(ntp__whole_sums *exact, ntp__planes *out, const double *sums,
                             const double *weight, int32_t taps, int32_t first, int32_t n,
                             int32_t planes);

#endif
