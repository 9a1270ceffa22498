/* SPDX-License-Identifier: MIT */
/*
 * verb_blend.c - ntp blend: a detail normals texture over a base
 *
 * The base is read block by block.  The detail, which repeats, is held in memory.
 */
#include <stdlib.h>
#include <string.h>

#include "examine/hold_image.h"
#include "report/report.h"
#include "verbs/verbs.h"
#include "write/green.h"
#include "write/question.h"
#include "write/write_run.h"

typedef struct settings {
    ntp_blend_options how;
    int y, detail_y; /* of the options, or -1 */
    ntp_image detail;
    const facts *detail_facts;
    const source *detail_source;
    uint32_t detail_touch;
} settings;

typedef struct state {
    ntp_image made; /* the blended rows */
    ntp_diff *diff; /* base against result */
    green y, detail_y;
} state;

/* The detail while it is read. */
typedef struct layer {
    input in;
    worker *w;
    source s;
    facts f;
    void *data;
} layer;

/* ------------------------------------------------------------------------- green */

/* Is y not 0 in any texel that is blended? */
static bool has_y(const facts *f, const ntp_blend_options *how)
{
    const bool touched = how->touch_unused != 0 && f->stats.unused > 0;
    return touched || !slopes_are_flat(f->most.y, &f->stats);
}

typedef struct both {
    green base, detail;
    bool base_is_known, detail_is_known;
} both;

/*
 * Turning green of one texture changes nothing where all its y are 0: a base without y takes the
 * green of the detail, and a detail without y that of the base.
 */
static both find_both(const production *p)
{
    const settings *set = p->m->settings;
    const facts *detail = set->detail_facts;
    both g = { .base_is_known = green_find(&g.base, set->y, &p->f),
               .detail_is_known = green_find(&g.detail, set->detail_y, detail) };
    const bool base_has_y = has_y(&p->f, &set->how);
    const bool detail_has_y = has_y(detail, &set->how) && set->how.strength != 0;
    if (!g.base_is_known && (!base_has_y || !detail_has_y)) {
        g.base = (green) { g.detail_is_known ? g.detail.y : NTP_Y_UP, GREEN_UNNEEDED, 0 };
        g.base_is_known = true;
        if (!g.detail_is_known)
            g.detail = g.base;
        g.detail_is_known = true;
    }
    if (!g.detail_is_known && !detail_has_y) {
        g.detail = (green) { g.base.y, GREEN_UNNEEDED, 0 };
        g.detail_is_known = true;
    }
    return g;
}

static bool knows(production *p, text *why)
{
    const settings *set = p->m->settings;
    const both g = find_both(p);
    if (!g.base_is_known)
        green_ask(why, &p->f, "--y");
    if (!g.base_is_known && !g.detail_is_known)
        text_add(why, " --detail-y says it of DETAIL, which does not show it either");
    if (g.base_is_known && !g.detail_is_known) {
        text_add(why, "DETAIL is ");
        text_name(why, p->m->o->paths[1]);
        text_add(why, ": ");
        green_ask(why, set->detail_facts, "--detail-y");
    }
    return g.base_is_known && g.detail_is_known;
}

/* -------------------------------------------------------------------------- rows */

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    state *st = p->state;
    const both g = find_both(p);
    (void) shape;
    (void) error;
    st->y = g.base;
    st->detail_y = g.detail;
    p->s.view.y = g.base.y;
    p->changes = true;
    st->made = p->s.view;
    st->made.ring_rows = p->s.block_rows;
    st->made.data =
        buffer_reserve(&p->w->extra, (size_t) st->made.row_stride * (size_t) p->s.block_rows);
    st->diff = worker_diff(p->w);
    return true;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_const_image base = ntp_image_as_const(&p->s.view);
    const ntp_const_image made = ntp_image_as_const(&st->made);
    ntp_const_image detail = ntp_image_as_const(&set->detail);
    detail.y = st->detail_y.y;
    ntp_blend_options how = set->how;
    how.touch_unused |= p->touch | set->detail_touch;
    ntp_status status = ntp_blend(&st->made, &base, &detail, &how, area);
    if (status == NTP_OK)
        status = ntp_diff_add(st->diff, NULL, &base, &made, area);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    return production_write(p, st->made.data, st->made.row_stride, area, error) &&
           (area->y1 < base.height || source_is_current(set->detail_source, error));
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const char *mode = ntp_blend_mode_name(set->how.mode);
    ntp_diff_stats stats;
    if (ntp_diff_summarize(&stats, st->diff) != NTP_OK)
        return;
    if (line != NULL) {
        text_addf(line, "%s, with ", class_title(p->f.type.type));
        text_name(line, p->m->o->paths[1]);
        text_addf(line, " by %s, strength %.6g; turned by up to ", mode, set->how.strength);
        text_degrees(line, stats.angles.max);
        text_add(line, " degrees, ");
        text_degrees(line, stats.angles.mean);
        text_add(line, " on average");
        green_tell(line, "; ", "green of BASE", &st->y);
        green_tell(line, "; ", "green of DETAIL", &st->detail_y);
    }
    if (object == NULL)
        return;
    json_set_changes(object, &stats);
    json_object_set_new(object, "texels", json_count(stats.texels));
    json_set_name(object, "detail", p->m->o->paths[1]);
    json_object_set_new(object, "detail_type",
                        json_string(ntp_class_name(set->detail_facts->type.type)));
    json_object_set_new(object, "mode", json_string(mode));
    json_object_set_new(object, "strength", json_real(set->how.strength));
    json_object_set_new(object, "detail_alpha", json_boolean(set->how.detail_alpha != 0));
    green_report(object, "y", &st->y);
    green_report(object, "detail_y", &st->detail_y);
}

