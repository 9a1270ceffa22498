/* SPDX-License-Identifier: MIT */
/*
 * solve.c - normals -> heightfield: the direct least-squares solver
 *
 * The normal equations of "slopes of h nearest to the stored ones" are separable.  Rows are taken
 * in batches, and their right-hand sides are transformed along the row.  Each column is solved by a
 * recursion: down the picture as the batches come, and up again as they are transformed back.  So
 * the working memory is that of a few rows, and the picture is walked over twice.  For stencils
 * that recursion cannot do, the columns are transformed in between.
 *
 * Batches do not depend on each other, nor do groups of columns, so several threads can do them.
 * Then the columns of one round of batches are done beside the rows of the next round.  Threads
 * wait for each other half as often, and memory and arithmetic are busy at the same time.
 */
#include "base/parts.h"
#include "to_height/direct/direct.h"

#include <float.h>
#include <string.h>

enum {
    ROWS = NTP__FFT_ROWS,
    RUN = 8,                       /* neighboring batches of an item of work */
    MOST_GROUP = 8 * NTP__COLUMNS, /* most columns of an item of work */
    NONE = -1                      /* no round */
};

/* A range of rows: first..end - 1. */
typedef struct span {
    int32_t first, end;
} span;

/* What a part works with. */
typedef struct part {
    void *fft_work;
    float *spare; /* stands for rows below the last one */
    ntp__source source;
    float range[2];
} part;

typedef struct job {
    ntp__crew crew;
    const ntp__solver_kernels *kernels;
    ntp__problem problem;
    ntp__fft fft;
    ntp__columns recursion;
    ntp__filter filter;
    double *squares; /* of the right-hand side, of each row */
    part *parts;
    const ntp_image *dst;
    const ntp_height_rows
        *rows;          /* NULL, or dst holds only the rows that the parts are at work on */
    ntp__window window; /* with rows: where the normals in memory lie in the picture */
    void *normals;
    size_t row_bytes;
    span held;           /* with rows: the rows that dst holds */
    span lines, columns; /* the rows that are being transformed, and those in the recursion */
    int32_t group;       /* columns of an item of work */
} job;

/* ------------------------------------------------------------------------ working memory */

/* With memory->base NULL the functions below only measure. */

static void lay_out_part(const job *j, part *to, ntp__scratch *memory, const ntp__slopes *slopes)
{
    const ntp__problem *p = &j->problem;
    size_t work = ntp__fft_work_bytes(ntp__axis_transform(&p->along), p->along.n, p->single);
    size_t columns = ntp__fft_work_bytes(ntp__axis_transform(&p->down), p->down.n, p->single);
    part own = { .range = { FLT_MAX, -FLT_MAX } };
    own.spare = ntp__take(memory, (size_t) p->along.n * sizeof *own.spare);
    ntp__source_init(&own.source, memory, p, slopes);
    own.source.window = j->rows != NULL ? &j->window : NULL;
    own.fft_work = ntp__take(memory, p->filter && columns > work ? columns : work);
    if (to != NULL)
        *to = own;
}

static void lay_out(job *j, ntp__scratch *memory, const ntp__slopes *slopes)
{
    const ntp__problem *p = &j->problem;
    j->kernels = ntp__solver_kernels_for(NTP__CPU_ALL);
    j->parts = ntp__take(memory, (size_t) j->crew.parts * sizeof *j->parts);
    j->squares = ntp__take(memory, (size_t) p->down.n * sizeof *j->squares);
    for (int32_t i = 0; i < j->crew.parts; i++)
        lay_out_part(j, j->parts != NULL ? &j->parts[i] : NULL, memory, slopes);
    void *work = j->parts != NULL ? j->parts[0].fft_work : NULL;
    ntp__fft_plan(&j->fft, memory, ntp__axis_transform(&p->along), p->along.n, p->single, work);
    if (p->filter)
        ntp__filter_init(&j->filter, memory, p, work);
    else
        ntp__columns_init(&j->recursion, memory, p);
}

/* --------------------------------------------------------------------------------- tasks */

static float *height_row(const job *j, int32_t y)
{
    return ntp__at_mut(j->dst, 0, j->rows != NULL ? y - j->held.first : y);
}

static int32_t batch_rows(const job *j, part *p, int32_t first, float *rows[ROWS])
{
    int32_t left = j->problem.down.n - first;
    memset(p->spare, 0, (size_t) j->problem.along.n * sizeof(float));
    for (int32_t i = 0; i < ROWS; i++)
        rows[i] = i < left ? height_row(j, first + i) : p->spare;
    return left < ROWS ? left : ROWS;
}

