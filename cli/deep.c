/* SPDX-License-Identifier: MIT */
/*
 * deep.c - what ntp check --deep finds out beside: the kernel, the seams, the fit of a surface
 *
 * The fit is that of the best heights there are: what their normals leave unexplained.  A texture
 * that was made from heights fits to the rounding: each level is off by 0.29 (rms), and half of the
 * square of that goes into the heights.  One that was painted, or mixed as colors, does not fit.
 */
#include "deep.h"

#include <stdlib.h>

#include "heights.h"
#include "whole.h"

enum {
    READ_PERMILLE = 500,
    MOST_TEXELS = 16384 * 16384 /* of a scan of many files, several of them at once */
};

static bool is_tangent_space(const facts *f)
{
    const uint32_t misplaced =
        NTP_ACCIDENT_RED_IS_Z | NTP_ACCIDENT_GREEN_IS_Z | NTP_ACCIDENT_DXT5NM | NTP_ACCIDENT_GAMMA;
    return f->encoding != NTP_HEIGHT && (f->type.accidents & misplaced) == 0 &&
           (f->type.type == NTP_CLASS_STANDARD || f->type.type == NTP_CLASS_ZZERO ||
            f->type.type == NTP_CLASS_XY);
}

/* Which way green points, by what is known; without any of it, where the kernels fit better. */
static ntp_y choose_y(const facts *f, const ntp_const_image *src, uint32_t touch, int asked)
{
    if (asked >= 0 || f->orientation.decided || f->in->y != NAME_Y_NONE)
        return asked >= 0               ? (ntp_y) asked
               : f->orientation.decided ? f->orientation.y
               : f->in->y == NAME_Y_UP  ? NTP_Y_UP
                                        : NTP_Y_DOWN;
    ntp_origin up = { 0 }, down = { 0 };
    ntp_const_image flipped = *src;
    flipped.y = NTP_Y_DOWN;
    ntp_find_origin(&up, src, touch);
    ntp_find_origin(&down, &flipped, touch);
    return down.points > 0 && down.misfit[down.kernel] < up.misfit[up.kernel] ? NTP_Y_DOWN
                                                                              : NTP_Y_UP;
}

/* The rms of what the best heights leave, in levels; negative: it was not to be had. */
static double fit_heights(worker *w, const facts *f, const ntp_const_image *src, uint32_t touch)
{
    const size_t texels = (size_t) src->width * (size_t) src->height;
    const ntp_image heights = ntp_image_packed(buffer_reserve(&w->extra2, texels * sizeof(float)),
                                               src->width, src->height, 1, NTP_F32);
    const bool fixed[2] = { false, false };
    ntp_height_options how = {
        .kernel = f->deep.origin.kernel, .z = NTP_Z_AUTO, .touch_unused = touch, .dx = 1, .dy = 1
    };
    border_choice found[2];
    ntp_height_result done = { .residual = -1 };
    if (heights_find_borders(found, w, &heights, src, &how, fixed, f->deep.seam,
                             (stretch) { READ_PERMILLE, 750 }) != NTP_OK)
        return -1;
    how.border_x = found[0].border;
    how.border_y = found[1].border;
    how.measure = 1;
    const ntp_status status = heights_solve(w, &heights, src, &how, (stretch) { 750, 1000 }, &done);
    return status == NTP_OK ? done.residual : -1;
}

bool look_deeper(source *s, facts *f, int y, ntpio_error *error)
{
    ntp_image whole;
    void *data;
    const uint32_t touch = touch_for(&f->stats, f->encoding);
    const uint64_t texels = (uint64_t) s->view.width * (uint64_t) s->view.height;
    if (!is_tangent_space(f) || texels > MOST_TEXELS || !whole_fits(s))
        return true;
    s->read_permille = READ_PERMILLE;
    if (!source_rewind(s, error))
        return false;
    const bool ok = whole_read(s, &whole, &data, error);
    if (ok) {
        ntp_const_image src = ntp_image_as_const(&whole);
        src.y = NTP_Y_UP;
        src.y = choose_y(f, &src, touch, y);
        ntp_find_origin(&f->deep.origin, &src, touch);
        ntp_find_seams(&f->deep.seam[0], &f->deep.seam[1], &src, touch);
        /* Slopes beside a hole are of heights that are not known: no fit tells anything there. */
        f->deep.residual = f->stats.unused == 0 ? fit_heights(s->w, f, &src, touch) : -1;
        f->deep.y = src.y;
        f->deep.known = true;
    }
    free(data);
    return ok && interrupted_by == 0;
}
