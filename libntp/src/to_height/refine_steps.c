/* SPDX-License-Identifier: MIT */
/*
 * refine_steps.c - a step to heights whose normals come nearer to the texture
 *
 * The method is L-BFGS: a direction comes from the gradient, from the inverse of the normal
 * equations of least squares as first guess of the inverse curvature, and from what the last steps
 * changed in the gradient (J. Nocedal, Updating Quasi-Newton Matrices with Limited Storage, 1980).
 *
 * The method needs products of the last steps with the last changes of the gradient.  A change y of
 * the gradient is kept as its answer, the inverse applied to it.  As the inverse is symmetric, all
 * products come from one walk over the planes.
 */
#include "to_height/refinement.h"

#include <string.h>

enum { MOST_TRIES = 12 }; /* lengths of a step */

/* The metric has more than slopes: pairs, and the squared Laplacian, so many times as strong as in
 * the direct solver.  They keep the correction out of the finest detail, to which kernels of 3 x 3
 * and more hardly respond: heights would follow the rounding there. */
static const double strength = 1e-4, roughness = 8;

/* A step has to lower the sum by this part of what the gradient promises. */
static const double sufficient = 1e-4;

static void each_row(ntp__refinement *f, ntp__crew_task *task)
{
    ntp__crew_each(&f->crew, task, f, f->plan->height);
}

/* The sum over all rows of one of the numbers that each row has. */
static double total(const ntp__refinement *f, int32_t which)
{
    double sum = 0;
    for (int32_t y = 0; y < f->plan->height; y++)
        sum += f->sums[(size_t) y * NTP__MEMORY * NTP__DOTS + (size_t) which];
    return sum;
}

/* ---------------------------------------------------------------------- value and gradient */

static void move_row(void *job, int32_t part, int32_t y)
{
    ntp__refinement *f = job;
    double *h = f->heights + ntp__refinement_row(f, y);
    const float *way = f->way + ntp__refinement_row(f, y);
    (void) part;
    for (int32_t x = 0; x < f->plan->width; x++)
        h[x] += f->by * (double) way[x];
}

/* Moves the heights along the way, and returns the value there. */
double ntp__refinement_value(ntp__refinement *f, double length, uint64_t *off)
{
    ntp__plane heights = { f->heights, NULL, f->plan->width };
    f->by = length - f->moved;
    f->moved = length;
    if (f->by != 0)
        each_row(f, move_row);
    return ntp__round_trip_excess(f->trip, &heights, f->right, f->down, off);
}

/* out += row y of the adjoint of (x line of y line), applied to derivatives. */
static void add_adjoint(const ntp__refinement *f, double *out, double *mixed, int32_t y,
                        const ntp__line *along_rows, const ntp__line *along_columns,
                        const float *derivatives)
{
    ntp__line_terms terms;
    int32_t width = f->plan->width;
    ntp__line_column(&terms, along_columns, y);
    memset(mixed, 0, (size_t) width * sizeof *mixed);
    for (int32_t j = 0; j < terms.count; j++) {
        const float *row = derivatives + ntp__refinement_row(f, terms.at[j]);
        double weight = terms.weight[j];
        for (int32_t x = 0; x < width; x++)
            mixed[x] += weight * (double) row[x];
    }
    ntp__line_adjoint(along_rows, out, mixed);
}

static void gradient_row(void *job, int32_t part, int32_t y)
{
    ntp__refinement *f = job;
    const ntp__stencil *s = f->trip->stencil;
    double *out = f->gradient + ntp__refinement_row(f, y);
    double *mixed = f->work + (size_t) part * (size_t) f->plan->width;
    float *before = f->before + ntp__refinement_row(f, y);
    for (int32_t x = 0; x < f->plan->width; x++) {
        before[x] = (float) out[x];
        out[x] = 0;
    }
    for (int32_t t = 0; t < s->terms; t++) {
        add_adjoint(f, out, mixed, y, &s->along_x[t], &s->across_y[t], f->right);
        add_adjoint(f, out, mixed, y, &s->across_x[t], &s->along_y[t], f->down);
    }
}

/* -------------------------------------------------------------------------------- metric */

/* The stored slopes, and by how much x and y of the normal change with them: the mean of both,
 * squared. */
