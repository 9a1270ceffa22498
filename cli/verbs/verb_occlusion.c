/* SPDX-License-Identifier: MIT */
/*
 * verb_occlusion.c - ntp occlusion: ambient occlusion, from heights or normals
 *
 * The texture, its heights and the sums of light are held whole, about 12 bytes a texel beside the
 * input.  All threads that other files leave work on it.
 */
#include <stdlib.h>

#include "report/report.h"
#include "surface/solve_heights.h"
#include "verbs/relief.h"
#include "verbs/verbs.h"

enum { HEIGHTS_PERMILLE = 500 }; /* the progress when the heights are there */

typedef struct settings {
    relief_settings relief; /* first */
    double radius;
} settings;

static bool finish(production *p, ntpio_error *error)
{
    const settings *set = p->m->settings;
    const relief_state *st = p->state;
    ntp_const_image heights;
    if (!relief_choose_borders(p, error) || !relief_heights(p, &heights, error))
        return false;
    const ntp_occlusion_options how = { .scale = relief_is_height(p) ? st->scale : 1,
                                        .radius = set->radius,
                                        .border_x = st->border_x,
                                        .border_y = st->border_y };
    const size_t texels = (size_t) heights.width * (size_t) heights.height;
    void *data = buffer_reserve(&p->w->raw, texels << st->type);
    const ntp_image map = ntp_image_packed(data, heights.width, heights.height, 1, st->type);
    const ntp_status status =
        heights_occlude(p->w, &map, &heights, &how, (stretch) { HEIGHTS_PERMILLE, 1000 });
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    const ntp_rect all = { 0, 0, map.width, map.height };
    return relief_start(p, NULL, 0, error) &&
           production_write(p, map.data, map.row_stride, &all, error);
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    if (line != NULL) {
        text_add(line, "ambient occlusion ");
        relief_describe(p, line, NULL);
    }
    if (object == NULL)
        return;
    relief_describe(p, NULL, object);
    json_object_set_new(object, "radius", json_real(set->radius));
}

int occlusion_run(const options *o)
{
    settings set;
    if (!relief_read_settings(&set.relief, o))
        return NTP_EXIT_USAGE;
    set.radius = option_number(o, OPT_RADIUS);
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .takes_heights = true,
                      .plan = PLAN_AFTER_READING,
                      .read_permille = READ_PERMILLE,
                      .state_size = sizeof(relief_state),
                      .settings = &set,
                      .knows = relief_knows,
                      .begin = relief_begin,
                      .rows = relief_rows,
                      .finish = finish,
                      .describe = describe };
    return produce(&m);
}
