/* SPDX-License-Identifier: MIT */
/*
 * refine.c - changes heights until their normals round to the texture
 *
 * Each level stands for a box.  What is minimized is the squared excess of x and y (and of z where
 * blue tells more) beyond their boxes, in levels: it is 0 where the texture comes back.  The method
 * is L-BFGS: a direction comes from the gradient, from the inverse of the normal equations of least
 * squares as first guess of the inverse curvature, and from what the last steps changed in the
 * gradient.  A round takes one solution by transforms.
 *
 * The method needs products of the last steps with the last changes of the gradient.  A change y of
 * the gradient is kept as its answer, the inverse applied to it.  As the inverse is symmetric, all
 * products come from one walk over the planes.
 */
#include "to_height/refine.h"

#include "base/finite.h"
#include "to_height/shared/inverse.h"
#include "to_height/ties.h"
#include "to_height/weighted/weighted.h"

#include <float.h>
#include <string.h>

enum {
    MEMORY = 6,       /* steps that are remembered; more take no fewer rounds */
    DOTS = 4,         /* products of each remembered step, see `learn_row` */
    MOST_TRIES = 12,  /* lengths of a step */
    PATIENCE = 8,     /* rounds that help little, after which other texels are tied */
    HELP = 12,        /* to help is to lower the texels that differ by such a part */
    MOST_CHANGES = 12 /* of what is tied */
};

/* The share of each box that has no excess, from some round on.  A small one keeps slopes off the
 * edges of boxes, so that fewer leave them again, and brings heights nearer to the true ones.  But
 * the smaller boxes are, the fewer heights are in all of them: the last stages begin where nothing
 * helps any more. */
typedef struct stage {
    int32_t round, with_blue; /* from this round on; the second where blue has an excess too */
    double share;
} stage;
static const stage stages[] = { { 0, 0, 0.7 },
                                { 4, 4, 0.85 },
                                { 100, 30, 0.96 },
                                { INT32_MAX, INT32_MAX, 0.99 },
                                { INT32_MAX, INT32_MAX, 0.998 } };
enum { STAGES = sizeof stages / sizeof stages[0] };
/* Where floats hardly tell one level from the next. */
static const double least_share = 0.4;

/* The metric has more than slopes: pairs, and the squared Laplacian, so many times as strong as in
 * the direct solver.  They keep the correction out of the finest detail, to which kernels of 3 x 3
 * and more hardly respond: heights would follow the rounding there. */
static const double strength = 1e-4, roughness = 8;

/* Of the first step: a part of the texels has an excess, so the curvature is less than that of all
 * slopes. */
static const double first_length = 2;

/* A step has to lower the sum by this part of what the gradient promises. */
static const double sufficient = 1e-4;

typedef struct refinement {
    ntp__round_trip *trip;
    const ntp__height_plan *plan;
    ntp__crew crew;
    ntp__inverse inverse;
    ntp__ties ties;
    double *heights, *gradient; /* packed planes, as all below */
    float *trial;               /* the heights rounded */
    float *before;              /* the gradient before the step */
    float *right, *down;        /* derivatives by slopes */
    float *way;                 /* the direction */
    float *scale;               /* of the inverse */
    float *answer, *answer_before;
    float *step[MEMORY], *answered[MEMORY]; /* remembered */
    double *work;                           /* two rows for each part */
    double *sums;                           /* MEMORY * DOTS of each row */
    int32_t stage, remembered, newest;
    double with_change[MEMORY][MEMORY];   /* [i][j]: step i by the change of j */
    double answer_change[MEMORY][MEMORY]; /* answer i by the change of j */
    double with_gradient[MEMORY], answer_gradient[MEMORY];
    double length;                             /* of the first guess of the inverse curvature */
    double rounding;                           /* of heights to floats, of half a level */
    double moved;                              /* the part of `way` by which heights have moved */
    double of_step[MEMORY], of_answer[MEMORY]; /* what `way` is made of */
    double by;
} refinement;

/* ------------------------------------------------------------------------ working memory */

