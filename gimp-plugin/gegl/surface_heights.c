/* SPDX-License-Identifier: MIT */
/*
 * surface_heights.c - the heights behind normals, as `ntp` finds them where nothing is told
 *
 * The texels show the kernel and the borders.  With unused texels, which are holes, the least squares
 * are weighted.
 */
#include "surface_heights.h"

#include <stdint.h>
#include <stdlib.h>

enum { ALIGNMENT = 64 };

/* Working memory; data is NULL where there is none. */
typedef struct memory {
    unsigned char *all;
    void *data;
    size_t size;
} memory;

static memory memory_of(size_t size)
{
    memory m = { size > 0 ? malloc(size + ALIGNMENT) : NULL, NULL, size };
    if (m.all != NULL)
        m.data = m.all + (ALIGNMENT - (uintptr_t) m.all % ALIGNMENT) % ALIGNMENT;
    return m;
}

static ntp_status find_holes(bool *holes, const ntp_const_image *normals)
{
    ntp_stats stats = { 0 };
    ntp_tally *tally = calloc(1, ntp_tally_size());
    ntp_status status = NTP_ERR_SCRATCH;
    if (tally != NULL)
        status = ntp_tally_add(tally, normals, 0, NULL);
    if (status == NTP_OK)
        status = ntp_tally_summarize(&stats, tally, normals->encoding);
    free(tally);
    *holes = stats.unused > 0 && stats.unused < stats.texels;
    return status;
}

static ntp_status find_borders(ntp_height_options *how, const ntp_const_image *normals,
                               const bool wrap[2], const ntp_hooks *hooks)
{
    const int32_t open[2] = { !wrap[0], !wrap[1] };
    ntp_border_fit found[2];
    ntp_seam seams[2];
    if (!open[0] && !open[1])
        return NTP_OK;
    ntp_find_seams(&seams[0], &seams[1], normals, 0);
    const int32_t tiles[2] = { seams[0].wraps, seams[1].wraps };
    const memory m = memory_of(
        ntp_find_borders_scratch_size(how, normals->width, normals->height, hooks->parts));
    const ntp_status status =
        ntp_find_borders(found, normals, how, open, tiles, m.data, m.size, hooks);
    free(m.all);
    how->border_x = open[0] ? found[0].border : NTP_BORDER_WRAP;
    how->border_y = open[1] ? found[1].border : NTP_BORDER_WRAP;
    return status;
}

ntp_status surface_heights(const ntp_image *heights, const ntp_const_image *normals,
                           const bool wrap[2], const ntp_hooks *hooks)
{
    ntp_height_options how = { .dx = 1, .dy = 1 };
    ntp_kernel_fit kernel = { .kernel = NTP_KERNEL_CENTRAL };
    bool holes = false;
    ntp_status status = find_holes(&holes, normals);
    if (status != NTP_OK)
        return status;
    how.method = holes ? NTP_HEIGHT_WEIGHTED : NTP_HEIGHT_AUTO;
    ntp_find_kernel(&kernel, normals, 0);
    how.kernel = kernel.kernel;
    status = find_borders(&how, normals, wrap, hooks);
    if (status != NTP_OK)
        return status;
    const memory m =
        memory_of(ntp_height_scratch_size(&how, normals->width, normals->height, hooks->parts));
    ntp_height_result result;
    status = ntp_height_from_normals(heights, normals, &how, m.data, m.size, hooks, &result);
    free(m.all);
    return status;
}
