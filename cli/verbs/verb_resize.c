/* SPDX-License-Identifier: MIT */
/*
 * verb_resize.c - ntp resize: another size, or all sizes of a mip chain
 *
 * Each level of a chain is made from the texture itself, not from the level before.  The mean of
 * normals is short where they differ; a level of unit vectors has lost that, and its means would be
 * wrong.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"
#include "verbs/verbs.h"
#include "write/whole_image.h"

typedef struct settings {
    ntp_resize_options how;
    bool mips;
    int32_t width, height; /* 0: by percent */
    double percent;
} settings;

typedef struct state {
    int32_t width, height; /* of the output */
    int32_t levels;        /* of the chain; 1 without one */
} state;

/* What one size needs while it is made. */
typedef struct sizing {
    ntp_resize_plan *plan;
    void *memory, *scratch;
    size_t scratch_size;
} sizing;

/* --------------------------------------------------------------------------- sizes */

static bool read_size(settings *set, const char *spec)
{
    char *end;
    const double first = strtod(spec, &end);
    if (end != spec && strcmp(end, "%") == 0 && first > 0 && first <= 100.0 * NTP_MAX_SIDE) {
        set->percent = first;
        return true;
    }
    const long width = strtol(spec, &end, 10);
    const bool crossed = end != spec && *end == 'x';
    const char *second = end + crossed;
    const long height = crossed ? strtol(second, &end, 10) : 0;
    if (end != second && *end == 0 && width >= 1 && height >= 1 && width <= NTP_MAX_SIDE &&
        height <= NTP_MAX_SIDE) {
        set->width = (int32_t) width;
        set->height = (int32_t) height;
        return true;
    }
    if (spec[0] != 0 && spec[strspn(spec, "0123456789")] == 0)
        complain("--size %s: give both sides, --size %sx%s, or percent, as --size 50%%", spec, spec,
                 spec);
    else
        complain("--size %s: a size is WIDTHxHEIGHT, 1 to %d each, or PERCENT%%", spec,
                 NTP_MAX_SIDE);
    return false;
}

/* A side times the percentage, rounded, at least 1; 0 if it is too long. */
static int32_t scaled_side(int32_t side, double percent)
{
    const double scaled = side * percent / 100 + 0.5;
    return scaled >= NTP_MAX_SIDE + 1.0 ? 0 : scaled < 1 ? 1 : (int32_t) scaled;
}

static bool choose_size(production *p, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    st->levels = set->mips ? ntp_mip_levels(view->width, view->height) : 1;
    st->width = set->mips            ? view->width
                : set->percent > 0.0 ? scaled_side(view->width, set->percent)
                                     : set->width;
    st->height = set->mips            ? view->height
                 : set->percent > 0.0 ? scaled_side(view->height, set->percent)
                                      : set->height;
    const uint64_t most = (uint64_t) option_integer(p->m->o, OPT_MAX_TEXELS);
    if (st->width == 0 || st->height == 0 || (uint64_t) st->width * (uint64_t) st->height > most)
        return wrong_use(p, "would become larger than --max-side or --max-texels", error);
    return true;
}

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const state *st = p->state;
    if (!choose_size(p, error))
        return false;
    p->changes = true;
    shape->width = (uint32_t) st->width;
    shape->height = (uint32_t) st->height;
    return whole_begin(p, error);
}

/* -------------------------------------------------------------------------- making */

static ntp_status make(void *context, const ntp_image *dst, const ntp_const_image *src,
                       const ntp_rect *area)
{
    const sizing *z = context;
    return ntp_resize(dst, src, z->plan, z->scratch, z->scratch_size, area);
}

static bool make_size(production *p, ntpio_writer *writer, int32_t width, int32_t height,
                      ntpio_error *error)
{
    const ntp_image *view = &p->s.view;
    ntp_resize_options how = ((const settings *) p->m->settings)->how;
    how.touch_unused |= p->touch;
    const size_t size = ntp_resize_plan_size(&how, view->width, view->height, width, height);
    sizing z = { .memory = need_aligned(size) };
    const ntp_status status = ntp_resize_plan_init(&z.plan, z.memory, size, &how, view->width,
                                                   view->height, width, height);
    bool ok = status == NTP_OK || library_error(&p->s, status, error);
    if (ok) {
        z.scratch_size = ntp_resize_scratch_size(z.plan);
        z.scratch = need_aligned(z.scratch_size);
        ok = whole_write(p, writer, width, height, make, &z, error);
    }
    free_aligned(z.scratch);
    free_aligned(z.memory);
    return ok;
}

