/* SPDX-License-Identifier: MIT */
/*
 * heights.c - heights of a texture that is held in memory, and what its edges tell of borders
 *
 * Borders: the heights are made without regard to the slopes at the edges; then the normals that
 * each border would give there are compared with the stored ones.
 */
#include "heights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"

enum {
    BORDERS = NTP_BORDER_REPEAT_SLOPE + 1,
    STRIP = 8, /* lines along an edge, enough for every kernel that is tried */
    ENDS = 4,  /* texels at the ends of a line: the other axis has borders too */
    LEAST_SIDE = 2 * STRIP
};

/* Levels of 8 bit by which normals of the right border may be off, rms. */
static const double MOST_ERROR = 3;
/* What fits nearly as well as the best is as good. */
static const double NEARLY = 1.25, NEARLY_LEVELS = 0.05;
/* Noise at the edges does not speak against what tiles. */
static const double MUCH_WORSE = 1.5;

/* -------------------------------------------------------------------------- solving */

typedef struct team {
    worker *w;
    crew *threads;
    stretch part;
} team;

static int32_t tell_progress(void *user, double share)
{
    const team *all = user;
    const int permille = all->part.from + (int) (share * (all->part.to - all->part.from));
    atomic_store_explicit(&all->w->permille, permille, memory_order_relaxed);
    return interrupted_by != 0;
}

static void run_parts(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    crew_run(((team *) user)->threads, count, task, work);
}

ntp_status heights_solve(worker *w, const ntp_image *heights, const ntp_const_image *src,
                         const ntp_height_options *how, stretch part, ntp_height_result *result)
{
    const int32_t parts = w->threads < NTP_MAX_PARTS ? w->threads : NTP_MAX_PARTS;
    const size_t size = ntp_height_scratch_size(how, src->width, src->height, parts);
    if (size == 0)
        return NTP_ERR_FORMAT;
    void *scratch = need(aligned_alloc(64, (size + 63) / 64 * 64));
    team all = { w, crew_start(parts), part };
    const ntp_hooks hooks = {
        .user = &all, .progress = tell_progress, .parallel_for = run_parts, .parts = parts
    };
    const ntp_status status =
        ntp_height_from_normals(heights, src, how, scratch, size, &hooks, result);
    crew_stop(all.threads);
    free(scratch);
    return status;
}

/* -------------------------------------------------------------------------- borders */

ntp_border heights_free_border(ntp_kernel kernel)
{
    /* forward: the last slope is not looked at; others: mirrored heights have none at the edge */
    return kernel == NTP_KERNEL_FORWARD ? NTP_BORDER_CLAMP : NTP_BORDER_MIRROR;
}

/* One axis of a texture: lines across it, of which the first and the last are at its edges. */
typedef struct axis {
    const ntp_image *heights;
    const ntp_const_image *src;
    ntp_gradient_options how;
    bool down;  /* lines are rows */
    bool wraps; /* as far as the whole texture tells */
} axis;

/* Sample c of a pixel, 0..1. */
static double sample(const ntp_const_image *view, int32_t x, int32_t y, int32_t c)
{
    const unsigned char *at = (const unsigned char *) view->data +
                              (ptrdiff_t) y * view->row_stride + (ptrdiff_t) x * view->pixel_stride;
    if (view->type == NTP_U8)
        return at[c] / 255.0;
    if (view->type == NTP_U16)
        return ((const uint16_t *) (const void *) at)[c] / 65535.0;
    return (double) ((const float *) (const void *) at)[c];
}

static bool is_unused(const ntp_const_image *view, int32_t x, int32_t y)
{
    const double r = sample(view, x, y, 0), g = sample(view, x, y, 1);
    const bool end = r <= 0 || r >= 1; /* NaN is not */
    return (end && r == g) || !isfinite(r) || !isfinite(g) ||
           (view->channels == 4 && sample(view, x, y, 3) <= 0);
}