static void weigh_row(void *job, int32_t part, int32_t y)
{
    ntp__refinement *f = job;
    double *p = f->trip->parts[part].row[0], *q = f->trip->parts[part].row[1];
    size_t start = ntp__refinement_row(f, y);
    ntp__slopes_row(f->trip->slopes, p, q, y, NULL);
    for (int32_t x = 0; x < f->plan->width; x++) {
        double a = p[x] * p[x], b = q[x] * q[x], square = 1 + a + b;
        double sum = (1 + a) * (1 + a) + 2 * a * b + (1 + b) * (1 + b);
        f->scale[start + (size_t) x] = (float) (sum / (2 * square * square * square));
        f->right[start + (size_t) x] = (float) (p[x] * f->plan->dx);
        f->down[start + (size_t) x] = (float) (q[x] * f->plan->dy);
    }
}

/* What the squared Laplacian counts: see `roughness`.  The adjoint of the stored slopes, which lies
 * in the gradient, stands for the Laplacian. */
static double prior_of(const ntp__refinement *f)
{
    double level = 2 / f->trip->slopes->range * ntp__least_step(f->plan), sum = 0;
    size_t texels = (size_t) f->plan->width * (size_t) f->plan->height;
    for (size_t i = 0; i < texels; i++)
        sum += f->gradient[i] * f->gradient[i];
    return sum > 0 ? roughness * level * level / 12 * (double) texels / sum : 0;
}

void ntp__refinement_set_metric(ntp__refinement *f)
{
    bool forward = f->plan->kernel == NTP_KERNEL_FORWARD;
    size_t bytes = (size_t) f->plan->width * (size_t) f->plan->height * sizeof *f->gradient;
    memset(f->gradient, 0, bytes);
    each_row(f, weigh_row);
    each_row(f, gradient_row);
    bool baked = f->plan->kernel == NTP_KERNEL_BAKED; /* it has pairs alone */
    f->inverse.strength = forward ? 0 : baked ? 1 : strength;
    f->inverse.prior = forward || baked || f->plan->kernel == NTP_KERNEL_CENTRAL ? 0 : prior_of(f);
    ntp__inverse_scale(&f->inverse, f->scale, f->before);
    memset(f->gradient, 0, bytes);
}

/* -------------------------------------------------------------------------------- memory */

/* The products of the remembered steps and answers with the change of the gradient and with the
 * gradient.  The newest step is stored on the way. */
static void learn_row(void *job, int32_t part, int32_t y)
{
    ntp__refinement *f = job;
    int32_t width = f->plan->width;
    const double *g = f->gradient + ntp__refinement_row(f, y);
    const float *before = f->before + ntp__refinement_row(f, y),
                *way = f->way + ntp__refinement_row(f, y);
    const float *answer = f->answer + ntp__refinement_row(f, y);
    const float *answer_before = f->answer_before + ntp__refinement_row(f, y);
    float *step = f->step[f->newest] + ntp__refinement_row(f, y);
    float *answered = f->answered[f->newest] + ntp__refinement_row(f, y);
    (void) part;
    for (int32_t x = 0; x < width; x++) {
        step[x] = (float) (f->moved * (double) way[x]);
        answered[x] = answer[x] - answer_before[x];
    }
    for (int32_t i = 0; i < f->remembered; i++) {
        const float *s = f->step[i] + ntp__refinement_row(f, y),
                    *a = f->answered[i] + ntp__refinement_row(f, y);
        double sum[NTP__DOTS] = { 0, 0, 0, 0 };
        for (int32_t x = 0; x < width; x++) {
            double change = g[x] - (double) before[x];
            sum[0] += (double) s[x] * change;
            sum[1] += (double) a[x] * change;
            sum[2] += (double) s[x] * g[x];
            sum[3] += (double) a[x] * g[x];
        }
        memcpy(f->sums + ((size_t) y * NTP__MEMORY + (size_t) i) * NTP__DOTS, sum, sizeof sum);
    }
}

/* Takes the last step into memory, in place of the oldest one. */
static void learn(ntp__refinement *f)
{
    int32_t k = f->remembered < NTP__MEMORY ? f->remembered : (f->newest + 1) % NTP__MEMORY;
    f->newest = k;
    f->remembered += f->remembered < NTP__MEMORY;
    each_row(f, learn_row);
    for (int32_t i = 0; i < f->remembered; i++) {
        f->with_change[i][k] = total(f, i * NTP__DOTS);
        f->answer_change[i][k] = f->answer_change[k][i] = total(f, i * NTP__DOTS + 1);
        f->with_gradient[i] = total(f, i * NTP__DOTS + 2);
        f->answer_gradient[i] = total(f, i * NTP__DOTS + 3);
    }
    /* Only steps along which the gradient grew tell the curvature. */
    if (f->with_change[k][k] > 0 && f->answer_change[k][k] > 0)
        f->length = f->with_change[k][k] / f->answer_change[k][k];
    else
        f->remembered = 0;
}

