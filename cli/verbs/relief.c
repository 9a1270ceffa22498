/* SPDX-License-Identifier: MIT */
/*
 * relief.c - what ntp curvature and ntp occlusion share: heights or normals in, a gray map out
 */
#include "verbs/relief.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "options/names.h"
#include "report/report.h"
#include "surface/relief_scale.h"
#include "write/whole_image.h"

enum { DEPTH_FLOAT = 3 };

static const char HEIGHT_SCALE[] = "Height scale";

/* ------------------------------------------------------------------------- options */

static int border_of(const options *o, option_id axis)
{
    return (int) option_integer(o, option_given(o, axis) ? axis : OPT_BORDER) - 1;
}

static int solved_border(const options *o, option_id axis)
{
    return border_of(o, axis) == NTP_BORDER_WRAP ? (int) NTP_BORDER_WRAP : AUTO;
}

/* --depth, and the ending of a file that -o names. */
static bool read_depth(relief_settings *set, const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    const char *ending = output != NULL ? name_ending(output) : "";
    const bool pfm = strcasecmp(ending, ".pfm") == 0;
    set->depth = option_given(o, OPT_DEPTH) ? (int) option_integer(o, OPT_DEPTH) + 1
                 : pfm                      ? DEPTH_FLOAT
                                            : 0;
    if (pfm && set->depth != DEPTH_FLOAT)
        complain("-o %s: PFM holds floats; leave out --depth", output);
    else if (set->depth == DEPTH_FLOAT &&
             (strcasecmp(ending, ".png") == 0 || strcasecmp(ending, ".tga") == 0))
        complain("-o %s: --depth float writes .pfm", output);
    else if (set->depth == 2 && strcasecmp(ending, ".tga") == 0)
        complain("-o %s: TGA holds 8 bits; use .png", output);
    else
        return true;
    return false;
}

bool relief_read_settings(relief_settings *set, const options *o)
{
    const bool measures =
        option_given(o, OPT_SCALE) && strcmp(option_string(o, OPT_SCALE), "auto") == 0;
    *set = (relief_settings) { .solve = { .how = { .dx = 1, .dy = 1 },
                                          .kernel = AUTO,
                                          .border_x = solved_border(o, OPT_BORDER_X),
                                          .border_y = solved_border(o, OPT_BORDER_Y),
                                          .y = green_told(o, OPT_Y),
                                          .limits = limits_from(o) },
                               .scale = measures ? 1 : option_number(o, OPT_SCALE),
                               .scale_given = option_given(o, OPT_SCALE),
                               .measures = measures,
                               .blur = option_number(o, OPT_BLUR),
                               .border_x = border_of(o, OPT_BORDER_X),
                               .border_y = border_of(o, OPT_BORDER_Y),
                               .source = (ntp_height_source) option_integer(o, OPT_SOURCE) };
    return read_depth(set, o);
}

/* --------------------------------------------------------------------------- input */

bool relief_begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const relief_settings *set = p->m->settings;
    relief_state *st = p->state;
    const ntp_type own = p->s.view.type == NTP_TYPE_U8 ? NTP_TYPE_U8 : NTP_TYPE_U16;
    (void) shape;
    st->type = set->depth == 0 ? own : (ntp_type) (set->depth - 1);
    p->changes = true;
    return whole_begin(p, error);
}

bool relief_rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    (void) error;
    whole_add(p, area);
    return true;
}

bool relief_is_height(const production *p)
{
    return p->s.view.encoding == NTP_ENCODING_HEIGHT;
}

/* What ntp to-height stored; 0: nothing. */
static double stored_scale(const ntpio_info *info)
{
    for (size_t i = 0; i < info->text_count; i++) {
        if (strcmp(info->texts[i].key, HEIGHT_SCALE) == 0)
            return strtod(info->texts[i].value, NULL);
    }
    return 0;
}