/* wall.png -> wall_mip3.png */
static char *level_path(const char *output, int32_t level)
{
    const char *ending = name_ending(output);
    text name = { 0 };
    text_bytes(&name, output, strlen(output) - strlen(ending));
    text_addf(&name, "_mip%d%s", (int) level, ending);
    char *path = copy_string(text_string(&name));
    text_free(&name);
    return path;
}

static bool make_level(production *p, int32_t level, ntpio_error *error)
{
    const ntp_image *view = &p->s.view;
    const int32_t width = ntp_mip_side(view->width, level);
    const int32_t height = ntp_mip_side(view->height, level);
    ntpio_write_options shape = { .width = (uint32_t) width,
                                  .height = (uint32_t) height,
                                  .channels = view->channels,
                                  .sample_bytes = p->s.info->sample_bytes };
    char *path = level_path(p->in->output, level);
    ntpio_writer *writer = NULL;
    if (production_may_write(p, path, error))
        writer = production_open(p, path, &shape, error);
    bool ok = writer != NULL && make_size(p, writer, width, height, error);
    if (ok)
        ok = ntpio_commit(writer, error);
    else
        ntpio_abort(writer);
    free(path);
    return ok;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    const state *st = p->state;
    if (!whole_add(p, area))
        return true;
    for (int32_t level = 1; level < st->levels; level++) {
        if (!make_level(p, level, error))
            return false;
    }
    return make_size(p, p->writer, st->width, st->height, error);
}

/* --------------------------------------------------------------------- what was done */

static json_t *levels_json(const production *p)
{
    const state *st = p->state;
    json_t *list = need(json_array());
    for (int32_t level = 0; level < st->levels; level++) {
        json_t *one = need(json_object());
        char *path = level == 0 ? copy_string(p->in->output) : level_path(p->in->output, level);
        json_set_name(one, "path", path);
        json_object_set_new(one, "width", json_integer(ntp_mip_side(st->width, level)));
        json_object_set_new(one, "height", json_integer(ntp_mip_side(st->height, level)));
        json_array_append_new(list, one);
        free(path);
    }
    return list;
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const char *filter = ntp_filter_name(set->how.filter);
    if (line != NULL) {
        text_addf(line, "%s, %d x %d to ", class_title(p->f.type.type), (int) p->s.view.width,
                  (int) p->s.view.height);
        if (set->mips)
            text_addf(line, "%d levels down to 1 x 1", (int) st->levels);
        else
            text_addf(line, "%d x %d", (int) st->width, (int) st->height);
        text_addf(line, ", filter %s", filter);
    }
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "width", json_integer(st->width));
    json_object_set_new(object, "height", json_integer(st->height));
    json_object_set_new(object, "filter", json_string(filter));
    json_object_set_new(object, "border_x", json_string(ntp_border_name(set->how.border_x)));
    json_object_set_new(object, "border_y", json_string(ntp_border_name(set->how.border_y)));
    json_object_set_new(object, "texels", json_count((uint64_t) st->width * (uint64_t) st->height));
    if (set->mips)
        json_object_set_new(object, "mips", levels_json(p));
}

static ntp_border border_of(const options *o, option_id axis)
{
    return (ntp_border) option_integer(o, option_given(o, axis) ? axis : OPT_BORDER);
}

int resize_run(const options *o)
{
    static const ntp_filter FILTERS[] = { NTP_FILTER_BOX, NTP_FILTER_TRIANGLE,
                                          NTP_FILTER_LANCZOS3 };
    const char *size = option_string(o, OPT_SIZE), *output = option_string(o, OPT_OUTPUT);
    settings set = { .mips = option_given(o, OPT_MIPS) };
    if ((size != NULL) == set.mips) {
        complain("give either --size or --mips");
        return NTP_EXIT_USAGE;
    }
    if (set.mips && output != NULL && strcmp(output, "-") == 0) {
        complain("--mips writes several files; standard output holds one");
        return NTP_EXIT_USAGE;
    }
    if (size != NULL && !read_size(&set, size))
        return NTP_EXIT_USAGE;
    set.how.filter = option_given(o, OPT_FILTER) ? FILTERS[option_integer(o, OPT_FILTER)]
                     : set.mips                  ? NTP_FILTER_BOX
                                                 : NTP_FILTER_TRIANGLE;
    set.how.border_x = border_of(o, OPT_BORDER_X);
    set.how.border_y = border_of(o, OPT_BORDER_Y);
    set.how.touch_unused = option_given(o, OPT_TOUCH_UNUSED) ? NTP_UNUSED_ALL : 0;
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .any_order = true,
                      .plan = PLAN_MEASURE_FIRST,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    return produce(&m);
}
