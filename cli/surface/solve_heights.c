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
    void *scratch = need_aligned(size);
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

ntp_status heights_find_borders(ntp_border_fit found[2], worker *w, const ntp_image *heights,
                                const ntp_const_image *src, const ntp_height_options *how,
                                const bool fixed[2], const ntp_seam seams[2], stretch part)
{
    const ntp_border unknown = ntp_free_border(how->kernel);
    const ntp_const_image made = ntp_image_as_const(heights);
    ntp_height_options first = *how;
    if (how->kernel == NTP_KERNEL_BAKED) /* made without any */
        return NTP_OK;
    first.refine = first.detrend = 0;
    first.residual_scope = NTP_RESIDUAL_NONE;
    first.border_x = fixed[0] ? how->border_x : unknown;
    first.border_y = fixed[1] ? how->border_y : unknown;
    const ntp_status status = heights_solve(w, heights, src, &first, part, NULL);
    for (int i = 0; status == NTP_OK && i < 2; i++)
        ntp_find_border(&found[i], src, &made, &first, i, seams[i].wraps);
    return status == NTP_ERR_CANCELLED ? status : NTP_OK;
}