static bool find_scale(production *p, text *why)
{
    const relief_settings *set = p->m->settings;
    relief_state *st = p->state;
    const double stored = stored_scale(p->s.info);
    st->scale = set->scale_given                 ? set->scale
                : p->s.view.type == NTP_TYPE_F32 ? 1
                : stored - stored == 0           ? stored
                                                 : 0;
    if (st->scale == 0 && set->scale_given)
        text_add(why, "with --scale 0 these heights are flat");
    else if (st->scale == 0)
        text_add(
            why,
            "these are heights; --scale says how many texels white rises above black, or auto");
    return st->scale != 0;
}

bool relief_knows(production *p, text *why)
{
    return relief_is_height(p) ? find_scale(p, why) : to_height_knows(p, why);
}

ntp_status relief_blur(const ntp_image *dst, const ntp_const_image *src, const production *p,
                       ntp_height_source channel, double sigma)
{
    const relief_state *st = p->state;
    const ntp_blur_options how = { .sigma = sigma,
                                   .weight = 1,
                                   .border_x = st->border_x,
                                   .border_y = st->border_y,
                                   .source = channel };
    const size_t size = ntp_height_blur_scratch_size(&how, src->width);
    void *scratch = need_aligned(size);
    const ntp_status status = ntp_height_blur(dst, src, &how, scratch, size);
    free_aligned(scratch);
    return status;
}

/* Floats in memory of the worker. */
static ntp_image floats(buffer *own, const ntp_image *view)
{
    const size_t bytes = (size_t) view->width * (size_t) view->height * sizeof(float);
    return ntp_image_packed(buffer_reserve(own, bytes), view->width, view->height, 1, NTP_TYPE_F32);
}

/* The input as it was read. */
static ntp_const_image input_of(const production *p)
{
    ntp_const_image src = ntp_image_as_const(&p->s.view);
    src.data = p->w->extra.data;
    src.ring_rows = 0;
    return src;
}

/* Heights in another channel than the first go there for this. */
static ntp_status look_at_edges(production *p, ntp_border found[2])
{
    const relief_settings *set = p->m->settings;
    const relief_state *st = p->state;
    ntp_const_image src = relief_is_height(p) ? input_of(p) : st->solve.src;
    ntp_status status = NTP_OK;
    if (relief_is_height(p) && set->source != NTP_HEIGHT_SOURCE_RED) {
        const ntp_image made = floats(&p->w->extra3, &p->s.view);
        status = relief_blur(&made, &src, p, set->source, 0);
        src = ntp_image_as_const(&made);
    }
    return status == NTP_OK ? ntp_relief_borders(&found[0], &found[1], &src) : status;
}

bool relief_choose_borders(production *p, ntpio_error *error)
{
    const relief_settings *set = p->m->settings;
    relief_state *st = p->state;
    ntp_border found[2] = { NTP_BORDER_WRAP, NTP_BORDER_WRAP };
    if (relief_is_height(p) && set->source == NTP_HEIGHT_SOURCE_ALPHA &&
        p->s.view.channels % 2 == 1)
        return wrong_use(p, "it has no alpha to take the height from", error);
    const bool asked = set->border_x == AUTO || set->border_y == AUTO;
    const ntp_status status = asked ? look_at_edges(p, found) : NTP_OK;
    st->border_x = set->border_x == AUTO ? found[0] : (ntp_border) set->border_x;
    st->border_y = set->border_y == AUTO ? found[1] : (ntp_border) set->border_y;
    return status == NTP_OK || library_error(&p->s, status, error);
}

/* A border that is not given is that of ntp from-height, so that both find the same scale. */
static ntp_border given_border(int asked)
{
    return asked == AUTO ? NTP_BORDER_WRAP : (ntp_border) asked;
}

/* With --scale auto: the scale that shows the relief. */
static bool measure(production *p, const ntp_const_image *heights, ntpio_error *error)
{
    const relief_settings *set = p->m->settings;
    relief_state *st = p->state;
    const ntp_normals_options how = { .scale = 1,
                                      .dx = 1,
                                      .dy = 1,
                                      .border_x = given_border(set->border_x),
                                      .border_y = given_border(set->border_y),
                                      .source = set->source };
    const ntp_status status = heights_suit_scale(heights, &how, &st->scale);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    if (st->scale == 0) /* flat */
        st->scale = 1;
    return true;
}

