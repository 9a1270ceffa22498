/* SPDX-License-Identifier: MIT */
/*
 * to_height_choose.c - what the options leave to evidence: Y, the kernel, the borders
 *
 * The texels are asked first.  What they do not tell is taken from the name (Y) or from what is
 * safe: the central kernel, and borders that suppose nothing about the other end.
 */
#include <stdlib.h>

#include "to_height.h"

static void choose_y(to_height_state *st, const to_height_settings *set, const input *in)
{
    ntp_orientation_result found = { 0 };
    if (set->y != AUTO) {
        st->y = (ntp_y) set->y;
        st->y_by = BY_OPTION;
        st->y_confidence = 1;
        return;
    }
    ntp_orientation *memory = need(calloc(1, ntp_orientation_size()));
    if (ntp_orientation_measure(memory, &st->src, st->how.touch_unused, 1, NULL) == NTP_OK)
        ntp_orientation_decide(&found, memory);
    free(memory);
    st->y_confidence = found.confidence;
    st->y_by = found.decided ? BY_TEXELS : in->y != NAME_Y_NONE ? BY_NAME : BY_DEFAULT;
    st->y = found.decided ? found.y : in->y == NAME_Y_DOWN ? NTP_Y_DOWN : NTP_Y_UP;
}

static void choose_kernel(to_height_state *st, const to_height_settings *set)
{
    ntp_origin found = { .kernel = NTP_KERNEL_CENTRAL };
    st->how.kernel = (ntp_kernel) set->kernel;
    st->kernel_by = BY_OPTION;
    if (set->kernel != AUTO)
        return;
    ntp_find_origin(&found, &st->src, st->how.touch_unused);
    st->how.kernel = found.kernel;
    st->kernel_by = found.decided || found.kernel != NTP_KERNEL_CENTRAL ? BY_TEXELS : BY_DEFAULT;
}

/* Free borders do little harm to a texture that tiles; wrap spoils one that does not. */
static void choose_borders(to_height_state *st, const to_height_settings *set)
{
    const int asked[2] = { set->border_x, set->border_y };
    const ntp_height_method method = set->how.method;
    ntp_seam seams[2] = { { 0 }, { 0 } };
    ntp_border chosen[2];
    if (asked[0] == AUTO || asked[1] == AUTO)
        ntp_find_seams(&seams[0], &seams[1], &st->src, st->how.touch_unused);
    for (int axis = 0; axis < 2; axis++) {
        const bool by_method =
            method == NTP_HEIGHT_FRANKOT_CHELLAPPA || method == NTP_HEIGHT_POISSON_DCT;
        const bool wraps =
            by_method ? method == NTP_HEIGHT_FRANKOT_CHELLAPPA : seams[axis].wraps != 0;
        chosen[axis] = asked[axis] != AUTO ? (ntp_border) asked[axis]
                       : wraps             ? NTP_BORDER_WRAP
                                           : NTP_BORDER_EXTRAPOLATE;
        st->border_by[axis] = asked[axis] != AUTO || by_method             ? BY_OPTION
                              : seams[axis].tiling == NTP_TILING_UNDECIDED ? BY_DEFAULT
                                                                           : BY_TEXELS;
    }
    st->how.border_x = chosen[0];
    st->how.border_y = chosen[1];
}

void to_height_choose(to_height_state *st, const to_height_settings *set, const input *in)
{
    choose_y(st, set, in);
    st->src.y = st->y;
    choose_kernel(st, set);
    choose_borders(st, set);
}