/* With memory->base NULL it only measures. */
static void lay_out(refinement *f, const ntp__height_plan *plan, ntp__scratch *memory)
{
    size_t texels = (size_t) plan->width * (size_t) plan->height, plane = texels * sizeof(float);
    f->plan = plan;
    ntp__inverse_init(&f->inverse, plan, f->crew, memory);
    ntp__ties_init(&f->ties, plan, memory);
    f->heights = ntp__take(memory, texels * sizeof(double));
    f->gradient = ntp__take(memory, texels * sizeof(double));
    f->trial = ntp__take(memory, plane);
    f->before = ntp__take(memory, plane);
    f->right = ntp__take(memory, plane);
    f->down = ntp__take(memory, plane);
    f->way = ntp__take(memory, plane);
    f->scale = ntp__take(memory, plane);
    f->answer = ntp__take(memory, plane);
    f->answer_before = ntp__take(memory, plane);
    for (int32_t i = 0; i < MEMORY; i++) {
        float *both = ntp__take(memory, 2 * plane);
        f->step[i] = both;
        f->answered[i] = both != NULL ? both + texels : NULL;
    }
    f->work = ntp__take(memory, (size_t) f->crew.parts * (size_t) plan->width * sizeof(double));
    f->sums = ntp__take(memory, (size_t) plan->height * MEMORY * DOTS * sizeof(double));
}

size_t ntp__refine_scratch(const ntp__height_plan *plan, int32_t parts)
{
    refinement f;
    ntp__scratch memory = { NULL, 0 };
    memset(&f, 0, sizeof f);
    f.crew.parts = parts;
    lay_out(&f, plan, &memory);
    return memory.used;
}

static size_t row_start(const refinement *f, int32_t y)
{
    return (size_t) y * (size_t) f->plan->width;
}

static void each_row(refinement *f, ntp__crew_task *task)
{
    ntp__crew_each(&f->crew, task, f, f->plan->height);
}

/* The sum over all rows of one of the numbers that each row has. */
static double total(const refinement *f, int32_t which)
{
    double sum = 0;
    for (int32_t y = 0; y < f->plan->height; y++)
        sum += f->sums[(size_t) y * MEMORY * DOTS + (size_t) which];
    return sum;
}

/* ---------------------------------------------------------------------- value and gradient */

static void move_row(void *job, int32_t part, int32_t y)
{
    refinement *f = job;
    double *h = f->heights + row_start(f, y);
    const float *way = f->way + row_start(f, y);
    (void) part;
    for (int32_t x = 0; x < f->plan->width; x++)
        h[x] += f->by * (double) way[x];
}

/* Moves the heights along the way, and returns the value there. */
static double value_at(refinement *f, double length, uint64_t *off)
{
    ntp__plane heights = { f->heights, NULL, f->plan->width };
    f->by = length - f->moved;
    f->moved = length;
    if (f->by != 0)
        each_row(f, move_row);
    return ntp__round_trip_excess(f->trip, &heights, f->right, f->down, off);
}

/* out += row y of the adjoint of (x line of y line), applied to derivatives. */
static void add_adjoint(const refinement *f, double *out, double *mixed, int32_t y,
                        const ntp__line *along_rows, const ntp__line *along_columns,
                        const float *derivatives)
{
    ntp__line_terms terms;
    int32_t width = f->plan->width;
    ntp__line_column(&terms, along_columns, y);
    memset(mixed, 0, (size_t) width * sizeof *mixed);
    for (int32_t j = 0; j < terms.count; j++) {
        const float *row = derivatives + row_start(f, terms.at[j]);
        double weight = terms.weight[j];
        for (int32_t x = 0; x < width; x++)
            mixed[x] += weight * (double) row[x];
    }
    ntp__line_adjoint(along_rows, out, mixed);
}