/* Adds the squared errors of a line: that of `made` against that of the texture. */
static void compare_line(double *sum, uint64_t *count, const axis *a, const ntp_const_image *made,
                         int32_t made_line, int32_t line)
{
    const int32_t length = a->down ? a->src->width : a->src->height;
    for (int32_t i = ENDS; i < length - ENDS; i++) {
        const int32_t x = a->down ? i : line, y = a->down ? line : i;
        const int32_t u = a->down ? i : made_line, v = a->down ? made_line : i;
        if (is_unused(a->src, x, y))
            continue;
        for (int32_t c = 0; c < 2; c++) {
            const double off = sample(a->src, x, y, c) - sample(made, u, v, c);
            *sum += off * off;
        }
        *count += 2;
    }
}

/* The strip of heights from line `first` on, as a view. */
static ntp_const_image strip_of(const axis *a, int32_t first)
{
    ntp_const_image view = ntp_image_as_const(a->heights);
    view.data = (const unsigned char *) view.data +
                (ptrdiff_t) first * (a->down ? view.row_stride : view.pixel_stride);
    *(a->down ? &view.height : &view.width) = STRIP;
    return view;
}

static float height_at(const axis *a, int32_t line, int32_t i)
{
    const ntp_image *h = a->heights;
    const int32_t x = a->down ? i : line, y = a->down ? line : i;
    return ((const float *) h->data)[(size_t) y * (size_t) h->width + (size_t) x];
}

/* By how much the heights have drifted from one edge to the other: the mean step across the seam
 * less the mean of the steps beside it. */
static double drift_of(const axis *a, int32_t lines, int32_t length)
{
    double sum = 0;
    for (int32_t i = 0; i < length; i++) {
        const double first = (double) height_at(a, 0, i),
                     last = (double) height_at(a, lines - 1, i);
        const double after = (double) height_at(a, 1, i);
        const double before = (double) height_at(a, lines - 2, i);
        sum += first - last - (after - first + last - before) / 2;
    }
    return sum / length;
}

/* The last lines and the first ones beside each other: a copy.  Where the texture is known to wrap,
 * what all heights have drifted is rounding, and taken out. */
static ntp_const_image wrapped_strip(const axis *a, float *memory)
{
    const int32_t lines = a->down ? a->src->height : a->src->width;
    const int32_t length = a->down ? a->src->width : a->src->height;
    const float drift = a->wraps ? (float) drift_of(a, lines, length) : 0;
    for (int32_t k = 0; k < STRIP; k++) {
        const int32_t line = k < STRIP / 2 ? lines - STRIP / 2 + k : k - STRIP / 2;
        for (int32_t i = 0; i < length; i++) {
            const size_t to = a->down ? (size_t) k * (size_t) length + (size_t) i
                                      : (size_t) i * STRIP + (size_t) k;
            memory[to] = height_at(a, line, i) - (k < STRIP / 2 ? 0 : drift);
        }
    }
    const ntp_image view =
        ntp_image_packed(memory, a->down ? length : STRIP, a->down ? STRIP : length, 1, NTP_F32);
    return ntp_image_as_const(&view);
}

/* Normals of a strip, into memory. */
static bool make_normals(ntp_image *made, const axis *a, const ntp_const_image *strip,
                         ntp_border border, void *memory)
{
    ntp_gradient_options how = a->how;
    how.border_x = how.border_y = border;
    *made = ntp_image_packed(memory, strip->width, strip->height, a->src->channels, a->src->type);
    made->encoding = a->src->encoding;
    made->y = a->src->y;
    return ntp_normals_from_height(made, strip, &how, NULL, NULL) == NTP_OK;
}

