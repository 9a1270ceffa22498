/* SPDX-License-Identifier: MIT */
/*
 * find_borders.c - the borders of both axes of a texture, from bands of it
 *
 * The border of an axis shows at the two edges, and bends heights near them.  So a band of lines
 * that reach from edge to edge tells it, at a small share of what the whole texture costs.  The
 * band is cut out of the texture, so its long sides have free borders and do not count.
 */
#include "base/scratch.h"
#include "base/view.h"
#include "detect/ends_meet.h"
#include "detect/level_edges.h"

#include <math.h>
#include <string.h>

enum {
    WHOLE = 128, /* a side of up to so many lines is one band */
    LINES = 32,  /* of a band: so many texels at two edges tell their rms to a tenth */
    SHARE = 64,  /* a large texture has bands of this share of its lines */
    STARTS = 4,  /* places for a band begin at this share of its lines */
    LEAST_SIDE = 16
};

/* What is tried where the edges show no border.  A border takes the place of the one before if it
 * fits clearly better. */
static const ntp_border tried[] = { NTP_BORDER_WRAP, NTP_BORDER_EXTRAPOLATE, NTP_BORDER_CLAMP };
enum { TRIED = sizeof tried / sizeof *tried };
static const double clearly_better = 0.99;
/* It is certain only where all others fit so much worse: tiles had another one ahead by 1.1 %. */
static const double surely_better = 0.97;
/* Smooth ground goes on at an edge as it did before it, so of damaged tiles the edges fit this border,
 * and wrap at most 3.7 times as badly. */
static const double as_smooth = 5;
/* It is not tried if the normals at the edges are so many times as far off as with the best one. */
static const double far_off = 2;
/* Nor if normals at the edges of heights that were made with the best one are so many times as far off
 * by it. */
static const double confirming = 1.4;
/* In levels of 8 bit: where normals fit so well, no border is wrong. */
static const double fits_well = 0.4;
/* Of edges that fit wrap so well beside the best border, in levels too, heights at both ends tell more. */
static const double as_well = 1.25, as_well_levels = 0.05;
/* And where texels at the edges do, whose rounding counts twice: 0.41 levels. */
static const double edges_fit = 0.8;
/* Texels at the edges of a damaged texture fit wrap if they are no further off than so many times
 * the others, and every other border is so many times as far off. */
static const double edges_alike = 1.3, edges_differ = 1.5;
/* Nor is wrap where normals are so many times as far off.  Of damaged tiles it was at most 4.4. */
static const double most_off_wrap = 6;

/* The share of a solution in the progress.  Two with wrap come first. */
static const double step = 0.5 / (2 + TRIED);

typedef struct search {
    const ntp_hooks *hooks;
    double from; /* the share of the work that is done */
    const ntp_const_image *whole;
    ntp_const_image src; /* the band */
    ntp_height_options how;
    ntp_decode asked; /* by the caller, */
    ntp_z asked_z;    /* as is this */
    ntp__reading *reading;
    ntp_image heights;
    void *rest;
    size_t rest_size;
    double wrapped; /* the residual with wrap; below 0: not known yet, or it cannot be solved */
    ntp__ends ends;
} search;

/* The lines of a band across `side` lines.  A mirrored transform is quick for lengths like 65. */
static int32_t band_lines(int32_t side, ntp_kernel kernel)
{
    int32_t lines = LINES;
    while (2 * lines <= side / SHARE)
        lines *= 2;
    return side <= WHOLE ? side : lines + (ntp_free_border(kernel) == NTP_BORDER_MIRROR);
}

/* ------------------------------------------------------------------------ working memory */

static ntp_height_options with_borders(const ntp_height_options *how, ntp_border x, ntp_border y)
{
    ntp_height_options with = *how;
    with.border_x = x;
    with.border_y = y;
    return with;
}

/* The most that any pair of borders takes. */
static size_t solver_size(const ntp_height_options *how, int32_t width, int32_t height,
                          int32_t parts)
{
    size_t most = 0;
    for (int32_t b = 0; b < NTP_BORDERS * NTP_BORDERS; b++) {
        ntp_height_options with =
            with_borders(how, (ntp_border) (b / NTP_BORDERS), (ntp_border) (b % NTP_BORDERS));
        with.residual_scope = NTP_RESIDUAL_ALL;
        size_t size = ntp_height_scratch_size(&with, width, height, parts);
        most = size > most ? size : most;
    }
    return most;
}

