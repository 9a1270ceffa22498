/* SPDX-License-Identifier: MIT */
/*
 * loops_avx2.c - the loops of find_kernel.c, find_seams.c, between.c and ends_meet.c with AVX2
 */
#include "detect/between_loops_tmpl.h"
#include "detect/kernel_loops_tmpl.h"
#include "detect/line_loops_tmpl.h"

/* These round n up to whole lanes: NTP__BLOCK numbers have place for them. */

void ntp__to_slopes_avx2(float *p, float *q, int32_t *bad, ntp__block *b, int32_t m, float sign,
                         int32_t n)
{
    const int32_t filled = (n + 7) & -8;
    for (int32_t i = n; i < filled; i++)
        b->c[0][i] = b->c[1][i] = 0;
    ntp__to_slopes(p, q, bad, b, m, sign, filled);
}

void ntp__to_noise_avx2(float *p_noise, float *q_noise, const float *p_row, const float *q_row,
                        float level, int32_t n)
{
    ntp__to_noise(p_noise, q_noise, p_row, q_row, level, (n + 7) & -8);
}

void ntp__to_worth_avx2(int32_t *worth, const float *u, const float *v, const int32_t *bad,
                        int32_t taps, float level, int32_t n)
{
    ntp__to_worth(worth, u, v, bad, taps, level, (n + 7) & -8);
}

double ntp__sum_squares_avx2(float *e, const float *expected, const int32_t *worth, int32_t n)
{
    return ntp__sum_squares(e, expected, worth, (n + 7) & -8);
}

void ntp__line_slopes_avx2(ntp__line *l, int32_t along, int32_t m, int32_t n)
{
    ntp__block *b = &l->block;
    const int32_t filled = (n + 7) & -8;
    for (int32_t i = n; i < filled; i++)
        b->c[0][i] = b->c[1][i] = 0;
    ntp__line_slopes(l->p + 1, l->q + 1, b->c[along], b->c[1 - along], m, filled);
}

void ntp__sum_line_avx2(ntp__line_sums *sums, ntp__windows *windows, ntp__line *l, bool first,
                        double jump, int32_t n)
{
    ntp__sum_line(sums, windows, l, first, jump, n);
}

void ntp__sum_slopes_avx2(float *p_sum, float *q_sum, const ntp__block *b, int32_t m, float sign,
                          int32_t step)
{
    if (step == 1)
        ntp__sum_slopes(p_sum, q_sum, b, m, sign, 1);
    else
        ntp__sum_slopes(p_sum, q_sum, b, m, sign, BETWEEN_STEP);
}

void ntp__sum_products_avx2(ntp__products *sums, const float (*u)[BETWEEN_MOVED],
                            const float (*v)[BETWEEN_MOVED])
{
    ntp__sum_products(sums, u, v);
}

void ntp__add_floats_avx2(double *sum, const float *v, int32_t n)
{
    ntp__add_floats(sum, v, n);
}
