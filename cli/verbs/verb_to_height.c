/* SPDX-License-Identifier: MIT */
/*
 * verb_to_height.c - ntp to-height: heightfields from normals
 *
 * The texture and its heights are held whole.  Heights are floats: 4 bytes for each texel beside
 * the input, and about 40 more with --method weighted.  The solver uses all threads that other
 * files leave.
 */
#include "verbs/verb_to_height.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "examine/samples.h"
#include "report/report.h"
#include "surface/height_range.h"
#include "surface/solve_heights.h"
#include "verbs/verbs.h"
#include "write/side_image.h"
#include "write/whole_image.h"

enum {
    BLOCK_ROWS = 64,
    TEXTS = 2 /* scale and offset */
};

static const char SCALE_KEY[] = "Height scale", OFFSET_KEY[] = "Height offset";

/* ------------------------------------------------------------------------- options */

static bool read_seeds(ntp_height_options *how, const char *list)
{
    const char *at = list;
    how->use_seeds = list != NULL;
    for (int i = 0; list != NULL && i < 4; i++) {
        char *end = NULL;
        how->seeds[i] = strtod(at, &end);
        const size_t length = strspn(at, "0123456789.eE+-");
        if (length == 0 || end != at + length || !isfinite(how->seeds[i]) ||
            *end != (i < 3 ? ',' : 0)) {
            complain("--seeds %s: expected four numbers with commas between them", list);
            return false;
        }
        at = end + 1;
    }
    return true;
}

static bool is_free(int border)
{
    return border != AUTO && border != NTP_BORDER_WRAP;
}

/* Reports options that contradict each other, whatever the input is. */
static bool agree(const to_height_settings *set)
{
    const ntp_height_method method = set->how.method;
    const bool any_wrap = set->border_x == NTP_BORDER_WRAP || set->border_y == NTP_BORDER_WRAP;
    if (method == NTP_HEIGHT_FRANKOT_CHELLAPPA &&
        (is_free(set->border_x) || is_free(set->border_y)))
        complain("--method frankot-chellappa is for textures that tile: the border is wrap");
    else if (method == NTP_HEIGHT_POISSON_DCT && any_wrap)
        complain("--method poisson-dct is for textures that do not tile: the border is not wrap");
    else if (method != NTP_HEIGHT_TELESCOPING && set->how.use_seeds)
        complain("--seeds needs --method telescoping");
    else if (method != NTP_HEIGHT_TELESCOPING && set->how.equalize)
        complain("--equalize needs --method telescoping");
    else if (method == NTP_HEIGHT_TELESCOPING && set->how.refine > 0)
        complain("--refine needs a method of least squares, not --method telescoping");
    else if (set->mask_file != NULL && method != NTP_HEIGHT_AUTO && method != NTP_HEIGHT_WEIGHTED)
        complain("--mask needs --method weighted");
    else
        return true;
    return false;
}

/* --depth, and the ending of a file that -o names. */
static bool read_depth(to_height_settings *set, const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    const char *ending = output != NULL ? name_ending(output) : "";
    const bool given = option_given(o, OPT_DEPTH), pfm = strcasecmp(ending, ".pfm") == 0;
    set->is_float = given ? option_integer(o, OPT_DEPTH) == 1 : pfm;
    if (given && !set->is_float && pfm)
        complain("-o %s: PFM holds floats; leave out --depth 16", output);
    else if (set->is_float && (strcasecmp(ending, ".png") == 0 || strcasecmp(ending, ".tga") == 0))
        complain("-o %s: --depth float writes .pfm", output);
    else if (strcasecmp(ending, ".tga") == 0)
        complain("-o %s: TGA holds 8 bits, too few for heights; use .png or .pfm", output);
    else
        return true;
    return false;
}

static int border_of(const options *o, option_id axis)
{
    return (int) option_integer(o, option_given(o, axis) ? axis : OPT_BORDER) - 1;
}

static bool read_settings(to_height_settings *set, const options *o)
{
    *set = (to_height_settings) { .kernel = (int) option_integer(o, OPT_KERNEL) - 1,
                                  .border_x = border_of(o, OPT_BORDER_X),
                                  .border_y = border_of(o, OPT_BORDER_Y),
                                  .mask_file = option_string(o, OPT_MASK),
                                  .limits = limits_from(o) };
    set->y = green_told(o, OPT_Y);
    set->how.method = (ntp_height_method) option_integer(o, OPT_METHOD);
    set->how.decode = (ntp_decode) option_integer(o, OPT_DECODE);
    set->how.z = (ntp_z) option_integer(o, OPT_Z);
    set->how.refine = (int32_t) option_integer(o, OPT_REFINE);
    set->how.detrend = option_given(o, OPT_DETREND);
    set->how.equalize = option_given(o, OPT_EQUALIZE);
    set->how.residual_scope = NTP_RESIDUAL_ALL;
    set->clip = option_number(o, OPT_CLIP);
    set->how.dx = option_number(o, OPT_DX);
    set->how.dy = option_number(o, OPT_DY);
    if (!(set->how.dx > 0) || !(set->how.dy > 0)) {
        complain("--dx and --dy must be greater than 0");
        return false;
    }
    return read_seeds(&set->how, option_string(o, OPT_SEEDS)) && read_depth(set, o) && agree(set);
}