static void gradient_row(void *job, int32_t part, int32_t y)
{
    refinement *f = job;
    const ntp__stencil *s = f->trip->stencil;
    double *out = f->gradient + row_start(f, y);
    double *mixed = f->work + (size_t) part * (size_t) f->plan->width;
    float *before = f->before + row_start(f, y);
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

static double least_step(const ntp__height_plan *plan)
{
    return plan->dx < plan->dy ? plan->dx : plan->dy;
}

/* The stored slopes, and by how much x and y of the normal change with them: the mean of both,
 * squared. */
static void weigh_row(void *job, int32_t part, int32_t y)
{
    refinement *f = job;
    double *p = f->trip->parts[part].row[0], *q = f->trip->parts[part].row[1];
    size_t start = row_start(f, y);
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
static double prior_of(const refinement *f)
{
    double level = 2 / f->trip->slopes->range * least_step(f->plan), sum = 0;
    size_t texels = (size_t) f->plan->width * (size_t) f->plan->height;
    for (size_t i = 0; i < texels; i++)
        sum += f->gradient[i] * f->gradient[i];
    return sum > 0 ? roughness * level * level / 12 * (double) texels / sum : 0;
}

static void set_metric(refinement *f)
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
    refinement *f = job;
    int32_t width = f->plan->width;
    const double *g = f->gradient + row_start(f, y);
    const float *before = f->before + row_start(f, y), *way = f->way + row_start(f, y);
    const float *answer = f->answer + row_start(f, y);
    const float *answer_before = f->answer_before + row_start(f, y);
    float *step = f->step[f->newest] + row_start(f, y);
    float *answered = f->answered[f->newest] + row_start(f, y);
    (void) part;
    for (int32_t x = 0; x < width; x++) {
        step[x] = (float) (f->moved * (double) way[x]);
        answered[x] = answer[x] - answer_before[x];
    }
    for (int32_t i = 0; i < f->remembered; i++) {
        const float *s = f->step[i] + row_start(f, y), *a = f->answered[i] + row_start(f, y);
        double sum[DOTS] = { 0, 0, 0, 0 };
        for (int32_t x = 0; x < width; x++) {
            double change = g[x] - (double) before[x];
            sum[0] += (double) s[x] * change;
            sum[1] += (double) a[x] * change;
            sum[2] += (double) s[x] * g[x];
            sum[3] += (double) a[x] * g[x];
        }
        memcpy(f->sums + ((size_t) y * MEMORY + (size_t) i) * DOTS, sum, sizeof sum);
    }
}

/* Takes the last step into memory, in place of the oldest one. */
static void learn(refinement *f)
{
    int32_t k = f->remembered < MEMORY ? f->remembered : (f->newest + 1) % MEMORY;
    f->newest = k;
    f->remembered += f->remembered < MEMORY;
    each_row(f, learn_row);
    for (int32_t i = 0; i < f->remembered; i++) {
        f->with_change[i][k] = total(f, i * DOTS);
        f->answer_change[i][k] = f->answer_change[k][i] = total(f, i * DOTS + 1);
        f->with_gradient[i] = total(f, i * DOTS + 2);
        f->answer_gradient[i] = total(f, i * DOTS + 3);
    }
    /* Only steps along which the gradient grew tell the curvature. */
    if (f->with_change[k][k] > 0 && f->answer_change[k][k] > 0)
        f->length = f->with_change[k][k] / f->answer_change[k][k];
    else
        f->remembered = 0;
}

/* The i-th remembered step, the oldest first. */
static int32_t place(const refinement *f, int32_t i)
{
    return f->remembered < MEMORY ? i : (f->newest + 1 + i) % MEMORY;
}

static void way_row(void *job, int32_t part, int32_t y)
{
    refinement *f = job;
    double *way = f->work + (size_t) part * (size_t) f->plan->width, sum = 0;
    const float *answer = f->answer + row_start(f, y);
    const double *g = f->gradient + row_start(f, y);
    float *out = f->way + row_start(f, y);
    int32_t width = f->plan->width;
    for (int32_t x = 0; x < width; x++)
        way[x] = -f->length * (double) answer[x];
    for (int32_t i = 0; i < f->remembered; i++) {
        const float *s = f->step[i] + row_start(f, y), *a = f->answered[i] + row_start(f, y);
        for (int32_t x = 0; x < width; x++)
            way[x] += f->of_answer[i] * (double) a[x] - f->of_step[i] * (double) s[x];
    }
    for (int32_t x = 0; x < width; x++) {
        out[x] = (float) way[x];
        sum += (double) out[x] * g[x];
    }
    f->sums[(size_t) y * MEMORY * DOTS] = sum;
}

/* The two loops of L-BFGS, on products alone; then the way.  Returns its product with the
 * gradient. */
static double set_way(refinement *f)
{
    double alpha[MEMORY] = { 0 };
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

/* -------------------------------------------------------------------------------- rounds */

/* What rounding heights to floats can take from half a level. */
static double rounding_of(const refinement *f, const ntp_image *dst)
{
    double most = 0;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            double size = row[x] < 0 ? -(double) row[x] : (double) row[x];
            most = size > most ? size : most;
        }
    }
    return most * FLT_EPSILON / least_step(f->plan) * f->trip->slopes->range;
}

