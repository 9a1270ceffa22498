/* SPDX-License-Identifier: MIT */
/*
 * slopes.h - rows of normals as slopes
 *
 * This room has what both solvers and the round trip use, and nothing that only one of them uses.
 *   height_plan.h       what is to be solved
 *   slopes.c            the texture as slopes
 *   slope_operator.h    heights to slopes as a linear operator, and its adjoint
 *   inverse.h           the normal equations without weights and holes, solved by transforms
 *   holes.h             the texels that get no height
 *   row_cache.h         rows of slopes that are kept for the rows around
 *   fft.h               Fourier and cosine transforms of many rows (fft_lines_tmpl.h does them)
 *   solver_kernels.h    the loops that are compiled for each instruction set
 */
#ifndef NTP_SLOPES_H
#define NTP_SLOPES_H

#include "base/view.h"
#include "to_height/shared/height_plan.h"

/* How the samples of a texture become slopes. */
typedef struct ntp__slopes {
    const ntp_const_image *src;
    ntp_decode decode;
    uint32_t touch_unused; /* with the bits of what is no padding in this encoding */
    int32_t zero;          /* x is (2 c - zero) / range */
    double range;
    double z_scale;  /* z-zero: z is b * z_scale / range */
    int32_t neutral; /* |2 c - zero| up to this counts as 0 */
    bool derived;
    bool mixed;   /* z is a mean of the stored and the derived one */
    double least; /* the least z, times range */
} ntp__slopes;

typedef struct ntp__slope_counts {
    uint64_t unused, not_finite;
    double consistency, consistency_max; /* for telescoping: see ntp_height_result */
    float range[2];                      /* of the heights that the direct solver wrote */
} ntp__slope_counts;

/* NTP_DECODE_AUTO is read as NTP_DECODE_UNORM. */
void ntp__slopes_init(ntp__slopes *s, const ntp_const_image *src, const ntp__height_plan *plan);

/* Slopes of row y, to the right and down the picture.  counts may be NULL. */
void ntp__slopes_row(const ntp__slopes *s, double *right, double *down, int32_t y,
                     ntp__slope_counts *counts);

/* The same in float arithmetic, which is precise enough for 8-bit textures. */
void ntp__slopes_row_single(const ntp__slopes *s, float *right, float *down, int32_t y,
                            ntp__slope_counts *counts);

#endif
