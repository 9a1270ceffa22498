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
 * Blocks of batches do not depend on each other; the recursion takes them one after another, in
 * lanes of columns if there are many threads.  A thread transforms a block, and then walks the
 * recursion over it, if the blocks above have come so far; going up it is the other way round.
 */
#include "base/parts.h"
#include "to_height/direct/direct.h"

#include <float.h>
#include <string.h>

enum {
    ROWS = NTP__FFT_ROWS,
    RUN = 8,                  /* most batches of a block */
    BLOCK_BYTES = 1 << 19,    /* about the heights of a block: they stay in a cache */
    PART_BLOCKS = 8,          /* so many or more for each part, where the picture is large enough */
    ROUND_BLOCKS = 16,        /* of a round, for each part */
    LANE_PARTS = 4,           /* parts that one lane of the recursion keeps at work */
    GROUP = 8 * NTP__COLUMNS, /* columns whose state stays in the nearest cache */
    MOST_ITEMS = GROUP / ROWS /* columns to filter, in batches, of a part between two reports */
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
    span held;     /* the rows of this round; with rows: those that dst holds */
    int32_t block; /* rows of a block */
    int32_t lanes, lane_columns;
    int32_t first_filtered; /* the first batch of columns that is being filtered */
    bool up;                /* the way through the picture */
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

/* The rows of a block of this round, counted in the order of the recursion. */
static span block_rows(const job *j, int32_t i)
{
    int32_t count = (j->held.end - j->held.first + j->block - 1) / j->block;
    int32_t first = j->held.first + (j->up ? count - 1 - i : i) * j->block;
    int32_t end = first + j->block;
    span s = { first, end < j->held.end ? end : j->held.end };
    return s;
}

static void analyze(void *work, int32_t part_index, int32_t block)
{
    job *j = work;
    span s = block_rows(j, block);
    for (int32_t y = s.first; y < s.end; y += ROWS)
        analyze_batch(j, &j->parts[part_index], y);
}

static void synthesize(void *work, int32_t part_index, int32_t block)
{
    job *j = work;
    part *p = &j->parts[part_index];
    span s = block_rows(j, block);
    for (int32_t y = s.first; y < s.end; y += ROWS) {
        float *rows[ROWS];
        int32_t count = batch_rows(j, p, y, rows);
        j->fft.loops->inverse(&j->fft, rows, p->fft_work);
        for (int32_t k = 0; k < count; k++)
            j->kernels->range(p->range, rows[k], j->problem.along.n);
    }
}

/* The recursion through a block, in the columns of a lane. */
static void recur(void *work, int32_t lane, int32_t block)
{
    job *j = work;
    span s = block_rows(j, block);
    int32_t x = lane * j->lane_columns, end = x + j->lane_columns;
    for (end = end < j->problem.along.n ? end : j->problem.along.n; x < end; x += GROUP) {
        int32_t next = end - x < GROUP ? end : x + GROUP;
        for (int32_t y = s.first; y < s.end && !j->up; y++)
            ntp__columns_down(&j->recursion, height_row(j, y), y, x, next);
        for (int32_t y = s.end - 1; y >= s.first && j->up; y--)
            ntp__columns_up(&j->recursion, height_row(j, y), y, x, next);
    }
}

static void filter_columns(void *work, int32_t part_index, int32_t item)
{
    const job *j = work;
    ntp__filter_columns(&j->filter, j->dst, (j->first_filtered + item) * NTP__FFT_ROWS,
                        j->parts[part_index].fft_work);
}

static bool stopped(const job *j, double share)
{
    const ntp_hooks *hooks = j->crew.hooks;
    return hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, share) != 0;
}

/* -------------------------------------------------------------------------------- passes */

/* With callbacks: the rows of heights in memory. */
static int32_t held_rows(const job *j)
{
    return j->crew.parts * RUN * ROWS;
}

/* The number of rows of a round.  A single part waits for nobody, so its rounds are short. */
static int32_t round_rows(const job *j)
{
    int32_t blocks = ROUND_BLOCKS * j->crew.parts;
    if (j->crew.parts == 1 || j->rows != NULL)
        return held_rows(j);
    return (blocks < NTP__MOST_BLOCKS ? blocks : NTP__MOST_BLOCKS) * j->block;
}

static span round_at(const job *j, int32_t round)
{
    int32_t rows = round_rows(j), left = j->problem.down.n - round * rows;
    span s = { round * rows, round * rows + (left < rows ? left : rows) };
    return s;
}