/* Baked normals show borders as central slopes do: no kernel makes them again. */
static ntp_height_options plain(const ntp_height_options *how)
{
    ntp_height_options first = *how;
    first.refine = first.detrend = 0;
    if (first.kernel == NTP_KERNEL_BAKED)
        first.kernel = NTP_KERNEL_CENTRAL;
    if (first.kernel == NTP_KERNEL_CENTRAL) /* smooth heights of damaged texels hide the edges */
        first.prior = NTP_PRIOR_NONE;
    return first;
}

/* Lays out the memory for the bands of one axis, or measures it where memory->base is NULL. */
static bool lay_out(search *s, ntp__scratch *memory, int32_t width, int32_t height, int32_t parts)
{
    size_t texels = (size_t) width * (size_t) height;
    s->rest_size = solver_size(&s->how, width, height, parts);
    void *heights = ntp__take(memory, texels * sizeof(float));
    s->heights = ntp_image_packed(heights, width, height, 1, NTP_TYPE_F32);
    s->rest = ntp__take(memory, s->rest_size);
    return s->rest_size > 0;
}

size_t ntp_find_borders_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                                     int32_t parts)
{
    ntp__scratch rows = { NULL, 0 }, columns = { NULL, 0 };
    search s;
    memset(&s, 0, sizeof s);
    if (how == NULL || width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE)
        return 0;
    s.how = plain(how);
    if (!lay_out(&s, &rows, width, band_lines(height, s.how.kernel), parts) ||
        !lay_out(&s, &columns, band_lines(width, s.how.kernel), height, parts))
        return 0;
    return rows.used > columns.used ? rows.used : columns.used;
}

/* -------------------------------------------------------------------------------- bands */

/* How far the texels at both ends of a line are from flat, in squares of levels. */
static double slope_at_ends(const ntp_const_image *turned, int32_t line)
{
    ntp__block block;
    double sum = 0, m = ntp__max(turned->type);
    for (int32_t end = 0; end < 2; end++) {
        ntp__unpack(&block, turned, end == 0 ? 0 : turned->width - 1, line, 1);
        double x = 2 * block.c[0][0] - m, y = 2 * block.c[1][0] - m;
        sum += x * x + y * y;
    }
    return sum;
}

/* The first line of the band with the most slope at the edges. */
static int32_t choose_band(const ntp_const_image *turned, int32_t lines)
{
    int32_t best = 0;
    double most = -1;
    for (int32_t first = 0; first + lines <= turned->height; first += lines / STARTS) {
        double sum = 0;
        /* every other line will do */
        for (int32_t i = 0; i < lines; i += 2)
            sum += slope_at_ends(turned, first + i);
        if (sum > most) {
            most = sum;
            best = first;
        }
    }
    return best;
}

/* Cuts the band for an axis out of src; false: it is all of src. */
static bool cut_band(search *s, const ntp_const_image *src, ntp_kernel kernel, bool down)
{
    const ntp_const_image turned = down ? ntp__transposed(src) : *src;
    int32_t lines = band_lines(turned.height, kernel);
    int32_t first = lines < turned.height ? choose_band(&turned, lines) : 0;
    s->src = *src;
    s->src.data = ntp__at(src, down ? first : 0, down ? 0 : first);
    *(down ? &s->src.width : &s->src.height) = lines;
    return lines < turned.height;
}

/* ----------------------------------------------------------------------------- solutions */

static int32_t report(void *user, double share)
{
    const search *s = user;
    return s->hooks->progress(s->hooks->user, s->from + step * share);
}

static void share_out(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    const search *s = user;
    s->hooks->parallel_for(s->hooks->user, count, task, work);
}

/* Solves the band with this border, and gives the residual in levels of 8 bit; below 0: it cannot
 * be solved. */
