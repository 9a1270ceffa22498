/* SPDX-License-Identifier: MIT */
/*
 * solver_kernels.h - the loops of normals -> heightfield that are compiled per instruction set
 *
 * solver_kernels.c is plain C, which the compiler vectorizes.  Sums have a fixed order, and no
 * multiplication is fused with an addition, so every instruction set gives the same bytes.
 */
#ifndef NTP_SOLVER_KERNELS_H
#define NTP_SOLVER_KERNELS_H

#include "base/cpu.h"
#include "to_height/shared/fft.h"

/* Loops over n numbers of a row, all float or all double. */
typedef struct ntp__row_loops {
    /* f = wa a + wb b; and f += that. */
    void (*set_pair)(void *f, const void *a, double wa, const void *b, double wb, int32_t n);
    void (*add_pair)(void *f, const void *a, double wa, const void *b, double wb, int32_t n);
    double (*sum)(const void *f, int32_t n);
    double (*sum_squares)(const void *f, int32_t n);
} ntp__row_loops;

/* How 8-bit levels become slopes; see slopes.h. */
typedef struct ntp__slope_levels {
    int32_t zero, neutral;
    float z_scale, z_zero; /* z is z_scale blue - z_zero */
    float square;          /* range^2 */
    float sign;            /* of y, down the picture */
    float least;           /* z, times range */
    bool derived, mixed;
} ntp__slope_levels;

/* Slopes of n packed texels of `step` samples, 3 or 4; nonzero: one of them may be unused. */
typedef int32_t ntp__slopes8_fn(float *right, float *down, const uint8_t *src, int32_t step,
                                int32_t n, const ntp__slope_levels *how);

/* The recursion along columns, a row at a time; see columns.c. */
typedef struct ntp__column_loops {
    /* state = scale row + r state; row = state */
    void (*down)(double *state, float *row, const double *r, double scale, int32_t n);
    /* and sum += power scale row, power *= r, where power is not below `tiny` */
    void (*down_live)(double *state, float *row, const double *r, double scale, double *sum,
                      double *power, double tiny, int32_t n);
    /* state = r (row + state); row = state */
    void (*up)(double *state, float *row, const double *r, int32_t n);
    /* The same with row + entry for row.  Before that, entry is divided by r, or set to `start`
     * where `begin` is this row. */
    void (*up_live)(double *state, float *row, const double *r, const double *inverse,
                    double *entry, const double *start, const double *begin, double at, int32_t n);
} ntp__column_loops;

typedef struct ntp__solver_kernels {
    ntp__fft_loops fft_single, fft_double;
    ntp__row_loops rows_single, rows_double;
    ntp__column_loops columns;
    ntp__slopes8_fn *slopes8;
    /* For n texels, the squared distance between the (x, y) of two normals, both given as slopes: row[0]
     * and row[1], row[2] and row[3]. */
    void (*squares_off)(double *out, double *const *row, int32_t x, int32_t n);
    /* range[0] = the least of range[0] and n numbers; range[1] = the greatest */
    void (*range)(float range[2], const float *row, int32_t n);
} ntp__solver_kernels;

const ntp__solver_kernels *ntp__solver_kernels_for(int mask);

#endif
