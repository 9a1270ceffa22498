/* SPDX-License-Identifier: MIT */
/*
 * integrate.c - normals -> heightfield: the direct least-squares solver
 *
 * The normal equations of "slopes of h nearest to the stored ones" are separable.  Batches of
 * rows are read, their divergence (the adjoint of the stencils) is transformed along the row,
 * and kept in dst; then each column is solved by a recursion (integrate_columns.c); then rows are
 * transformed back.  So the working memory is that of a few rows.  Batches and groups of columns
 * are independent: the caller may have them done on several threads.
 */
#include "integrate.h"

#include <string.h>

enum {
    ROWS = NTP__FFT_ROWS,
    KEPT = 4,       /* rows of slopes that a part remembers: those of a stencil and one more */
    EXTRA_ROWS = 5, /* of telescoping */
    ALIGNMENT = 64
};

/* What a part works with. */
typedef struct part {
    void *fft_work;
    double *right[KEPT], *down[KEPT]; /* slopes of rows */
    int32_t row[KEPT], next;          /* which; -1: none */
    ntp__slope_counts row_counts[KEPT];
    double *line; /* divergence of a row */
    float *spare; /* stands for rows below the last one */
    double *column;
    ntp__slope_counts counts;
} part;

typedef struct job {
    const ntp_image *dst;
    const ntp_const_image *src;
    const ntp_hooks *hooks;
    ntp__grid_axis along, down;
    ntp__slopes slopes;
    ntp__fft fft;
    double *sums; /* of the divergence of each row */
    part *parts;
    int32_t part_count;
    int32_t first; /* item of the running parallel_for that part 0 does */
} job;

typedef void job_task(job *j, part *p, int32_t item);

/* ------------------------------------------------------------------------ working memory */

