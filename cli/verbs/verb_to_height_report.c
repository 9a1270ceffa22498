/* SPDX-License-Identifier: MIT */
/*
 * verb_to_height_report.c - what ntp to-height reports: the scale, and each choice with its reason
 */
#include "options/names.h"
#include "report/report.h"
#include "verbs/verb_to_height.h"

static const char *const BY[] = { "option", "texels", "default" };

/* Exact to a part in ten thousand. */
static void add_height(text *t, double v)
{
    text_addf(t, "%.4g", v);
}

/* In levels of 8 bit.  Rounding leaves .2, JPEG and painting a few. */
static const double POOR_FIT = 8;
/* Where the middle 98 % of the heights take less of the range, the rest are spikes. */
static const double LEAST_MIDDLE = 0.03;

static bool is_poor(const to_height_state *st)
{
    const double level = st->src.type == NTP_TYPE_U8 ? 1 : 257;
    return st->result.residual > POOR_FIT * level;
}

static void tell_poor_fit(text *t, const to_height_state *st)
{
    text_addf(t, "the heights give back normals that are %.3g levels of 8 bit off (rms): ",
              st->src.type == NTP_TYPE_U8 ? st->result.residual : st->result.residual / 257);
    text_add(t, "no surface has these normals, or --y, --kernel or --border is wrong");
}

static bool has_spikes(const to_height_state *st)
{
    return st->middle_share < LEAST_MIDDLE;
}

static void tell_spikes(text *t, const to_height_state *st)
{
    text_addf(t, "the middle 98 %% of the heights take %.2g %% of the range; ",
              100 * st->middle_share);
    text_add(t,
             st->clipped > 0 ? "a greater --clip leaves more out" : "--clip 0.1 leaves spikes out");
}

/* A list of what `tell` says, or an empty one. */
static json_t *list_of(bool there, void (*tell)(text *t, const to_height_state *st),
                       const to_height_state *st)
{
    json_t *list = need(json_array());
    text t = { 0 };
    if (there) {
        tell(&t, st);
        json_array_append_new(list, json_string(text_string(&t)));
    }
    text_free(&t);
    return list;
}

static void add_choices(text *line, const to_height_state *st)
{
    if (st->y.by == GREEN_BY_OPTION)
        text_addf(line, ", green points %s", y_name(st->y.y));
    green_tell(line, ", ", "green", &st->y);
    text_addf(line, ", %s", ntp_kernel_name(st->how.kernel));
    if (st->how.border_x == st->how.border_y)
        text_addf(line, ", border %s", ntp_border_name(st->how.border_x));
    else
        text_addf(line, ", border %s across and %s down", ntp_border_name(st->how.border_x),
                  ntp_border_name(st->how.border_y));
    text_addf(line, ", %s", ntp_height_method_name(st->result.method));
}

static void add_refined(text *line, const to_height_state *st)
{
    const ntp_height_result *r = &st->result;
    text_addf(line, "; %d %s of refinement%s", r->rounds, r->rounds == 1 ? "round" : "rounds",
              st->cut_short ? ", interrupted: " : ": ");
    if (r->refine_left == 0) {
        text_add(line, "every texel comes back");
        return;
    }
    text_count(line, r->refine_left);
    text_add(line, r->refine_left == 1 ? " texel differs" : " texels differ");
}