/* The i-th remembered step, the oldest first. */
static int32_t place(const ntp__refinement *f, int32_t i)
{
    return f->remembered < NTP__MEMORY ? i : (f->newest + 1 + i) % NTP__MEMORY;
}

static void way_row(void *job, int32_t part, int32_t y)
{
    ntp__refinement *f = job;
    double *way = f->work + (size_t) part * (size_t) f->plan->width, sum = 0;
    const float *answer = f->answer + ntp__refinement_row(f, y);
    const double *g = f->gradient + ntp__refinement_row(f, y);
    float *out = f->way + ntp__refinement_row(f, y);
    int32_t width = f->plan->width;
    for (int32_t x = 0; x < width; x++)
        way[x] = -f->length * (double) answer[x];
    for (int32_t i = 0; i < f->remembered; i++) {
        const float *s = f->step[i] + ntp__refinement_row(f, y),
                    *a = f->answered[i] + ntp__refinement_row(f, y);
        for (int32_t x = 0; x < width; x++)
            way[x] += f->of_answer[i] * (double) a[x] - f->of_step[i] * (double) s[x];
    }
    for (int32_t x = 0; x < width; x++) {
        out[x] = (float) way[x];
        sum += (double) out[x] * g[x];
    }
    f->sums[(size_t) y * NTP__MEMORY * NTP__DOTS] = sum;
}

/* The two loops of L-BFGS, on products alone; then the way.  Returns its product with the
 * gradient. */
static double set_way(ntp__refinement *f)
{
    double alpha[NTP__MEMORY] = { 0 };
    for (int32_t i = f->remembered - 1; i >= 0; i--) {
        int32_t k = place(f, i);
        double product = f->with_gradient[k];
        for (int32_t j = i + 1; j < f->remembered; j++)
            product -= alpha[place(f, j)] * f->with_change[k][place(f, j)];
        alpha[k] = product / f->with_change[k][k];
    }
    for (int32_t i = 0; i < f->remembered; i++) {
        int32_t k = place(f, i);
        double product = f->answer_gradient[k];
        for (int32_t j = 0; j < f->remembered; j++)
            product -= alpha[j] * f->answer_change[j][k];
        product *= f->length;
        for (int32_t j = 0; j < i; j++)
            product += f->of_step[place(f, j)] * f->with_change[place(f, j)][k];
        f->of_step[k] = alpha[k] - product / f->with_change[k][k];
        f->of_answer[k] = f->length * alpha[k];
    }
    each_row(f, way_row);
    f->moved = 0;
    return total(f, 0);
}

/* ---------------------------------------------------------------------------------- step */

/* Moves along the way to a lower value; false: there is none. */
static bool descend(ntp__refinement *f, double *value, double slope, uint64_t *off)
{
    double length = 1;
    for (int32_t i = 0; i < MOST_TRIES; i++) {
        double there = ntp__refinement_value(f, length, off);
        if (there <= *value + sufficient * length * slope) {
            *value = there;
            return true;
        }
        /* The least value of the parabola, within limits. */
        double shorter = -slope * length / (2 * (there - *value - slope * length));
        length *= shorter > 0.1 ? (shorter < 0.5 ? shorter : 0.5) : 0.1;
    }
    ntp__refinement_value(f, 0, off);
    return false;
}

/* The gradient here, and its answer. */
static void ask(ntp__refinement *f)
{
    ntp_image answer;
    float *other = f->answer_before;
    f->answer_before = f->answer;
    f->answer = other;
    answer = ntp_image_packed(f->answer, f->plan->width, f->plan->height, 1, NTP_TYPE_F32);
    each_row(f, gradient_row);
    ntp__ties_level(&f->ties, f->gradient);
    ntp__inverse_apply(&f->inverse, &answer, f->gradient);
    ntp__ties_level_floats(&f->ties, f->answer);
}

/* One round: a way, and a step along it.  false: nothing more helps. */
bool ntp__refinement_advance(ntp__refinement *f, bool stepped, double *value, uint64_t *off)
{
    ask(f);
    if (stepped)
        learn(f);
    double slope = set_way(f);
    bool lower = slope < 0 && descend(f, value, slope, off);
    if (!lower && f->remembered > 0) {
        f->remembered = 0;
        slope = set_way(f);
        lower = slope < 0 && descend(f, value, slope, off);
    }
    return lower;
}