static size_t aligned(size_t bytes)
{
    return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static void *take(char **memory, size_t bytes)
{
    void *taken = *memory;
    *memory += aligned(bytes);
    return taken;
}

static ntp__fft_kind kind_of(const ntp__grid_axis *along)
{
    return along->wrap ? NTP__FFT_REAL : NTP__FFT_COSINE;
}

static size_t part_bytes(const ntp__grid_axis *along, int32_t height)
{
    size_t row = aligned((size_t) along->n * sizeof(double));
    return aligned(ntp__fft_work(kind_of(along), along->n)) + (2 * KEPT + 1) * row +
           aligned((size_t) along->n * sizeof(float)) + aligned((size_t) height * sizeof(double));
}

static ntp_status check_options(ntp__grid_axis *along, ntp__grid_axis *down,
                                const ntp_height_options *how, int32_t width, int32_t height)
{
    if (how->method == NTP_HEIGHT_WEIGHTED)
        return NTP_ERR_FORMAT;
    bool wrap_x = how->border_x == NTP_BORDER_WRAP, wrap_y = how->border_y == NTP_BORDER_WRAP;
    if ((how->method == NTP_HEIGHT_FRANKOT_CHELLAPPA && !(wrap_x && wrap_y)) ||
        (how->method == NTP_HEIGHT_POISSON_DCT && (wrap_x || wrap_y)))
        return NTP_ERR_ARGUMENT;
    if (!(how->dx >= 0) || !(how->dy >= 0) || !(how->dx - how->dx == 0) ||
        !(how->dy - how->dy == 0) || (int) how->prior < NTP_PRIOR_AUTO ||
        (int) how->prior > NTP_PRIOR_ROUGHNESS)
        return NTP_ERR_ARGUMENT;
    if ((how->dx != 0 && how->dx != 1) || (how->dy != 0 && how->dy != 1) ||
        how->prior == NTP_PRIOR_ROUGHNESS)
        return NTP_ERR_FORMAT;
    /* No slope at a border is used in telescoping. */
    bool sums = how->method == NTP_HEIGHT_TELESCOPING;
    NTP__TRY(
        ntp__grid_axis_init(along, width, how->kernel, sums ? NTP_BORDER_CLAMP : how->border_x));
    return ntp__grid_axis_init(down, height, how->kernel, sums ? NTP_BORDER_CLAMP : how->border_y);
}

ntp_status ntp__integrate_check(const ntp_height_options *how, int32_t width, int32_t height)
{
    ntp__grid_axis along, down;
    return check_options(&along, &down, how, width, height);
}

size_t ntp__integrate_scratch(const ntp_height_options *how, int32_t width, int32_t height,
                              int32_t parts)
{
    ntp__grid_axis along, down;
    if (check_options(&along, &down, how, width, height) != NTP_OK)
        return 0;
    if (how->method == NTP_HEIGHT_TELESCOPING)
        return aligned(EXTRA_ROWS * (size_t) width * sizeof(double));
    size_t count = (size_t) parts;
    return aligned(ntp__fft_tables(kind_of(&along), width)) + aligned(count * sizeof(part)) +
           aligned((size_t) height * sizeof(double)) + count * part_bytes(&along, height);
}

static void lay_out(job *j, void *scratch)
{
    char *memory = scratch;
    int32_t width = j->src->width, height = j->src->height;
    size_t row = (size_t) width * sizeof(double);
    ntp__fft_kind kind = kind_of(&j->along);
    void *tables = take(&memory, ntp__fft_tables(kind, width));
    j->parts = take(&memory, (size_t) j->part_count * sizeof(part));
    j->sums = take(&memory, (size_t) height * sizeof(double));
    memset(j->parts, 0, (size_t) j->part_count * sizeof(part));
    for (int32_t i = 0; i < j->part_count; i++) {
        part *p = &j->parts[i];
        p->fft_work = take(&memory, ntp__fft_work(kind, width));
        for (int32_t k = 0; k < KEPT; k++) {
            p->right[k] = take(&memory, row);
            p->down[k] = take(&memory, row);
        }
        p->line = take(&memory, row);
        p->spare = take(&memory, (size_t) width * sizeof(float));
        p->column = take(&memory, (size_t) height * sizeof(double));
    }
    ntp__fft_init(&j->fft, kind, width, tables, j->parts[0].fft_work);
}

/* ----------------------------------------------------------------------------- batches */

/* The slopes of row y: its place in what the part remembers. */
static int32_t get_row(const job *j, part *p, int32_t y)
{
    for (int32_t k = 0; k < KEPT; k++) {
        if (p->row[k] == y)
            return k;
    }
    int32_t k = p->next;
    p->next = (p->next + 1) % KEPT;
    p->row[k] = y;
    memset(&p->row_counts[k], 0, sizeof p->row_counts[k]);
    ntp__slopes_row(&j->slopes, p->right[k], p->down[k], y, &p->row_counts[k]);
    return k;
}

/* f = the adjoint of slopes to the right. */
static void adjoint_along(double *f, const ntp__grid_axis *axis, const double *right)
{
    int32_t n = axis->n;
    for (int32_t x = 2; x < n - 2; x++)
        f[x] = axis->central ? 0.5 * (right[x - 1] - right[x + 1]) : right[x - 1] - right[x];
    for (int32_t i = 0; i < 4; i++) {
        int32_t x = i < 2 ? i : n - 4 + i; /* the first two and the last two */
        if (x >= n || (i >= 2 && x < 2))
            continue;
        ntp__terms terms;
        ntp__adjoint(&terms, axis, x);
        f[x] = 0;
        for (int32_t k = 0; k < terms.count; k++)
            f[x] += terms.weight[k] * right[terms.at[k]];
    }
}

static void divergence(job *j, part *p, int32_t y)
{
    ntp__terms terms;
    int32_t n = j->along.n;
    int32_t own = get_row(j, p, y);
    p->counts.unused += p->row_counts[own].unused;
    p->counts.not_finite += p->row_counts[own].not_finite;
    adjoint_along(p->line, &j->along, p->right[own]);
    ntp__adjoint(&terms, &j->down, y);
    for (int32_t i = 0; i < terms.count; i++) {
        const double *down = p->down[get_row(j, p, terms.at[i])];
        double weight = terms.weight[i];
        for (int32_t x = 0; x < n; x++)
            p->line[x] += weight * down[x];
    }
    double sum = 0;
    for (int32_t x = 0; x < n; x++)
        sum += p->line[x];
    j->sums[y] = sum;
}

static void batch_rows(const job *j, part *p, int32_t item, float *rows[ROWS])
{
    memset(p->spare, 0, (size_t) j->along.n * sizeof(float));
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        rows[i] = y < j->down.n ? ntp__at_mut(j->dst, 0, y) : p->spare;
    }
}