static ntp_status solve(double *residual, search *s, ntp_border border, bool down)
{
    ntp_height_result result = { .residual = -1 };
    ntp_hooks hooks = { .user = s };
    if (s->hooks != NULL) {
        hooks.progress = s->hooks->progress != NULL ? report : NULL;
        hooks.parallel_for = s->hooks->parallel_for != NULL ? share_out : NULL;
        hooks.parts = s->hooks->parts;
    }
    *(down ? &s->how.border_y : &s->how.border_x) = border;
    ntp_height_options how = s->how;
    if (how.decode == NTP_DECODE_NEUTRAL) /* only AUTO finds how far flat ground is from zero */
        how.decode = s->asked;
    ntp_status status =
        ntp_height_from_normals(&s->heights, &s->src, &how, s->rest, s->rest_size, &hooks, &result);
    s->from += step;
    /* The next solution of this band need not ask the texels again; but for how small z can be. */
    if (status == NTP_OK) {
        s->how.decode = result.decode;
        s->how.z = result.z == NTP_Z_DERIVED ? NTP_Z_DERIVED : s->how.z;
    }
    *residual = s->src.type == NTP_TYPE_U8 ? result.residual : result.residual / 257;
    if (status == NTP_ERR_ARGUMENT || status == NTP_ERR_FORMAT) {
        *residual = -1;
        return NTP_OK;
    }
    return status;
}

/* The error of the border that comes nearest to the normals at the edges. */
static double least_error(const ntp_border_fit *fit)
{
    double least = -1;
    for (int32_t b = 0; b < NTP_BORDERS; b++) {
        if (fit->error[b] >= 0 && (least < 0 || fit->error[b] < least))
            least = fit->error[b];
    }
    return least;
}

/* Do heights that were made with the border of the fit give the normals at the edges back clearly
 * better by it than by another border? */
static ntp_status confirms(bool *confirmed, const ntp_border_fit *fit, const search *s,
                           ntp_border other, bool down)
{
    const ntp_const_image made = ntp_image_as_const(&s->heights);
    ntp_border_fit edges;
    NTP__TRY(ntp_find_border(&edges, &s->src, &made, &s->how, down, 0));
    double own = edges.error[fit->border];
    *confirmed = own >= 0 && edges.error[other] > confirming * own;
    return NTP_OK;
}

/* Is there reason not to try this border after `now`?  over: times as far off at the edges as the best. */
static bool is_ruled_out(ntp_border border, ntp_border now, const search *s, double over,
                         bool wraps)
{
    if (border == NTP_BORDER_WRAP)
        return !wraps && (over > most_off_wrap || s->ends == NTP__ENDS_DIFFER);
    /* Steps at the edges, which heights with a mirror hide, fit wrap for want of anything else. */
    return over > far_off && (now != NTP_BORDER_WRAP || border != NTP_BORDER_EXTRAPOLATE);
}

/* Tries other borders than the free one, which leaves `least`. */
static ntp_status try_borders(ntp_border_fit *fit, search *s, double least, bool wraps, bool down)
{
    const double off = least_error(fit);
    const bool mirrored =
        s->how.kernel != NTP_KERNEL_FORWARD && ntp__edges_are_level(s->whole, down);
    double next = HUGE_VAL; /* of those that were not taken the least residual */
    for (int32_t i = 0; i < TRIED; i++) {
        double residual = s->wrapped;
        bool confirmed = false;
        /* The slopes close, and so do the heights. */
        if (wraps && fit->border == NTP_BORDER_WRAP)
            break;
        const bool wrap = tried[i] == NTP_BORDER_WRAP;
        if ((mirrored && !wrap) ||
            is_ruled_out(tried[i], fit->border, s, fit->error[tried[i]] / off, wraps)) {
            if (wrap ? s->ends != NTP__ENDS_DIFFER : mirrored)
                next = 0; /* a lean that damage made may be all that speaks against it */
            continue;
        }
        if (fit->border == NTP_BORDER_EXTRAPOLATE) /* the heights are those of it */
            NTP__TRY(confirms(&confirmed, fit, s, tried[i], down));
        if (confirmed)
            continue;
        if (!wrap || residual < 0)
            NTP__TRY(solve(&residual, s, tried[i], down));
        if (residual < 0)
            continue;
        if (residual < clearly_better * least) {
            double before = least;
            least = residual;
            residual = before;
            fit->border = tried[i];
        }
        next = residual < next ? residual : next;
        fit->decided =
            fit->border != ntp_free_border(s->how.kernel) && least < surely_better * next;
    }
    return NTP_OK;
}

