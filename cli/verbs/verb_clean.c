/* SPDX-License-Identifier: MIT */
/*
 * verb_clean.c - ntp clean: repairs normals
 *
 * A file that is held is measured first.  In any other one, blue is derived while it is measured; if
 * --method auto then takes another method, and blue changed, the rows are made again.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "options/names.h"
#include "os/threads.h"
#include "report/report.h"
#include "verbs/verbs.h"
#include "write/write_run.h"

enum {
    PLAN_TEXELS = 512 * 512, /* from about here on, a table for 8-bit rows saves time */
    METHODS = 3,
    ENCODINGS = 3,
    ALPHAS = 2 /* alpha 0 means unused, or alpha is a height */
};

/* Tables are made when they are first needed; all workers share them. */
typedef struct plans {
    os_lock lock;
    void *memory[METHODS][ENCODINGS][ALPHAS];
    ntp_clean_plan *made[METHODS][ENCODINGS][ALPHAS];
} plans;

typedef struct settings {
    ntp_clean_options how;
    bool choose;         /* --method auto */
    bool compare_angles; /* the measured angles are those of --method derive for all texels */
    plans *shared;
} settings;

typedef struct state {
    ntp_clean_options how;
    ntp_clean_counts counts;
    ntp_reason why; /* of the method, with --method auto */
    const ntp_clean_plan *plan;
    ntp_diff *diff; /* stored against cleaned; NULL: the measured angles are right */
} state;

static const ntp_clean_plan *plan_for(plans *shared, ntp_encoding encoding,
                                      const ntp_clean_options *how)
{
    const int alpha = (how->touch_unused & NTP_UNUSED_TRANSPARENT) != 0;
    os_lock_take(&shared->lock);
    void **memory = &shared->memory[how->method][encoding][alpha];
    ntp_clean_plan **plan = &shared->made[how->method][encoding][alpha];
    if (*memory == NULL) {
        const size_t size = ntp_clean_plan_size();
        *memory = need_aligned(size);
        if (ntp_clean_plan_init(plan, *memory, size, encoding, how) != NTP_OK)
            *plan = NULL;
    }
    const ntp_clean_plan *made = *plan;
    os_lock_release(&shared->lock);
    return made;
}

static ntp_status choose(production *p)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_status status = ntp_choose_method(&st->how.method, &st->why, p->w->tally,
                                                p->s.view.encoding, p->s.info->lossy);
    /* Unused texels were not asked.  Normalizing repairs them, and leaves what is rounded. */
    if (status == NTP_OK && st->how.method == NTP_CLEAN_KEEP && set->how.touch_unused != 0 &&
        p->f.stats.unused > 0)
        st->how.method = NTP_CLEAN_NORMALIZE;
    return status;
}

/* Blue was derived.  If that changed nothing, other methods change nothing either. */
static bool holds(production *p)
{
    const state *st = p->state;
    return choose(p) == NTP_OK && (st->how.method == NTP_CLEAN_DERIVE || st->counts.changed == 0);
}

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    st->how = set->how;
    st->how.touch_unused |= p->touch;
    if (set->choose && p->known) {
        const ntp_status status = choose(p);
        if (status != NTP_OK)
            return library_error(&p->s, status, error);
    }
    if (p->undone.kind == UNDO_DXT5NM) { /* there is no blue */
        st->how.method = NTP_CLEAN_DERIVE;
        st->why = (ntp_reason) { NTP_REASON_XY_ONLY, 0 };
    }
    if (set->compare_angles || p->undone.kind != UNDO_NOTHING || st->how.method != NTP_CLEAN_DERIVE)
        st->diff = worker_diff(p->w);
    const bool large = (int64_t) view->width * view->height >= PLAN_TEXELS;
    if (large && view->type == NTP_TYPE_U8)
        st->plan = plan_for(set->shared, view->encoding, &st->how);
    shape->channels = view->channels;
    shape->as_it_came = p->s.info;
    return true;
}

/* The rows before they are cleaned, for the comparison. */
static ntp_const_image copy_rows(production *p, const ntp_rect *area)
{
    const ntp_image *view = &p->s.view;
    ntp_const_image before = ntp_image_as_const(view);
    const size_t row = (size_t) view->row_stride;
    unsigned char *copy = buffer_reserve(&p->w->extra, row * (size_t) p->s.block_rows);
    memcpy(copy, source_rows(&p->s, area), row * (size_t) (area->y1 - area->y0));
    before.data = copy;
    before.ring_rows = p->s.block_rows;
    return before;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    const ntp_const_image same = ntp_image_as_const(view);
    ntp_const_image before = same;
    if (p->undone.kind != UNDO_NOTHING)
        before = undo_stored(&p->s);
    else if (st->diff != NULL)
        before = copy_rows(p, area);
    ntp_status status = ntp_clean(view, &same, &st->how, st->plan, &st->counts, area);
    if (status == NTP_OK && st->diff != NULL)
        status = ntp_diff_add(st->diff, NULL, &same, &before, area);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    p->changes = st->counts.changed > 0 || p->undone.kind != UNDO_NOTHING;
    return production_write(p, source_rows(&p->s, area), view->row_stride, area, error);
}

