/* SPDX-License-Identifier: MIT */
/*
 * solve.c - weighted least squares by conjugate gradients
 *
 * The direction d is conjugate to the ones before.  z, the preconditioned residual, lies in dst as
 * floats.  So the preconditioner differs slightly each time, which the flexible formula for beta
 * allows.  At the end the residual is worked out anew from the stored slopes.  If it is not yet
 * small enough, the iteration starts again from there.
 */
#include "to_height/weighted/weighted.h"

#include <math.h>
#include <string.h>

/* The strength of pairs beside slopes.  They decide where the stencil is nearly blind.  Elsewhere
 * their effect stays below the rounding of 8 bits, or of 16.  Kernels of 3 x 3 and more are blind
 * to more. */
static const double strength_8 = 1e-2, strength_16 = 1e-3, strength_16_central = 1e-4;
static const double strength_without_prior = 1e-5;
/* In the preconditioner alone, where slopes decide.  With less, floats have no digits for what the
 * stencil does not see.  Where it does not know the ends or the holes, it must not make too much of
 * the finest detail. */
static const double strength_least = 1e-8, strength_inexact = 1e-4;
/* In the second solution, by the prior.  The difference of a pair is the mean of two slopes but for
 * an error, and this grows with the Laplacian, as the prior does.  The stencils of wider kernels
 * hide more of the heights, so the error is larger; of 8 bits, rounding is a part of it. */
static const double by_prior_8 = 16, by_prior_8_wide = 0.3;
static const double by_prior_16 = 300, by_prior_16_wide = 10;
/* The second solution ends when one part of its iterations, the last fifth, made the sum of squares
 * fall by less than this share of what rounding makes of it.  With 0.1 up to 5 % more texels
 * differ. */
static const double share_of_rounding = 0.02, usual_tolerance = 1e-6;
/* Floats are taken to be rounded to this. */
static const double finest_level = 0x1p-20;
enum { LEAST_PART = 12, TIMES_MOST = 30 /* of max_iterations */ };
/* Where no slope counts, pairs are so many times as strong.  With more, iteration takes longer. */
static const double alone = 10;

/* ------------------------------------------------------------------------ working memory */

static void lay_out_part(ntp__weighted *w, ntp__weighted_part *part, ntp__scratch *memory)
{
    size_t width = (size_t) w->width, row = width * sizeof(double);
    ntp__weighted_part p;
    memset(&p, 0, sizeof p);
    ntp__row_cache_init(&p.weighted, memory, NTP__KEPT, row);
    ntp__row_cache_init(&p.stored, memory, NTP__KEPT, row);
    for (int32_t k = 0; k < NTP__SPARE; k++)
        p.spare[k] = ntp__take(memory, row);
    p.nothing = ntp__take(memory, row);
    p.no_weights = ntp__take(memory, width * sizeof(float));
    if (memory->base == NULL)
        return;
    memset(p.nothing, 0, row);
    memset(p.no_weights, 0, width * sizeof(float));
    *part = p;
}

