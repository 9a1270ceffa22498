/* SPDX-License-Identifier: MIT */
/*
 * integrate.c - normals -> heightfield: checks, and the direct least-squares solver
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
    if ((int) how->method < NTP_HEIGHT_AUTO || (int) how->method > NTP_HEIGHT_POISSON_DCT ||
        (int) how->decode < NTP_DECODE_AUTO || (int) how->decode > NTP_DECODE_SNORM ||
        (how->z != NTP_Z_STORED && how->z != NTP_Z_DERIVED) || (int) how->kernel < 0 ||
        (int) how->kernel > NTP_KERNEL_GIMP9 || (int) how->border_x < 0 ||
        (int) how->border_x > NTP_BORDER_REPEAT_SLOPE || (int) how->border_y < 0 ||
        (int) how->border_y > NTP_BORDER_REPEAT_SLOPE)
        return NTP_ERR_ARGUMENT;
    bool wrap_x = how->border_x == NTP_BORDER_WRAP, wrap_y = how->border_y == NTP_BORDER_WRAP;
    if ((how->method == NTP_HEIGHT_FRANKOT_CHELLAPPA && !(wrap_x && wrap_y)) ||
        (how->method == NTP_HEIGHT_POISSON_DCT && (wrap_x || wrap_y)))
        return NTP_ERR_ARGUMENT;
    if (how->use_seeds) {
        for (int32_t i = 0; i < 4; i++) {
            if (!(how->seeds[i] - how->seeds[i] == 0))
                return NTP_ERR_ARGUMENT;
        }
        if (how->method != NTP_HEIGHT_TELESCOPING)
            return NTP_ERR_ARGUMENT;
    }
    /* No slope at a border is used in telescoping. */
    bool sums = how->method == NTP_HEIGHT_TELESCOPING;
    NTP__TRY(
        ntp__grid_axis_init(along, width, how->kernel, sums ? NTP_BORDER_CLAMP : how->border_x));
    return ntp__grid_axis_init(down, height, how->kernel, sums ? NTP_BORDER_CLAMP : how->border_y);
}

size_t ntp_height_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                               int32_t parts)
{
    ntp_height_options zero;
    memset(&zero, 0, sizeof zero);
    ntp__grid_axis along, down;
    if (width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE || parts < 0 ||
        parts > NTP_MAX_PARTS ||
        check_options(&along, &down, how != NULL ? how : &zero, width, height) != NTP_OK)
        return 0;
    if (how != NULL && how->method == NTP_HEIGHT_TELESCOPING)
        return aligned(EXTRA_ROWS * (size_t) width * sizeof(double));
    size_t count = parts > 0 ? (size_t) parts : 1;
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

static ntp_status check_views(const ntp_image *dst, const ntp_const_image *src)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image seen = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_view(&seen));
    if (dst->encoding != NTP_HEIGHT || dst->type != NTP_F32 || dst->channels != 1)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&seen, src) || src->ring_rows != 0 || dst->ring_rows != 0 ||
        dst->pixel_stride != (ptrdiff_t) sizeof(float))
        return NTP_ERR_SHAPE;
    return NTP_OK;
}

static ntp_status least_squares(job *j, void *scratch)
{
    int32_t batches = (j->down.n + ROWS - 1) / ROWS;
    int32_t groups = (j->along.n + NTP__COLUMNS - 1) / NTP__COLUMNS;
    lay_out(j, scratch);
    NTP__TRY(each(j, analyze, batches, 0, 0.5));
    NTP__TRY(each(j, solve, groups, 0.5, 0.75));
    return each(j, synthesize, batches, 0.75, 1);
}

static void describe(ntp_height_result *result, const job *j, const ntp_height_options *how,
                     const ntp__slope_counts *counts)
{
    bool wrap = j->along.wrap && j->down.wrap;
    result->method = how->method != NTP_HEIGHT_AUTO ? how->method
                     : wrap                         ? NTP_HEIGHT_FRANKOT_CHELLAPPA
                                                    : NTP_HEIGHT_POISSON_DCT;
    result->decode = j->slopes.decode;
    result->unused = counts->unused;
    result->not_finite = counts->not_finite;
    float min = *(const float *) j->dst->data, max = min;
    for (int32_t y = 0; y < j->down.n; y++) {
        const float *row = ntp__at_mut(j->dst, 0, y);
        for (int32_t x = 0; x < j->along.n; x++) {
            min = row[x] < min ? row[x] : min;
            max = row[x] > max ? row[x] : max;
        }
    }
    result->min = min;
    result->max = max;
}

ntp_status ntp_height_from_normals(const ntp_image *dst, const ntp_const_image *src,
                                   const ntp_height_options *how, void *scratch,
                                   size_t scratch_size, const ntp_hooks *hooks,
                                   ntp_height_result *result)
{
    job j;
    ntp_height_options zero;
    ntp__slope_counts counts = { 0, 0 };
    memset(&j, 0, sizeof j);
    memset(&zero, 0, sizeof zero);
    how = how != NULL ? how : &zero;
    NTP__TRY(check_views(dst, src));
    NTP__TRY(check_options(&j.along, &j.down, how, src->width, src->height));
    j.part_count = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    if (j.part_count < 1 || j.part_count > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    if (scratch == NULL || (uintptr_t) scratch % ALIGNMENT != 0 ||
        scratch_size < ntp_height_scratch_size(how, src->width, src->height, j.part_count))
        return NTP_ERR_SCRATCH;
    j.dst = dst;
    j.src = src;
    j.hooks = hooks;
    if (stopped(&j, 0))
        return NTP_ERR_CANCELLED;
    ntp__slopes_init(&j.slopes, src, how);
    if (how->method == NTP_HEIGHT_TELESCOPING)
        ntp__telescope(dst, &j.slopes, how, scratch, &counts);
    else
        NTP__TRY(least_squares(&j, scratch));
    for (int32_t i = 0; j.parts != NULL && i < j.part_count; i++) {
        counts.unused += j.parts[i].counts.unused;
        counts.not_finite += j.parts[i].counts.not_finite;
    }
    if (result != NULL)
        describe(result, &j, how, &counts);
    return NTP_OK;
}

const char *ntp_height_method_name(ntp_height_method method)
{
    switch (method) {
    case NTP_HEIGHT_AUTO:
        return "auto";
    case NTP_HEIGHT_TELESCOPING:
        return "telescoping";
    case NTP_HEIGHT_FRANKOT_CHELLAPPA:
        return "frankot-chellappa";
    case NTP_HEIGHT_POISSON_DCT:
        return "poisson-dct";
    }
    return "unknown";
}
