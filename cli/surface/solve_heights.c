/* SPDX-License-Identifier: MIT */
/*
 * solve_heights.c - heights of a texture in memory, and the borders that its edges show
 */
#include "surface/solve_heights.h"

#include <stdlib.h>

#include "run/thread_crew.h"

/* -------------------------------------------------------------------------- solving */

typedef struct team {
    worker *w;
    crew *threads;
    stretch part;
    const ntp_height_result *result; /* which the rounds of refinement fill; or NULL */
} team;

static int32_t tell_progress(void *user, double share)
{
    const team *all = user;
    const int permille = all->part.from + (int) (share * (all->part.to - all->part.from));
    const ntp_height_result *now = all->result;
    const uint64_t left = now != NULL && now->rounds > 0 ? now->refine_left : 0;
    atomic_store_explicit(&all->w->permille, permille, memory_order_relaxed);
    atomic_store_explicit(&all->w->left, left, memory_order_relaxed);
    return interrupted_by != 0;
}

static void run_parts(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    crew_run(((team *) user)->threads, count, task, work);
}

static ntp_hooks hooks_of(team *all, int32_t parts)
{
    return (ntp_hooks) {
        .user = all, .progress = tell_progress, .parallel_for = run_parts, .parts = parts
    };
}

ntp_status heights_solve(worker *w, const ntp_image *heights, const ntp_const_image *src,
                         const ntp_height_options *how, stretch part, ntp_height_result *result)
{
    const int32_t parts = w->threads < NTP_MAX_PARTS ? w->threads : NTP_MAX_PARTS;
    const size_t size = ntp_height_scratch_size(how, src->width, src->height, parts);
    if (size == 0)
        return NTP_ERR_FORMAT;
    void *scratch = need_aligned(size);
    team all = { w, crew_start(parts), part, result };
    const ntp_hooks hooks = hooks_of(&all, parts);
    const ntp_status status =
        ntp_height_from_normals(heights, src, how, scratch, size, &hooks, result);
    crew_stop(all.threads);
    free_aligned(scratch);
    return status;
}

ntp_status heights_occlude(worker *w, const ntp_image *map, const ntp_const_image *heights,
                           const ntp_occlusion_options *how, stretch part)
{
    const int32_t parts = w->threads < NTP_MAX_PARTS ? w->threads : NTP_MAX_PARTS;
    const size_t size = ntp_occlusion_scratch_size(how, heights->width, heights->height, parts);
    void *scratch = need_aligned(size);
    team all = { w, crew_start(parts), part, NULL };
    const ntp_hooks hooks = hooks_of(&all, parts);
    const ntp_status status = ntp_occlusion(map, heights, how, scratch, size, &hooks);
    crew_stop(all.threads);
    free_aligned(scratch);
    return status;
}

ntp_status depth_solve(worker *w, const ntp_image *depth, const ntp_image *confidence,
                       const ntp_const_image *src, const ntp_depth_options *how, stretch part,
                       ntp_depth_result *result)
{
    const size_t size = ntp_depth_scratch_size(src->width, src->height);
    if (size == 0)
        return NTP_ERR_SHAPE;
    void *scratch = need_aligned(size);
    team all = { .w = w, .part = part };
    const ntp_hooks hooks = { .user = &all, .progress = tell_progress };
    const ntp_status status =
        ntp_depth_from_normals(depth, confidence, src, how, scratch, size, &hooks, result);
    free_aligned(scratch);
    return status;
}

/* -------------------------------------------------------------------------- borders */

ntp_status heights_find_borders(ntp_border_fit found[2], worker *w, const ntp_const_image *src,
                                const ntp_height_options *how, const bool fixed[2],
                                const ntp_seam seams[2], stretch part)
{
    const int32_t open[2] = { !fixed[0], !fixed[1] };
    const int32_t wraps[2] = { seams[0].wraps, seams[1].wraps };
    const int32_t parts = w->threads < NTP_MAX_PARTS ? w->threads : NTP_MAX_PARTS;
    const size_t size = ntp_find_borders_scratch_size(how, src->width, src->height, parts);
    void *scratch = size > 0 ? need_aligned(size) : NULL;
    team all = { w, crew_start(parts), part, NULL };
    const ntp_hooks hooks = hooks_of(&all, parts);
    const ntp_status status = ntp_find_borders(found, src, how, open, wraps, scratch, size, &hooks);
    crew_stop(all.threads);
    free_aligned(scratch);
    return status;
}