static void add_line(text *line, const to_height_settings *set, const to_height_state *st)
{
    const ntp_height_result *r = &st->result;
    text_addf(line, "scale %.9g", st->scale);
    if (set->is_float) {
        text_add(line, ", ");
        add_height(line, r->min);
        text_add(line, " to ");
        add_height(line, r->max);
        text_add(line, " texels");
    } else {
        text_addf(line, ", offset %.9g", st->offset);
    }
    add_choices(line, st);
    if (r->residual >= 0)
        text_addf(line, ", normals fit to %.2f levels", r->residual);
    if (st->how.refine > 0)
        add_refined(line, st);
    if (r->islands > 1) {
        text_add(line, "; ");
        text_count(line, r->islands);
        text_add(line, " separate areas, each with a height of its own");
    }
    if (r->not_finite > 0) {
        text_add(line, "; ");
        text_count(line, r->not_finite);
        text_add(line, " texels that are not vectors");
    }
    if (st->clipped > 0) {
        text_add(line, "; ");
        text_count(line, st->clipped);
        text_add(line, " heights clipped");
    }
    if (is_poor(st)) {
        text_add(line, "\n  warning: ");
        tell_poor_fit(line, st);
    }
    if (has_spikes(st)) {
        text_add(line, "\n  note: ");
        tell_spikes(line, st);
    }
}

void to_height_warn(const production *p, text *line)
{
    const to_height_state *st = p->state;
    if (!is_poor(st))
        return;
    text_add(line, "warning: ");
    tell_poor_fit(line, st);
}

static void set_choices(json_t *object, const to_height_state *st)
{
    const ntp_height_options *how = &st->how;
    const ntp_height_result *r = &st->result;
    json_object_set_new(object, "method", json_string(ntp_height_method_name(r->method)));
    json_object_set_new(object, "dx", json_real(how->dx));
    json_object_set_new(object, "dy", json_real(how->dy));
    json_object_set_new(object, "kernel", json_string(ntp_kernel_name(how->kernel)));
    json_object_set_new(object, "kernel_by", json_string(BY[st->kernel_by]));
    json_object_set_new(object, "border_x", json_string(ntp_border_name(how->border_x)));
    json_object_set_new(object, "border_x_by", json_string(BY[st->border_by[0]]));
    json_object_set_new(object, "border_y", json_string(ntp_border_name(how->border_y)));
    json_object_set_new(object, "border_y_by", json_string(BY[st->border_by[1]]));
    json_object_set_new(object, "from", json_string(encoding_name(st->src.encoding)));
    green_report(object, "y", &st->y);
    json_object_set_new(object, "y", json_string(y_name(st->y.y))); /* also where unneeded */
    json_object_set_new(object, "decode", json_string(decode_name(r->decode)));
    json_object_set_new(object, "z", json_string(z_name(r->z)));
}

void to_height_describe(const production *p, text *line, json_t *object)
{
    const to_height_settings *set = p->m->settings;
    const to_height_state *st = p->state;
    const ntp_height_result *r = &st->result;
    if (line != NULL)
        add_line(line, set, st);
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "scale", json_real(st->scale));
    json_object_set_new(object, "offset", json_real(st->offset));
    json_object_set_new(object, "depth", set->is_float ? json_string("float") : json_integer(16));
    json_object_set_new(object, "min", json_real(r->min));
    json_object_set_new(object, "max", json_real(r->max));
    json_object_set_new(object, "clip", json_real(set->clip));
    json_object_set_new(object, "clipped", json_count(st->clipped));
    json_object_set_new(object, "middle_share", json_real(st->middle_share));
    json_object_set_new(object, "warnings", list_of(is_poor(st), tell_poor_fit, st));
    json_object_set_new(object, "notes", list_of(has_spikes(st), tell_spikes, st));
    set_choices(object, st);
    json_object_set_new(object, "residual_levels",
                        r->residual >= 0 ? json_real(r->residual) : json_null());
    json_object_set_new(object, "refine_rounds", json_integer(r->rounds));
    json_object_set_new(object, "refine_left",
                        st->how.refine > 0 ? json_count(r->refine_left) : json_null());
    json_object_set_new(object, "trend_x", json_real(r->trend_x));
    json_object_set_new(object, "trend_y", json_real(r->trend_y));
    json_object_set_new(object, "iterations", json_integer(r->iterations));
    json_object_set_new(object, "islands", json_count(r->islands));
    json_object_set_new(object, "holes", json_count(r->holes));
    json_object_set_new(object, "unused", json_count(r->unused));
    json_object_set_new(object, "not_finite", json_count(r->not_finite));
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}
