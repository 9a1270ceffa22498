/* SPDX-License-Identifier: MIT */
/*
 * relief_scale.c - the scale that --scale auto stands for
 */
#include "surface/relief_scale.h"

#include <stdlib.h>

#include "text/text.h"

ntp_status heights_suit_scale(const ntp_const_image *heights, const ntp_normals_options *how,
                              double *scale)
{
    ntp_relief *relief = need(calloc(1, sizeof *relief));
    ntp_status status = NTP_OK;
    for (int32_t y = 0; y < heights->height && status == NTP_OK; y++) {
        int32_t first = 0;
        const int32_t every = ntp_relief_row(heights->width, heights->height, y, &first);
        if (every > 0)
            status = ntp_relief_add(relief, heights, how, first, y, every);
    }
    *scale *= ntp_relief_scale(relief);
    free(relief);
    return status;
}
