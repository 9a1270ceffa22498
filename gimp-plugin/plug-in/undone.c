/* SPDX-License-Identifier: MIT */
/*
 * undone.c - a layer whose accident is undone while it is read
 */
#include "undone.h"

#include <string.h>

static void set_full(unsigned char *sample, ntp_type type)
{
    const uint16_t level = 65535;
    const float one = 1;
    if (type == NTP_TYPE_U8)
        *sample = 255;
    else if (type == NTP_TYPE_U16)
        memcpy(sample, &level, sizeof level);
    else
        memcpy(sample, &one, sizeof one);
}

static void exchange(unsigned char *a, unsigned char *b, size_t size)
{
    unsigned char kept[sizeof(float)];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

/* x is in alpha; blue and alpha have nothing then. */
static void unpack(unsigned char *texel, size_t size, ntp_type type)
{
    memcpy(texel, texel + 3 * size, size);
    set_full(texel + 2 * size, type);
    set_full(texel + 3 * size, type);
}

static void put_right(undo_kind kind, unsigned char *texel, const raster *r, size_t texels)
{
    const size_t size = raster_sample(r);
    for (size_t i = 0; i < texels; i++, texel += raster_pixel(r)) {
        if (kind == UNDO_DXT5NM)
            unpack(texel, size, r->type);
        else
            exchange(texel + (kind == UNDO_RED_BLUE ? 0 : size), texel + 2 * size, size);
    }
}

static bool read_undone(void *user, int32_t y0, int32_t y1, void *rows)
{
    const undone *u = user;
    const size_t texels = (size_t) u->raster.width * (size_t) (y1 - y0);
    undo_loss loss = { 0 };
    if (!u->layer->read(u->layer->user, y0, y1, rows))
        return false;
    if (u->kind == UNDO_SRGB || u->kind == UNDO_BLUE)
        undo_levels(u->kind, rows, u->raster.type, u->raster.channels, texels, &loss);
    else if (u->kind != UNDO_NOTHING)
        put_right(u->kind, rows, &u->raster, texels);
    return true;
}

void undone_open(undone *u, const raster *layer, undo_kind kind)
{
    *u = (undone) { .raster = *layer, .layer = layer, .kind = kind };
    u->raster.user = u;
    u->raster.read = read_undone;
    u->raster.write = NULL;
}

bool undone_is_possible(undo_kind kind, const raster *layer)
{
    return kind != UNDO_NOTHING && (kind != UNDO_SRGB || layer->type != NTP_TYPE_F32) &&
           layer->channels >= (kind == UNDO_DXT5NM ? 4 : 3);
}
