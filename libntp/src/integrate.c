/* SPDX-License-Identifier: MIT */
/*
 * integrate.c - normals -> heightfield: the direct least-squares solver
 *
 * The normal equations of "slopes of h nearest to the stored ones" are separable.  Rows are taken
 * in batches: their right-hand sides are transformed along the row, and each column is
 * solved by a recursion, down the picture as the batches come, and up again as they are
 * transformed back.  So the working memory is that of a few rows, and the picture is walked over
 * twice.  Stencils beyond recursion are solved by transforms of the columns in between.  Batches,
 * and groups of columns, are independent: the caller may have them done on several threads.
 */
#include "integrate.h"

#include <string.h>

enum {
    ROWS = NTP__FFT_ROWS,
    RUN = 2,                  /* batches of a part that follow each other */
    GROUP = 8 * NTP__COLUMNS, /* columns of a part */
    EXTRA_ROWS = 5            /* of telescoping */
};

/* What a part works with. */
typedef struct part {
    void *fft_work;
    float *spare; /* stands for rows below the last one */
    ntp__row_cache cache;
} part;

typedef struct job {
    const ntp_hooks *hooks;
    ntp__problem problem;
    ntp__fft fft;
    ntp__columns columns;
    ntp__filter filter;
    double *squares; /* of the right-hand side, of each row */
    part *parts;
    int32_t part_count;
    const ntp_image *dst;
    int32_t first, end; /* rows that the parts are at work on */
} job;

typedef void job_task(job *j, part *p, int32_t item);

/* ------------------------------------------------------------------------ working memory */

static size_t part_bytes(const ntp__problem *p)
{
    size_t work = ntp__fft_work_bytes(ntp__axis_transform(&p->along), p->along.n, p->single);
    size_t columns = ntp__fft_work_bytes(ntp__axis_transform(&p->down), p->down.n, p->single);
    if (p->filter && columns > work)
        work = columns;
    return ntp__aligned(work) + ntp__aligned((size_t) p->along.n * sizeof(float)) +
           ntp__row_cache_bytes(p);
}

static size_t scratch_bytes(const ntp__problem *p, int32_t parts)
{
    size_t count = (size_t) parts;
    return ntp__aligned(count * sizeof(part)) + ntp__aligned((size_t) p->down.n * sizeof(double)) +
           ntp__columns_bytes(p) + ntp__filter_bytes(p) +
           ntp__fft_plan_bytes(ntp__axis_transform(&p->along), p->along.n, p->single) +
           count * part_bytes(p);
}

static void *take(char **memory, size_t bytes)
{
    void *taken = *memory;
    *memory += ntp__aligned(bytes);
    return taken;
}

static void lay_out(job *j, void *scratch, const ntp__slopes *slopes)
{
    char *memory = scratch;
    const ntp__problem *p = &j->problem;
    ntp__fft_kind kind = ntp__axis_transform(&p->along);
    j->parts = take(&memory, (size_t) j->part_count * sizeof(part));
    j->squares = take(&memory, (size_t) p->down.n * sizeof(double));
    void *columns = take(&memory, ntp__columns_bytes(p));
    void *filter = take(&memory, ntp__filter_bytes(p));
    void *tables = take(&memory, ntp__fft_plan_bytes(kind, p->along.n, p->single));
    for (int32_t i = 0; i < j->part_count; i++) {
        char *own = take(&memory, part_bytes(p));
        j->parts[i].spare = take(&own, (size_t) p->along.n * sizeof(float));
        ntp__row_cache_init(&j->parts[i].cache, p, slopes, take(&own, ntp__row_cache_bytes(p)));
        j->parts[i].fft_work = own;
    }
    ntp__fft_plan(&j->fft, kind, p->along.n, p->single, tables, j->parts[0].fft_work);
    if (p->filter)
        ntp__filter_init(&j->filter, p, filter, j->parts[0].fft_work);
    else
        ntp__columns_init(&j->columns, p, columns);
}

/* --------------------------------------------------------------------------------- tasks */

static int32_t batch_rows(const job *j, part *p, int32_t first, float *rows[ROWS])
{
    int32_t left = j->problem.down.n - first;
    memset(p->spare, 0, (size_t) j->problem.along.n * sizeof(float));
    for (int32_t i = 0; i < ROWS; i++)
        rows[i] = i < left ? ntp__at_mut(j->dst, 0, first + i) : p->spare;
    return left < ROWS ? left : ROWS;
}

static void analyze_batch(job *j, part *p, int32_t first)
{
    float *rows[ROWS];
    double *sums = j->problem.filter ? NULL : j->columns.null[0], sum;
    size_t real = j->problem.single ? sizeof(float) : sizeof(double);
    int32_t count = batch_rows(j, p, first, rows);
    for (int32_t i = 0; i < ROWS; i++) {
        void *line = ntp__fft_line(&j->fft, p->fft_work, i);
        if (i >= count) {
            memset(line, 0, (size_t) j->problem.along.n * real);
            continue;
        }
        ntp__divergence(&p->cache, line, first + i, &sum, &j->squares[first + i]);
        if (sums != NULL)
            sums[first + i] = sum;
    }
    j->fft.loops->forward(&j->fft, rows, p->fft_work);
}