static void analyze(job *j, part *p, int32_t item)
{
    float *rows[ROWS];
    batch_rows(j, p, item, rows);
    for (int32_t k = 0; k < KEPT; k++)
        p->row[k] = -1;
    for (int32_t i = 0; i < ROWS; i++) {
        int32_t y = item * ROWS + i;
        if (y < j->down.n)
            divergence(j, p, y);
        else
            memset(p->line, 0, (size_t) j->along.n * sizeof *p->line);
        ntp__fft_load(&j->fft, i, p->line, p->fft_work);
    }
    ntp__fft_forward(&j->fft, rows, p->fft_work);
}

static void solve(job *j, part *p, int32_t item)
{
    int32_t x0 = item * NTP__COLUMNS, left = j->along.n - x0;
    ntp__solve_columns(j->dst, &j->along, &j->down, j->sums, p->column, x0,
                       x0 + (left < NTP__COLUMNS ? left : NTP__COLUMNS));
}

static void synthesize(job *j, part *p, int32_t item)
{
    float *rows[ROWS];
    batch_rows(j, p, item, rows);
    ntp__fft_inverse(&j->fft, rows, p->fft_work);
}

/* ------------------------------------------------------------------------ parallel loops */

typedef struct loop {
    job *j;
    job_task *task;
} loop;

static void run_part(void *work, int32_t index)
{
    const loop *l = work;
    l->task(l->j, &l->j->parts[index], l->j->first + index);
}

static bool stopped(const job *j, double share)
{
    const ntp_hooks *hooks = j->hooks;
    return hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, share) != 0;
}

/* Does all items; `from` to `to` are the shares of the whole work before and after. */
static ntp_status each(job *j, job_task *task, int32_t count, double from, double to)
{
    loop l = { j, task };
    const ntp_hooks *hooks = j->hooks;
    for (j->first = 0; j->first < count; j->first += j->part_count) {
        int32_t left = count - j->first, n = left < j->part_count ? left : j->part_count;
        if (stopped(j, from + (to - from) * j->first / count))
            return NTP_ERR_CANCELLED;
        if (hooks != NULL && hooks->parallel_for != NULL && n > 1) {
            hooks->parallel_for(hooks->user, n, run_part, &l);
        } else {
            for (int32_t i = 0; i < n; i++)
                run_part(&l, i);
        }
    }
    return NTP_OK;
}

/* ------------------------------------------------------------------------------- public */

static ntp_status least_squares(job *j, void *scratch)
{
    int32_t batches = (j->down.n + ROWS - 1) / ROWS;
    int32_t groups = (j->along.n + NTP__COLUMNS - 1) / NTP__COLUMNS;
    lay_out(j, scratch);
    NTP__TRY(each(j, analyze, batches, 0, 0.5));
    NTP__TRY(each(j, solve, groups, 0.5, 0.75));
    return each(j, synthesize, batches, 0.75, 1);
}

ntp_status ntp__integrate(const ntp_image *dst, const ntp__slopes *slopes,
                          const ntp_height_options *how, void *scratch, const ntp_hooks *hooks,
                          ntp__slope_counts *counts)
{
    job j;
    memset(&j, 0, sizeof j);
    NTP__TRY(check_options(&j.along, &j.down, how, dst->width, dst->height));
    j.part_count = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    j.dst = dst;
    j.src = slopes->src;
    j.hooks = hooks;
    j.slopes = *slopes;
    if (how->method == NTP_HEIGHT_TELESCOPING) {
        if (stopped(&j, 0))
            return NTP_ERR_CANCELLED;
        ntp__telescope(dst, &j.slopes, how, scratch, counts);
        return NTP_OK;
    }
    NTP__TRY(least_squares(&j, scratch));
    for (int32_t i = 0; i < j.part_count; i++) {
        counts->unused += j.parts[i].counts.unused;
        counts->not_finite += j.parts[i].counts.not_finite;
    }
    return NTP_OK;
}
