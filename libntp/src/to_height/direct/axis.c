/* SPDX-License-Identifier: MIT */
/*
 * axis.c - the stencils of an axis: their adjoints, and what they multiply frequencies by
 *
 * Beyond free ends heights go on mirrored, about the edge of the last texel (clamp) or about its
 * middle (mirror).  Slopes along the axis go on with the other sign.  Then every stencil is a
 * convolution, cosines are its eigenvectors, and the adjoint is the reversed convolution.
 * One-sided and baked slopes lie on the edges between texels, as in the compact Laplacian.
 */
#include "stencil/taps.h"
#include "to_height/direct/direct.h"

#include <string.h>

enum { RADIUS = NTP__MAX_RADIUS, BAKED = 4 /* slopes that make an edge */ };

/* --------------------------------------------------------------------------------- kinds */

/* Can the solver do this border? */
static bool border_known(ntp_kernel kernel, ntp_border border)
{
    if (kernel == NTP_KERNEL_BAKED || kernel == NTP_KERNEL_FORWARD)
        return true;
    if (kernel == NTP_KERNEL_CENTRAL)
        return border != NTP_BORDER_REPEAT_SLOPE;
    /* Up to one texel outside, clamped heights are mirrored ones. */
    bool clamp = border == NTP_BORDER_CLAMP && ntp__kernel_table[kernel].radius == 1;
    return border == NTP_BORDER_WRAP || border == NTP_BORDER_MIRROR || clamp;
}

static void init_axis(ntp__grid_axis *axis, int32_t n, ntp_kernel kernel, ntp_border border)
{
    memset(axis, 0, sizeof *axis);
    axis->n = n;
    axis->kernel = kernel;
    axis->border = border;
    axis->wrap = border == NTP_BORDER_WRAP;
    axis->edge = 1;
    if (kernel == NTP_KERNEL_BAKED) {
        axis->kind = NTP__AXIS_BAKED;
    } else if (kernel == NTP_KERNEL_FORWARD) {
        axis->kind = NTP__AXIS_FORWARD;
        if (border == NTP_BORDER_MIRROR)
            axis->last = -0.5;
        else if (border == NTP_BORDER_EXTRAPOLATE || border == NTP_BORDER_REPEAT_SLOPE)
            axis->last = 0.5;
    } else if (kernel == NTP_KERNEL_CENTRAL) {
        axis->kind = NTP__AXIS_CENTRAL;
        /* h[1] - h[0] where clamping makes (h[1] - h[0])/2; 0 where mirroring does */
        axis->edge = border == NTP_BORDER_EXTRAPOLATE ? 0.5 : 1;
    } else {
        axis->kind = NTP__AXIS_TAPS;
    }
}

ntp__fft_kind ntp__axis_transform(const ntp__grid_axis *axis)
{
    bool edges = axis->kind == NTP__AXIS_FORWARD || axis->kind == NTP__AXIS_BAKED;
    if (axis->wrap)
        return NTP__FFT_REAL;
    return axis->border == NTP_BORDER_MIRROR && !edges && axis->n > 1 ? NTP__FFT_MIRROR
                                                                      : NTP__FFT_COSINE;
}

int32_t ntp__reach(const ntp__grid_axis *axis)
{
    if (axis->kind == NTP__AXIS_TAPS)
        return ntp__kernel_table[axis->kernel].radius;
    return axis->kind == NTP__AXIS_BAKED ? BAKED - 1 : 1;
}

int32_t ntp__reflected(const ntp__grid_axis *axis, int32_t i, bool odd, double *sign)
{
    int32_t n = axis->n;
    ntp__fft_kind kind = ntp__axis_transform(axis);
    int32_t period = kind == NTP__FFT_REAL ? n : kind == NTP__FFT_COSINE ? 2 * n : 2 * (n - 1);
    int32_t at = i % period;
    at += at < 0 ? period : 0;
    *sign = 1;
    if (kind == NTP__FFT_MIRROR && odd && at % (n - 1) == 0)
        *sign = 0;
    if (at < n)
        return at;
    *sign = odd ? -*sign : *sign;
    return kind == NTP__FFT_COSINE ? period - 1 - at : period - at;
}