static void analyze(job *j, part *p, int32_t item)
{
    for (int32_t i = 0; i < RUN; i++) {
        int32_t y = j->first + (item * RUN + i) * ROWS;
        if (y < j->end)
            analyze_batch(j, p, y);
    }
}

static void synthesize(job *j, part *p, int32_t item)
{
    for (int32_t i = 0; i < RUN; i++) {
        float *rows[ROWS];
        int32_t y = j->first + (item * RUN + i) * ROWS;
        if (y >= j->end)
            return;
        batch_rows(j, p, y, rows);
        j->fft.loops->inverse(&j->fft, rows, p->fft_work);
    }
}

static int32_t group_end(const job *j, int32_t item)
{
    int32_t end = (item + 1) * GROUP;
    return end < j->problem.along.n ? end : j->problem.along.n;
}

static void columns_down(job *j, part *p, int32_t item)
{
    (void) p;
    for (int32_t y = j->first; y < j->end; y++)
        ntp__columns_down(&j->columns, ntp__at_mut(j->dst, 0, y), y, item * GROUP,
                          group_end(j, item));
}

static void columns_up(job *j, part *p, int32_t item)
{
    (void) p;
    for (int32_t y = j->end - 1; y >= j->first; y--)
        ntp__columns_up(&j->columns, ntp__at_mut(j->dst, 0, y), y, item * GROUP,
                        group_end(j, item));
}

static void filter_columns(job *j, part *p, int32_t item)
{
    ntp__filter_columns(&j->filter, j->dst, item * NTP__FFT_ROWS, p->fft_work);
}

/* ------------------------------------------------------------------------ parallel loops */

typedef struct loop {
    job *j;
    job_task *task;
    int32_t first, count, each;
} loop;

/* Part `index` does items index, index + parts, ... */
static void run_part(void *work, int32_t index)
{
    const loop *l = work;
    for (int32_t item = index; item < l->count; item += l->j->part_count)
        l->task(l->j, &l->j->parts[index], l->first + item);
}

static void each(job *j, job_task *task, int32_t first, int32_t count)
{
    loop l = { j, task, first, count, 0 };
    const ntp_hooks *hooks = j->hooks;
    int32_t parts = count < j->part_count ? count : j->part_count;
    if (hooks != NULL && hooks->parallel_for != NULL && parts > 1) {
        hooks->parallel_for(hooks->user, parts, run_part, &l);
    } else {
        for (int32_t i = 0; i < parts; i++)
            run_part(&l, i);
    }
}

static bool stopped(const job *j, double share)
{
    const ntp_hooks *hooks = j->hooks;
    return hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, share) != 0;
}

/* -------------------------------------------------------------------------------- passes */

static int32_t groups(const job *j)
{
    return (j->problem.along.n + GROUP - 1) / GROUP;
}

/* Rows that are taken at a time, and how many times that is. */
static int32_t round_rows(const job *j)
{
    return j->part_count * RUN * ROWS;
}

static void set_round(job *j, int32_t round)
{
    int32_t rows = round_rows(j), left = j->problem.down.n - round * rows;
    j->first = round * rows;
    j->end = j->first + (left < rows ? left : rows);
}

static ntp_status go_down(job *j, int32_t rounds, double share)
{
    for (int32_t i = 0; i < rounds; i++) {
        if (stopped(j, share * i / rounds))
            return NTP_ERR_CANCELLED;
        set_round(j, i);
        each(j, analyze, 0, (j->end - j->first + RUN * ROWS - 1) / (RUN * ROWS));
        if (!j->problem.filter)
            each(j, columns_down, 0, groups(j));
    }
    return NTP_OK;
}

static ntp_status go_up(job *j, int32_t rounds, double share)
{
    for (int32_t i = rounds - 1; i >= 0; i--) {
        if (stopped(j, 1 - share * (i + 1) / rounds))
            return NTP_ERR_CANCELLED;
        set_round(j, i);
        if (!j->problem.filter)
            each(j, columns_up, 0, groups(j));
        each(j, synthesize, 0, (j->end - j->first + RUN * ROWS - 1) / (RUN * ROWS));
    }
    return NTP_OK;
}

static ntp_status filter_all(job *j)
{
    double sum = 0, width = j->problem.along.n, height = j->problem.down.n;
    int32_t count = (j->problem.along.n + NTP__FFT_ROWS - 1) / NTP__FFT_ROWS;
    int32_t step = j->part_count * GROUP / NTP__FFT_ROWS;
    for (int32_t y = 0; y < j->problem.down.n; y++)
        sum += j->squares[y];
    ntp__filter_set_prior(&j->filter, sum / (width * height));
    for (int32_t i = 0; i < count; i += step) {
        if (stopped(j, (1 + (double) i / count) / 3))
            return NTP_ERR_CANCELLED;
        each(j, filter_columns, i, count - i < step ? count - i : step);
    }
    return NTP_OK;
}

