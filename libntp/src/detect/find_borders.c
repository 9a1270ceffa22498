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

#include <string.h>

enum {
    WHOLE = 128, /* a side of up to so many lines is one band */
    LINES = 64,  /* of a band: so many texels at two edges tell their rms to a twentieth */
    SHARE = 32,  /* a large texture has bands of this share of its lines */
    STARTS = 4,  /* places for a band begin at this share of its lines */
    LEAST_SIDE = 16
};

/* What is tried where the edges show no border.  A border takes the place of the one before if it
 * fits clearly better. */
static const ntp_border tried[] = { NTP_BORDER_WRAP, NTP_BORDER_EXTRAPOLATE, NTP_BORDER_CLAMP };
enum { TRIED = sizeof tried / sizeof *tried };
static const double clearly_better = 0.99;
/* It is not tried if the normals at the edges are so many times as far off as with the best one. */
static const double far_off = 2;
/* In levels of 8 bit: where normals fit so well, no border is wrong. */
static const double fits_well = 0.4;
/* And where texels at the edges do, whose rounding counts twice: 0.41 levels. */
static const double edges_fit = 0.8;

/* The share of a solution in the progress.  Two with wrap come first. */
static const double step = 0.5 / (2 + TRIED);

typedef struct search {
    const ntp_hooks *hooks;
    double from; /* the share of the work that is done */
    ntp_const_image src;
    ntp_height_options how;
    ntp_image heights;
    void *rest;
    size_t rest_size;
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

static ntp_height_options plain(const ntp_height_options *how)
{
    ntp_height_options first = *how;
    first.refine = first.detrend = 0;
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
    if (!lay_out(&s, &rows, width, band_lines(height, how->kernel), parts) ||
        !lay_out(&s, &columns, band_lines(width, how->kernel), height, parts))
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
    ntp_status status = ntp_height_from_normals(&s->heights, &s->src, &s->how, s->rest,
                                                s->rest_size, &hooks, &result);
    s->from += step;
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

/* Tries other borders than the free one, which leaves `least`. */
static ntp_status try_borders(ntp_border_fit *fit, search *s, double least, bool down)
{
    const double most = far_off * least_error(fit);
    for (int32_t i = 0; i < TRIED; i++) {
        double residual;
        /* heights of a texture that tiles may drift, which says nothing about wrap */
        if (tried[i] != NTP_BORDER_WRAP && fit->error[tried[i]] > most)
            continue;
        NTP__TRY(solve(&residual, s, tried[i], down));
        if (residual < 0 || residual >= clearly_better * least)
            continue;
        least = residual;
        fit->border = tried[i];
        fit->decided = 1;
    }
    return NTP_OK;
}

/* Does the axis wrap, if the texture tiles along it?  In a large texture only the edges show it. */
static ntp_status fits_wrapped(bool *fits, search *s, bool down)
{
    const ntp_const_image made = ntp_image_as_const(&s->heights);
    ntp_border_fit edges;
    double residual;
    s->from = down ? step : 0;
    NTP__TRY(solve(&residual, s, NTP_BORDER_WRAP, down));
    NTP__TRY(ntp_find_border(&edges, &s->src, &made, &s->how, down, 1));
    *fits = residual >= 0 && residual <= fits_well && edges.error[NTP_BORDER_WRAP] <= edges_fit;
    return NTP_OK;
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
    return fit->decided || residual <= fits_well ? NTP_OK : try_borders(fit, s, residual, down);
}

/* -------------------------------------------------------------------------------- public */

/* Cuts the band of an axis, and lays out its memory. */
static void start(search *s, const ntp_const_image *src, const ntp_height_options *how, bool down,
                  bool both, void *scratch, const ntp_hooks *hooks)
{
    ntp__scratch memory = { scratch, 0 };
    memset(s, 0, sizeof *s);
    s->hooks = hooks;
    s->how = plain(how);
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
    const ntp_border given[2] = { how->border_x, how->border_y };
    for (int32_t i = 0; i < 2; i++) {
        guess(&fit[i], how, wraps[i] != 0);
        if (!open[i])
            fit[i].border = given[i];
    }
    bool direct = how->method == NTP_HEIGHT_AUTO || how->method == NTP_HEIGHT_POISSON_DCT;
    if (!direct || how->mask != NULL || how->kernel == NTP_KERNEL_BAKED || size == 0 ||
        src->width < LEAST_SIDE || src->height < LEAST_SIDE)
        return NTP_OK;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 || scratch_size < size)
        return NTP_ERR_SCRATCH;
    search s[2];
    bool all_wrap = true;
    for (int32_t i = 0; i < 2; i++) {
        if (open[i])
            start(&s[i], src, how, i == 1, open[1 - i] != 0, scratch, hooks);
        all_wrap = all_wrap && (!open[i] || wraps[i]);
    }
    for (int32_t i = 0; i < 2 && all_wrap; i++) {
        if (open[i])
            NTP__TRY(fits_wrapped(&all_wrap, &s[i], i == 1));
    }
    for (int32_t i = 0; i < 2 && !all_wrap; i++) {
        if (open[i])
            NTP__TRY(find(&fit[i], &s[i], wraps[i] != 0, i == 1));
    }
    return NTP_OK;
}