static size_t greater(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* With memory->base NULL it only measures. */
static void lay_out(ntp__weighted *w, ntp__scratch *memory)
{
    size_t texels = (size_t) w->width * (size_t) w->height;
    size_t rows = (size_t) w->height * sizeof(double);
    w->parts = ntp__take(memory, (size_t) w->crew.parts * sizeof *w->parts);
    for (int32_t i = 0; i < w->crew.parts; i++)
        lay_out_part(w, w->parts != NULL ? &w->parts[i] : NULL, memory);
    ntp__inverse_init(&w->inverse, w->plan, w->crew, memory);
    w->stencil = ntp__take(memory, sizeof *w->stencil);
    w->sum = ntp__take(memory, rows);
    w->sum_also = ntp__take(memory, rows);
    w->laplacian = ntp__take(memory, texels * sizeof(double));
    w->x = ntp__take(memory, texels * sizeof(double));
    w->r = ntp__take(memory, texels * sizeof(double));
    w->d = ntp__take(memory, texels * sizeof(double));
    w->a = ntp__take(memory, greater(texels * sizeof(double), ntp__walk_bytes(w->plan)));
    w->right = ntp__take(memory, texels * sizeof(float));
    w->down = ntp__take(memory, texels * sizeof(float));
}

static double strength_of(const ntp__height_plan *plan, const ntp__slopes *slopes)
{
    if (plan->kernel == NTP_KERNEL_FORWARD)
        return 0;
    if (plan->kernel == NTP_KERNEL_BAKED)
        return 1;
    if (plan->prior == NTP_PRIOR_NONE)
        return strength_without_prior;
    if (slopes->src->type == NTP_TYPE_U8)
        return strength_8;
    return plan->kernel == NTP_KERNEL_CENTRAL ? strength_16_central : strength_16;
}

static void init(ntp__weighted *w, const ntp__height_plan *plan, ntp__crew crew)
{
    memset(w, 0, sizeof *w);
    w->plan = plan;
    w->mask = plan->mask;
    w->crew = crew;
    w->width = plan->width;
    w->height = plan->height;
    w->rows = plan->kernel != NTP_KERNEL_BAKED;
    w->dx = plan->dx;
    w->dy = plan->dy;
}

size_t ntp__weighted_scratch(const ntp__height_plan *plan, int32_t parts)
{
    ntp__weighted w;
    ntp__scratch memory = { NULL, 0 };
    ntp__crew crew = { NULL, parts };
    init(&w, plan, crew);
    lay_out(&w, &memory);
    return memory.used;
}

/* -------------------------------------------------------------------------------- passes */

static double total(const double *sum, int32_t n)
{
    double all = 0;
    for (int32_t i = 0; i < n; i++)
        all += sum[i];
    return all;
}

/* x and r move along d. */
static void step(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    (void) part;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++) {
        size_t at = ntp__weighted_at(w, y);
        for (size_t i = at; i < at + (size_t) w->width; i++) {
            w->x[i] += w->alpha * w->d[i];
            w->r[i] -= w->alpha * w->a[i];
        }
    }
}

/* sum: r z of each row.  sum_also: a z of each row.  z is set to 0 in holes. */
static void multiply(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    (void) part;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++) {
        size_t at = ntp__weighted_at(w, y);
        float *z = ntp__at_mut(w->dst, 0, y);
        double rz = 0, az = 0;
        for (int32_t x = 0; x < w->width; x++) {
            z[x] = ntp__in_hole(w->right[at + (size_t) x]) ? 0 : z[x];
            rz += w->r[at + (size_t) x] * (double) z[x];
            az += w->a[at + (size_t) x] * (double) z[x];
        }
        w->sum[y] = rz;
        w->sum_also[y] = az;
    }
}

static void turn(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    (void) part;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++) {
        double *d = w->d + ntp__weighted_at(w, y);
        const float *z = ntp__at_mut(w->dst, 0, y);
        for (int32_t x = 0; x < w->width; x++)
            d[x] = w->beta != 0 ? (double) z[x] + w->beta * d[x] : (double) z[x];
    }
}

static void each_band(ntp__weighted *w, ntp__crew_task *task)
{
    ntp__crew_each(&w->crew, task, w, ntp__bands(w));
}

/* ----------------------------------------------------------------------------- iteration */

typedef struct progress {
    double first, last; /* errors */
    double from, to;    /* shares of the whole at both */
    double share;
} progress;

/* About log2 of v. */
static double magnitude_of(double v)
{
    int32_t sum = 0;
    while (v > 1) {
        v /= 2;
        sum++;
    }
    while (v > 0 && v < 1) {
        v *= 2;
        sum--;
    }
    return sum;
}

static bool stopped(const ntp__weighted *w, progress *p, double error)
{
    const ntp_hooks *hooks = w->crew.hooks;
    if (hooks == NULL || hooks->progress == NULL)
        return false;
    double all = magnitude_of(p->first) - magnitude_of(p->last);
    double done = magnitude_of(p->first) - magnitude_of(error);
    double share = all > 0 ? done / all : 1;
    share = p->from + (p->to - p->from) * (share > 1 ? 1 : share);
    p->share = share > p->share ? share : p->share;
    return hooks->progress(hooks->user, p->share) != 0;
}

/* Makes z, and returns the error of r.  It is the root of r z, which is about the root of the sum
 * of weight (error of slope)^2. */
static double precondition(ntp__weighted *w)
{
    ntp__inverse_apply(&w->inverse, w->dst, w->r);
    each_band(w, multiply);
    double rz = total(w->sum, w->height);
    return rz > 0 ? sqrt(rz) : 0;
}

/* One step from x along d, and the next d.  r is the residual of x, dst is z, and *error is the error
 * of r.  Returns by how much the sum of squares falls; 0: no step was possible. */