/* ------------------------------------------------------------------------------- adjoints */

static void add_term(ntp__terms *terms, int32_t at, double weight)
{
    for (int32_t i = 0; i < terms->count; i++) {
        if (terms->at[i] == at) {
            terms->weight[i] += weight;
            return;
        }
    }
    terms->at[terms->count] = at;
    terms->weight[terms->count] = weight;
    terms->count++;
}

/* The slope between i and i + 1 of a surface, from the slopes at four texels, to fourth order. */
static void add_baked_edge(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i, double weight)
{
    static const double middle[BAKED] = { -1.0 / 24, 13.0 / 24, 13.0 / 24, -1.0 / 24 };
    static const double end[BAKED] = { 9.0 / 24, 19.0 / 24, -5.0 / 24, 1.0 / 24 };
    static const double end3[] = { 5.0 / 12, 8.0 / 12, -1.0 / 12 };
    int32_t n = axis->n;
    bool last = i == n - 2;
    if (axis->wrap || (i > 0 && !last)) {
        for (int32_t k = 0; k < BAKED; k++)
            add_term(terms, (int32_t) (((int64_t) i + k - 1 + 2 * (int64_t) n) % n),
                     weight * middle[k]);
    } else if (n == 2) {
        add_term(terms, 0, weight / 2);
        add_term(terms, 1, weight / 2);
    } else {
        int32_t count = n == 3 ? 3 : BAKED;
        for (int32_t k = 0; k < count; k++)
            add_term(terms, last ? n - 1 - k : k, weight * (n == 3 ? end3[k] : end[k]));
    }
}

/* The slope between i and i + 1. */
static void add_edge(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i, double weight)
{
    if (axis->kind == NTP__AXIS_BAKED) {
        add_baked_edge(terms, axis, i, weight);
    } else if (axis->wrap || i != axis->n - 2 || axis->last == 0) {
        add_term(terms, i, weight);
    } else {
        add_term(terms, i, weight / 2);
        add_term(terms, i + 1, weight * axis->last);
    }
}

static void add_central(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i, double weight)
{
    double sign;
    int32_t at = ntp__reflected(axis, i, true, &sign);
    bool end = !axis->wrap && (at == 0 || at == axis->n - 1);
    if (sign != 0)
        add_term(terms, at, weight * sign * (end ? axis->edge : 1));
}

void ntp__adjoint(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i)
{
    int32_t n = axis->n;
    terms->count = 0;
    if (n == 1)
        return;
    if (axis->kind == NTP__AXIS_CENTRAL) {
        add_central(terms, axis, i - 1, 0.5);
        add_central(terms, axis, i + 1, -0.5);
        return;
    }
    if (axis->wrap || i > 0)
        add_edge(terms, axis, i > 0 ? i - 1 : n - 1, 1);
    if (axis->wrap || i < n - 1)
        add_edge(terms, axis, i, -1);
}

/* ------------------------------------------------------------------------------- symbols */

/* cos and sin of `times` times half the frequency of element j. */
static void half_turns(double *c, double *s, const ntp__grid_axis *axis, int32_t j, int32_t times)
{
    int64_t n = axis->n, k = axis->wrap && 2 * (int64_t) j > n ? n - j : j, whole = 2 * n;
    ntp__fft_kind kind = ntp__axis_transform(axis);
    /* The frequency is 2 pi k/n for wrap, pi k/n for clamp, and pi k/(n - 1) for mirror. */
    if (kind != NTP__FFT_REAL)
        whole = 4 * (kind == NTP__FFT_MIRROR ? n - 1 : n);
    ntp__turn(c, s, k * times % whole, whole);
}

