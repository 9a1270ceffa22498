/* SPDX-License-Identifier: MIT */
/*
 * verb_heatmap.c - ntp heatmap: paints what is wrong where
 */
#include "report/report.h"
#include "verbs/verbs.h"
#include "write/write_run.h"

enum { HEAT_CHANNELS = 3 };

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    (void) p;
    (void) error;
    shape->channels = HEAT_CHANNELS;
    shape->sample_bytes = 1;
    return true;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    const ntp_image *view = &p->s.view;
    const ntp_palette palette = (ntp_palette) option_integer(p->m->o, OPT_PALETTE);
    const size_t row = (size_t) view->width * HEAT_CHANNELS;
    unsigned char *data = buffer_reserve(&p->w->extra, row * (size_t) p->s.block_rows);
    ntp_image heat = ntp_image_packed(data, view->width, view->height, HEAT_CHANNELS, NTP_TYPE_U8);
    heat.encoding = NTP_ENCODING_HEIGHT;
    heat.ring_rows = p->s.block_rows;
    const ntp_const_image seen = ntp_image_as_const(view);
    const ntp_status status = ntp_heatmap(&heat, &seen, palette, p->touch, area);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    p->changes = true;
    return production_write(p, data, (ptrdiff_t) row, area, error);
}

static void describe(const production *p, text *line, json_t *object)
{
    uint64_t all = 0, used = 0;
    failing_texels(&p->f, NTP_VERDICT_NEIGHBOR, false, &all, &used);
    if (line != NULL) {
        text_addf(line, "%s, ", class_title(p->f.type.type));
        text_percent(line, all, p->f.stats.texels);
        text_add(line, " of the texels fail");
    }
    if (object == NULL)
        return;
    json_object_set_new(object, "changed", json_null());
    json_object_set_new(object, "angle_deg", json_angles(&p->f.stats.angles));
    json_object_set_new(object, "palette", json_string(option_string(p->m->o, OPT_PALETTE)));
    json_object_set_new(object, "fail", json_count(all));
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}

int heatmap_run(const options *o)
{
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .any_order = true,
                      .state_size = 1,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    return produce(&m);
}
