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

ntp_status heights_occlude(worker *w, const ntp_image *map, const ntp_const_image *heights,
                           const ntp_occlusion_options *how, stretch part)
{
    const int32_t parts = w->threads < NTP_MAX_PARTS ? w->threads : NTP_MAX_PARTS;
    const size_t size = ntp_occlusion_scratch_size(how, heights->width, heights->height, parts);
    void *scratch = need_aligned(size);
    team all = { w, crew_start(parts), part };
    const ntp_hooks hooks = {
        .user = &all, .progress = tell_progress, .parallel_for = run_parts, .parts = parts
    };
    const ntp_status status = ntp_occlusion(map, heights, how, scratch, size, &hooks);
    crew_stop(all.threads);
    free(scratch);
    return status;
}

/* -------------------------------------------------------------------------- borders */

/* What is tried where the edges show no border.  A border takes the place of the one before if it
 * fits clearly better. */
static const ntp_border TRIED[] = { NTP_BORDER_WRAP, NTP_BORDER_EXTRAPOLATE, NTP_BORDER_CLAMP };
static const double CLEARLY_BETTER = 0.99;
/* In levels of 8 bit: where normals fit so well, no border is wrong. */
static const double FITS_WELL = 0.4;

/* The residual of the best heights with these borders, in levels of 8 bit; below 0: they cannot be
 * solved. */
static double residual_with(worker *w, const ntp_image *heights, const ntp_const_image *src,
                            const ntp_height_options *how, stretch part, ntp_status *status)
{
    ntp_height_result done = { .residual = -1 };
    *status = heights_solve(w, heights, src, how, part, &done);
    if (*status != NTP_OK)
        return -1;
    return src->type == NTP_TYPE_U8 ? done.residual : done.residual / 257;
}

/* The i-th of `count` equal shares of the work. */
static stretch slice(stretch part, int i, int count)
{
    const int width = part.to - part.from;
    return (stretch) { part.from + width * i / count, part.from + width * (i + 1) / count };
}

/* Solves with other borders where none is decided, one axis after the other, and takes the one that
 * leaves least. */
static ntp_status try_borders(ntp_border_fit found[2], worker *w, const ntp_image *heights,
                              const ntp_const_image *src, const ntp_height_options *how,
                              const bool fixed[2], stretch part)
{
    enum { COUNT = sizeof TRIED / sizeof TRIED[0], SOLUTIONS = 1 + 2 * COUNT };
    ntp_height_options with = *how;
    ntp_border *const border[2] = { &with.border_x, &with.border_y };
    ntp_status status;
    for (int i = 0; i < 2; i++)
        *border[i] = fixed[i] ? *border[i] : found[i].border;
    with.residual_scope = NTP_RESIDUAL_ALL;
    double least = residual_with(w, heights, src, &with, slice(part, 0, SOLUTIONS), &status);
    if (status == NTP_ERR_CANCELLED || !(least > FITS_WELL))
        return status;
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < COUNT && !fixed[i] && !found[i].decided; k++) {
            const ntp_border before = *border[i];
            *border[i] = TRIED[k];
            const stretch now = slice(part, 1 + i * COUNT + k, SOLUTIONS);
            const double residual = residual_with(w, heights, src, &with, now, &status);
            if (status == NTP_ERR_CANCELLED)
                return status;
            if (residual >= 0 && residual < CLEARLY_BETTER * least)
                least = residual;
            else
                *border[i] = before;
        }
    }
    for (int i = 0; i < 2; i++) {
        if (fixed[i] || *border[i] == found[i].border)
            continue;
        found[i].border = *border[i];
        found[i].decided = 1;
    }
    return NTP_OK;
}

/* Is the texture told to tile, and are heights that tile right?  Then no other border is better. */
static bool tiles_well(ntp_border_fit found[2], worker *w, const ntp_image *heights,
                       const ntp_const_image *src, const ntp_height_options *how,
                       const bool fixed[2], const ntp_seam seams[2], stretch part,
                       ntp_status *status)
{
    ntp_height_options with = *how;
    ntp_border *const border[2] = { &with.border_x, &with.border_y };
    for (int i = 0; i < 2; i++) {
        if (!fixed[i] && !seams[i].wraps)
            return false;
        *border[i] = fixed[i] ? *border[i] : NTP_BORDER_WRAP;
    }
    with.residual_scope = NTP_RESIDUAL_ALL;
    const double residual = residual_with(w, heights, src, &with, part, status);
    if (!(residual >= 0 && residual <= FITS_WELL))
        return false;
    for (int i = 0; i < 2; i++) {
        found[i].border = NTP_BORDER_WRAP;
        found[i].decided = 1;
    }
    return true;
}

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
    ntp_status status = NTP_OK;
    if (tiles_well(found, w, heights, src, &first, fixed, seams, slice(part, 0, 6), &status) ||
        status == NTP_ERR_CANCELLED)
        return status;
    status = heights_solve(w, heights, src, &first, slice(part, 1, 6), NULL);
    if (status != NTP_OK)
        return status == NTP_ERR_CANCELLED ? status : NTP_OK;
    for (int i = 0; i < 2; i++)
        ntp_find_border(&found[i], src, &made, &first, i, seams[i].wraps);
    if ((!fixed[0] && !found[0].decided) || (!fixed[1] && !found[1].decided))
        status = try_borders(found, w, heights, src, &first, fixed,
                             (stretch) { slice(part, 0, 3).to, part.to });
    return status == NTP_ERR_CANCELLED ? status : NTP_OK;
}