static ntp_angles angles_of(const production *p)
{
    const state *st = p->state;
    ntp_diff_stats stats;
    if (st->diff != NULL && ntp_diff_summarize(&stats, st->diff) == NTP_OK)
        return stats.angles;
    return p->f.stats.angles;
}

/* The method in words: z may be mirrored although all else is kept. */
static const char *method_done(const state *st)
{
    const bool mirrored = st->how.method == NTP_CLEAN_KEEP && st->counts.changed > 0;
    return mirrored ? "mirror" : clean_method_name(st->how.method);
}

/* Texels that differ from those in the file. */
static uint64_t changed(const production *p)
{
    const state *st = p->state;
    ntp_diff_stats stats;
    if (p->undone.kind != UNDO_NOTHING && ntp_diff_summarize(&stats, st->diff) == NTP_OK)
        return stats.different;
    return st->counts.changed;
}

/* The reason of the method.  What is rounded is kept: then the method is for unused texels alone. */
static void reason_of(char *why, size_t size, const state *st)
{
    if (st->why.code == NTP_REASON_ALL_ROUNDED && st->how.method == NTP_CLEAN_NORMALIZE)
        snprintf(why, size, "%s",
                 "only unused texels need it: every used texel is correctly rounded");
    else
        ntp_reason_text(why, size, &st->why);
}

static void describe_text(const production *p, text *line)
{
    const state *st = p->state;
    const settings *set = p->m->settings;
    const ntp_angles angles = angles_of(p);
    const bool would = option_given(p->m->o, OPT_DRY_RUN);
    const uint64_t count = changed(p);
    if (p->undone.kind != UNDO_NOTHING)
        undo_tell(line, &p->undone, would);
    if (count == 0) {
        text_add(line, "nothing to repair");
        return;
    }
    text_count(line, count);
    text_add(line, count == 1 ? " texel (" : " texels (");
    text_percent(line, count, p->f.stats.texels);
    text_addf(line, ") %s, turned by up to ", would ? "would change" : "changed");
    text_degrees(line, angles.max);
    text_add(line, " degrees, ");
    text_degrees(line, angles.mean);
    text_add(line, " on average");
    if (p->f.type.type != NTP_CLASS_STANDARD)
        text_addf(line, "; %s", class_title(p->f.type.type));
    if (!set->choose || st->counts.changed == 0)
        return;
    char why[300];
    reason_of(why, sizeof why, st);
    if (st->how.method == NTP_CLEAN_KEEP)
        text_addf(line, "; only negative z was mirrored, because %s", why);
    else
        text_addf(line, "; method %s, because %s", clean_method_name(st->how.method), why);
}

static void describe(const production *p, text *line, json_t *object)
{
    const state *st = p->state;
    const settings *set = p->m->settings;
    if (line != NULL)
        describe_text(p, line);
    if (object == NULL)
        return;
    const ntp_angles angles = angles_of(p);
    json_object_set_new(object, "changed", json_count(changed(p)));
    json_object_set_new(object, "undone", undo_json(&p->undone));
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
    json_object_set_new(object, "angle_deg", json_angles(&angles));
    json_object_set_new(object, "method", json_string(method_done(st)));
    if (set->choose) {
        char why[300];
        reason_of(why, sizeof why, st);
        json_object_set_new(object, "method_reason", json_string(why));
    }
    json_object_set_new(object, "keep_negative_z", json_boolean(st->how.keep_negative_z));
    json_object_set_new(object, "only_failing", json_boolean(st->how.only_failing));
    json_object_set_new(object, "touch_unused",
                        json_boolean(option_given(p->m->o, OPT_TOUCH_UNUSED)));
}

int clean_run(const options *o)
{
    static const ntp_clean_method METHODS_OF_OPTION[] = { NTP_CLEAN_DERIVE, NTP_CLEAN_DERIVE,
                                                          NTP_CLEAN_NORMALIZE };
    const int64_t method = option_integer(o, OPT_METHOD);
    plans shared = { 0 };
    settings set = { .shared = &shared, .choose = method == 0 };
    os_lock_init(&shared.lock);
    set.how.method = METHODS_OF_OPTION[method];
    set.how.keep_negative_z = option_given(o, OPT_KEEP_NEGATIVE_Z);
    set.how.only_failing = option_given(o, OPT_ONLY_FAILING);
    set.how.verdict = (ntp_verdict) option_integer(o, OPT_VERDICT);
    set.how.touch_unused = option_given(o, OPT_TOUCH_UNUSED) ? NTP_UNUSED_ALL : 0;
    set.compare_angles =
        set.how.keep_negative_z || set.how.only_failing || set.how.touch_unused != 0;
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .any_order = true,
                      .plan = PLAN_WHILE_READING,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .begin = begin,
                      .rows = rows,
                      .holds = set.choose ? holds : NULL,
                      .describe = describe };
    const int code = produce(&m);
    for (int i = 0; i < METHODS; i++) {
        for (int k = 0; k < ENCODINGS; k++) {
            for (int a = 0; a < ALPHAS; a++)
                free_aligned(shared.memory[i][k][a]);
        }
    }
    return code;
}