static void analyze_batch(job *j, part *p, int32_t first)
{
    float *rows[ROWS];
    double *sums = j->problem.filter ? NULL : j->recursion.null[0], sum;
    size_t real = j->problem.single ? sizeof(float) : sizeof(double);
    int32_t count = batch_rows(j, p, first, rows);
    for (int32_t i = 0; i < ROWS; i++) {
        void *line = ntp__fft_line(&j->fft, p->fft_work, i);
        if (i >= count) {
            memset(line, 0, (size_t) j->problem.along.n * real);
            continue;
        }
        ntp__right_hand_side(&p->source, line, first + i, &sum, &j->squares[first + i]);
        if (sums != NULL)
            sums[first + i] = sum;
    }
    j->fft.loops->forward(&j->fft, rows, p->fft_work);
}

static void analyze(void *work, int32_t part_index, int32_t item)
{
    job *j = work;
    for (int32_t i = 0; i < RUN; i++) {
        int32_t y = j->lines.first + (item * RUN + i) * ROWS;
        if (y < j->lines.end)
            analyze_batch(j, &j->parts[part_index], y);
    }
}

static void synthesize(void *work, int32_t part_index, int32_t item)
{
    job *j = work;
    part *p = &j->parts[part_index];
    for (int32_t i = 0; i < RUN; i++) {
        float *rows[ROWS];
        int32_t y = j->lines.first + (item * RUN + i) * ROWS;
        if (y >= j->lines.end)
            return;
        int32_t count = batch_rows(j, p, y, rows);
        j->fft.loops->inverse(&j->fft, rows, p->fft_work);
        for (int32_t k = 0; k < count; k++)
            j->kernels->range(p->range, rows[k], j->problem.along.n);
    }
}

static int32_t group_end(const job *j, int32_t item)
{
    int32_t end = (item + 1) * j->group;
    return end < j->problem.along.n ? end : j->problem.along.n;
}

static void columns_down(void *work, int32_t part_index, int32_t item)
{
    job *j = work;
    (void) part_index;
    for (int32_t y = j->columns.first; y < j->columns.end; y++)
        ntp__columns_down(&j->recursion, height_row(j, y), y, item * j->group, group_end(j, item));
}

static void columns_up(void *work, int32_t part_index, int32_t item)
{
    job *j = work;
    (void) part_index;
    for (int32_t y = j->columns.end - 1; y >= j->columns.first; y--)
        ntp__columns_up(&j->recursion, height_row(j, y), y, item * j->group, group_end(j, item));
}

static void filter_columns(void *work, int32_t part_index, int32_t item)
{
    const job *j = work;
    ntp__filter_columns(&j->filter, j->dst, (j->lines.first + item) * NTP__FFT_ROWS,
                        j->parts[part_index].fft_work);
}

static bool stopped(const job *j, double share)
{
    const ntp_hooks *hooks = j->crew.hooks;
    return hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, share) != 0;
}

/* -------------------------------------------------------------------------------- passes */

/* The number of rows of a round. */
static int32_t round_rows(const job *j)
{
    return j->crew.parts * RUN * ROWS;
}

static span round_at(const job *j, int32_t round)
{
    int32_t rows = round_rows(j), left = j->problem.down.n - round * rows;
    span s = { round * rows, round * rows + (left < rows ? left : rows) };
    return s;
}

/* Does the rows of one round along with the columns of another.  There are none before the first
 * round and after the last. */
static void run(job *j, ntp__crew_task *lines, int32_t line_round, ntp__crew_task *columns,
                int32_t column_round, int32_t rounds)
{
    ntp__crew_items some = { lines, j, 0 }, more = { columns, j, 0 };
    if (line_round >= 0 && line_round < rounds) {
        j->lines = round_at(j, line_round);
        some.count = (j->lines.end - j->lines.first + RUN * ROWS - 1) / (RUN * ROWS);
    }
    if (column_round >= 0 && column_round < rounds && !j->problem.filter) {
        j->columns = round_at(j, column_round);
        more.count = (j->problem.along.n + j->group - 1) / j->group;
    }
    ntp__crew_both(&j->crew, &some, &more);
}

/* Every part gets columns, in whole groups of NTP__COLUMNS. */
static void set_group(job *j)
{
    int32_t each = (j->problem.along.n + j->crew.parts - 1) / j->crew.parts;
    int32_t group = (each + NTP__COLUMNS - 1) / NTP__COLUMNS * NTP__COLUMNS;
    j->group = group < MOST_GROUP ? group : MOST_GROUP;
}