/* ---------------------------------------------------------------------- the detail */

/* A gray file of one color becomes RGB, as in the base. */
static void view_detail(layer *l)
{
    const int32_t channels = l->s.info->channels;
    const bool gray = channels < 3 && l->f.encoding != NTP_ENCODING_XY;
    if (gray)
        source_view_as_rgb(&l->s, class_encoding(l->f.type.type, 3));
    else
        source_view(&l->s, class_encoding(l->f.type.type, channels), NTP_Y_UP, NULL, 0);
}

static bool examine_detail(layer *l, const options *o, ntpio_error *error)
{
    if (!examine(&l->s, forced_class(o), &l->f, error))
        return false;
    if (!option_given(o, OPT_FORCE) || question_detail(NULL, &l->f))
        return true;
    facts_free(&l->f);
    return source_rewind(&l->s, error) && examine(&l->s, NTP_CLASS_STANDARD, &l->f, error);
}

static unsigned read_detail(layer *l, settings *set, const options *o, const ntpio_limits *limits)
{
    ntpio_error error = { 0 };
    l->in = (input) { .path = o->paths[1], .named = true };
    l->w = worker_new();
    l->in.y = name_orientation(l->in.path);
    bool ok = source_open(&l->s, l->w, &l->in, limits, &error);
    green_seek(&l->s);
    ok = ok && examine_detail(l, o, &error);
    if (!ok) {
        complain("%s", error.message);
        return RAN_FAILED;
    }
    text why = { 0 };
    const bool fit = question_detail(&why, &l->f);
    if (!fit)
        complain("%s: %s", o->paths[1], text_string(&why));
    text_free(&why);
    if (!fit)
        return RAN_FINDINGS;
    ok = source_rewind(&l->s, &error);
    if (ok) {
        view_detail(l);
        ok = hold_all(&set->detail, &l->data, &l->s, &error);
    }
    if (!ok) {
        complain("%s", error.message);
        return RAN_FAILED;
    }
    source_close_file(&l->s); /* -o may name it, and no open file is replaced on Windows */
    set->detail_facts = &l->f;
    set->detail_source = &l->s;
    set->detail_touch = touch_for(&l->f.stats, l->f.encoding);
    return 0;
}

/* With --force, -o may name the detail, as it may name the base, but not one of a format that is only
 * read. */
static bool replaces_original(const layer *l, const char *output)
{
    const char *name = unwritten_name(l->s.info);
    if (name == NULL || output == NULL || !is_same_file(l->in.path, output))
        return false;
    complain("%s: %s is not written; give -o for a PNG of another name", l->in.path, name);
    return true;
}

static void free_detail(layer *l)
{
    source_close(&l->s);
    facts_free(&l->f);
    if (l->w != NULL)
        worker_free(l->w);
    free(l->data);
}

int blend_run(const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    if (!inputs_are_two(o, ", BASE and DETAIL"))
        return NTP_EXIT_USAGE;
    settings set = { .y = green_told(o, OPT_Y), .detail_y = green_told(o, OPT_DETAIL_Y) };
    set.how.mode = (ntp_blend_mode) option_integer(o, OPT_MODE);
    set.how.use_strength = 1;
    set.how.strength = option_number(o, OPT_STRENGTH);
    set.how.detail_alpha = option_given(o, OPT_DETAIL_ALPHA);
    set.how.touch_unused = option_given(o, OPT_TOUCH_UNUSED) ? NTP_UNUSED_ALL : 0;
    const ntpio_limits limits = limits_from(o);
    layer detail = { 0 };
    unsigned ran = read_detail(&detail, &set, o, &limits);
    if (ran == 0 && replaces_original(&detail, output))
        ran = RAN_USAGE;
    options base = *o; /* the base is the only input of the run */
    base.path_count = 1;
    const maker m = { .o = &base,
                      .forced = forced_class(o),
                      .plan = PLAN_MEASURE_FIRST,
                      .finds_green = true,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .knows = knows,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    const int code = ran != 0 ? exit_code(ran) : produce(&m);
    free_detail(&detail);
    return code;
}
