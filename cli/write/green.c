/* SPDX-License-Identifier: MIT */
/*
 * green.c - which way green points, for verbs whose result depends on it
 */
#include "write/green.h"

#include <stdio.h>
#include <stdlib.h>

#include "options/names.h"
#include "report/report.h"

/* An answer of `ntp check` that is at least as sure as this is used without asking. */
static const double SURE = 0.9;

int green_told(const options *o, option_id id)
{
    return (int) option_integer(o, id) - 1; /* the choices are auto, up, down */
}

static bool name_says_otherwise(const ntp_orientation_result *found, name_y name)
{
    return found->decided && name == (found->y == NTP_Y_UP ? NAME_Y_DOWN : NAME_Y_UP);
}

void green_seek(source *s)
{
    s->orient = ORIENT_SAMPLED;
    s->find_slopes = true;
}

bool green_find(green *g, int told, const facts *f)
{
    const ntp_orientation_result *found = &f->orientation;
    if (told >= 0) {
        *g = (green) { (ntp_y) told, GREEN_BY_OPTION, 1 };
        return true;
    }
    *g = (green) { found->y, GREEN_BY_TEXELS, found->confidence };
    return found->decided && found->confidence >= SURE && !name_says_otherwise(found, f->in->y);
}

bool green_find_or_up(green *g, int told, const facts *f)
{
    const ntp_orientation_result *found = &f->orientation;
    if (green_find(g, told, f))
        return true;
    *g = (green) { NTP_Y_UP, GREEN_BY_CONVENTION, 0 };
    return f->in->y != NAME_Y_DOWN && !(found->decided && found->y == NTP_Y_DOWN);
}

void green_measure(facts *f, const ntp_const_image *src, uint32_t touch_unused)
{
    ntp_orientation *memory = need(calloc(1, ntp_orientation_size()));
    if (ntp_orientation_add(memory, src, touch_unused, 0, NULL) == NTP_OK)
        ntp_orientation_summarize(&f->orientation, memory);
    free(memory);
}

void green_ask(text *t, const facts *f, const char *option)
{
    const ntp_orientation_result *found = &f->orientation;
    const char *name = f->in->y == NAME_Y_UP ? y_title(NTP_Y_UP) : y_title(NTP_Y_DOWN);
    if (found->decided)
        text_addf(t, "its texels look like %s, %.0f %% sure", y_title(found->y),
                  100 * found->confidence);
    else
        text_add(t, "its texels do not show which way green points");
    if (f->in->y != NAME_Y_NONE)
        text_addf(t, "%s its name says %s",
                  name_says_otherwise(found, f->in->y) ? ", but" : ", and", name);
    text_addf(t, "; which is it, %s up (OpenGL) or %s down (DirectX)?", option, option);
}

void green_tell(text *line, const char *separator, const char *whose, const green *g)
{
    if (g->by == GREEN_BY_TEXELS)
        text_addf(line, "%s%s points %s (%.0f %% sure)", separator, whose, y_name(g->y),
                  100 * g->confidence);
    else if (g->by == GREEN_BY_CONVENTION)
        text_addf(line, "%s%s taken as pointing %s, as is usual", separator, whose, y_name(g->y));
}

void green_report(json_t *object, const char *key, const green *g)
{
    static const char *const BY[] = { "option", "texels", "unneeded", "convention" };
    char name[40];
    json_object_set_new(object, key,
                        g->by == GREEN_UNNEEDED ? json_null() : json_string(y_name(g->y)));
    snprintf(name, sizeof name, "%s_by", key);
    json_object_set_new(object, name, json_string(BY[g->by]));
    snprintf(name, sizeof name, "%s_confidence", key);
    json_object_set_new(object, name, json_angle(g->confidence));
}