void ntp__symbol_at(ntp__symbol *symbol, const ntp__grid_axis *axis, int32_t j)
{
    double c, s;
    memset(symbol, 0, sizeof *symbol);
    symbol->across[0] = 1;
    half_turns(&c, &s, axis, j, 1);
    symbol->roughness = 4 * s * s;
    if (axis->kind == NTP__AXIS_CENTRAL) {
        half_turns(&c, &s, axis, j, 2);
        symbol->along[0] = s;
    } else if (axis->kind != NTP__AXIS_TAPS) {
        symbol->along[0] = 2 * s;
    } else {
        const ntp__kernel *kernel = &ntp__kernel_table[axis->kernel];
        for (int32_t t = 0; t < kernel->terms; t++) {
            double across = kernel->term[t].across[RADIUS], along = 0;
            for (int32_t i = 1; i <= RADIUS; i++) {
                half_turns(&c, &s, axis, j, 2 * i);
                along += 2 * kernel->term[t].along[RADIUS + i] * s;
                across += 2 * kernel->term[t].across[RADIUS + i] * c;
            }
            /* The denominator goes into one of the two factors. */
            symbol->along[t] = along / kernel->denominator;
            symbol->across[t] = across;
        }
    }
}

void ntp__symbols(ntp__symbol *symbol, const ntp__grid_axis *axis)
{
    for (int32_t j = 0; j < axis->n; j++) {
        if (axis->wrap && j > axis->n - j)
            symbol[j] = symbol[axis->n - j];
        else
            ntp__symbol_at(&symbol[j], axis, j);
    }
}

/* ------------------------------------------------------------------------------- problem */

/* Slopes count as differences of heights per step of dy.  Those to the right are per step of dx, so
 * they weigh (dy/dx)^2. */
static void set_weights(ntp__problem *p, const ntp__height_plan *plan)
{
    double dx = plan->dx, dy = plan->dy;
    p->ratio = dy / dx * (dy / dx);
    p->right_weight = dy * (dy / dx);
    p->down_weight = dy;
}

ntp_status ntp__direct_check(const ntp__height_plan *plan)
{
    ntp_kernel kernel = plan->kernel;
    /* Telescoping uses no slope at a border. */
    bool known = plan->solver == NTP__SOLVER_TELESCOPING
                     ? kernel == NTP_KERNEL_CENTRAL || kernel == NTP_KERNEL_FORWARD
                     : border_known(kernel, plan->border_x) && border_known(kernel, plan->border_y);
    return known ? NTP_OK : NTP_ERR_FORMAT;
}

void ntp__problem_init(ntp__problem *p, const ntp__height_plan *plan, ntp_type type)
{
    memset(p, 0, sizeof *p);
    set_weights(p, plan);
    init_axis(&p->along, plan->width, plan->kernel, plan->border_x);
    init_axis(&p->down, plan->height, plan->kernel, plan->border_y);
    bool taps = p->along.kind == NTP__AXIS_TAPS;
    /* Central slopes hardly respond to the finest detail either, which errors of damage show. */
    bool damaged = plan->kernel == NTP_KERNEL_CENTRAL && plan->error > 0;
    bool prior =
        plan->prior == NTP_PRIOR_ROUGHNESS || (plan->prior == NTP_PRIOR_AUTO && (taps || damaged));
    p->single = type == NTP_TYPE_U8;
    p->filter = taps || prior || ntp__axis_transform(&p->down) == NTP__FFT_MIRROR;
    /* A level is 2/M, and rounding errors are spread evenly over it; floats have 24 bits. */
    double level = type == NTP_TYPE_U8 ? 2.0 / 255 : type == NTP_TYPE_U16 ? 2.0 / 65535 : 0x1p-23;
    double error = level * 0.28867513459481288;
    p->sigma = prior ? (error > plan->error ? error : plan->error) * p->down_weight : 0;
}
