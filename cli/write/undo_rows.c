/* SPDX-License-Identifier: MIT */
/*
 * undo_rows.c - which accident a texture shows, and levels put right again
 */
#include "write/undo_rows.h"

#include <math.h>
#include <stdbool.h>

#include "write/srgb_levels.h"

undo_kind undo_kind_shown(const ntp_classification *type, int32_t channels)
{
    const uint32_t a = type->accidents;
    const bool standard = type->type == NTP_CLASS_STANDARD;
    if ((!standard && type->type != NTP_CLASS_ZZERO && type->type != NTP_CLASS_XY) || channels < 3)
        return UNDO_NOTHING;
    if ((a & NTP_ACCIDENT_GAMMA) != 0)
        return UNDO_SRGB;
    if ((a & NTP_ACCIDENT_RED_IS_Z) != 0)
        return UNDO_RED_BLUE;
    if ((a & NTP_ACCIDENT_GREEN_IS_Z) != 0)
        return UNDO_GREEN_BLUE;
    if ((a & NTP_ACCIDENT_DXT5NM) != 0)
        return channels == 4 ? UNDO_DXT5NM : UNDO_NOTHING;
    return standard && (a & NTP_ACCIDENT_Z_FLIPPED) != 0 ? UNDO_BLUE : UNDO_NOTHING;
}

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

static void undo_srgb(void *rows, ntp_type type, int32_t channels, size_t texels, undo_loss *loss)
{
    const uint32_t max = type == NTP_TYPE_U8 ? 255 : 65535;
    const srgb_levels *table = srgb_levels_of(max);
    for (size_t t = 0; t < texels; t++) {
        uint32_t square = 0;
        for (int c = 0; c < 3; c++) {
            const size_t i = t * (size_t) channels + (size_t) c;
            const uint32_t level = load(rows, type, i), lost = table->loss[level];
            store(rows, type, i, table->linear[level]);
            square += lost * lost;
            loss->most = lost > loss->most ? lost : loss->most;
        }
        /* a level is 2 / M of a vector of length 1 */
        const double angle = 2 * sqrt((double) square) / max;
        loss->sum += angle;
        loss->angle = angle > loss->angle ? angle : loss->angle;
    }
    loss->texels += texels;
}

/* Texels that are black or white are unused, and stay. */
static void undo_blue(void *rows, ntp_type type, int32_t channels, size_t texels)
{
    const uint32_t max = type == NTP_TYPE_U8 ? 255 : 65535;
    for (size_t t = 0; t < texels; t++) {
        const size_t i = t * (size_t) channels;
        const uint32_t r = load(rows, type, i), g = load(rows, type, i + 1);
        const uint32_t b = load(rows, type, i + 2);
        if (r != g || g != b || (b != 0 && b != max))
            store(rows, type, i + 2, max - b);
    }
}

static void undo_blue_of_floats(float *rows, int32_t channels, size_t texels)
{
    for (size_t t = 0; t < texels; t++) {
        float *texel = rows + t * (size_t) channels;
        const bool alike = texel[0] == texel[1] && texel[1] == texel[2];
        if (!alike || (texel[2] != 0 && texel[2] != 1))
            texel[2] = 1 - texel[2];
    }
}

void undo_levels(undo_kind kind, void *rows, ntp_type type, int32_t channels, size_t texels,
                 undo_loss *loss)
{
    if (kind == UNDO_SRGB)
        undo_srgb(rows, type, channels, texels, loss);
    else if (kind == UNDO_BLUE && type == NTP_TYPE_F32)
        undo_blue_of_floats(rows, channels, texels);
    else if (kind == UNDO_BLUE)
        undo_blue(rows, type, channels, texels);
}