static double go_on(ntp__weighted *w, double *error)
{
    double rz = *error * *error;
    each_band(w, turn);
    ntp__weighted_apply(w, w->a, w->d, false);
    double curvature = total(w->sum, w->height);
    if (!(curvature > 0))
        return 0; /* d is only rounding errors, and so will the residual be */
    w->alpha = rz / curvature;
    each_band(w, step);
    *error = precondition(w);
    w->beta = -w->alpha * total(w->sum_also, w->height) / rz;
    w->beta = w->beta > 0 ? w->beta : 0;
    return w->alpha * rz;
}

/* Iterates from x on until the error is small. */
static ntp_status descend(ntp__weighted *w, double *error, double goal, int32_t most,
                          int32_t *iterations, progress *p)
{
    w->beta = 0;
    while (*error > goal && *iterations < most) {
        if (stopped(w, p, *error))
            return NTP_ERR_CANCELLED;
        if (!(go_on(w, error) > 0))
            return NTP_OK;
        ++*iterations;
    }
    return NTP_OK;
}

/* Iterates from x on until one part of the iterations makes the sum of squares fall by no more than
 * `enough`. */
static ntp_status descend_in_parts(ntp__weighted *w, double *error, double enough, int32_t most,
                                   int32_t *iterations, progress *p)
{
    double fall = p->first, last;
    int32_t done = 0;
    w->beta = 0;
    do {
        int32_t part = done / 4 > LEAST_PART ? done / 4 : LEAST_PART;
        last = fall;
        fall = 0;
        for (int32_t i = 0; i < part && done < most; i++) {
            if (stopped(w, p, last))
                return NTP_ERR_CANCELLED;
            double by = go_on(w, error);
            if (!(by > 0))
                return NTP_OK;
            fall += by;
            done++;
            ++*iterations;
        }
    } while (fall > enough && done < most);
    return NTP_OK;
}

/* Repeats until the residual that is worked out from the slopes is small enough, or nothing more
 * helps.  It is this share of the whole work. */
static ntp_status iterate(ntp__weighted *w, double scale, double share, ntp_height_result *result)
{
    int32_t most = w->plan->max_iterations;
    double goal = w->plan->tolerance * scale;
    progress p = { scale, goal, 0, share, 0 };
    for (;;) {
        ntp__weighted_apply(w, w->r, w->x, true);
        double error = precondition(w);
        result->error = scale > 0 ? error / scale : 0;
        if (error <= goal)
            return NTP_OK;
        int32_t before = result->iterations;
        NTP__TRY(descend(w, &error, goal, most, &result->iterations, &p));
        if (result->iterations == before)
            return NTP_ERR_NOT_CONVERGED;
    }
}

/* The prior of the direct solver is the variance of the rounding of slopes, level^2/12, over the
 * mean square of the right-hand side, which stands for the Laplacian of the heights.  With weights
 * less of it makes better heights; the right-hand side of wide kernels has less than the Laplacian.
 * With 8 bits it is also relative to the mean weight: with more, fewer texels come back.  These were
 * measured. */
static double part_of_prior(const ntp__weighted *w)
{
    int32_t radius = ntp__kernel_table[w->plan->kernel].radius;
    if (w->slopes->src->type == NTP_TYPE_U8)
        return radius > 1 ? 0.5 : 0.6;
    return radius > 2 ? 0.5 : 0.75;
}

/* Works in r and d. */
static double prior_of(ntp__weighted *w)
{
    ntp_type type = w->slopes->src->type;
    double level = type == NTP_TYPE_U8 ? 2.0 / 255 : type == NTP_TYPE_U16 ? 2.0 / 65535 : 0x1p-23;
    double step = w->dx < w->dy ? w->dx : w->dy, sum = 0, weights = 0, count = 0;
    size_t texels = (size_t) w->width * (size_t) w->height;
    memset(w->d, 0, texels * sizeof *w->d);
    ntp__weighted_apply(w, w->r, w->d, true);
    for (size_t i = 0; i < texels; i++) {
        bool counts = ntp__counts(w->right[i]);
        sum += w->r[i] * w->r[i];
        weights += counts ? (double) w->right[i] / w->inverse.share_x : 0;
        count += counts;
    }
    /* The right-hand side has it, squared. */
    double weight = count > 0 ? weights / count : 0;
    double fine = level > finest_level ? level : finest_level;
    w->rounding = 2 * weights * fine * fine / 12 * step * step;
    double noise =
        level * level / 12 * part_of_prior(w) * step * step * (type == NTP_TYPE_U8 ? weight : 1);
    return sum > 0 ? noise * weight * weight * count / sum : 0;
}

