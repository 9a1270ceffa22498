/* SPDX-License-Identifier: MIT */
/*
 * undo.c - accidents that are exactly undone: exchanged channels, DXT5nm, inverted blue, sRGB
 */
#include "write/undo.h"

#include <math.h>
#include <string.h>

#include "examine/samples.h"
#include "report/report.h"
#include "write/srgb_levels.h"

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
    const uint32_t a = f->type.accidents;
    if (!class_is_tangent(f->type.type) || f->info.channels < 3)
        return UNDO_NOTHING;
    if ((a & NTP_ACCIDENT_GAMMA) != 0)
        return UNDO_SRGB;
    if ((a & NTP_ACCIDENT_RED_IS_Z) != 0)
        return UNDO_RED_BLUE;
    if ((a & NTP_ACCIDENT_GREEN_IS_Z) != 0)
        return UNDO_GREEN_BLUE;
    if ((a & NTP_ACCIDENT_DXT5NM) != 0)
        return f->info.channels == 4 ? UNDO_DXT5NM : UNDO_NOTHING;
    const bool standard = f->type.type == NTP_CLASS_STANDARD;
    return standard && (a & NTP_ACCIDENT_Z_FLIPPED) != 0 ? UNDO_BLUE : UNDO_NOTHING;
}

bool undo_is_possible(undo_kind kind, const ntpio_info *info)
{
    return kind != UNDO_SRGB || info->sample_bytes <= 2;
}

/* ------------------------------------------------------------------------- the rows */

static uint32_t load(const void *rows, ntp_type type, size_t i)
{
    return type == NTP_TYPE_U8 ? ((const uint8_t *) rows)[i] : ((const uint16_t *) rows)[i];
}

static void store(void *rows, ntp_type type, size_t i, uint32_t level)
{
    if (type == NTP_TYPE_U8)
        ((uint8_t *) rows)[i] = (uint8_t) level;
    else
        ((uint16_t *) rows)[i] = (uint16_t) level;
}

static void undo_srgb(undo *u, void *rows, size_t texels)
{
    const uint32_t max = u->type == NTP_TYPE_U8 ? 255 : 65535;
    const srgb_levels *table = srgb_levels_of(max);
    for (size_t t = 0; t < texels; t++) {
        uint32_t square = 0;
        for (int c = 0; c < 3; c++) {
            const size_t i = t * (size_t) u->channels + (size_t) c;
            const uint32_t level = load(rows, u->type, i), loss = table->loss[level];
            store(rows, u->type, i, table->linear[level]);
            square += loss * loss;
            u->loss_most = loss > u->loss_most ? loss : u->loss_most;
        }
        /* a level is 2 / M of a vector of length 1 */
        const double angle = 2 * sqrt((double) square) / max;
        u->loss_sum += angle;
        u->loss_angle = angle > u->loss_angle ? angle : u->loss_angle;
    }
    u->texels += texels;
}

/* Texels that are black or white are unused, and stay. */
static void undo_blue(undo *u, void *rows, size_t texels)
{
    const uint32_t max = u->type == NTP_TYPE_U8 ? 255 : 65535;
    for (size_t t = 0; t < texels; t++) {
        const size_t i = t * (size_t) u->channels;
        const uint32_t r = load(rows, u->type, i), g = load(rows, u->type, i + 1);
        const uint32_t b = load(rows, u->type, i + 2);
        if (r != g || g != b || (b != 0 && b != max))
            store(rows, u->type, i + 2, max - b);
    }
}

static void undo_blue_of_floats(undo *u, float *rows, size_t texels)
{
    for (size_t t = 0; t < texels; t++) {
        float *texel = rows + t * (size_t) u->channels;
        const bool alike = texel[0] == texel[1] && texel[1] == texel[2];
        if (!alike || (texel[2] != 0 && texel[2] != 1))
            texel[2] = 1 - texel[2];
    }
}

static void alter(void *context, void *rows, size_t texels)
{
    undo *u = context;
    if (u->kind == UNDO_SRGB)
        undo_srgb(u, rows, texels);
    else if (u->kind == UNDO_BLUE && u->type == NTP_TYPE_F32)
        undo_blue_of_floats(u, rows, texels);
    else if (u->kind == UNDO_BLUE)
        undo_blue(u, rows, texels);
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
    u->texels = 0;
    u->loss_most = 0;
    u->loss_sum = u->loss_angle = 0;
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
    if (u->kind == UNDO_SRGB && u->texels > 0) {
        text_addf(line, "; its rounding leaves levels off by up to %u, that is up to ",
                  (unsigned) u->loss_most);
        text_degrees(line, u->loss_angle * DEGREES);
        text_add(line, " degrees, ");
        text_degrees(line, u->loss_sum / (double) u->texels * DEGREES);
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
    const double mean = u->texels > 0 ? u->loss_sum / (double) u->texels : 0;
    json_object_set_new(object, "loss_levels", json_integer((json_int_t) u->loss_most));
    json_object_set_new(object, "loss_deg_mean", json_angle(mean * DEGREES));
    json_object_set_new(object, "loss_deg_max", json_angle(u->loss_angle * DEGREES));
    return object;
}
