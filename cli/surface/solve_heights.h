/* SPDX-License-Identifier: MIT */
/*
 * solve_heights.h - heights of a texture that is held in memory, and what its edges tell of borders
 */
#ifndef NTP_CLI_SOLVE_HEIGHTS_H
#define NTP_CLI_SOLVE_HEIGHTS_H

#include <libntp.h>
#include <stdbool.h>

#include "examine/examine.h"

/* A part of the work on a file, in thousandths, for the progress bar. */
typedef struct stretch {
    int from, to;
} stretch;

/* ntp_height_from_normals on all threads of the worker.  NTP_ERR_FORMAT: this kernel with these
 * borders by this method is not to be had. */
ntp_status heights_solve(worker *w, const ntp_image *heights, const ntp_const_image *src,
                         const ntp_height_options *how, stretch part, ntp_height_result *result);

/*
 * Which borders the normals at the edges were made with.  heights: room for the heights of src, which
 * it spoils.  how: its borders count where `fixed` says so.  seams: of ntp_find_seams.  found stays
 * as it is where no heights are to be had.
 */
ntp_status heights_find_borders(ntp_border_fit found[2], worker *w, const ntp_image *heights,
                                const ntp_const_image *src, const ntp_height_options *how,
                                const bool fixed[2], const ntp_seam seams[2], stretch part);

#endif