/* Why --refine is impossible here; NULL if it is possible. */
static const char *why_not_refined(const to_height_state *st)
{
    if (st->how.refine == 0)
        return NULL;
    if (st->src.type == NTP_TYPE_F32)
        return "--refine is for textures of 8 and 16 bits: floats are not rounded";
    if (st->how.method == NTP_HEIGHT_WEIGHTED && st->how.detrend)
        return "--refine and --detrend do not go together with --method weighted";
    return NULL;
}

static bool cannot(const production *p, ntp_status status, ntpio_error *error)
{
    const to_height_state *st = p->state;
    const char *refined = why_not_refined(st);
    char why[200];
    if (status == NTP_ERR_CANCELLED)
        return library_error(&p->s, status, error);
    if (status == NTP_ERR_NOT_CONVERGED)
        return wrong_use(
            p,
            "the weighted least squares did not reach their tolerance, as happens where long "
            "paths lead around holes; --method poisson-dct, without --mask, takes holes for flat",
            error);
    if (refined != NULL)
        return wrong_use(p, refined, error);
    snprintf(why, sizeof why, "kernel %s with borders %s and %s cannot be solved by this method",
             ntp_kernel_name(st->how.kernel), ntp_border_name(st->how.border_x),
             ntp_border_name(st->how.border_y));
    return wrong_use(p, why, error);
}

/* -------------------------------------------------------------------------- writing */

/* A number of nine digits: what is printed is exactly what was used. */
static double nine_digits(double v, bool up)
{
    char digits[40];
    snprintf(digits, sizeof digits, "%.9g", v);
    const double read = strtod(digits, NULL);
    if (!up || read >= v)
        return read;
    snprintf(digits, sizeof digits, "%.9g", v * (1 + 4e-9));
    return strtod(digits, NULL);
}

/* Clips the heights, and finds out whether a few of them take most of the range. */
static void choose_range(to_height_state *st, const to_height_settings *set,
                         const ntp_image *heights)
{
    float *all = heights->data;
    const size_t texels = (size_t) heights->width * (size_t) heights->height;
    const bool holes = st->result.holes > 0;
    if (set->clip > 0) {
        const height_range range = heights_middle(all, texels, holes, set->clip);
        st->clipped = heights_clip(all, texels, range);
        st->result.min = (double) range.least;
        st->result.max = (double) range.greatest;
    }
    const double all_of_it = st->result.max - st->result.min;
    const height_range middle = heights_middle(all, texels, holes, 1);
    st->middle_share =
        all_of_it > 0 ? ((double) middle.greatest - (double) middle.least) / all_of_it : 1;
}

/* height = offset + scale * value; the value written is in 0..1. */
static void choose_scale(to_height_state *st, bool is_float)
{
    st->offset = is_float ? 0 : nine_digits(st->result.min, false);
    st->scale = is_float ? 1 : nine_digits(st->result.max - st->offset, true);
    if (st->scale < 0) /* all heights alike, and rounded up */
        st->scale = 0;
}

static void to_levels(uint16_t *levels, const float *heights, size_t count,
                      const to_height_state *st)
{
    for (size_t i = 0; i < count; i++) {
        const double v =
            st->scale > 0 ? ((double) heights[i] - st->offset) / st->scale * 65535 + 0.5 : 0;
        levels[i] = v >= 65535 ? 65535 : v >= 0 ? (uint16_t) v : 0;
    }
}

static char *number_text(double v)
{
    text t = { 0 };
    text_addf(&t, "%.9g", v);
    char *string = copy_string(text_string(&t));
    text_free(&t);
    return string;
}

static bool is_ours(const char *key)
{
    return strcmp(key, SCALE_KEY) == 0 || strcmp(key, OFFSET_KEY) == 0;
}

/* The texts of the input without its scale and offset, and the new ones. */
static ntpio_text *all_texts(const ntpio_info *info, const to_height_state *st, size_t *count)
{
    ntpio_text *texts = need(calloc(info->text_count + TEXTS, sizeof *texts));
    *count = 0;
    for (size_t i = 0; i < info->text_count; i++) {
        if (!is_ours(info->texts[i].key))
            texts[(*count)++] = info->texts[i];
    }
    texts[(*count)++] =
        (ntpio_text) { .key = (char *) (uintptr_t) SCALE_KEY, .value = number_text(st->scale) };
    texts[(*count)++] =
        (ntpio_text) { .key = (char *) (uintptr_t) OFFSET_KEY, .value = number_text(st->offset) };
    return texts;
}