/* Do the normals at the edges show wrap?  The heights were made with it and have this residual. */
static bool shows_wrap(const ntp_border_fit *edges, double residual)
{
    double wrap = edges->error[NTP_BORDER_WRAP];
    if (residual < 0 || wrap < 0)
        return false;
    if (residual <= fits_well && wrap <= edges_fit)
        return true;
    for (int32_t b = 0; b < NTP_BORDERS; b++) {
        if (b != NTP_BORDER_WRAP && edges->error[b] >= 0 && edges->error[b] < edges_differ * wrap)
            return false;
    }
    return wrap <= edges_alike * residual;
}

/* Does the axis wrap, if the texture tiles along it?  In a large texture only the edges show it.
 * Heights that were made with wrap do not drift. */
static ntp_status fits_wrapped(bool *fits, search *s, bool down)
{
    const ntp_const_image made = ntp_image_as_const(&s->heights);
    ntp_border_fit edges;
    s->from = down ? step : 0;
    NTP__TRY(solve(&s->wrapped, s, NTP_BORDER_WRAP, down));
    NTP__TRY(ntp_find_border(&edges, &s->src, &made, &s->how, down, 0));
    *fits = shows_wrap(&edges, s->wrapped);
    return NTP_OK;
}

/* May wrap be the better guess?  Blue that is something else than z makes odd lengths without damage. */
static bool may_guess(const ntp_height_options *solved)
{
    bool square = !(solved->dx < solved->dy || solved->dx > solved->dy);
    return square && solved->method == NTP_HEIGHT_AUTO && solved->z != NTP_Z_DERIVED;
}

/* Do edges fit wrap as well as the border of the fit, as flat ones do? */
static bool wraps_as_well(const ntp_border_fit *fit)
{
    double wrap = fit->error[NTP_BORDER_WRAP];
    return fit->border != NTP_BORDER_WRAP && wrap >= 0 &&
           wrap <= as_well * least_error(fit) + as_well_levels;
}

static ntp__ends find_ends(const search *s, bool down)
{
    ntp_height_options how = s->how;
    how.decode = s->asked;
    how.z = s->asked_z;
    return may_guess(&how) ? ntp__find_ends(s->reading, s->whole, &how, down) : NTP__ENDS_UNTOLD;
}

static ntp_status find(ntp_border_fit *fit, search *s, bool wraps, bool down)
{
    const ntp_const_image made = ntp_image_as_const(&s->heights);
    double residual;
    s->from = 2 * step + (down ? (1 + TRIED) * step : 0);
    NTP__TRY(solve(&residual, s, ntp_free_border(s->how.kernel), down));
    if (residual < 0)
        return NTP_OK;
    NTP__TRY(ntp_find_border(fit, &s->src, &made, &s->how, down, wraps));
    if (residual <= fits_well && !wraps_as_well(fit))
        return NTP_OK;
    s->ends = find_ends(s, down);
    if (s->ends == NTP__ENDS_MEET) {
        fit->border = NTP_BORDER_WRAP;
        fit->decided = 0;
        return NTP_OK;
    }
    if (residual <= fits_well)
        return NTP_OK;
    if (!fit->decided)
        return try_borders(fit, s, residual, wraps, down);
    const double *error = fit->error;
    fit->decided = fit->border != NTP_BORDER_EXTRAPOLATE || error[NTP_BORDER_WRAP] < 0 ||
                   error[NTP_BORDER_WRAP] > as_smooth * error[NTP_BORDER_EXTRAPOLATE];
    return NTP_OK;
}

/* -------------------------------------------------------------------------------- public */