static ntp_status least_squares(job *j)
{
    int32_t rounds = (j->problem.down.n + round_rows(j) - 1) / round_rows(j);
    double share = j->problem.filter ? 1.0 / 3 : 0.5;
    NTP__TRY(go_down(j, rounds, share));
    if (j->problem.filter)
        NTP__TRY(filter_all(j));
    else
        ntp__columns_turn(&j->columns);
    return go_up(j, rounds, share);
}

/* -------------------------------------------------------------------------------- whole */

static bool spacing_good(double d)
{
    return d >= 0 && d - d == 0;
}

/* Heights in steps of dy down: the slopes right are per step of dx, and weigh (dy/dx)^2. */
static bool set_weights(ntp__problem *p, const ntp_height_options *how)
{
    double dx = how->dx != 0 ? how->dx : 1, dy = how->dy != 0 ? how->dy : 1;
    p->ratio = dy / dx * (dy / dx);
    p->right_weight = dy * (dy / dx);
    p->down_weight = dy;
    return spacing_good(how->dx) && spacing_good(how->dy) && p->ratio > 0x1p-100 &&
           p->ratio < 0x1p100 && dy > 0x1p-100 && dy < 0x1p100;
}

ntp_status ntp__problem_init(ntp__problem *p, const ntp_height_options *how, int32_t width,
                             int32_t height, ntp_type type)
{
    bool sums = how->method == NTP_HEIGHT_TELESCOPING;
    bool wrap_x = how->border_x == NTP_BORDER_WRAP, wrap_y = how->border_y == NTP_BORDER_WRAP;
    memset(p, 0, sizeof *p);
    if ((how->method == NTP_HEIGHT_FRANKOT_CHELLAPPA && !(wrap_x && wrap_y)) ||
        (how->method == NTP_HEIGHT_POISSON_DCT && (wrap_x || wrap_y)) ||
        (int) how->prior < NTP_PRIOR_AUTO || (int) how->prior > NTP_PRIOR_ROUGHNESS ||
        !set_weights(p, how))
        return NTP_ERR_ARGUMENT;
    if (sums && how->kernel != NTP_KERNEL_CENTRAL && how->kernel != NTP_KERNEL_FORWARD)
        return NTP_ERR_FORMAT;
    /* No slope at a border is used in telescoping. */
    NTP__TRY(ntp__grid_axis_init(&p->along, width, how->kernel,
                                 sums ? NTP_BORDER_CLAMP : how->border_x));
    NTP__TRY(ntp__grid_axis_init(&p->down, height, how->kernel,
                                 sums ? NTP_BORDER_CLAMP : how->border_y));
    bool taps = p->along.kind == NTP__AXIS_TAPS;
    bool prior = how->prior == NTP_PRIOR_ROUGHNESS || (how->prior == NTP_PRIOR_AUTO && taps);
    p->single = type == NTP_U8;
    p->filter = taps || prior || ntp__axis_transform(&p->down) == NTP__FFT_MIRROR;
    /* A level is 2/M, its rounding error even over that; floats are 24 bits. */
    double level = type == NTP_U8 ? 2.0 / 255 : type == NTP_U16 ? 2.0 / 65535 : 0x1p-23;
    p->sigma = prior ? level * 0.28867513459481288 * p->down_weight : 0;
    return NTP_OK;
}

ntp_status ntp__integrate_check(const ntp_height_options *how, int32_t width, int32_t height)
{
    ntp__problem p;
    return ntp__problem_init(&p, how, width, height, NTP_F32);
}

size_t ntp__integrate_scratch(const ntp_height_options *how, int32_t width, int32_t height,
                              int32_t parts)
{
    ntp__problem p;
    if (ntp__problem_init(&p, how, width, height, NTP_F32) != NTP_OK)
        return 0;
    if (how->method == NTP_HEIGHT_TELESCOPING)
        return ntp__aligned(EXTRA_ROWS * (size_t) width * sizeof(double));
    return scratch_bytes(&p, parts);
}

ntp_status ntp__integrate(const ntp_image *dst, const ntp__slopes *slopes,
                          const ntp_height_options *how, void *scratch, const ntp_hooks *hooks,
                          ntp__slope_counts *counts)
{
    job j;
    memset(&j, 0, sizeof j);
    NTP__TRY(ntp__problem_init(&j.problem, how, dst->width, dst->height, slopes->src->type));
    j.part_count = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    j.dst = dst;
    j.hooks = hooks;
    if (how->method == NTP_HEIGHT_TELESCOPING) {
        if (stopped(&j, 0))
            return NTP_ERR_CANCELLED;
        ntp__telescope(dst, slopes, how, scratch, counts);
        return NTP_OK;
    }
    lay_out(&j, scratch, slopes);
    NTP__TRY(least_squares(&j));
    for (int32_t i = 0; i < j.part_count; i++) {
        counts->unused += j.parts[i].cache.counts.unused;
        counts->not_finite += j.parts[i].cache.counts.not_finite;
    }
    return NTP_OK;
}
