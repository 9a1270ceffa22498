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

void to_height_choose(to_height_state *st, const to_height_settings *set, const input *in)
{
    choose_y(st, set, in);
    st->src.y = st->y;
    st->how.kernel = set->kernel == AUTO ? NTP_KERNEL_CENTRAL : (ntp_kernel) set->kernel;
    st->kernel_by = set->kernel == AUTO ? BY_DEFAULT : BY_OPTION;
    const int borders[2] = { set->border_x, set->border_y };
    ntp_border *chosen[2] = { &st->how.border_x, &st->how.border_y };
    for (int axis = 0; axis < 2; axis++) {
        const bool wraps = set->how.method == NTP_HEIGHT_FRANKOT_CHELLAPPA;
        st->border_by[axis] = borders[axis] == AUTO && !wraps ? BY_DEFAULT : BY_OPTION;
        *chosen[axis] = borders[axis] != AUTO ? (ntp_border) borders[axis]
                        : wraps               ? NTP_BORDER_WRAP
                                              : NTP_BORDER_EXTRAPOLATE;
    }
}