static void begin_stage(refinement *f, int32_t which)
{
    bool last = which + 1 == STAGES; /* most heights lose far less than the highest can */
    double share = stages[which].share, most = 1 - (last ? f->rounding / 4 : f->rounding);
    share = share < most ? share : most;
    f->trip->inside = share > least_share ? share : least_share;
    f->remembered = 0;
    f->stage = which;
}

static void begin(refinement *f, const ntp_image *dst, bool holes)
{
    double slope = 2 * least_step(f->plan) / f->trip->slopes->range; /* about that of a level */
    size_t texels = (size_t) dst->width * (size_t) dst->height;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++)
            f->heights[row_start(f, y) + (size_t) x] = (double) row[x];
    }
    if (holes)
        ntp__round_trip_mark_holes(f->trip, f->heights, NULL);
    set_metric(f);
    memset(f->way, 0, texels * sizeof *f->way);
    f->length = first_length * slope * slope;
    f->rounding = rounding_of(f, dst);
    ntp__round_trip_see_blue(f->trip);
    ntp__ties_find(&f->ties, f->trip, f->plan, f->heights);
}

/* Their mean becomes 0, as the scale of the inverse moves it.  With holes it stays: they are NaN. */
static void round_heights(refinement *f)
{
    size_t texels = (size_t) f->plan->width * (size_t) f->plan->height;
    double sum = 0;
    for (size_t i = 0; i < texels; i++)
        sum += f->heights[i];
    double mean = ntp__is_nan(sum) ? 0 : sum / (double) texels;
    for (size_t i = 0; i < texels; i++)
        f->trial[i] = (float) (f->heights[i] - mean);
}

/* Puts the heights into dst, rounded, if fewer texels differ than with those in it. */
static void keep_better(refinement *f, const ntp_image *dst, uint64_t *least)
{
    ntp__plane trial = { NULL, f->trial, f->plan->width };
    uint64_t off;
    round_heights(f);
    ntp__round_trip_excess(f->trip, &trial, NULL, NULL, &off);
    if (off >= *least)
        return;
    *least = off;
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        const float *from = f->trial + row_start(f, y);
        for (int32_t x = 0; x < dst->width; x++)
            row[x] = ntp__is_nan((double) from[x]) ? 0 : from[x];
    }
}

/* Moves along the way to a lower value; false: there is none. */
static bool descend(refinement *f, double *value, double slope, uint64_t *off)
{
    double length = 1;
    for (int32_t i = 0; i < MOST_TRIES; i++) {
        double there = value_at(f, length, off);
        if (there <= *value + sufficient * length * slope) {
            *value = there;
            return true;
        }
        /* The least value of the parabola, within limits. */
        double shorter = -slope * length / (2 * (there - *value - slope * length));
        length *= shorter > 0.1 ? (shorter < 0.5 ? shorter : 0.5) : 0.1;
    }
    value_at(f, 0, off);
    return false;
}

/* The gradient here, and its answer. */
static void ask(refinement *f)
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
static bool advance(refinement *f, bool stepped, double *value, uint64_t *off)
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