static bool start(production *p, bool is_float, ntpio_error *error)
{
    const ntpio_info *info = p->s.info;
    size_t count = 0;
    ntpio_text *texts = all_texts(info, p->state, &count);
    ntpio_write_options shape = { .width = info->width,
                                  .height = info->height,
                                  .channels = 1,
                                  .sample_bytes = is_float ? 4 : 2,
                                  .copy_from = &p->f.info, /* which has no texts */
                                  .texts = texts,
                                  .text_count = count };
    p->writer = production_open(p, p->in->output, &shape, error);
    for (size_t i = 1; i <= TEXTS; i++)
        free(texts[count - i].value);
    free(texts);
    return p->writer != NULL;
}

static bool write_heights(production *p, const ntp_image *heights, bool is_float,
                          ntpio_error *error)
{
    const to_height_state *st = p->state;
    const size_t width = (size_t) heights->width;
    uint16_t *levels = is_float ? NULL : need(malloc(width * BLOCK_ROWS * sizeof *levels));
    bool ok = start(p, is_float, error);
    for (int32_t y = 0; ok && y < heights->height; y += BLOCK_ROWS) {
        const int32_t end = heights->height - y < BLOCK_ROWS ? heights->height : y + BLOCK_ROWS;
        const ntp_rect area = { 0, y, heights->width, end };
        const float *rows = (const float *) heights->data + (size_t) y * width;
        if (!is_float)
            to_levels(levels, rows, (size_t) (end - y) * width, p->state);
        ok = (interrupted_by == 0 || st->cut_short) &&
             production_write(p, is_float ? (const void *) rows : levels,
                              (ptrdiff_t) (width * (is_float ? 4 : 2)), &area, error);
    }
    free(levels);
    return ok;
}

/* ------------------------------------------------------------------------ production */

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    (void) shape;
    p->changes = true;
    return whole_begin(p, error);
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    (void) error;
    whole_add(p, area);
    return true;
}

/* Unused texels are holes, for which --method auto needs weights. */
static void choose_method(to_height_state *st, const production *p)
{
    const ntp_stats *s = &p->f.stats;
    if (st->how.method == NTP_HEIGHT_AUTO && s->unused > 0 && s->unused < s->texels)
        st->how.method = NTP_HEIGHT_WEIGHTED;
}

void to_height_see(production *p)
{
    to_height_state *st = p->state;
    st->src = ntp_image_as_const(&p->s.view);
    st->src.data = p->w->extra.data;
    st->src.ring_rows = 0;
    st->how.touch_unused = p->touch;
}

bool to_height_solve(production *p, ntp_image *heights, ntpio_error *error)
{
    const to_height_settings *set = p->m->settings;
    to_height_state *st = p->state;
    const ntp_image *view = &p->s.view;
    const size_t texels = (size_t) view->width * (size_t) view->height;
    st->how = set->how;
    st->how.touch_unused = p->touch;
    choose_method(st, p);
    unsigned char *plane = NULL;
    ntp_image mask = { 0 };
    ntp_const_image seen;
    bool ok = true;
    if (set->mask_file != NULL) {
        plane = need(malloc(texels * sample_size(NTP_TYPE_U16)));
        mask = ntp_image_packed(plane, view->width, view->height, 1, NTP_TYPE_U16);
        seen = ntp_image_as_const(&mask);
        st->how.mask = &seen;
        ok = side_image_read(plane, NTP_TYPE_U16, set->mask_file, &set->limits, p->s.info,
                             "texture", error);
    }
    *heights = ntp_image_packed(buffer_reserve(&p->w->extra2, texels * sizeof(float)), view->width,
                                view->height, 1, NTP_TYPE_F32);
    if (ok) {
        ntp_status status = to_height_choose(st, set, p->w);
        if (status == NTP_OK)
            status = heights_solve(p->w, heights, &st->src, &st->how,
                                   (stretch) { SOLVE_PERMILLE, 1000 }, &st->result);
        st->cut_short = status == NTP_ERR_CANCELLED && st->result.method != NTP_HEIGHT_AUTO;
        ok = status == NTP_OK || st->cut_short || cannot(p, status, error);
    }
    free(plane);
    st->how.mask = NULL;
    return ok;
}

static bool finish(production *p, ntpio_error *error)
{
    const to_height_settings *set = p->m->settings;
    to_height_state *st = p->state;
    ntp_image heights;
    if (!to_height_solve(p, &heights, error))
        return false;
    choose_range(st, set, &heights);
    choose_scale(st, set->is_float);
    return write_heights(p, &heights, set->is_float, error);
}

int to_height_run(const options *o)
{
    to_height_settings set;
    if (!read_settings(&set, o))
        return NTP_EXIT_USAGE;
    const maker m = { .o = o,
                      .forced = (int) option_integer(o, OPT_TYPE) - 1,
                      .plan = PLAN_AFTER_READING,
                      .read_permille = READ_PERMILLE,
                      .state_size = sizeof(to_height_state),
                      .settings = &set,
                      .knows = to_height_knows,
                      .begin = begin,
                      .rows = rows,
                      .finish = finish,
                      .describe = to_height_describe,
                      .warn = to_height_warn };
    return produce(&m);
}
