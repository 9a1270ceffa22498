/* SPDX-License-Identifier: MIT */
/*
 * verb_transform.c - ntp transform: flips, turns and strength, pictures and vectors together
 */
#include "report/report.h"
#include "verbs/verbs.h"
#include "write/green.h"
#include "write/whole_image.h"

typedef struct settings {
    ntp_transform_options how;
    int32_t quarters; /* of the angle, or -1 */
    int y;            /* of --y, or -1 */
} settings;

typedef struct state {
    green y;
} state;

static bool turns_vectors(const settings *set)
{
    return set->quarters % 2 != 0;
}

/* Is the result as high as the input was wide? */
static bool lies_down(const settings *set)
{
    return set->quarters == 1 || set->quarters == 3;
}

/*
 * Flips, a half turn and strength treat green up and green down alike, level by level.  Any other
 * turn mixes red and green, with a sign that depends on green: after a quarter turn the two results
 * are opposite vectors.  Flat texels have no direction to get wrong.
 */
static bool depends_on_green(const production *p)
{
    const settings *set = p->m->settings;
    const ntp_stats *stats = &p->f.stats;
    return turns_vectors(set) &&
           !(slopes_are_flat(p->f.most.x, stats) && slopes_are_flat(p->f.most.y, stats));
}

static bool find_y(const production *p, green *g)
{
    const settings *set = p->m->settings;
    if (green_find(g, set->y, &p->f))
        return true;
    const bool needed = depends_on_green(p);
    if (!needed)
        *g = (green) { .by = GREEN_UNNEEDED };
    return !needed;
}

static bool knows(production *p, text *why)
{
    green g;
    const bool known = find_y(p, &g);
    if (!known)
        green_ask(why, &p->f, "--y");
    return known;
}

static ntp_status make(void *context, const ntp_image *dst, const ntp_const_image *src,
                       const ntp_rect *area)
{
    const settings *set = context;
    return ntp_transform(dst, src, &set->how, area);
}

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    find_y(p, &st->y);
    p->s.view.y = st->y.y;
    p->changes = true;
    shape->as_it_came = p->s.info;
    if (lies_down(set)) {
        shape->width = (uint32_t) p->s.view.height;
        shape->height = (uint32_t) p->s.view.width;
    }
    return whole_begin(p, error);
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    settings set = *(const settings *) p->m->settings;
    if (!whole_add(p, area))
        return true;
    set.how.touch_unused = p->touch;
    const bool turned = lies_down(&set);
    const ntp_image *view = &p->s.view;
    return whole_write(p, p->writer, turned ? view->height : view->width,
                       turned ? view->width : view->height, make, &set, error);
}

static const char *flip_name(const ntp_transform_options *how)
{
    return how->flip_x ? how->flip_y ? "xy" : "x" : how->flip_y ? "y" : NULL;
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const char *flip = flip_name(&set->how);
    if (line != NULL) {
        text_addf(line, "%s", class_title(p->f.type.type));
        if (flip != NULL)
            text_addf(line, ", flipped in %s", flip);
        if (set->how.angle != 0)
            text_addf(line, ", turned %.9g degrees clockwise", set->how.angle);
        if (set->how.use_strength)
            text_addf(line, ", slopes times %.6g", set->how.strength);
        green_tell(line, "; ", "green", &st->y);
    }
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "strength",
                        json_real(set->how.use_strength ? set->how.strength : 1));
    json_object_set_new(object, "flip", flip != NULL ? json_string(flip) : json_null());
    json_object_set_new(object, "rotate",
                        set->quarters >= 0 ? json_integer(90 * set->quarters)
                                           : json_real(set->how.angle));
    if (set->quarters < 0) {
        json_object_set_new(object, "border_x", json_string(ntp_border_name(set->how.border_x)));
        json_object_set_new(object, "border_y", json_string(ntp_border_name(set->how.border_y)));
    }
    green_report(object, "y", &st->y);
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}

static ntp_border border_of(const options *o, option_id axis)
{
    return (ntp_border) option_integer(o, option_given(o, axis) ? axis : OPT_BORDER);
}

int transform_run(const options *o)
{
    const bool flip = option_given(o, OPT_FLIP);
    const int64_t axes = option_integer(o, OPT_FLIP);
    const bool turn = option_given(o, OPT_ROTATE);
    settings set = { .y = green_told(o, OPT_Y) };
    set.how.flip_x = flip && axes != 1;
    set.how.flip_y = flip && axes != 0;
    set.how.angle = turn ? option_number(o, OPT_ROTATE) : 0;
    set.how.border_x = border_of(o, OPT_BORDER_X);
    set.how.border_y = border_of(o, OPT_BORDER_Y);
    set.quarters = ntp_quarter_turns(set.how.angle);
    set.how.use_strength = option_given(o, OPT_STRENGTH);
    set.how.strength = option_number(o, OPT_STRENGTH);
    if (!flip && !turn && !set.how.use_strength) {
        complain("nothing to do: give --strength, --flip or --rotate");
        return NTP_EXIT_USAGE;
    }
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .plan = PLAN_MEASURE_FIRST,
                      .finds_green = turns_vectors(&set) && set.y < 0,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .knows = knows,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    return produce(&m);
}
