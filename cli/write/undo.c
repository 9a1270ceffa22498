/* SPDX-License-Identifier: MIT */
/*
 * undo.c - accidents that are exactly undone: exchanged channels, DXT5nm, inverted blue, sRGB
 */
#include "write/undo.h"

#include "examine/samples.h"
#include "report/report.h"

static const double DEGREES = 57.29577951308232;

static const struct {
    const char *name, *title, *what;
} KINDS[] = {
    [UNDO_NOTHING] = { "nothing", "nothing", "nothing" },
    [UNDO_RED_BLUE] = { "red-blue", "red and blue are exchanged", "the exchange of red and blue" },
    [UNDO_GREEN_BLUE] = { "green-blue", "green and blue are exchanged",
                          "the exchange of green and blue" },
    [UNDO_DXT5NM] = { "dxt5nm", "it is packed as DXT5nm: x is in alpha, y in green",
                      "the packing as DXT5nm" },
    [UNDO_BLUE] = { "inverted-blue", "blue is inverted", "the inversion of blue" },
    [UNDO_SRGB] = { "srgb", "the numbers were converted to sRGB", "the conversion to sRGB" },
};

const char *undo_title(undo_kind kind)
{
    return KINDS[kind].title;
}

undo_kind undo_kind_of(const facts *f)
{
    return undo_kind_shown(&f->type, f->info.channels);
}

bool undo_is_possible(undo_kind kind, const ntpio_info *info)
{
    return kind != UNDO_SRGB || info->sample_bytes <= 2;
}

/* ------------------------------------------------------------------------- the rows */

static void alter(void *context, void *rows, size_t texels)
{
    undo *u = context;
    undo_levels(u->kind, rows, u->type, u->channels, texels, &u->loss);
}

void undo_begin(undo *u, source *s, undo_kind kind, double confidence)
{
    static const int8_t MAPS[][4] = { [UNDO_RED_BLUE] = { 2, 1, 0, 3 },
                                      [UNDO_GREEN_BLUE] = { 0, 2, 1, 3 },
                                      [UNDO_DXT5NM] = { 3, 1, FROM_ONE, FROM_ONE },
                                      [UNDO_BLUE] = { 0, 1, 2, 3 },
                                      [UNDO_SRGB] = { 0, 1, 2, 3 } };
    const int32_t channels = kind == UNDO_DXT5NM ? 3 : s->info->channels;
    *u = (undo) { .kind = kind,
                  .confidence = confidence,
                  .type = sample_type(s->info->sample_bytes),
                  .channels = channels };
    s->alter = alter;
    s->alter_context = u;
    source_view(s, NTP_ENCODING_STANDARD, NTP_Y_UP, MAPS[kind], channels);
}

void undo_restart(undo *u)
{
    u->loss = (undo_loss) { 0 };
}

ntp_const_image undo_stored(const source *s)
{
    ntp_image stored = ntp_image_packed(s->w->raw.data, s->view.width, s->view.height,
                                        s->info->channels, s->view.type);
    stored.encoding = NTP_ENCODING_STANDARD;
    stored.ring_rows = s->block_rows;
    stored.y = s->view.y;
    return ntp_image_as_const(&stored);
}

/* ------------------------------------------------------------------------ the words */

void undo_tell(text *line, const undo *u, bool would)
{
    text_addf(line, "%s %s (%.0f %% sure)", would ? "would undo" : "undid", KINDS[u->kind].what,
              100 * u->confidence);
    if (u->kind == UNDO_SRGB && u->loss.texels > 0) {
        text_addf(line, "; its rounding leaves levels off by up to %u, that is up to ",
                  (unsigned) u->loss.most);
        text_degrees(line, u->loss.angle * DEGREES);
        text_add(line, " degrees, ");
        text_degrees(line, u->loss.sum / (double) u->loss.texels * DEGREES);
        text_add(line, " on average");
    }
    text_add(line, "; ");
}

json_t *undo_json(const undo *u)
{
    if (u->kind == UNDO_NOTHING)
        return json_null();
    json_t *object = need(json_object());
    json_object_set_new(object, "what", json_string(KINDS[u->kind].name));
    json_object_set_new(object, "confidence", json_angle(u->confidence));
    const double mean = u->loss.texels > 0 ? u->loss.sum / (double) u->loss.texels : 0;
    json_object_set_new(object, "loss_levels", json_integer((json_int_t) u->loss.most));
    json_object_set_new(object, "loss_deg_mean", json_angle(mean * DEGREES));
    json_object_set_new(object, "loss_deg_max", json_angle(u->loss.angle * DEGREES));
    return object;
}