static void run_round(job *j)
{
    ntp__crew_steps steps = { j->up ? synthesize : analyze, recur, j, 0, 0, j->up };
    steps.count = (j->held.end - j->held.first + j->block - 1) / j->block;
    steps.lanes = j->problem.filter ? 0 : j->lanes;
    ntp__crew_blocks(&j->crew, &steps);
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static void set_blocks(job *j)
{
    int32_t width = j->problem.along.n, parts = j->crew.parts;
    int32_t batches = BLOCK_BYTES / (int32_t) sizeof(float) / width / ROWS;
    int32_t all = (j->problem.down.n + ROWS - 1) / ROWS;
    int32_t lanes = least((parts + LANE_PARTS - 1) / LANE_PARTS, NTP__MOST_LANES);
    batches = least(least(batches, RUN), parts > 1 ? all / (PART_BLOCKS * parts) : RUN);
    if (j->rows != NULL) /* no more blocks than one call takes */
        batches = least(RUN, (parts * RUN + NTP__MOST_BLOCKS - 1) / NTP__MOST_BLOCKS);
    j->block = (batches > 1 ? batches : 1) * ROWS;
    int32_t groups = (width + NTP__COLUMNS - 1) / NTP__COLUMNS;
    j->lane_columns = (groups + lanes - 1) / lanes * NTP__COLUMNS;
    j->lanes = (width + j->lane_columns - 1) / j->lane_columns;
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

static ntp_status go_down(job *j, int32_t rounds, double share)
{
    j->up = false;
    for (int32_t i = 0; i < rounds; i++) {
        if (stopped(j, share * i / rounds))
            return NTP_ERR_CANCELLED;
        j->held = round_at(j, i);
        if (j->rows != NULL)
            NTP__TRY(read_normals(j));
        run_round(j);
        if (j->rows != NULL)
            NTP__TRY(write_heights(j));
    }
    return NTP_OK;
}

static ntp_status go_up(job *j, int32_t rounds, double share)
{
    j->up = true;
    for (int32_t i = rounds - 1; i >= 0; i--) {
        if (stopped(j, 1 - share * (i + 1) / rounds))
            return NTP_ERR_CANCELLED;
        j->held = round_at(j, i);
        if (j->rows != NULL)
            NTP__TRY(read_heights(j));
        run_round(j);
        if (j->rows != NULL)
            NTP__TRY(write_heights(j));
    }
    return NTP_OK;
}

static ntp_status filter_all(job *j)
{
    double sum = 0, width = j->problem.along.n, height = j->problem.down.n;
    int32_t count = (j->problem.along.n + NTP__FFT_ROWS - 1) / NTP__FFT_ROWS;
    int32_t step = j->crew.parts * MOST_ITEMS;
    for (int32_t y = 0; y < j->problem.down.n; y++)
        sum += j->squares[y];
    ntp__filter_set_prior(&j->filter, sum / (width * height));
    for (int32_t i = 0; i < count; i += step) {
        if (stopped(j, (1 + (double) i / count) / 3))
            return NTP_ERR_CANCELLED;
        j->first_filtered = i;
        ntp__crew_each(&j->crew, filter_columns, j, count - i < step ? count - i : step);
    }
    return NTP_OK;
}

static ntp_status least_squares(job *j)
{
    set_blocks(j);
    int32_t rounds = (j->problem.down.n + round_rows(j) - 1) / round_rows(j);
    double share = j->problem.filter ? 1.0 / 3 : 0.5;
    NTP__TRY(go_down(j, rounds, share));
    if (j->problem.filter)
        NTP__TRY(filter_all(j));
    else
        ntp__columns_turn(&j->recursion);
    return go_up(j, rounds, share);
}

/* -------------------------------------------------------------------------------- whole */

static size_t scratch_of(const ntp__height_plan *plan, int32_t parts)
{
    job j;
    ntp__scratch solution = { NULL, 0 }, after = { NULL, 0 };
    memset(&j, 0, sizeof j);
    ntp__problem_init(&j.problem, plan, NTP_TYPE_F32);
    j.crew.parts = parts;
    lay_out(&j, &solution, NULL);
    ntp__edges_fit(NULL, NULL, &j.problem, &after, NULL, NULL);
    return solution.used > after.used ? solution.used : after.used;
}

/* Evidence may call for a prior, which takes other memory. */
size_t ntp__direct_scratch(const ntp__height_plan *plan, int32_t parts)
{
    ntp__height_plan damaged = *plan;
    size_t size = scratch_of(plan, parts), other = 0;
    damaged.error = 1;
    if (plan->z == NTP_Z_AUTO)
        other = scratch_of(&damaged, parts);
    return size > other ? size : other;
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
    ntp__edges_fit(dst, slopes, &j.problem, &after, &j.crew, counts->range);
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
        ntp__take(memory, (size_t) held_rows(j) * (size_t) form->width * sizeof(float)),
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