/* Is the preconditioner the inverse of the problem, but for weights? */
static bool is_exact(const ntp__weighted *w)
{
    const ntp_border border[2] = { w->plan->border_x, w->plan->border_y };
    bool exact = !w->holes;
    for (int32_t i = 0; i < 2; i++) {
        bool clamp =
            border[i] == NTP_BORDER_CLAMP && ntp__kernel_table[w->plan->kernel].radius == 1;
        exact = exact && (clamp || border[i] == NTP_BORDER_WRAP || border[i] == NTP_BORDER_MIRROR);
    }
    return exact;
}

/* Is there more to do than what pairs leave? */
static bool pairs_alone(const ntp__weighted *w)
{
    return !w->rows || w->strength == 0 || w->plan->prior == NTP_PRIOR_NONE;
}

/* Solves without pairs, or with holes with pairs that are as weak as they are inexact. */
static ntp_status solve_slopes(ntp__weighted *w, double scale, ntp_height_result *result)
{
    bool exact = is_exact(w), deep = w->slopes->src->type != NTP_TYPE_U8;
    bool wide = ntp__kernel_table[w->plan->kernel].radius > 1;
    double pairs = deep   ? wide ? by_prior_16_wide : by_prior_16
                   : wide ? by_prior_8_wide
                          : by_prior_8;
    if (!exact)
        NTP__TRY(iterate(w, scale, 0.5, result));
    w->strength = w->strength_alone = 0;
    w->prior = w->inverse.prior = prior_of(w);
    w->strength = w->strength_alone = w->holes ? pairs * w->prior : 0;
    w->inverse.strength = exact ? strength_least : strength_inexact;
    if (exact)
        return iterate(w, scale, 1, result);
    ntp__weighted_apply(w, w->r, w->x, true);
    double error = precondition(w);
    double finer = w->plan->tolerance / usual_tolerance;
    progress p = { error * error, share_of_rounding * w->rounding * finer * finer, 0.5, 1, 0.5 };
    return descend_in_parts(w, &error, p.last, TIMES_MOST * w->plan->max_iterations,
                            &result->iterations, &p);
}

static void store(void *job, int32_t part, int32_t item)
{
    ntp__weighted *w = job;
    (void) part;
    for (int32_t y = item * NTP__BAND; y < w->height && y < (item + 1) * NTP__BAND; y++) {
        const double *x = w->x + ntp__weighted_at(w, y);
        float *row = ntp__at_mut(w->dst, 0, y);
        for (int32_t i = 0; i < w->width; i++)
            row[i] = (float) x[i];
    }
}

ntp_status ntp__weighted_solve(const ntp_image *dst, const ntp__slopes *slopes,
                               const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                               ntp_height_result *result)
{
    ntp__weighted w;
    ntp__scratch memory = { scratch, 0 };
    double trend[2] = { 0, 0 };
    size_t texels = (size_t) dst->width * (size_t) dst->height;
    init(&w, plan, ntp__crew_of(hooks));
    w.strength = strength_of(plan, slopes);
    w.strength_alone = w.rows ? alone * w.strength : w.strength;
    w.dst = dst;
    result->iterations = 0;
    w.slopes = slopes;
    lay_out(&w, &memory);
    w.inverse.strength = w.strength;
    ntp__weighted_setup(&w);
    double scale = sqrt(total(w.sum, w.height));
    memset(w.x, 0, texels * sizeof *w.x);
    memset(w.a, 0, texels * sizeof *w.a);
    ntp__weighted_start(&w);
    ntp_status status =
        pairs_alone(&w) ? iterate(&w, scale, 1, result) : solve_slopes(&w, scale, result);
    if (status == NTP_ERR_CANCELLED)
        return status;
    result->holes = result->not_finite = 0;
    for (int32_t i = 0; i < w.crew.parts; i++) {
        result->holes += w.parts[i].holes;
        result->not_finite += w.parts[i].not_finite;
    }
    result->islands = ntp__islands_level(&w, plan->detrend ? trend : NULL);
    result->trend_x = trend[0];
    result->trend_y = trend[1];
    each_band(&w, store);
    return status;
}