/* Reads the normals that the rows of a round need, in up to three runs. */
static ntp_status read_normals(job *j)
{
    int32_t height = j->problem.down.n, reach = ntp__reach(&j->problem.down);
    int32_t from = j->held.first - reach, count = j->held.end - j->held.first + 2 * reach;
    bool wrap = j->problem.down.wrap;
    if (count >= height) {
        from = 0;
        count = height;
    } else if (!wrap) {
        from = from > 0 ? from : 0;
        count = j->held.end + reach < height ? j->held.end + reach - from : height - from;
    }
    j->window.first = from < 0 ? from + height : from;
    j->window.height = height;
    for (int32_t i = 0; i < count;) {
        int32_t y = (j->window.first + i) % height;
        int32_t n = count - i < height - y ? count - i : height - y;
        if (j->rows->read_normals(j->rows->user, (char *) j->normals + (size_t) i * j->row_bytes, y,
                                  n) != 0)
            return NTP_ERR_CANCELLED;
        i += n;
    }
    return NTP_OK;
}

static ntp_status write_heights(job *j)
{
    int32_t n = j->held.end - j->held.first;
    return j->rows->write_heights(j->rows->user, j->dst->data, j->held.first, n) == 0
               ? NTP_OK
               : NTP_ERR_CANCELLED;
}

static ntp_status read_heights(job *j)
{
    int32_t n = j->held.end - j->held.first;
    return j->rows->read_heights(j->rows->user, j->dst->data, j->held.first, n) == 0
               ? NTP_OK
               : NTP_ERR_CANCELLED;
}

/* Is each round finished before the next begins?  A single part walks over the rows of a round
 * while they are in its cache; with callbacks no more than one round is in memory. */
static bool in_step(const job *j)
{
    return j->crew.parts == 1 || j->rows != NULL;
}

static ntp_status go_down(job *j, int32_t rounds, double share)
{
    bool step = in_step(j);
    for (int32_t i = 0; i < rounds + (step ? 0 : 1); i++) {
        if (stopped(j, share * i / rounds))
            return NTP_ERR_CANCELLED;
        if (!step) {
            run(j, analyze, i, columns_down, i - 1, rounds);
            continue;
        }
        j->held = round_at(j, i);
        if (j->rows != NULL)
            NTP__TRY(read_normals(j));
        run(j, analyze, i, NULL, NONE, rounds);
        run(j, NULL, NONE, columns_down, i, rounds);
        if (j->rows != NULL)
            NTP__TRY(write_heights(j));
    }
    return NTP_OK;
}

static ntp_status go_up(job *j, int32_t rounds, double share)
{
    bool step = in_step(j);
    for (int32_t i = rounds - 1; i >= (step ? 0 : -1); i--) {
        if (stopped(j, 1 - share * (i + 1) / rounds))
            return NTP_ERR_CANCELLED;
        if (!step) {
            run(j, synthesize, i + 1, columns_up, i, rounds);
            continue;
        }
        j->held = round_at(j, i);
        if (j->rows != NULL)
            NTP__TRY(read_heights(j));
        run(j, NULL, NONE, columns_up, i, rounds);
        run(j, synthesize, i, NULL, NONE, rounds);
        if (j->rows != NULL)
            NTP__TRY(write_heights(j));
    }
    return NTP_OK;
}

static ntp_status filter_all(job *j)
{
    double sum = 0, width = j->problem.along.n, height = j->problem.down.n;
    int32_t count = (j->problem.along.n + NTP__FFT_ROWS - 1) / NTP__FFT_ROWS;
    int32_t step = j->crew.parts * MOST_GROUP / NTP__FFT_ROWS;
    for (int32_t y = 0; y < j->problem.down.n; y++)
        sum += j->squares[y];
    ntp__filter_set_prior(&j->filter, sum / (width * height));
    for (int32_t i = 0; i < count; i += step) {
        if (stopped(j, (1 + (double) i / count) / 3))
            return NTP_ERR_CANCELLED;
        j->lines.first = i;
        ntp__crew_each(&j->crew, filter_columns, j, count - i < step ? count - i : step);
    }
    return NTP_OK;
}

static ntp_status least_squares(job *j)
{
    int32_t rounds = (j->problem.down.n + round_rows(j) - 1) / round_rows(j);
    double share = j->problem.filter ? 1.0 / 3 : 0.5;
    set_group(j);
    NTP__TRY(go_down(j, rounds, share));
    if (j->problem.filter)
        NTP__TRY(filter_all(j));
    else
        ntp__columns_turn(&j->recursion);
    return go_up(j, rounds, share);
}

/* -------------------------------------------------------------------------------- whole */