/* The mean of each island becomes 0 again, as corrections spread across holes. */
static void level_islands(refinement *f, const ntp_image *dst, uint64_t *off)
{
    ntp__weighted w = { .plan = f->plan, .width = dst->width, .height = dst->height };
    ntp__plane trial = { NULL, f->trial, dst->width };
    w.right = f->right;
    w.x = f->gradient;
    w.r = (double *) (void *) f->step[0];
    w.d = (double *) (void *) f->step[1];
    w.a = (double *) (void *) f->step[2];
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            size_t at = row_start(f, y) + (size_t) x;
            w.right[at] = ntp__is_nan(f->heights[at]) ? 0 : 1;
            w.x[at] = (double) row[x];
        }
    }
    ntp__islands_level(&w, NULL);
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            size_t at = row_start(f, y) + (size_t) x;
            row[x] = (float) w.x[at];
            f->trial[at] = ntp__is_nan(f->heights[at]) ? (float) f->heights[at] : row[x];
        }
    }
    ntp__round_trip_excess(f->trip, &trial, NULL, NULL, off);
}

static bool is_over(const refinement *f, int32_t rounds)
{
    const stage *next = &stages[f->stage + 1];
    return f->stage + 1 < STAGES && rounds >= (f->trip->blue ? next->with_blue : next->round);
}

/* What comes next where nothing helps any more; false: nothing does. */
static bool go_on(refinement *f, int32_t *changes)
{
    if (f->ties.any && ++*changes <= MOST_CHANGES &&
        ntp__ties_change(&f->ties, f->trip, f->plan, f->heights)) {
        ntp__ties_level(&f->ties, f->heights);
        begin_stage(f, f->stage);
    } else if (f->stage + 1 < STAGES) {
        begin_stage(f, f->stage + 1);
    } else if (f->ties.any && !f->ties.sure) {
        f->ties.any = false;
        begin_stage(f, f->stage);
    } else {
        return false;
    }
    return true;
}

/* The rounds; *least is the number of texels that differ with the heights in dst. */
static ntp_status iterate(refinement *f, const ntp_image *dst, int32_t *rounds, uint64_t *least)
{
    const ntp_hooks *hooks = f->crew.hooks;
    bool stepped = false;
    int32_t best = 0, changes = 0; /* the last round that helped */
    uint64_t off, mark = UINT64_MAX;
    double value = value_at(f, 0, least);
    if (f->plan->refine > 0 && *least > 0 && f->ties.any) {
        ntp__ties_level(&f->ties, f->heights);
        keep_better(f, dst, least);
    }
    while (*rounds < f->plan->refine && *least > 0) {
        if (hooks != NULL && hooks->progress != NULL &&
            hooks->progress(hooks->user, (double) *rounds / f->plan->refine) != 0)
            return NTP_ERR_CANCELLED;
        bool over = is_over(f, *rounds), stalls = f->ties.any && *rounds - best > PATIENCE;
        if (stalls)
            stalls = go_on(f, &changes);
        else if (over || *rounds == 0)
            begin_stage(f, f->stage + over);
        if (stalls || over || *rounds == 0) {
            value = value_at(f, f->moved, &off);
            stepped = false;
            best = *rounds;
            mark = UINT64_MAX;
        }
        ++*rounds;
        if (!advance(f, stepped, &value, &off)) {
            if (!go_on(f, &changes))
                break;
            value = value_at(f, f->moved, &off);
            stepped = false;
            best = *rounds;
            mark = UINT64_MAX;
            continue;
        }
        stepped = true;
        if (off < *least)
            keep_better(f, dst, least);
        if (off < mark - mark / HELP) {
            mark = off;
            best = *rounds;
        }
    }
    return NTP_OK;
}

ntp_status ntp__refine(const ntp_image *dst, ntp__round_trip *trip, const ntp__height_plan *plan,
                       bool holes, void *scratch, const ntp_hooks *hooks, ntp_height_result *result)
{
    refinement f;
    ntp__scratch memory = { scratch, 0 };
    memset(&f, 0, sizeof f);
    f.trip = trip;
    f.crew = ntp__crew_of(hooks);
    lay_out(&f, plan, &memory);
    begin(&f, dst, holes);
    ntp_status status = iterate(&f, dst, &result->rounds, &result->refine_left);
    if (holes && result->rounds > 0)
        level_islands(&f, dst, &result->refine_left);
    return status;
}