/* The rms error of both edges in levels of 8 bit; negative: cannot be told. */
static double edge_error(const axis *a, ntp_border border, float *copy, void *memory)
{
    const int32_t lines = a->down ? a->src->height : a->src->width;
    ntp_image made;
    double sum = 0;
    uint64_t count = 0;
    for (int32_t end = 0; end < 2; end++) {
        const bool wraps = border == NTP_BORDER_WRAP;
        const ntp_const_image strip =
            wraps ? wrapped_strip(a, copy) : strip_of(a, end == 0 ? 0 : lines - STRIP);
        if (!make_normals(&made, a, &strip, wraps ? NTP_BORDER_CLAMP : border, memory))
            return -1;
        const ntp_const_image seen = ntp_image_as_const(&made);
        const int32_t at =
            wraps ? (end == 0 ? STRIP / 2 : STRIP / 2 - 1) : (end == 0 ? 0 : STRIP - 1);
        compare_line(&sum, &count, a, &seen, at, end == 0 ? 0 : lines - 1);
    }
    const double scale = a->src->encoding == NTP_VECTOR ? 127.5 : 255;
    return count > 0 ? sqrt(sum / (double) count) * scale : -1;
}

/* What fits, and first of all what the whole texture speaks for. */
static border_choice choose(const double error[BORDERS], bool wraps, ntp_kernel kernel)
{
    const ntp_border likely = wraps ? NTP_BORDER_WRAP : NTP_BORDER_EXTRAPOLATE;
    int best = -1;
    for (int b = 0; b < BORDERS; b++) {
        if (error[b] >= 0 && (best < 0 || error[b] < error[best]))
            best = b;
    }
    if (best >= 0 && error[best] <= MOST_ERROR) {
        const bool as_good =
            error[likely] >= 0 && error[likely] <= NEARLY * error[best] + NEARLY_LEVELS;
        return (border_choice) { as_good ? likely : (ntp_border) best, true };
    }
    if (wraps && error[NTP_BORDER_WRAP] >= 0 && error[NTP_BORDER_WRAP] <= MUCH_WORSE * error[best])
        return (border_choice) { NTP_BORDER_WRAP, true };
    return (border_choice) { heights_free_border(kernel), false };
}

/* Can heights be made with this border at all edges? */
static bool is_solved(const axis *a, const ntp_height_options *how, ntp_border border)
{
    ntp_height_options with = *how;
    with.border_x = with.border_y = border;
    return ntp_height_scratch_size(&with, a->src->width, a->src->height, 1) > 0;
}

static border_choice look_at_edges(const axis *a, const ntp_height_options *how)
{
    const size_t length = (size_t) (a->down ? a->src->width : a->src->height);
    float *copy = need(malloc(length * STRIP * sizeof *copy));
    void *memory = need(malloc(length * STRIP * 4 * sizeof(float)));
    double error[BORDERS];
    for (int b = 0; b < BORDERS; b++)
        error[b] =
            is_solved(a, how, (ntp_border) b) ? edge_error(a, (ntp_border) b, copy, memory) : -1;
    free(memory);
    free(copy);
    return choose(error, a->wraps, how->kernel);
}

ntp_status heights_find_borders(border_choice found[2], worker *w, const ntp_image *heights,
                                const ntp_const_image *src, const ntp_height_options *how,
                                const bool fixed[2], const ntp_seam seams[2], stretch part)
{
    const ntp_border unknown = heights_free_border(how->kernel);
    const bool too_small = src->width < LEAST_SIDE || src->height < LEAST_SIDE;
    ntp_height_options first = *how;
    first.refine = first.detrend = first.measure = 0;
    first.border_x = fixed[0] ? how->border_x : unknown;
    first.border_y = fixed[1] ? how->border_y : unknown;
    for (int i = 0; i < 2; i++)
        found[i] = (border_choice) { seams[i].wraps ? NTP_BORDER_WRAP : unknown, seams[i].wraps };
    if (too_small || how->kernel == NTP_KERNEL_BAKED)
        return NTP_OK;
    const ntp_status status = heights_solve(w, heights, src, &first, part, NULL);
    if (status != NTP_OK)
        return status == NTP_ERR_CANCELLED ? status : NTP_OK;
    for (int i = 0; i < 2; i++) {
        const axis a = { .heights = heights,
                         .src = src,
                         .how = { .scale = 1, .dx = how->dx, .dy = how->dy, .kernel = how->kernel },
                         .down = i == 1,
                         .wraps = seams[i].wraps != 0 };
        found[i] = look_at_edges(&a, &first);
    }
    return NTP_OK;
}