/* Cuts the band of an axis, and lays out its memory. */
static void start(search *s, const ntp_const_image *src, const ntp_height_options *how, bool down,
                  bool both, void *scratch, const ntp_hooks *hooks)
{
    ntp__scratch memory = { scratch, 0 };
    memset(s, 0, sizeof *s);
    s->wrapped = -1;
    s->hooks = hooks;
    s->whole = src;
    s->how = *how;
    s->asked = how->decode;
    s->asked_z = how->z;
    bool free = cut_band(s, src, how->kernel, down) || both;
    if (free)
        *(down ? &s->how.border_x : &s->how.border_y) = ntp_free_border(how->kernel);
    s->how.residual_scope = !free  ? NTP_RESIDUAL_ALL
                            : down ? NTP_RESIDUAL_INSIDE_X
                                   : NTP_RESIDUAL_INSIDE_Y;
    lay_out(s, &memory, s->src.width, s->src.height,
            hooks != NULL && hooks->parts > 0 ? hooks->parts : 1);
}

/* What is the answer where nothing can be solved. */
static void guess(ntp_border_fit *fit, const ntp_height_options *how, bool wraps)
{
    fit->border = wraps ? NTP_BORDER_WRAP : ntp_free_border(how->kernel);
    fit->decided = wraps;
    for (int32_t b = 0; b < NTP_BORDERS; b++)
        fit->error[b] = -1;
}

/* Is no texel further from level along this axis than by rounding? */
static bool is_level(const ntp_const_image *src, int32_t axis)
{
    ntp__block block;
    int32_t low = ntp__max(src->type) / 2, sloped = src->type == NTP_TYPE_F32;
    for (int32_t y = 0; y < src->height && !sloped; y++) {
        for (int32_t x = 0; x < src->width && !sloped; x += NTP__BLOCK) {
            int32_t n = src->width - x < NTP__BLOCK ? src->width - x : NTP__BLOCK;
            ntp__unpack(&block, src, x, y, n);
            for (int32_t i = 0; i < n; i++)
                sloped |= (block.c[axis][i] != low) & (block.c[axis][i] != low + 1);
        }
    }
    return !sloped;
}

ntp_status ntp_find_borders(ntp_border_fit fit[2], const ntp_const_image *src,
                            const ntp_height_options *how, const int32_t open[2],
                            const int32_t wraps[2], void *scratch, size_t scratch_size,
                            const ntp_hooks *hooks)
{
    if (fit == NULL || how == NULL || open == NULL || wraps == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    int32_t parts = hooks != NULL && hooks->parts > 0 ? hooks->parts : 1;
    size_t size = ntp_find_borders_scratch_size(how, src->width, src->height, parts);
    ntp_height_options with = plain(how);
    ntp_border *border[2] = { &with.border_x, &with.border_y };
    bool asked[2];
    for (int32_t i = 0; i < 2; i++) {
        /* Where nothing slopes along an axis, it tiles, whatever made it. */
        bool level = open[i] && is_level(src, i);
        guess(&fit[i], how, level || wraps[i] != 0);
        asked[i] = open[i] && !level;
        if (!open[i])
            fit[i].border = *border[i];
        else if (level)
            *border[i] = NTP_BORDER_WRAP;
    }
    bool direct = how->method == NTP_HEIGHT_AUTO || how->method == NTP_HEIGHT_POISSON_DCT;
    if (!direct || how->mask != NULL || size == 0 || src->width < LEAST_SIDE ||
        src->height < LEAST_SIDE)
        return NTP_OK;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 || scratch_size < size)
        return NTP_ERR_SCRATCH;
    search s[2];
    ntp__reading reading = { .known = false };
    bool all_wrap = true;
    for (int32_t i = 0; i < 2; i++) {
        if (asked[i])
            start(&s[i], src, &with, i == 1, asked[1 - i], scratch, hooks);
        s[i].reading = &reading;
        all_wrap = all_wrap && (!asked[i] || wraps[i]);
    }
    for (int32_t i = 0; i < 2 && all_wrap; i++) {
        if (asked[i])
            NTP__TRY(fits_wrapped(&all_wrap, &s[i], i == 1));
    }
    for (int32_t i = 0; i < 2 && !all_wrap; i++) {
        if (asked[i])
            NTP__TRY(find(&fit[i], &s[i], wraps[i] != 0, i == 1));
    }
    return NTP_OK;
}
