/* SPDX-License-Identifier: MIT */
/*
 * filter.c - solves columns by transforms, for stencils that recursion cannot do
 *
 * For each pair of frequencies the normal equations are one equation: A h = f.  A is the sum of the
 * squared symbols of the stencils, right and down.  A stencil of 3 x 3 or more is nearly blind to
 * the finest detail.  There A is so small that division by it would magnify the rounding errors of
 * the slopes without limit.  So among heights that fit alike smooth ones are preferred, as by a
 * Wiener filter: h = f / (A + e L^2).  L is the Laplacian.  e is the variance of the rounding over
 * the mean square of the Laplacian of the heights, for which f stands.  The floats between the
 * passes are rounded too; that counts as noise of f itself: + t L^2 / A.
 */
#include "to_height/direct/direct.h"

#include <string.h>

/* t, the square of the relative error of f: of floats, and of transforms in float. */
static const double storage_noise = 0x1p-48, single_noise = 0x1p-44;

/* An A below this is 0 but for rounding errors of sines: a null mode. */
static const double null_mode = 0x1p-90;

void ntp__filter_init(ntp__filter *f, ntp__scratch *memory, const ntp__problem *p, void *work)
{
    memset(f, 0, sizeof *f);
    f->problem = p;
    f->along = ntp__take(memory, (size_t) p->along.n * sizeof *f->along);
    f->down = ntp__take(memory, (size_t) p->down.n * sizeof *f->down);
    ntp__fft_plan(&f->fft, memory, ntp__axis_transform(&p->down), p->down.n, p->single, work);
    f->precision = p->single ? single_noise : storage_noise;
    if (memory->base == NULL)
        return;
    ntp__symbols(f->along, &p->along);
    ntp__symbols(f->down, &p->down);
}

void ntp__filter_set_prior(ntp__filter *f, double mean_square)
{
    double sigma = f->problem->sigma;
    f->prior = mean_square > 0 ? sigma * sigma / mean_square : 0;
}

typedef struct columns {
    const ntp__filter *filter;
    int32_t x0, count;
} columns;

static void factors(const void *user, int32_t k, double factor[NTP__FFT_ROWS])
{
    const columns *c = user;
    const ntp__filter *f = c->filter;
    const ntp__symbol *y = &f->down[k];
    double ratio = f->problem->ratio;
    for (int32_t i = 0; i < NTP__FFT_ROWS; i++) {
        const ntp__symbol *x = &f->along[c->x0 + (i < c->count ? i : 0)];
        double right = x->along[0] * y->across[0] + x->along[1] * y->across[1];
        double down = x->across[0] * y->along[0] + x->across[1] * y->along[1];
        double rough = ratio * x->roughness + y->roughness;
        double seen = ratio * right * right + down * down;
        double square = rough * rough;
        factor[i] =
            seen > null_mode ? 1 / (seen + f->prior * square + f->precision * square / seen) : 0;
    }
}

void ntp__filter_columns(const ntp__filter *f, const ntp_image *dst, int32_t x0, void *work)
{
    int32_t left = dst->width - x0;
    columns c = { f, x0, left < NTP__FFT_ROWS ? left : NTP__FFT_ROWS };
    f->fft.loops->filter(&f->fft, ntp__at_mut(dst, x0, 0),
                         dst->row_stride / (ptrdiff_t) sizeof(float), c.count, factors, &c, work);
}
