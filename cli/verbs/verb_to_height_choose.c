/* SPDX-License-Identifier: MIT */
/*
 * verb_to_height_choose.c - what the options leave to evidence: Y, the kernel, the borders
 *
 * Where the texels do not show Y, the file is refused.  Otherwise there is a safe default: the
 * kernel central, and borders that assume nothing about the other end.
 */
#include <stdlib.h>

#include "surface/solve_heights.h"
#include "verbs/verb_to_height.h"

static bool slopes_in_y(const production *p, const ntp_const_image *src)
{
    steepest most = { 0, 0 };
    for (int32_t y = 0; y < src->height; y++)
        slopes_add(&most, src, (const char *) src->data + y * src->row_stride, p->touch);
    return !slopes_are_flat(most.y, &p->f.stats);
}

bool to_height_knows(production *p, text *why)
{
    const to_height_settings *set = p->m->settings;
    to_height_state *st = p->state;
    to_height_see(p);
    if (set->y == AUTO)
        green_measure(&p->f, &st->src, st->how.touch_unused);
    if (green_find(&st->y, set->y, &p->f))
        return true;
    if (slopes_in_y(p, &st->src)) {
        green_ask(why, &p->f, "--y");
        return false;
    }
    st->y = (green) { NTP_Y_UP, GREEN_UNNEEDED, 0 };
    return true;
}

static void choose_kernel(to_height_state *st, const to_height_settings *set)
{
    ntp_kernel_fit found = { .kernel = NTP_KERNEL_CENTRAL };
    st->how.kernel = (ntp_kernel) set->kernel;
    st->kernel_by = BY_OPTION;
    if (set->kernel != AUTO)
        return;
    ntp_find_kernel(&found, &st->src, st->how.touch_unused);
    const bool telescoping = st->how.method == NTP_HEIGHT_TELESCOPING;
    const bool sums = telescoping && found.kernel == NTP_KERNEL_BAKED; /* which it cannot do */
    st->how.kernel = sums ? NTP_KERNEL_CENTRAL : found.kernel;
    st->kernel_by = found.decided && !sums ? BY_TEXELS : BY_DEFAULT;
}

/*
 * The normals at the edges show the border if the heights can be solved quickly.  Otherwise the
 * border is wrap if the texture tiles.
 */
static ntp_status choose_borders(to_height_state *st, const to_height_settings *set, worker *w)
{
    const ntp_height_method method = st->how.method;
    const int asked[2] = { set->border_x, set->border_y };
    const bool fixed[2] = { asked[0] != AUTO, asked[1] != AUTO };
    ntp_border *chosen[2] = { &st->how.border_x, &st->how.border_y };
    ntp_seam seams[2] = { { 0 }, { 0 } };
    ntp_border_fit found[2];
    for (int i = 0; i < 2; i++) {
        const bool wraps = method == NTP_HEIGHT_FRANKOT_CHELLAPPA;
        *chosen[i] = fixed[i] ? (ntp_border) asked[i] : NTP_BORDER_WRAP;
        st->border_by[i] = fixed[i] || wraps ? BY_OPTION : BY_DEFAULT;
    }
    if ((fixed[0] && fixed[1]) || method == NTP_HEIGHT_FRANKOT_CHELLAPPA)
        return NTP_OK;
    if (method != NTP_HEIGHT_POISSON_DCT)
        ntp_find_seams(&seams[0], &seams[1], &st->src, st->how.touch_unused);
    const ntp_status status = heights_find_borders(found, w, &st->src, &st->how, fixed, seams,
                                                   (stretch) { READ_PERMILLE, SOLVE_PERMILLE });
    for (int i = 0; i < 2; i++) {
        if (fixed[i])
            continue;
        const bool never = method == NTP_HEIGHT_POISSON_DCT && found[i].border == NTP_BORDER_WRAP;
        *chosen[i] = never ? ntp_free_border(st->how.kernel) : found[i].border;
        st->border_by[i] = found[i].decided && !never ? BY_TEXELS : BY_DEFAULT;
    }
    return status;
}

ntp_status to_height_choose(to_height_state *st, const to_height_settings *set, worker *w)
{
    st->src.y = st->y.y;
    choose_kernel(st, set);
    return choose_borders(st, set, w);
}
