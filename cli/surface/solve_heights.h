/* SPDX-License-Identifier: MIT */
/*
 * solve_heights.h - heights of a texture in memory, and the borders that its edges show
 */
#ifndef NTP_CLI_SOLVE_HEIGHTS_H
#define NTP_CLI_SOLVE_HEIGHTS_H

#include <libntp.h>
#include <stdbool.h>

#include "examine/examine.h"

/* A part of the work on a file, in thousandths; the progress bar shows it. */
typedef struct stretch {
    int from, to;
} stretch;

/* ntp_height_from_normals on all threads of the worker.  NTP_ERR_FORMAT: the method cannot solve
 * this kernel with these borders. */
ntp_status heights_solve(worker *w, const ntp_image *heights, const ntp_const_image *src,
                         const ntp_height_options *how, stretch part, ntp_height_result *result);

/* ntp_occlusion on all threads of the worker. */
ntp_status heights_occlude(worker *w, const ntp_image *map, const ntp_const_image *heights,
                           const ntp_occlusion_options *how, stretch part);

/* ntp_depth_from_normals on one thread; confidence may be NULL. */
ntp_status depth_solve(worker *w, const ntp_image *depth, const ntp_image *confidence,
                       const ntp_const_image *src, const ntp_depth_options *how, stretch part,
                       ntp_depth_result *result);

/* ntp_find_borders on all threads of the worker.  how: its borders hold where `fixed` says so.
 * seams: those of ntp_find_seams. */
ntp_status heights_find_borders(ntp_border_fit found[2], worker *w, const ntp_const_image *src,
                                const ntp_height_options *how, const bool fixed[2],
                                const ntp_seam seams[2], stretch part);

#endif