bool relief_heights(production *p, ntp_const_image *heights, ntpio_error *error)
{
    const relief_settings *set = p->m->settings;
    const relief_state *st = p->state;
    ntp_height_source channel = set->source;
    ntp_image made;
    *heights = input_of(p);
    if (!relief_is_height(p)) {
        if (!to_height_solve(p, &made, error) || st->solve.cut_short)
            return false;
        *heights = ntp_image_as_const(&made);
        channel = NTP_HEIGHT_SOURCE_RED;
    }
    if (relief_is_height(p) && set->measures && !measure(p, heights, error))
        return false;
    if (set->blur == 0 && channel == NTP_HEIGHT_SOURCE_RED)
        return true;
    made = floats(&p->w->extra3, &p->s.view);
    const ntp_status status = relief_blur(&made, heights, p, channel, set->blur);
    *heights = ntp_image_as_const(&made);
    return status == NTP_OK || library_error(&p->s, status, error);
}

/* -------------------------------------------------------------------------- output */

/* The texts of the input, but for those about heights and curvature. */
bool relief_start(production *p, const char *key, double number, ntpio_error *error)
{
    const ntpio_info *info = p->s.info;
    const relief_state *st = p->state;
    ntpio_text *texts = need(calloc(info->text_count + 1, sizeof *texts));
    text value = { 0 };
    size_t count = 0;
    for (size_t i = 0; i < info->text_count; i++) {
        if (strncmp(info->texts[i].key, "Height ", 7) != 0 &&
            strncmp(info->texts[i].key, "Curvature ", 10) != 0)
            texts[count++] = info->texts[i];
    }
    text_addf(&value, "%.9g", number);
    char *string = copy_string(text_string(&value));
    if (key != NULL)
        texts[count++] = (ntpio_text) { .key = (char *) (uintptr_t) key, .value = string };
    ntpio_write_options shape = { .width = info->width,
                                  .height = info->height,
                                  .channels = 1,
                                  .sample_bytes = 1 << st->type,
                                  .copy_from = &p->f.info, /* which has no texts */
                                  .texts = texts,
                                  .text_count = count };
    p->writer = production_open(p, p->in->output, &shape, error);
    free(texts);
    free(string);
    text_free(&value);
    return p->writer != NULL;
}

/* The edges that were found not to fit together. */
static void tell_borders(text *line, const relief_settings *set, const relief_state *st)
{
    const bool x = set->border_x == AUTO && st->border_x == NTP_BORDER_CLAMP;
    const bool y = set->border_y == AUTO && st->border_y == NTP_BORDER_CLAMP;
    if (x || y)
        text_addf(line, ", border%s clamp", !y ? "-x" : !x ? "-y" : "");
}

void relief_describe(const production *p, text *line, json_t *object)
{
    const relief_settings *set = p->m->settings;
    const relief_state *st = p->state;
    const bool heights = relief_is_height(p);
    if (line != NULL) {
        text_addf(line, "from %s", heights ? "heights" : "normals");
        if (heights)
            text_addf(line, " with scale %.9g", st->scale);
        else
            green_tell(line, ", ", "green", &st->solve.y);
        tell_borders(line, set, st);
    }
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "from", json_string(encoding_name(p->s.view.encoding)));
    json_object_set_new(object, "scale", heights ? json_real(st->scale) : json_null());
    json_object_set_new(object, "blur", json_real(set->blur));
    json_object_set_new(object, "border_x", json_string(ntp_border_name(st->border_x)));
    json_object_set_new(object, "border_y", json_string(ntp_border_name(st->border_y)));
    json_object_set_new(object, "depth",
                        st->type == NTP_TYPE_F32 ? json_string("float")
                                                 : json_integer(8 << st->type));
    if (!heights)
        green_report(object, "y", &st->solve.y);
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}