size_t ntp__direct_scratch(const ntp__height_plan *plan, int32_t parts)
{
    job j;
    ntp__scratch solution = { NULL, 0 }, after = { NULL, 0 };
    memset(&j, 0, sizeof j);
    ntp__problem_init(&j.problem, plan, NTP_TYPE_F32);
    j.crew.parts = parts;
    lay_out(&j, &solution, NULL);
    ntp__edges_fit(NULL, NULL, &j.problem, &after, NULL);
    return solution.used > after.used ? solution.used : after.used;
}

static void add_counts(const job *j, ntp__slope_counts *counts)
{
    counts->range[0] = FLT_MAX;
    counts->range[1] = -FLT_MAX;
    for (int32_t i = 0; i < j->crew.parts; i++) {
        const part *p = &j->parts[i];
        counts->unused += p->source.counts.unused;
        counts->not_finite += p->source.counts.not_finite;
        counts->range[0] = p->range[0] < counts->range[0] ? p->range[0] : counts->range[0];
        counts->range[1] = p->range[1] > counts->range[1] ? p->range[1] : counts->range[1];
    }
}

ntp_status ntp__direct_solve(const ntp_image *dst, const ntp__slopes *slopes,
                             const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                             ntp__slope_counts *counts)
{
    job j;
    ntp__scratch solution = { scratch, 0 }, after = { scratch, 0 };
    memset(&j, 0, sizeof j);
    ntp__problem_init(&j.problem, plan, slopes->src->type);
    j.crew = ntp__crew_of(hooks);
    j.dst = dst;
    lay_out(&j, &solution, slopes);
    NTP__TRY(least_squares(&j));
    add_counts(&j, counts);
    ntp__edges_fit(dst, slopes, &j.problem, &after, counts->range);
    return NTP_OK;
}

/* ---------------------------------------------------------------------------- row by row */

static int32_t window_rows(const ntp__problem *p, int32_t parts)
{
    int32_t rows = parts * RUN * ROWS + 2 * ntp__reach(&p->down);
    return rows < p->down.n ? rows : p->down.n;
}

static size_t sample_row(const ntp_const_image *form)
{
    return (size_t) form->width * (size_t) form->channels * (size_t) ntp__sample_size(form->type);
}

/* The two windows: of heights and of normals. */
static void lay_out_windows(job *j, ntp__scratch *memory, const ntp_const_image *form,
                            ntp_image *heights)
{
    j->row_bytes = sample_row(form);
    *heights = ntp_image_packed(
        ntp__take(memory, (size_t) round_rows(j) * (size_t) form->width * sizeof(float)),
        form->width, form->height, 1, NTP_TYPE_F32);
    j->normals = ntp__take(memory, (size_t) window_rows(&j->problem, j->crew.parts) * j->row_bytes);
}

size_t ntp__direct_rows_scratch(const ntp_const_image *form, const ntp__height_plan *plan,
                                int32_t parts)
{
    job j;
    ntp__scratch memory = { NULL, 0 };
    ntp_image dst;
    memset(&j, 0, sizeof j);
    ntp__problem_init(&j.problem, plan, form->type);
    if (j.problem.filter)
        return 0;
    j.crew.parts = parts;
    lay_out_windows(&j, &memory, form, &dst);
    lay_out(&j, &memory, NULL);
    return memory.used;
}

ntp_status ntp__direct_rows(const ntp_const_image *form, const ntp_height_rows *rows,
                            const ntp__height_plan *plan, void *scratch, const ntp_hooks *hooks,
                            ntp_height_result *result)
{
    job j;
    ntp__slopes slopes;
    ntp__scratch memory = { scratch, 0 };
    ntp_image dst;
    ntp__slope_counts counts = { 0, 0, 0, 0, { 0, 0 } };
    memset(&j, 0, sizeof j);
    ntp__problem_init(&j.problem, plan, form->type);
    j.crew = ntp__crew_of(hooks);
    j.rows = rows;
    lay_out_windows(&j, &memory, form, &dst);
    ntp_const_image src = *form;
    src.data = j.normals;
    src.pixel_stride = form->channels * ntp__sample_size(form->type);
    src.row_stride = (ptrdiff_t) j.row_bytes;
    src.ring_rows = 0;
    j.dst = &dst;
    ntp__slopes_init(&slopes, &src, plan);
    lay_out(&j, &memory, &slopes);
    NTP__TRY(least_squares(&j));
    add_counts(&j, &counts);
    result->unused = counts.unused;
    result->not_finite = counts.not_finite;
    result->decode = slopes.decode;
    result->z = slopes.derived ? NTP_Z_DERIVED : NTP_Z_STORED;
    result->min = (double) counts.range[0];
    result->max = (double) counts.range[1];
    return NTP_OK;
}
